"""MADDPG as Lowe et al. (2017) published it, for continuous actions: a baseline, quirks included.

Every agent has an actor of its own, which outputs the mean and log-std of a Gaussian, and a critic
of its own over all observations and actions. The quirks of the published code are kept: no tanh and
no noise schedule, gradients clipped variable by variable, target networks that are not initialised
as copies, actions stored without clipping, and values bootstrapped beyond the time limit.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from taskbuilder.errors import UsageError
from taskbuilder.learn.learner import Algorithm, Preset
from taskbuilder.learn.off_policy import OffPolicy
from taskbuilder.learn.replay import Memory
from taskbuilder.learn.settings import Count, Layers, Positive, Share, Weight, Whole
from taskbuilder.learn.shapes import Rows, Shapes
from taskbuilder.policies.trained import Array32, Network, TrainedPolicy


@dataclass(frozen=True)
class OpenaiSettings:
    """The settings of `MaddpgOpenai`; the defaults are those published, for episodes of 50 steps.

    Attributes:
        hidden: Units of each hidden layer.
        lr: Learning rate of Adam, for actors and critics.
        discount: γ.
        tau: Polyak averaging factor of an agent's target networks, at each of its updates.
        batch: Transitions per update of an agent, drawn with replacement.
        capacity: Transitions in the replay buffer.
        warm_up: Control steps with the initial actors before learning begins: as many episodes as
            a batch has transitions, of 50 steps each.
        update_every: Control steps between updates of all agents.
        n_step: Control steps of the returns that critics learn from.
        clip: Maximum gradient norm of each variable (a weight matrix or a bias).
        regulariser: Weight of the mean squared outputs of an actor.
    """

    hidden: Layers = (64, 64)
    lr: Positive = 1e-2
    discount: Share = 0.95
    tau: Share = 0.01
    batch: Count = 1024
    capacity: Count = 1_000_000
    warm_up: Whole = 1024 * 50
    update_every: Positive = 100
    n_step: Count = 1
    clip: Positive = 0.5
    regulariser: Weight = 1e-3
    log_std_max: float = 88.0


class MaddpgOpenai:
    """The learner of the published MADDPG.

    Args:
        shapes: The sizes of observations and actions; the state is not used.
        settings: The settings of the algorithm.
        shared_reward: Whether all agents always get the same reward; each has its own critic even
            then.
        seed: Seed of the initial weights.
        device: The CPU; plans with another device are refused.
    """

    def __init__(
        self,
        shapes: Shapes,
        settings: OpenaiSettings,
        *,
        shared_reward: bool,
        seed: int,
        device: str = "cpu",
    ) -> None:
        del shared_reward, device
        generator = torch.Generator().manual_seed(seed)
        self.shapes, self.settings = shapes, settings
        self._learners = {a: _Agent(a, shapes, settings, generator) for a in shapes.agents}

    def act(
        self,
        observations: Mapping[str, Array32],
        rng: np.random.Generator,
        progress_fraction: float,
    ) -> dict[str, Array32]:
        """Exploratory actions: samples of the agents' Gaussians, which may exceed -1 to 1.

        Args:
            observations: (num_envs, n) each.
            rng: Generator of the samples.
            progress_fraction: The fraction of the training that is done; not used.
        """
        del progress_fraction
        with torch.no_grad():
            return {
                agent: self._sample(
                    learner.actor(torch.from_numpy(observations[agent])), rng
                ).numpy()
                for agent, learner in self._learners.items()
            }

    def start_from(self, policy: TrainedPolicy) -> None:
        """Not supported: the published algorithm starts from random weights.

        Raises:
            UsageError: Always.
        """
        del policy
        raise UsageError(f"maddpg_openai {_CANNOT['init']}")

    # --- learning

    def begin(self, rows: Rows, rng: np.random.Generator) -> None:
        """Do nothing: there is no standardisation and no behaviour cloning."""

    def update(self, memory: Memory, rng: np.random.Generator, step: int) -> dict[str, float]:
        """Update every agent, one after the other, each from a batch of its own.

        Args:
            memory: The memory to sample from.
            rng: Generator of batches and actions.
            step: Control steps so far; not used.

        Returns:
            The losses for the logs, as means over the agents.
        """
        del step
        losses = np.array([self._learn(agent, memory, rng) for agent in self.shapes.agents])
        critic, actor = losses.mean(0).tolist()
        return {"critic": critic, "actor": actor}

    def _learn(self, agent: str, memory: Memory, rng: np.random.Generator) -> tuple[float, float]:
        """Update the critic, then the actor, then the targets of one agent."""
        learner, tau = self._learners[agent], self.settings.tau
        batch = torch.from_numpy(memory.sample(self.settings.batch, rng))
        critic_loss = self._critic_loss(agent, batch, rng)
        learner.critic_adam.minimize(critic_loss)
        actor_loss = self._actor_loss(agent, batch, rng)
        learner.actor_adam.minimize(actor_loss)
        learner.target_actor.follow(learner.actor, tau)
        learner.target_critic.follow(learner.critic, tau)
        return critic_loss.item(), actor_loss.item()

    def _critic_loss(self, agent: str, batch: Tensor, rng: np.random.Generator) -> Tensor:
        layout = self.shapes.layout
        actions = [batch[:, part] for part in layout.action.values()]
        values = self._learners[agent].critic(_inputs(batch, layout.observations, actions))
        return (values[:, 0] - self._target(agent, batch, rng)).square().mean()

    def _target(self, agent: str, batch: Tensor, rng: np.random.Generator) -> Tensor:
        """The TD target r + γⁿ (1 - terminated) Q', at samples of all target actors: (n,).

        The time limit is not a terminal state here, so values are bootstrapped beyond it.
        """
        layout = self.shapes.layout
        with torch.no_grad():
            actions = [
                self._sample(learner.target_actor(batch[:, layout.next_observations[name]]), rng)
                for name, learner in self._learners.items()
            ]
            inputs = _inputs(batch, layout.next_observations, actions)
            values = self._learners[agent].target_critic(inputs)[:, 0]
            rewards = batch[:, layout.rewards][:, self.shapes.agents.index(agent)]
            bootstrap = 1.0 - batch[:, layout.terminated][:, 0]
            discount = self.settings.discount ** (1.0 + batch[:, layout.extra_steps][:, 0])
            return rewards + discount * bootstrap * values

    def _actor_loss(self, agent: str, batch: Tensor, rng: np.random.Generator) -> Tensor:
        """-Q at this agent's new action and the others' stored ones, and the regulariser."""
        layout, learner = self.shapes.layout, self._learners[agent]
        flat = learner.actor(batch[:, layout.observations[agent]])
        own = self._sample(flat, rng)
        actions = [own if name == agent else batch[:, part] for name, part in layout.action.items()]
        values = learner.critic(_inputs(batch, layout.observations, actions))
        return self.settings.regulariser * flat.square().mean() - values.mean()

    def _sample(self, flat: Tensor, rng: np.random.Generator) -> Tensor:
        """A draw of the Gaussian with this mean and log-std, differentiable: (n, 2 k) to (n, k)."""
        mean, log_std = flat.chunk(2, 1)
        noise = torch.from_numpy(rng.standard_normal(mean.shape, dtype=np.float32))
        return mean + log_std.clamp(max=self.settings.log_std_max).exp() * noise

    # --- saving and loading

    def policy(self, about: Mapping[str, Any]) -> TrainedPolicy:
        """The current policy for evaluation: the means of the Gaussians, clipped to -1 to 1.

        The published code evaluates with samples, as in training. Means make an evaluation
        independent of a generator; log-stds are left out.
        """
        networks = {a: learner.mean_network() for a, learner in self._learners.items()}
        return TrainedPolicy(networks, about)

    def arrays(self) -> dict[str, NDArray[Any]]:
        """The complete state of the learner by name: networks, targets, optimisers."""
        return {name: tensor.detach().numpy().copy() for name, tensor in self._tensors().items()}

    def load(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Restore the state that `arrays` returned.

        Raises:
            KeyError: Something is missing.
            RuntimeError: Something has another shape.
        """
        loaded = {name: torch.from_numpy(arrays[name]) for name in self._tensors()}
        for name, tensor in self._tensors().items():
            if tensor.shape != loaded[name].shape:
                shapes = f"{tuple(loaded[name].shape)}; {tuple(tensor.shape)} is needed"
                raise RuntimeError(f"{name} has shape {shapes}")
        with torch.no_grad():
            for name, tensor in self._tensors().items():
                tensor.copy_(loaded[name])

    def _tensors(self) -> dict[str, Tensor]:
        return {
            f"{agent}/{name}": tensor
            for agent, learner in self._learners.items()
            for name, tensor in learner.tensors().items()
        }


