"""Trained policies: a small network for each agent, evaluated without torch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taskbuilder.env.parallel import TaskEnv
from taskbuilder.errors import UsageError
from taskbuilder.rollout.play import Policy
from taskbuilder.rollout.players import Function
from taskbuilder.wording import excerpt

Array32 = NDArray[np.float32]
"""An array of float32."""

TINY = 1e-5
"""Epsilon of the layer norm, as in torch."""


@dataclass(frozen=True)
class Network:
    """A multilayer perceptron with ReLU between its layers.

    Attributes:
        layers: Weight (ins, outs) and bias (outs,) of each layer.
        squash: Whether the output goes through a tanh; otherwise it is clipped to -1 to 1.
        norms: Whether hidden layers have layer norm before the ReLU (Ba et al. 2016), without gain
            and bias.
    """

    layers: tuple[tuple[Array32, Array32], ...]
    squash: bool
    norms: bool = False

    def __call__(self, inputs: NDArray[np.floating]) -> Array32:
        """Evaluate the network: (..., ins) to (..., outs), from -1 to 1."""
        hidden = inputs.astype(np.float32)
        for number, (weight, bias) in enumerate(self.layers):
            hidden = hidden @ weight + bias
            if number < len(self.layers) - 1:
                hidden = np.maximum(_normalized(hidden) if self.norms else hidden, 0.0)
        return np.tanh(hidden) if self.squash else np.clip(hidden, -1.0, 1.0)


def _normalized(hidden: Array32) -> Array32:
    apart: Array32 = hidden - hidden.mean(-1, keepdims=True)
    scale: Array32 = np.sqrt(np.square(apart).mean(-1, keepdims=True) + np.float32(TINY))
    return apart / scale


@dataclass(frozen=True)
class TrainedPolicy:
    """A decentralised policy: each agent acts on its own observation.

    Attributes:
        networks: The network of each agent, by the agent's name.
        about: Metadata of the training: task, options of the environment, algorithm, ...
    """

    networks: Mapping[str, Network]
    about: Mapping[str, Any]

    def __repr__(self) -> str:
        agents = ", ".join(self.networks)
        return f"<{type(self).__name__} for {excerpt(self.about.get('task'))}: {agents}>"

    def act(self, observations: Mapping[str, NDArray[np.floating]]) -> dict[str, Array32]:
        """Every agent's action, from -1 to 1, given its own observation alone."""
        return {agent: net(observations[agent]) for agent, net in self.networks.items()}

    def player(self) -> Policy:
        """The policy as it plays episodes, one after the other."""
        return Function(self.act)

    def check_env(self, env: TaskEnv, name: str) -> None:
        """Check what a policy observes besides numbers; this one observes nothing else."""

    def sizes(self, agent: str) -> tuple[int, int]:
        """How many numbers an agent observes, and how many its action has.

        Raises:
            ValueError: The layers of its network do not fit each other.
        """
        network = self.networks[agent]
        takes = len(network.layers[0][0])
        (gives,) = network(np.zeros(takes)).shape
        return takes, gives

    def traits(self) -> dict[str, Any]:
        """What a file says of its networks besides their arrays."""
        networks = self.networks.values()
        return {name: all(getattr(net, name) for net in networks) for name in ("squash", "norms")}

    def arrays(self) -> dict[str, Array32]:
        """Its arrays by name, for a file."""
        return {
            f"{agent}/{number}/{kind}": array
            for agent, net in self.networks.items()
            for number, layer in enumerate(net.layers)
            for kind, array in zip(("weight", "bias"), layer, strict=True)
        }

    @classmethod
    def of(
        cls, arrays: Mapping[str, Array32], about: Mapping[str, Any], *, squash: bool, norms: bool
    ) -> TrainedPolicy:
        """Make a network from the arrays of a file.

        Raises:
            KeyError: Arrays are missing.
            ValueError: Arrays do not form a network.
        """
        agents: dict[str, set[int]] = {}
        for name, array in arrays.items():
            if array.dtype.kind != "f":
                raise ValueError(f"{name} has numbers of another kind")
            agent, number, _ = name.rsplit("/", 2)
            agents.setdefault(agent, set()).add(int(number))
        return cls(
            {a: Network(_layers(arrays, a, len(n)), squash, norms) for a, n in agents.items()},
            about,
        )


def _layers(
    arrays: Mapping[str, Array32], agent: str, count: int
) -> tuple[tuple[Array32, Array32], ...]:
    """The layers of an agent; broadcasting must not make of two arrays one of any size.

    Raises:
        ValueError: An array is no weight or no bias.
    """
    layers = tuple(
        (arrays[f"{agent}/{number}/weight"], arrays[f"{agent}/{number}/bias"])
        for number in range(count)
    )
    for weight, bias in layers:
        if weight.ndim != 2 or bias.shape != weight.shape[1:]:
            raise ValueError(f"{agent} has a layer of shapes {weight.shape} and {bias.shape}")
    return layers


def folded(
    layers: Sequence[tuple[Array32, Array32]], mean: Array32, scale: Array32, role: Array32
) -> tuple[tuple[Array32, Array32], ...]:
    """Fold the standardisation and the one-hot input into the first layer.

    Args:
        layers: Layers that take standardised observations, then a one-hot of the agent.
        mean: Mean of the observations.
        scale: Scale of the observations.
        role: The one-hot; (0,) if there is none.
    """
    (weight, bias), *rest = layers
    observed, one_hot = weight[: len(mean)], weight[len(mean) :]
    first = (observed / scale[:, None]).astype(np.float32)
    start = (bias + role @ one_hot - (mean / scale) @ observed).astype(np.float32)
    return ((first, start), *rest)


def unfolded(
    layers: Sequence[tuple[Array32, Array32]], mean: Array32, scale: Array32
) -> tuple[tuple[Array32, Array32], ...]:
    """Layers that take standardised observations: the inverse of `folded` without a one-hot."""
    (weight, bias), *rest = layers
    first = (weight * scale[:, None]).astype(np.float32)
    return ((first, (bias + mean @ weight).astype(np.float32)), *rest)


def check_network(policy: TrainedPolicy, agent: str, sizes: Sequence[int], *, norms: bool) -> None:
    """Check that the network of a policy can initialise the actor of an agent.

    Args:
        policy: The policy.
        agent: The agent.
        sizes: Sizes of the actor's input, hidden layers and output.
        norms: Whether the actor's hidden layers have layer norm.

    Raises:
        UsageError: The architectures differ.
    """
    if agent not in policy.networks:
        has = ", ".join(policy.networks)
        raise UsageError(f"the policy to start from plays {has}, and there is {agent} here")
    network = policy.networks[agent]
    own_sizes = [len(network.layers[0][0]), *(len(bias) for _, bias in network.layers)]
    if (own_sizes, network.norms) != (list(sizes), norms):
        raise UsageError(
            f"the policy to start from has {_in_words(own_sizes, network.norms)} for {agent}, and "
            f"this run {_in_words(sizes, norms)}"
        )


def _in_words(sizes: Sequence[int], norms: bool) -> str:
    layers = "-".join(map(str, sizes))
    return f"layers {layers} {'with' if norms else 'without'} layer norm"
