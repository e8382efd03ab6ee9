"""MADDPG with the critics of MATD3, shared actors and demonstrations.

Multi-agent deep deterministic policy gradient (Lowe et al. 2017) with the clipped double critics,
smoothed target actions and delayed actor updates of MATD3 (Ackermann et al. 2019, Fujimoto et al.
2018). Critics are centralised, have layer norm, and observe all observations, the state and all
actions. Actors end in a tanh and observe their own observation only. They are updated together,
with the actions of the current policies in place of those in the replay (Peng et al. 2021, FACMAC).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
import torch
from torch import Tensor

from taskbuilder.errors import UsageError
from taskbuilder.learn.actor_critic import ActorCritic
from taskbuilder.learn.exploration import Exploration
from taskbuilder.learn.learner import Algorithm, Preset
from taskbuilder.learn.networks import half_cosine, halved
from taskbuilder.learn.off_policy import OffPolicy
from taskbuilder.learn.replay import Memory, Replay
from taskbuilder.learn.settings import Count, Layers, Positive, Share, Weight, Whole, formerly
from taskbuilder.learn.shapes import Rows, Shapes
from taskbuilder.learn.standardizer import Standardizer
from taskbuilder.learn.values import make_values
from taskbuilder.policies.trained import Array32, TrainedPolicy

MEASURED = 20_000
"""Sampled transitions that set the standardisation of inputs when networks are reset."""


@dataclass(frozen=True)
class MaddpgSettings:
    """The settings of `Maddpg`.

    Attributes:
        hidden: Units of each hidden layer.
        lr: Learning rate of Adam, for actors and critics.
        lr_half_life: Control steps in which the learning rate halves; 0 for a constant rate.
        discount: γ.
        tau: Polyak averaging factor of the target networks, at each update of the actors.
        batch: Transitions per update.
        capacity: Transitions in the replay buffer.
        warm_up: Control steps of random actions before learning begins.
        update_every: Control steps between updates.
        n_step: Control steps of the returns that critics learn from.
        noise: Standard deviation of the Gaussian exploration noise at the start of training.
        final_noise: Its value at the end of a linear decay.
        noise_until: Fraction of the training after which the decay ends.
        least_noise: The noise in the first of several environments, relative to the last, and
            evenly spaced between. Little noise reaches states that need precise actions.
        gripper_epsilon: Probability, at a control step, that a gripper begins to open or close at
            random, for some steps; with `least_noise` as for the noise. See `Exploration`.
        smoothing: Standard deviation of the noise on target actions, clipped at twice this.
        actor_every: Critic updates per actor update.
        regulariser: Weight of the mean squared input of the actors' tanh; it keeps actions small.
        saturation_penalty: Weight of the mean squared part of this input beyond ±1.
        value_bins: Bins of the critics' distribution over returns; 0 for a scalar value.
        value_limit: The bins are from minus this to this; doubled where returns lie beyond.
        actor_norms: Whether the actors' hidden layers have layer norm, as the critics' do. Without
            it, all ReLUs of a layer can die when the distribution of the observations shifts.
        reset_networks_after: Control steps before the networks are first reset, against the primacy
            bias (Nikishin et al. 2022); 0 for never. Later resets: after twice as many, and so on.
        share: Whether agents with spaces of the same size share one actor, with a one-hot input.
        bc_updates: Behaviour cloning updates from demonstrations, before reinforcement learning.
        bc_noise: Standard deviation of noise on the standardised observations of demonstrations.
        critic_warmup_updates: Updates of critics alone at first, in runs from a policy or episodes.
        imitation: Weight of the imitation term, relative to the critics' normalised gradient.
        imitation_half_life: Control steps in which this weight halves; 0 for a constant weight.
    """

    hidden: Layers = (128, 128)
    lr: Positive = 3e-4
    lr_half_life: Whole = 0
    discount: Share = 0.97
    tau: Share = 0.005
    batch: Count = 128
    capacity: Count = 1_000_000
    warm_up: Whole = 2_000
    update_every: Positive = 1.0
    n_step: Count = 1
    noise: Weight = 0.25
    final_noise: Weight = 0.1
    noise_until: Share = 1.0
    least_noise: Weight = 1.0
    gripper_epsilon: Share = 0.0
    smoothing: Weight = 0.1
    actor_every: Count = 2
    regulariser: Weight = 0.03
    saturation_penalty: Weight = 0.0
    value_bins: Whole = 0
    value_limit: Positive = 50.0
    actor_norms: bool = False
    reset_networks_after: Whole = 0
    share: bool = True
    bc_updates: Annotated[Whole, formerly("bc_updates", "cloning")] = 10_000
    bc_noise: Weight = 0.05
    critic_warmup_updates: Annotated[Whole, formerly("critic_warmup_updates", "judging")] = 4_000
    imitation: Weight = 10.0
    imitation_half_life: Whole = 30_000


class Maddpg:
    """The MADDPG learner.

    Args:
        shapes: The sizes of observations, actions and state.
        settings: The settings of the algorithm.
        shared_reward: Whether all agents always get the same reward, so that one pair of critics
            is enough.
        seed: Seed of the initial weights.
        device: Device of the networks.
    """

    def __init__(
        self,
        shapes: Shapes,
        settings: MaddpgSettings,
        *,
        shared_reward: bool,
        seed: int,
        device: str = "cpu",
    ) -> None:
        self.shapes, self.settings, self._device = shapes, settings, torch.device(device)
        groups = shapes.same_spaces() if settings.share else tuple((a,) for a in shapes.agents)
        self._groups = groups
        self._rewards = 1 if shared_reward else len(shapes.agents)
        self._standard = Standardizer(shapes.layout, self._device)
        self._exploration = Exploration(shapes.grippers, settings)
        self._values = make_values(settings.value_bins, settings.value_limit, self._device)
        self._updates = self._renewals = 0
        self._begun = self._pretrained = False
        self._networks = self._build(seed)

    def _build(self, seed: int) -> ActorCritic:
        """Untrained networks, their target networks and optimisers."""
        settings = self.settings
        return ActorCritic(
            self.shapes,
            critics=2 * self._rewards,
            outputs=self._values.outputs,
            groups=self._groups,
            hidden=settings.hidden,
            lr=settings.lr,
            actor_norms=settings.actor_norms,
            seed=seed,
            device=self._device,
        )

    # --- acting

    def act(
        self,
        observations: Mapping[str, Array32],
        rng: np.random.Generator,
        progress_fraction: float,
    ) -> dict[str, Array32]:
        """Exploratory actions: (num_envs, n) each, from -1 to 1; random before learning begins.

        Args:
            observations: (num_envs, n) each.
            rng: Generator of the noise.
            progress_fraction: The fraction of the training that is done.
        """
        if not (self._begun or self._pretrained):
            shape = {a: (len(values), self.shapes.actions[a]) for a, values in observations.items()}
            return {a: rng.uniform(-1.0, 1.0, n).astype(np.float32) for a, n in shape.items()}
        with torch.no_grad():
            raw = self._networks.actors(self._standard.observations(observations))
            joint = raw.tanh_().cpu().numpy()
        self._exploration.explore_(joint, rng, progress_fraction)
        first, parts = self.shapes.layout.actions.start, self.shapes.layout.action
        return {a: joint[:, p.start - first : p.stop - first].copy() for a, p in parts.items()}

    # --- learning

    def begin(self, rows: Rows, rng: np.random.Generator) -> None:
        """Prepare for learning: set the standardisation, and clone the demonstrations.

        Args:
            rows: The transitions so far.
            rng: Generator that draws batches.
        """
        self._begun = True
        before = self.policy({}) if self._pretrained else None
        self._standard.measure(rows)
        if before is not None:
            self._take(before)
        demonstrations = rows[rows[:, self.shapes.layout.demonstrated.start] > 0.0]
        if not len(demonstrations) and before is None:
            return
        memory = Replay(rows.shape[1], len(rows))
        memory.add(demonstrations if len(demonstrations) else rows)
        if len(demonstrations):
            self._clone(memory, rng)
        for _ in range(self.settings.critic_warmup_updates):
            self._update_critics(self._sample_batch(memory, rng), rng)
            self._networks.follow_critics(self.settings.tau)

    def _clone(self, memory: Memory, rng: np.random.Generator) -> None:
        """Clone demonstrations, with a learning rate that falls to zero."""
        lr, updates = self.settings.lr, self.settings.bc_updates
        for update in range(updates):
            self._networks.set_lr(lr * half_cosine(update / updates))
            self._networks.update_actors(self._imitation(self._sample_batch(memory, rng), rng))
        self._networks.set_lr(lr)
        self._networks.follow_actors(1.0)

    def _sample_batch(self, memory: Memory, rng: np.random.Generator) -> Tensor:
        """A batch with standardised observations and state."""
        return self._standard.apply_(self._tensor(memory.sample(self.settings.batch, rng)))

    def _tensor(self, array: Array32) -> Tensor:
        return torch.from_numpy(array).to(self._device)

    def update(self, memory: Memory, rng: np.random.Generator, step: int) -> dict[str, float]:
        """Learn from a batch, and return the losses for the logs.

        Args:
            memory: The memory to sample from.
            rng: Generator of the batch and of the noise on target actions.
            step: Control steps so far.
        """
        settings = self.settings
        self._networks.set_lr(settings.lr * halved(step, settings.lr_half_life))
        first = settings.reset_networks_after
        if first and step >= first * 2**self._renewals:
            self._renewals += 1
            self._pretrained = False
            self._networks = self._build(int(rng.integers(2**63)))
            self.begin(memory.sample(MEASURED, rng), rng)
        batch = self._sample_batch(memory, rng)
        critic_loss = self._update_critics(batch, rng)
        self._updates += 1
        if self._updates % settings.actor_every:
            return {"critic": critic_loss}
        weight = settings.imitation * halved(step, settings.imitation_half_life)
        actor_loss = self._actor_loss(batch, weight, rng)
        self._networks.update_actors(actor_loss)
        self._networks.follow_critics(settings.tau)
        self._networks.follow_actors(settings.tau)
        return {"critic": critic_loss, "actor": float(actor_loss.detach())}

    def _update_critics(self, batch: Tensor, rng: np.random.Generator) -> float:
        """Update the critics, and return their loss."""
        layout, target = self.shapes.layout, self._target(batch, rng)
        inputs = batch[:, : layout.actions.stop]  # critic inputs, and actions
        out = self._networks.critics(inputs).unflatten(0, (2, self._rewards))
        loss = self._values.errors(out, target).mean(2).sum()
        self._networks.update_critics(loss)
        self._values.adapt_(target, (self._networks.critics, self._networks.target_critics))
        return float(loss.detach())

    def _target(self, batch: Tensor, rng: np.random.Generator) -> Tensor:
        """Reward + γⁿ (1 - ended) min of the two target critics: (rewards, n)."""
        layout, settings = self.shapes.layout, self.settings
        with torch.no_grad():
            next_observations = {
                agent: batch[:, part] for agent, part in layout.next_observations.items()
            }
            plain = self._networks.target_actors(next_observations).tanh_()
            noise = rng.standard_normal(plain.shape, dtype=np.float32) * settings.smoothing
            limit = 2.0 * settings.smoothing
            actions = (plain + self._tensor(noise).clamp_(-limit, limit)).clamp_(-1.0, 1.0)
            inputs = torch.cat([batch[:, layout.next_critic_input], actions], 1)
            values = self._values.mean(self._networks.target_critics(inputs))
            values = values.view(2, self._rewards, -1).amin(0)
            rewards = batch[:, layout.rewards].T[: self._rewards]
            discount = settings.discount ** (1.0 + batch[:, layout.extra_steps].T)
            # The time limit may be a terminal state, since the time left is observed.
            target: Tensor = rewards + discount * (1.0 - batch[:, layout.ended].T) * values
            return target

    def _actor_loss(self, batch: Tensor, weight: float, rng: np.random.Generator) -> Tensor:
        """The critics' normalised value of the current policies, and the imitation term."""
        raw: Tensor = self._networks.actors(self.shapes.layout.observed(batch))
        actions = raw.tanh()
        loss: Tensor = self.settings.regulariser * raw.square().mean()
        if penalty := self.settings.saturation_penalty:
            loss = loss + penalty * (raw.abs() - 1.0).relu().square().mean()
        paid = self.shapes.agents[: self._rewards]
        joint = torch.stack([self._joint(batch, actions, agent) for agent in paid])
        values = self._values.mean(self._networks.critics(joint, first=self._rewards))
        loss = loss - (values.mean(1) / values.detach().abs().mean(1).clamp(min=1.0)).sum()
        demonstrated = batch[:, self.shapes.layout.demonstrated.start] > 0.0
        if weight > 1e-3 and demonstrated.any():  # a smaller weight is not worth the time
            loss = loss + weight * self._imitation(batch[demonstrated], rng)
        return loss

    def _joint(self, batch: Tensor, actions: Tensor, agent: str) -> Tensor:
        """The input of the critic of an agent's reward; other agents' actions are detached."""
        layout = self.shapes.layout
        if self._rewards > 1:
            moved, part = actions, layout.action[agent]
            first, last = (end - layout.actions.start for end in (part.start, part.stop))
            actions = moved.detach().clone()
            actions[:, first:last] = moved[:, first:last]
        return torch.cat([batch[:, layout.critic_input], actions], 1)

    def _imitation(self, batch: Tensor, rng: np.random.Generator) -> Tensor:
        """Mean absolute difference from the expert's actions, seen with noise."""
        width, observed = self.settings.bc_noise, self.shapes.layout.observed(batch)
        for values in observed.values():
            values += width * self._tensor(rng.standard_normal(values.shape, dtype=np.float32))
        actions: Tensor = self._networks.actors(observed).tanh()
        return (actions - batch[:, self.shapes.layout.actions]).abs().mean()

    # --- starting from a policy

    def start_from(self, policy: TrainedPolicy) -> None:
        """Initialise the actors from a trained policy; the critics are then trained first.

        Raises:
            UsageError: Its networks are of another kind or size than these.
        """
        self._take(policy)
        self._pretrained = True

    def _take(self, policy: TrainedPolicy) -> None:
        """Copy a policy into the actors, under the current standardisation."""
        self._networks.actors.take(policy, *self._standard.by_agent())
        self._networks.follow_actors(1.0)

    # --- saving and loading

    def policy(self, about: Mapping[str, Any]) -> TrainedPolicy:
        """The current policy for evaluation: the target actors."""
        actors = self._networks.target_actors
        return TrainedPolicy(actors.policy(*self._standard.by_agent(), squash=True), about)

    def arrays(self) -> dict[str, Array32]:
        """The complete state of the learner by name: networks, targets, optimisers, statistics."""
        flags = {"updates": self._updates, "begun": self._begun, "renewals": self._renewals}
        flags |= {"pretrained": True} if self._pretrained else {}
        numbers = {name: np.array([value]) for name, value in flags.items()}
        return {**numbers, **{n: a for part in self._parts() for n, a in part.arrays().items()}}

    def load(self, arrays: Mapping[str, Array32]) -> None:
        """Restore the state that `arrays` returned.

        Raises:
            KeyError: Something is missing.
            RuntimeError: Something has another shape.
        """
        self._updates, self._begun = int(arrays["updates"][0]), bool(arrays["begun"][0])
        self._renewals = int(arrays["renewals"][0])
        self._pretrained = "pretrained" in arrays
        for part in self._parts():
            part.load(arrays)

    def _parts(self) -> tuple[Any, ...]:
        return self._networks, self._standard, self._exploration, self._values