def _inputs(batch: Tensor, observations: Mapping[str, slice], actions: Sequence[Tensor]) -> Tensor:
    """The inputs of the critics: all observations, then all actions."""
    return torch.cat([*(batch[:, part] for part in observations.values()), *actions], 1)


class _Agent:
    """Networks, targets and optimisers of one agent."""

    def __init__(
        self, agent: str, shapes: Shapes, settings: OpenaiSettings, generator: torch.Generator
    ) -> None:
        self._action_size = shapes.actions[agent]
        observed = sum(shapes.observations.values())
        actor = (shapes.observations[agent], *settings.hidden, 2 * self._action_size)
        critic = (observed + shapes.joint_action, *settings.hidden, 1)
        self.actor, self.target_actor = _Perceptron(actor, generator), _Perceptron(actor, generator)
        self.critic = _Perceptron(critic, generator)
        self.target_critic = _Perceptron(critic, generator)
        self.actor_adam = _Adam(self.actor.parameters, settings)
        self.critic_adam = _Adam(self.critic.parameters, settings)

    def mean_network(self) -> Network:
        """The actor without its log-stds."""
        *inner, last = self.actor.arrays()
        weight, bias = (array[..., : self._action_size] for array in last)
        return Network((*inner, (weight, bias)), squash=False)

    def tensors(self) -> dict[str, Tensor]:
        """Its tensors, by name."""
        parts = {
            "actor": self.actor.parameters,
            "critic": self.critic.parameters,
            "target_actor": self.target_actor.parameters,
            "target_critic": self.target_critic.parameters,
            "actor_adam": self.actor_adam.moments,
            "critic_adam": self.critic_adam.moments,
        }
        return {f"{part}/{n}": tensor for part, ts in parts.items() for n, tensor in enumerate(ts)}


