"""Actors, critics, their target networks and their optimisers."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence

import torch
from torch import Tensor

from taskbuilder.learn.networks import (
    Networks,
    SharedNetworks,
    follow,
    load_state,
    make_adam,
    minimize,
    set_lr,
    state_arrays,
)
from taskbuilder.learn.shapes import Shapes
from taskbuilder.policies.trained import Array32


class ActorCritic:
    """Centralised critics and the agents' actors; target networks begin as copies.

    Args:
        shapes: The sizes of observations, actions and state.
        critics: Number of critics.
        outputs: Outputs of each critic.
        groups: The groups of agents that share an actor.
        hidden: Units of each hidden layer.
        lr: Learning rate of Adam.
        actor_norms: Whether the actors' hidden layers have layer norm, as the critics' do.
        seed: Seed of the initial weights.
        device: Device of the networks.

    Attributes:
        critics, actors: The networks.
        target_critics, target_actors: The networks that follow them.
    """

    def __init__(
        self,
        shapes: Shapes,
        *,
        critics: int,
        outputs: int,
        groups: Sequence[tuple[str, ...]],
        hidden: Sequence[int],
        lr: float,
        actor_norms: bool,
        seed: int,
        device: torch.device,
    ) -> None:
        generator = torch.Generator().manual_seed(seed)
        sizes = (shapes.critic_input + shapes.joint_action, *hidden, outputs)
        self.critics = Networks(critics, sizes, generator, norms=True)
        self.actors = SharedNetworks(
            groups,
            shapes.observations,
            hidden,
            shapes.actions,
            generator,
            norms=actor_norms,
            last=0.1,
        )
        for module in (self.critics, self.actors):
            module.to(device)
        self.target_critics = copy.deepcopy(self.critics)
        self.target_actors = copy.deepcopy(self.actors)
        for target in (self.target_critics, self.target_actors):
            target.requires_grad_(False)
        self._critic_adam = make_adam([self.critics], lr)
        self._actor_adam = make_adam([self.actors], lr)

    def set_lr(self, lr: float) -> None:
        """Set the learning rate."""
        for adam in (self._critic_adam, self._actor_adam):
            set_lr(adam, lr)

    def update_critics(self, loss: Tensor) -> None:
        """Take a gradient step of the critics."""
        minimize(self._critic_adam, loss)

    def update_actors(self, loss: Tensor) -> None:
        """Take a gradient step of the actors."""
        minimize(self._actor_adam, loss)

    def follow_critics(self, share: float) -> None:
        """Move the target critics towards the critics by a fraction."""
        follow(self.target_critics, self.critics, share)

    def follow_actors(self, share: float) -> None:
        """Move the target actors towards the actors by a fraction."""
        follow(self.target_actors, self.actors, share)

    def arrays(self) -> dict[str, Array32]:
        """Networks, targets and optimisers, by name."""
        return state_arrays(self._modules(), self._adams())

    def load(self, arrays: Mapping[str, Array32]) -> None:
        """Restore what `arrays` returned.

        Raises:
            KeyError: Something is missing.
            RuntimeError: Something has another shape.
        """
        load_state(arrays, self._modules(), self._adams())

    def _modules(self) -> dict[str, torch.nn.Module]:
        names = ("critics", "actors", "target_critics", "target_actors")
        return {name: getattr(self, name) for name in names}

    def _adams(self) -> dict[str, torch.optim.Adam]:
        return {"critic_adam": self._critic_adam, "actor_adam": self._actor_adam}
