"""MADDPG as it learns these tasks: MATD3's critics, one actor for alike robots, demonstrations.

Multi-agent deep deterministic policy gradient (Lowe et al. 2017) with the clipped double critics,
smoothed targets and delayed actors of MATD3 (Ackermann et al. 2019, Fujimoto et al. 2018):
centralised critics with layer norm that see all observations, the state and all actions, and
actors that end in a tanh and see their own observation alone. Actors follow the critics' gradient
all at once, each by its present policy and not by old actions (Peng et al. 2021, FACMAC).
"""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from taskbuilder.learn.networks import Adam, Networks, follow
from taskbuilder.learn.policy import Array, Network, Policy, folded
from taskbuilder.learn.replay import Memory, Replay
from taskbuilder.learn.shapes import Rows, Shapes

Actions = dict[str, NDArray[np.float32]]

LEAST_SCALE = 0.3
"""What hardly moves while it is measured is not blown up by standardising."""

MEASURED = 20_000
"""Transitions by which what is seen is standardised when networks begin anew."""

LEAST_IMITATION = 1e-3
"""Below this weight, the imitation term is left out."""


@dataclass(frozen=True)
class MaddpgSettings:
    """What may be chosen.

    Attributes:
        hidden: Units of each hidden layer.
        lr: Of Adam, for actors and critics.
        lr_half_life: Control steps in which that halves; 0 if it stays.
        discount: γ.
        tau: Share of the way that targets follow at each update of the actors.
        batch: Transitions an update.
        capacity: Transitions that are kept.
        warm_up: Control steps of random actions before learning begins.
        update_every: Control steps between updates.
        noise: Standard deviation of exploration's Gaussian noise, at the start of training.
        final_noise: The same later, reached linearly.
        noise_until: Share of the training after which it is reached.
        smoothing: Standard deviation of the noise on target actions, clipped at twice that.
        actor_every: Updates of the critics between those of the actors.
        regulariser: Weight of the mean square of what goes into the actors' tanh. It keeps them off
            its ends, where nothing is learned any more, and still where motion pays nothing.
        actor_norms: Whether the actors' hidden layers are normalised, as the critics' are: where
            what is seen has moved on, none of their ReLUs may be left that answers to it.
        renew: Control steps after which networks begin anew, and again each time these have
            doubled; 0 for never. Those that began with the little that there was at first have set
            in it, and learn ever more slowly (the primacy bias, Nikishin et al. 2022).
        share: Whether agents with spaces of equal sizes share one actor, told apart by a one-hot.
        cloning: Updates of behaviour cloning before learning, where there are demonstrations.
        judging: Updates of the critics alone that follow, so that actors are not led astray.
        imitation: Weight of the imitation term beside the critics' normalised gradient.
        imitation_half_life: Control steps in which that weight halves.
    """

    hidden: tuple[int, ...] = (128, 128)
    lr: float = 3e-4
    lr_half_life: int = 0
    discount: float = 0.97
    tau: float = 0.005
    batch: int = 128
    capacity: int = 1_000_000
    warm_up: int = 2_000
    update_every: float = 1.0
    noise: float = 0.25
    final_noise: float = 0.1
    noise_until: float = 1.0
    smoothing: float = 0.1
    actor_every: int = 2
    regulariser: float = 0.03
    actor_norms: bool = False
    renew: int = 0
    share: bool = True
    cloning: int = 10_000
    judging: int = 4_000
    imitation: float = 10.0
    imitation_half_life: int = 30_000