class _Perceptron:
    """A multilayer perceptron with ReLU between its layers.

    Weights are uniform within √(6 / (ins + outs)) (Glorot and Bengio 2010), biases zero.

    Args:
        sizes: Sizes of the input, the hidden layers and the output.
        generator: Generator of the weights.

    Attributes:
        parameters: Weight (ins, outs) and bias (outs,) of each layer in turn.
    """

    def __init__(self, sizes: Sequence[int], generator: torch.Generator) -> None:
        self.parameters: list[Tensor] = []
        for ins, outs in pairwise(sizes):
            bound = math.sqrt(6.0 / (ins + outs))
            weight = (torch.rand(ins, outs, generator=generator) * 2.0 - 1.0) * bound
            self.parameters += [weight.requires_grad_(), torch.zeros(outs, requires_grad=True)]

    def __call__(self, inputs: Tensor) -> Tensor:
        """Evaluate it: (n, ins) to (n, outs)."""
        *inner, (weight, bias) = self._layers()
        hidden = inputs
        for inner_weight, inner_bias in inner:
            hidden = torch.addmm(inner_bias, hidden, inner_weight).relu_()
        return torch.addmm(bias, hidden, weight)

    def follow(self, source: _Perceptron, share: float) -> None:
        """Polyak averaging: move towards another network by a fraction."""
        with torch.no_grad():
            torch._foreach_lerp_(self.parameters, source.parameters, share)

    def arrays(self) -> list[tuple[Array32, Array32]]:
        """Copies of weight and bias of each layer."""
        return [(w.detach().numpy().copy(), b.detach().numpy().copy()) for w, b in self._layers()]

    def _layers(self) -> list[tuple[Tensor, Tensor]]:
        return list(zip(self.parameters[::2], self.parameters[1::2], strict=True))