def _settings_of(policy: TrainedPolicy) -> dict[str, Any]:
    """The settings that match a policy's networks; each agent has an actor of its own."""
    network = next(iter(policy.networks.values()))
    if not network.squash:
        raise UsageError("maddpg starts from policies that end in a tanh, and this one does not")
    hidden = [len(bias) for _, bias in network.layers[:-1]]
    return {"hidden": hidden, "actor_norms": network.norms, "share": False}


# Early transitions differ from late ones. Saturated actions neither brake nor explore.
_SCRATCH: dict[str, Any] = {
    "discount": 0.95,
    "n_step": 3,
    "capacity": 100_000,
    "actor_norms": True,
    "reset_networks_after": 10_000,
    "update_every": 0.5,
    "least_noise": 0.1,
    "regulariser": 0.2,
    "gripper_epsilon": 0.01,
    "value_bins": 100,
}
# Critics err, and the expert does not. Weak imitation, or smaller actions, unlearn the task.
_DEMOS = _SCRATCH | {
    "regulariser": 0.005,
    "reset_networks_after": 0,
    "lr_half_life": 10_000,
    "imitation": 100.0,
    "imitation_half_life": 0,
}

ALGORITHM = Algorithm(
    summary="MADDPG with clipped double critics, shared actors and demonstrations",
    settings=MaddpgSettings,
    learner=Maddpg,
    collection=OffPolicy,
    presets={
        "demos": Preset("learning with demonstrations", _DEMOS, {"distances": "log"}),
        "scratch": Preset("learning without demonstrations", _SCRATCH, {"distances": "log"}),
        "finetune": Preset("going on from a trained policy", {"noise": 0.1, "final_noise": 0.05}),
    },
    default_preset=lambda given: (
        "demos" if given.get("demos") else "finetune" if given.get("init") else "scratch"
    ),
    settings_of=_settings_of,
)
