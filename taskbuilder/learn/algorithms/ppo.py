"""PPO with parameters shared between agents of the same spaces; with a centralised critic, MAPPO.

Proximal policy optimisation (Schulman et al. 2017) with generalised advantage estimation (Schulman
et al. 2016), for any number of agents as in Yu et al. (2022). Agents whose observations and actions
have the same sizes share a network, with a one-hot input for the agent. Observations, values and
advantages are normalised. The critic observes what its agent observes (IPPO) or everything (MAPPO).
Policies are Gaussians with a log-std that does not depend on the state; the environment clips
actions beyond -1 to 1.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.distributions import Normal

from taskbuilder.learn.learner import Algorithm, Preset
from taskbuilder.learn.networks import (
    SharedNetworks,
    layers_of,
    load_state,
    set_lr,
    state_arrays,
)
from taskbuilder.learn.on_policy import OnPolicy
from taskbuilder.learn.running_moments import RunningMoments
from taskbuilder.learn.settings import Count, Layers, Positive, Share, Weight
from taskbuilder.learn.shapes import Rows, Shapes
from taskbuilder.policies.trained import Array32, TrainedPolicy

Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class PpoSettings:
    """The settings of `Ppo`.

    Attributes:
        hidden: Units of each hidden layer, of actors and critics.
        norms: Whether the actors' hidden layers have layer norm.
        squash: Whether the mean of an action ends in a tanh.
        lr: Learning rate of Adam.
        anneal_lr: Whether the learning rate decays linearly to zero over the training.
        discount: γ.
        gae_lambda: λ of generalised advantage estimation.
        rollout_steps: Control steps of every environment per rollout.
        epochs: Passes over the rollout per update.
        minibatches: Minibatches per epoch.
        clip: Clipping range of the probability ratio around 1.
        value_weight: Weight of the critics' loss, relative to the actors'.
        entropy_weight: Weight of the entropy bonus.
        max_grad_norm: Maximum norm of all gradients together.
        log_std: Initial log-std of the actions.
        centralised: Whether critics observe the state and all observations, or only those of their
            agent.
        bootstrap_time_limit: Whether values are bootstrapped at an end that is neither success nor
            failure; for tasks whose agents do not observe the time left.
        share: Whether agents of the same spaces share a network.
    """

    hidden: Layers = (128, 128)
    norms: bool = False
    squash: bool = False
    lr: Positive = 3e-4
    anneal_lr: bool = True
    discount: Share = 0.97
    gae_lambda: Share = 0.95
    rollout_steps: Count = 128
    epochs: Count = 10
    minibatches: Count = 4
    clip: Positive = 0.2
    value_weight: Weight = 0.5
    entropy_weight: Weight = 0.0
    max_grad_norm: Positive = 0.5
    log_std: float = -0.5
    centralised: bool = True
    bootstrap_time_limit: bool = False
    share: bool = True


class Ppo:
    """The PPO learner.

    Args:
        shapes: The sizes of observations, actions and state.
        settings: The settings of the algorithm.
        shared_reward: Whether all agents always get the same reward; not used.
        seed: Seed of the initial weights.
        device: Device of the networks.
    """

    def __init__(
        self,
        shapes: Shapes,
        settings: PpoSettings,
        *,
        shared_reward: bool,
        seed: int,
        device: str = "cpu",
    ) -> None:
        del shared_reward
        self.shapes, self.settings, self._device = shapes, settings, torch.device(device)
        alone = tuple((agent,) for agent in shapes.agents)
        groups = shapes.same_spaces() if settings.share else alone
        generator = torch.Generator().manual_seed(seed)
        self._actors = SharedNetworks(
            groups,
            shapes.observations,
            settings.hidden,
            shapes.actions,
            generator,
            norms=settings.norms,
        )
        joint = dict.fromkeys(shapes.agents, shapes.critic_input)
        self._critics = SharedNetworks(
            (shapes.agents,) if settings.centralised else groups,
            joint if settings.centralised else shapes.observations,
            settings.hidden,
            dict.fromkeys(shapes.agents, 1),
            generator,
        )
        _begin_orthogonal(self._actors, 0.01, generator)
        _begin_orthogonal(self._critics, 1.0, generator)
        self._log_std = nn.Parameter(torch.full((shapes.joint_action,), settings.log_std))
        self._modules = nn.ModuleDict({"actors": self._actors, "critics": self._critics})
        self._modules.register_parameter("log_std", self._log_std)
        self._modules.to(self._device)
        self._parameters = list(self._modules.parameters())
        self._adam = torch.optim.Adam(self._parameters, settings.lr, eps=1e-5)
        self._inputs = RunningMoments(shapes.layout.width)
        self._returns = RunningMoments(len(shapes.agents))
        self._pretrained = False

    # --- acting

    def act(
        self,
        observations: Mapping[str, Array32],
        rng: np.random.Generator,
        progress_fraction: float,
    ) -> dict[str, Array32]:
        """Sampled actions: (num_envs, n) each; the environment clips them to -1 to 1.

        Args:
            observations: (num_envs, n) each.
            rng: Generator of the samples.
            progress_fraction: The fraction of the training that is done; not used.
        """
        del progress_fraction
        parts = self.shapes.layout.observations
        with torch.no_grad():
            policy = self._policy(
                {a: self._normalized(values, parts[a]) for a, values in observations.items()}
            )
        mean, std = policy.mean.cpu().numpy(), policy.stddev.cpu().numpy()
        actions = mean + std * rng.standard_normal(mean.shape, dtype=np.float32)
        ends = np.cumsum(list(self.shapes.actions.values()))[:-1]
        return dict(zip(self.shapes.agents, np.split(actions, ends, axis=1), strict=True))

    def _policy(self, observations: Mapping[str, Tensor]) -> Normal:
        """The distribution of all agents' actions (n, joint action), given their observations."""
        mean = self._actors(observations)
        mean = mean.tanh() if self.settings.squash else mean
        return Normal(mean, self._log_std.exp().expand_as(mean), validate_args=False)

    def _values(self, batch: Tensor, *, next_state: bool = False) -> Tensor:
        """The critics' normalised values of normalised rows: (n, agents).

        Args:
            batch: The rows.
            next_state: Evaluate the state after the step instead of the one before it.
        """
        layout = self.shapes.layout
        own = layout.next_observations if next_state else layout.observations
        everything = layout.next_critic_input if next_state else layout.critic_input
        parts = dict.fromkeys(own, everything) if self.settings.centralised else own
        values: Tensor = self._critics({agent: batch[:, part] for agent, part in parts.items()})
        return values

    def _normalized(self, rows: Rows, part: slice = slice(None)) -> Tensor:
        normal = (rows - self._inputs.mean[part]) / self._inputs.scale[part]
        return torch.from_numpy(normal.astype(np.float32)).to(self._device)

    # --- learning

    def update(
        self, rollout: Rows, lost: Flags, rng: np.random.Generator, progress_fraction: float
    ) -> dict[str, float]:
        """Learn from a rollout, and return the losses for the logs.

        Args:
            rollout: (steps, num_envs, width) rows, in the order of time.
            lost: (steps, num_envs) bool, where a transition was lost with its worker; these are
                masked out.
            rng: Generator of the minibatches.
            progress_fraction: The fraction of the training that is done.
        """
        settings, layout = self.settings, self.shapes.layout
        if settings.anneal_lr:
            set_lr(self._adam, settings.lr * (1.0 - progress_fraction))
        rows = rollout.reshape(-1, rollout.shape[-1])
        batch = self._normalized(rows)
        actions = torch.from_numpy(rows[:, layout.actions]).to(self._device)
        with torch.no_grad():
            before = self._log_probabilities(batch, actions)[0]
            normal = [
                self._values(batch, next_state=after).cpu().numpy() for after in (False, True)
            ]
        values, next_values = (
            (self._returns.mean + self._returns.scale * each).reshape(*rollout.shape[:2], -1)
            for each in normal
        )
        advantages = self._advantages(rollout, values, next_values)
        returns = (advantages + values).reshape(len(rows), -1)
        valid = np.flatnonzero(~lost.reshape(-1))
        self._returns.add(returns[valid])
        targets = self._tensor((returns - self._returns.mean) / self._returns.scale)
        advantages = advantages.reshape(len(rows), -1)
        std = advantages[valid].std() + 1e-8
        normalized = self._tensor((advantages - advantages[valid].mean()) / std)
        losses: list[list[float]] = []
        for _ in range(settings.epochs):
            for part in np.array_split(rng.permutation(valid), settings.minibatches):
                rows_of = torch.from_numpy(part).to(self._device)
                losses.append(
                    self._step(*(t[rows_of] for t in (batch, actions, before, normalized, targets)))
                )
        # Only now, so that the old and the new policy are compared under one normalisation.
        self._measure(rows[valid])
        names = ("actor", "critic", "entropy", "kl", "clipped")
        return dict(zip(names, np.mean(losses, axis=0).tolist(), strict=True))

    def _measure(self, rows: Rows) -> None:
        """Update the normalisation with these rows; a pretrained policy keeps its outputs."""
        before = self.policy({}) if self._pretrained else None
        self._inputs.add(rows)
        if before is not None:
            self._actors.take(before, *self._measures())

    def _advantages(
        self, rollout: Rows, values: NDArray[np.float64], next_values: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Generalised advantage estimates: (steps, num_envs, agents).

        Args:
            rollout: (steps, num_envs, width).
            values: (steps, num_envs, agents), the values before each step.
            next_values: The values after it; at the end of an episode, those of its last state.
        """
        settings, layout = self.settings, self.shapes.layout
        ended = rollout[..., layout.ended]
        # The values of these states are masked out, and those of others bootstrapped.
        final = rollout[..., layout.terminated] if settings.bootstrap_time_limit else ended
        rewards = rollout[..., layout.rewards]
        errors = rewards + settings.discount * (1.0 - final) * next_values - values
        advantages = np.zeros_like(errors)
        advantage = np.zeros_like(errors[0])
        for step in reversed(range(len(errors))):
            decay = settings.discount * settings.gae_lambda * (1.0 - ended[step])
            advantage = errors[step] + decay * advantage
            advantages[step] = advantage
        return advantages

    def _step(
        self, batch: Tensor, actions: Tensor, before: Tensor, advantages: Tensor, targets: Tensor
    ) -> list[float]:
        """A gradient step on a minibatch of rows: (n, ...) each."""
        settings = self.settings
        log_probabilities, entropy = self._log_probabilities(batch, actions)
        change = log_probabilities - before  # (n, agents)
        ratio = change.exp()
        clipped = ratio.clamp(1.0 - settings.clip, 1.0 + settings.clip)
        actor_loss = -torch.minimum(ratio * advantages, clipped * advantages).mean()
        critic_loss = (self._values(batch) - targets).square().mean()
        loss = actor_loss + settings.value_weight * critic_loss - settings.entropy_weight * entropy
        self._adam.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        nn.utils.clip_grad_norm_(self._parameters, settings.max_grad_norm)
        self._adam.step()
        kl = (ratio.detach() - 1.0 - change.detach()).mean()  # Schulman's estimate k3
        share = (ratio.detach() != clipped.detach()).float().mean()
        return [float(x.detach()) for x in (actor_loss, critic_loss, entropy, kl, share)]

    def _log_probabilities(self, batch: Tensor, actions: Tensor) -> tuple[Tensor, Tensor]:
        """Log-probabilities of the taken actions (n, agents), and the policies' mean entropy."""
        policy = self._policy(self.shapes.layout.observed(batch))
        sizes = list(self.shapes.actions.values())
        parts = policy.log_prob(actions).split(sizes, 1)  # type: ignore[no-untyped-call]
        entropy = policy.entropy().sum(1).mean() / len(sizes)  # type: ignore[no-untyped-call]
        return torch.stack([part.sum(1) for part in parts], 1), entropy

    def _tensor(self, array: NDArray[np.floating]) -> Tensor:
        return torch.from_numpy(array.astype(np.float32)).to(self._device)

    # --- saving and loading

    def policy(self, about: Mapping[str, Any]) -> TrainedPolicy:
        """The current policy for evaluation: the means of the Gaussians, clipped to -1 to 1."""
        squash = self.settings.squash
        return TrainedPolicy(self._actors.policy(*self._measures(), squash=squash), about)

    def _measures(self) -> tuple[dict[str, Array32], dict[str, Array32]]:
        """Means and scales of the agents' observations."""
        parts = self.shapes.layout.observations
        mean, scale = (x.astype(np.float32) for x in (self._inputs.mean, self._inputs.scale))
        return {a: mean[p] for a, p in parts.items()}, {a: scale[p] for a, p in parts.items()}

    def start_from(self, policy: TrainedPolicy) -> None:
        """Initialise the actors' means from a trained policy.

        Raises:
            UsageError: Its networks are of another kind or size than these.
        """
        self._actors.take(policy, *self._measures())
        self._pretrained = True

    def arrays(self) -> dict[str, NDArray[Any]]:
        """The complete state of the learner by name: networks, optimiser, normalisation."""
        arrays: dict[str, NDArray[Any]] = {}
        arrays |= state_arrays({"networks": self._modules}, {"adam": self._adam})
        for name, measure in (("inputs", self._inputs), ("returns", self._returns)):
            arrays |= {f"{name}/{key}": array for key, array in measure.arrays().items()}
        return {**arrays, "pretrained": np.array([self._pretrained])}

    def load(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Restore the state that `arrays` returned.

        Raises:
            KeyError: Something is missing.
            RuntimeError: Something has another shape.
        """
        load_state(arrays, {"networks": self._modules}, {"adam": self._adam})
        self._inputs.load(_below("inputs", arrays))
        self._returns.load(_below("returns", arrays))
        self._pretrained = bool(arrays["pretrained"][0])


def _begin_orthogonal(networks: SharedNetworks, last: float, generator: torch.Generator) -> None:
    """Orthogonal initial weights, small ones in the actors' last layer; zero biases."""
    for network in networks:
        *hidden, head = layers_of(network)
        for layer in (*hidden, head):
            gain = last if layer is head else 2.0**0.5
            nn.init.orthogonal_(layer.weight[0], gain, generator=generator)
            nn.init.zeros_(layer.bias)


def _below(part: str, arrays: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    own = {name: array for name, array in arrays.items() if name.startswith(f"{part}/")}
    return {name.removeprefix(f"{part}/"): array for name, array in own.items()}


def _settings_of(policy: TrainedPolicy) -> dict[str, Any]:
    """The settings that match a policy's networks; each agent has an actor of its own."""
    network = next(iter(policy.networks.values()))
    hidden = [len(bias) for _, bias in network.layers[:-1]]
    return {
        "hidden": hidden,
        "norms": network.norms,
        "squash": network.squash,
        "share": False,
    }


ALGORITHM = Algorithm(
    summary="PPO with shared parameters; a centralised critic makes it MAPPO",
    settings=PpoSettings,
    learner=Ppo,
    collection=OnPolicy,
    presets={
        "mappo": Preset(
            "every critic sees what all agents do and the state", {"centralised": True}
        ),
        "ippo": Preset("every critic sees what its agent does", {"centralised": False}),
        "finetune": Preset(
            "going on from a trained policy",
            {"log_std": -1.6, "lr": 1e-4, "clip": 0.1},
        ),
    },
    default_preset=lambda given: "finetune" if given.get("init") else "mappo",
    settings_of=_settings_of,
)