class Maddpg:
    """The learner.

    Args:
        shapes: What agents and critics see and say.
        settings: What may be chosen.
        alike: Whether all agents are always paid the same, so that one pair of critics is enough.
        seed: Of the initial weights.
    """

    def __init__(self, shapes: Shapes, settings: MaddpgSettings, *, alike: bool, seed: int) -> None:
        self.shapes, self.settings = shapes, settings
        groups = shapes.alike() if settings.share else tuple((a,) for a in shapes.agents)
        self._groups = groups
        # Those who share an actor are told apart by a one-hot: (group, 1, group).
        self._roles = {group: torch.eye(len(group))[:, None] for group in groups}
        self._pays = 1 if alike else len(shapes.agents)
        # What is seen is standardised: rows of the replay memory less one, over the other.
        self._mean, self._scale = torch.zeros(shapes.layout.width), torch.ones(shapes.layout.width)
        self._updates = 0
        self._renewals = 0
        self._begun = False
        self._build(seed)

    def _build(self, seed: int) -> None:
        """Make networks that have learned nothing, and their targets and optimisers."""
        generator = torch.Generator().manual_seed(seed)
        shapes, settings = self.shapes, self.settings
        critic = (shapes.overview + shapes.joint_action, *settings.hidden, 1)
        self._critics = Networks(2 * self._pays, critic, generator, norms=True)
        self._actors = torch.nn.ModuleList(
            Networks(1, self._actor_sizes(group), generator, norms=settings.actor_norms, last=0.1)
            for group in self._groups
        )
        self._target_critics = copy.deepcopy(self._critics)
        self._target_actors = copy.deepcopy(self._actors)
        for target in (self._target_critics, self._target_actors):
            target.requires_grad_(False)
        self._critic_adam = Adam([self._critics], settings.lr)
        self._actor_adam = Adam([self._actors], settings.lr)

    def _actor_sizes(self, group: tuple[str, ...]) -> tuple[int, ...]:
        role = len(group) if len(group) > 1 else 0
        seen, said = self.shapes.observations[group[0]], self.shapes.actions[group[0]]
        return (seen + role, *self.settings.hidden, said)

    # --- acting

    def noise(self, done: float) -> float:
        """Standard deviation of exploration's noise after a share of the training, 0 to 1."""
        settings = self.settings
        fallen = min(done / max(settings.noise_until, 1e-9), 1.0)
        return settings.noise + (settings.final_noise - settings.noise) * fallen

    def act(
        self, observations: Mapping[str, Array], rng: np.random.Generator, done: float
    ) -> Actions:
        """What the agents do to explore: (num_envs, n) each, from -1 to 1; by chance at first.

        Args:
            observations: (num_envs, n) each.
            rng: Draws the noise.
            done: Share of the training that is done.
        """
        if not self._begun:
            shape = {a: (len(seen), self.shapes.actions[a]) for a, seen in observations.items()}
            return {a: rng.uniform(-1.0, 1.0, n).astype(np.float32) for a, n in shape.items()}
        with torch.no_grad():
            parts = self.shapes.layout.observations
            seen = {
                agent: (torch.from_numpy(observations[agent]) - self._mean[part])
                / self._scale[part]
                for agent, part in parts.items()
            }
            plain = self._raw(self._actors, seen).tanh_().numpy()
        noise = self.noise(done)
        first, actions = self.shapes.layout.actions.start, {}
        for agent, part in self.shapes.layout.action.items():
            own = plain[:, part.start - first : part.stop - first]
            own = own + noise * rng.standard_normal(own.shape, dtype=np.float32)
            actions[agent] = np.clip(own, -1, 1)
        return actions

    def _raw(self, actors: Any, seen: Mapping[str, Tensor]) -> Tensor:
        """All agents' actions before they are squashed, in their order: (n, joint action)."""
        parts: dict[str, Tensor] = {}
        for group, actor in zip(self._groups, actors, strict=True):
            inputs = torch.stack([seen[agent] for agent in group])
            if len(group) > 1:
                roles = self._roles[group].expand(-1, inputs.shape[1], -1)
                inputs = torch.cat([inputs, roles], 2)
            raw = actor(inputs.flatten(0, 1))[0]
            parts |= dict(zip(group, raw.chunk(len(group)), strict=True))
        return torch.cat([parts[agent] for agent in self.shapes.agents], 1)

    # --- learning

    def begin(self, rows: Rows, rng: np.random.Generator) -> None:
        """Prepare for learning: standardise what is seen, and clone demonstrations.

        Args:
            rows: Transitions so far.
            rng: Draws batches.
        """
        self._begun = True
        self._standardize(rows)
        shown = rows[rows[:, self.shapes.layout.demonstrated.start] > 0.0]
        if not len(shown):
            return
        known = Replay(shown.shape[1], len(shown))
        known.add(shown)
        for _ in range(self.settings.cloning):
            batch = self._drawn(known, rng)
            actions = self._raw(self._actors, self._parts(batch)).tanh()
            self._actor_adam.minimize(self._imitation(batch, actions))
        follow(self._target_actors, self._actors, 1.0)
        for _ in range(self.settings.judging):
            self._judge(self._drawn(known, rng), rng)
            follow(self._target_critics, self._critics, self.settings.tau)

    def _standardize(self, rows: Rows) -> None:
        layout = self.shapes.layout
        pairs = [(layout.observations[a], layout.next_observations[a]) for a in self.shapes.agents]
        for now, later in (*pairs, (layout.state, layout.next_state)):
            values = rows[:, now]
            self._mean[now] = self._mean[later] = torch.from_numpy(values.mean(0))
            scale = torch.from_numpy(np.maximum(values.std(0), LEAST_SCALE))
            self._scale[now] = self._scale[later] = scale

    def _drawn(self, memory: Memory, rng: np.random.Generator) -> Tensor:
        """A batch, what is seen in it standardised."""
        rows = torch.from_numpy(memory.sample(self.settings.batch, rng))
        return rows.sub_(self._mean).div_(self._scale)

    def update(self, memory: Memory, rng: np.random.Generator, step: int) -> dict[str, float]:
        """Learn from a batch.

        Args:
            memory: Where the batch comes from.
            rng: Draws it, and the noise on target actions.
            step: Control steps so far.

        Returns:
            Losses, for logs.
        """
        settings = self.settings
        if settings.lr_half_life:
            for adam in (self._critic_adam, self._actor_adam):
                adam.lr = settings.lr * 0.5 ** (step / settings.lr_half_life)
        if settings.renew and step >= settings.renew * 2**self._renewals:
            self._renewals += 1
            self._build(int(rng.integers(2**63)))
            self.begin(memory.sample(MEASURED, rng), rng)
        batch = self._drawn(memory, rng)
        critic_loss = self._judge(batch, rng)
        self._updates += 1
        if self._updates % settings.actor_every:
            return {"critic": critic_loss}
        weight = settings.imitation * 0.5 ** (step / settings.imitation_half_life)
        actor_loss = self._actor_loss(batch, weight)
        self._actor_adam.minimize(actor_loss)
        follow(self._target_critics, self._critics, settings.tau)
        follow(self._target_actors, self._actors, settings.tau)
        return {"critic": critic_loss, "actor": float(actor_loss.detach())}

    def _judge(self, batch: Tensor, rng: np.random.Generator) -> float:
        """Update the critics; gives their loss."""
        layout, target = self.shapes.layout, self._target(batch, rng)
        values = self._critics(batch[:, : layout.actions.stop])  # what is seen, and what was done
        loss = (values.view(2, self._pays, -1) - target).square().mean(2).sum()
        self._critic_adam.minimize(loss)
        return float(loss.detach())

    def _target(self, batch: Tensor, rng: np.random.Generator) -> Tensor:
        """Pay + γ (1 - ended) min of the two target critics: (pays, n)."""
        layout, settings = self.shapes.layout, self.settings
        with torch.no_grad():
            later = {agent: batch[:, part] for agent, part in layout.next_observations.items()}
            plain = self._raw(self._target_actors, later).tanh_()
            noise = rng.standard_normal(plain.shape, dtype=np.float32) * settings.smoothing
            limit = 2.0 * settings.smoothing
            actions = (plain + torch.from_numpy(noise).clamp_(-limit, limit)).clamp_(-1.0, 1.0)
            inputs = torch.cat([batch[:, layout.next_overview], actions], 1)
            values = self._target_critics(inputs).view(2, self._pays, -1).amin(0)
            pay = batch[:, layout.rewards].T[: self._pays]
            # The end of the time is an end as any other: the time left is part of the state.
            target: Tensor = pay + settings.discount * (1.0 - batch[:, layout.ended].T) * values
            return target

    def _parts(self, batch: Tensor) -> dict[str, Tensor]:
        """What the agents see in a batch."""
        parts = self.shapes.layout.observations
        return {agent: batch[:, part] for agent, part in parts.items()}

    def _actor_loss(self, batch: Tensor, weight: float) -> Tensor:
        """What the critics think of the present policies, over its size; and imitation."""
        raw = self._raw(self._actors, self._parts(batch))
        actions = raw.tanh()
        loss = self.settings.regulariser * raw.square().mean()
        paid = self.shapes.agents[: self._pays]
        joint = torch.stack([self._joint(batch, actions, agent) for agent in paid])
        values: Tensor = self._critics(joint, first=self._pays).flatten(1)
        size = values.detach().abs().mean(1).clamp(min=1.0)
        loss = loss - (values.mean(1) / size).sum()
        shown = batch[:, self.shapes.layout.demonstrated]
        if weight > LEAST_IMITATION and shown.any():
            loss = loss + weight * self._imitation(batch, actions)
        return loss

    def _joint(self, batch: Tensor, actions: Tensor, agent: str) -> Tensor:
        """What the critic of an agent's pay sees; by it, no other agent's action is moved."""
        layout = self.shapes.layout
        if self._pays > 1:
            moved, part = actions, layout.action[agent]
            first, last = (end - layout.actions.start for end in (part.start, part.stop))
            actions = moved.detach().clone()
            actions[:, first:last] = moved[:, first:last]
        return torch.cat([batch[:, layout.overview], actions], 1)

    def _imitation(self, batch: Tensor, actions: Tensor) -> Tensor:
        """Mean square of the difference from what experts did, over their transitions."""
        layout = self.shapes.layout
        shown = batch[:, layout.demonstrated]
        apart = actions - batch[:, layout.actions]
        return (shown * apart.square()).sum() / (shown.sum() * apart.shape[1]).clamp(min=1.0)

    # --- what is kept

    def policy(self, about: Mapping[str, Any]) -> Policy:
        """The present policy, to play: the target actors, an average over the last updates."""
        networks = {}
        for group, actor in zip(self._groups, self._target_actors, strict=True):
            layers = [(w[0].numpy().copy(), b[0, 0].numpy().copy()) for w, b in _weights(actor)]
            for number, agent in enumerate(group):
                role = np.eye(len(group), dtype=np.float32)[number] if len(group) > 1 else _NONE
                part = self.shapes.layout.observations[agent]
                mean, scale = self._mean[part].numpy(), self._scale[part].numpy()
                own = folded(layers, mean, scale, role)
                networks[agent] = Network(own, squash=True, norms=self.settings.actor_norms)
        return Policy({agent: networks[agent] for agent in self.shapes.agents}, about)

    def arrays(self) -> dict[str, Array]:
        """All that it has learned, by name: networks, targets, optimisers, statistics."""
        arrays = {"updates": np.array([self._updates]), "begun": np.array([self._begun])}
        arrays["renewals"] = np.array([self._renewals])
        for part, module in self._modules().items():
            for name, value in module.state_dict().items():
                arrays[f"{part}/{name}"] = value.numpy().copy()
        for part, adam in self._adams().items():
            arrays |= {f"{part}/{name}": value for name, value in adam.arrays().items()}
        return {**arrays, "mean": self._mean.numpy().copy(), "scale": self._scale.numpy().copy()}

    def load(self, arrays: Mapping[str, Array]) -> None:
        """Take over what `arrays` gave.

        Raises:
            KeyError: Something is missing.
            RuntimeError: Something has another shape.
        """
        self._updates, self._begun = int(arrays["updates"][0]), bool(arrays["begun"][0])
        self._renewals = int(arrays["renewals"][0])
        for part, module in self._modules().items():
            state = {
                name: torch.from_numpy(arrays[f"{part}/{name}"]) for name in module.state_dict()
            }
            module.load_state_dict(state)
        for part, adam in self._adams().items():
            own = {
                n.removeprefix(f"{part}/"): a for n, a in arrays.items() if n.startswith(f"{part}/")
            }
            adam.load(own)
        self._mean.copy_(torch.from_numpy(arrays["mean"]))
        self._scale.copy_(torch.from_numpy(arrays["scale"]))

    def _modules(self) -> dict[str, torch.nn.Module]:
        return {
            "critics": self._critics,
            "actors": self._actors,
            "target_critics": self._target_critics,
            "target_actors": self._target_actors,
        }

    def _adams(self) -> dict[str, Adam]:
        return {"critic_adam": self._critic_adam, "actor_adam": self._actor_adam}


_NONE = np.zeros(0, dtype=np.float32)


def _weights(networks: Any) -> list[tuple[Tensor, Tensor]]:
    return [(layer.weight.detach(), layer.bias.detach()) for layer in networks.layers]