class _Adam:
    """Adam as in TensorFlow 1, with the gradient of each variable clipped.

    The step is lr √(1 - β₂ᵗ) / (1 - β₁ᵗ) · m / (√v + ε): ε is added to the root of the second
    moment before the bias correction (Kingma and Ba 2015, end of their section 2).

    Attributes:
        moments: Steps so far (1,), then the first and the second moment of every parameter.
    """

    _first, _second, _epsilon = 0.9, 0.999, 1e-8

    def __init__(self, parameters: Sequence[Tensor], settings: OpenaiSettings) -> None:
        self._parameters, self._lr, self._clip = list(parameters), settings.lr, settings.clip
        self._steps = torch.zeros(1, dtype=torch.int64)
        self._mean = [torch.zeros_like(p) for p in parameters]
        self._square = [torch.zeros_like(p) for p in parameters]
        self.moments = [self._steps, *self._mean, *self._square]

    def minimize(self, loss: Tensor) -> None:
        """Take a gradient step on these parameters only."""
        gradients = _clipped(torch.autograd.grad(loss, self._parameters), self._clip)
        self._steps += 1
        steps = int(self._steps)
        rate = self._lr * math.sqrt(1.0 - self._second**steps) / (1.0 - self._first**steps)
        with torch.no_grad():
            torch._foreach_lerp_(self._mean, gradients, 1.0 - self._first)
            torch._foreach_mul_(self._square, self._second)
            torch._foreach_addcmul_(self._square, gradients, gradients, 1.0 - self._second)
            size = torch._foreach_sqrt(self._square)
            torch._foreach_add_(size, self._epsilon)
            torch._foreach_addcdiv_(self._parameters, self._mean, size, -rate)


def _clipped(gradients: Sequence[Tensor], limit: float) -> tuple[Tensor, ...]:
    """Every gradient, with its norm clipped."""
    norms = torch._foreach_norm(list(gradients))
    factors = [limit / max(norm, limit) for norm in torch.stack(list(norms)).tolist()]
    return tuple(torch._foreach_mul(list(gradients), factors))


_CANNOT = {
    "demos": "learns from no demonstrations; maddpg does",
    "init": "starts from no trained policy; maddpg and ppo do",
    "device": "runs on the CPU, as it was published; leave --device out",
}

ALGORITHM = Algorithm(
    summary="MADDPG as Lowe et al. (2017) published it, quirks included",
    settings=OpenaiSettings,
    learner=MaddpgOpenai,
    collection=OffPolicy,
    presets={
        # 75,000 whole episodes of 50 steps, with the team reward and the task's own observations.
        "paper": Preset(
            "the runs of the paper that the three tasks come from",
            # Without a bound a run of Pick-Push-Place overflowed after 597,800 control steps.
            settings={"log_std_max": 2.0},
            plan={
                "reward": "team",
                "observe": "task",
                "frame": "task",
                "rotation": "quaternion",
                "envs": 1,
                "steps": 75_000 * 50,
                "evaluate_every": 50_000,
                "checkpoint_every": 50_000,
            },
        ),
    },
    cannot=_CANNOT,
)
