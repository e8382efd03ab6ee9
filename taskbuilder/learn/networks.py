"""Networks of actors and critics, several of one shape evaluated at once."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from taskbuilder.errors import UsageError
from taskbuilder.policies.trained import (
    Array32,
    Network,
    TrainedPolicy,
    check_network,
    folded,
    unfolded,
)

COLUMNS = 16
"""Minimum columns of a matrix product; with fewer, it takes two to three times as long."""


class Linears(nn.Module):
    """Several linear layers of one shape, applied at once: (count, n, ins) to (count, n, outs)."""

    def __init__(self, count: int, ins: int, outs: int, generator: torch.Generator) -> None:
        super().__init__()
        bound = 1.0 / math.sqrt(ins)  # PyTorch's default for linear layers
        self.weight = nn.Parameter(_uniform((count, ins, outs), bound, generator))
        self.bias = nn.Parameter(_uniform((count, 1, outs), bound, generator))

    def forward(self, inputs: Tensor) -> Tensor:
        """Apply the first ``first`` layers, each to its own part of the inputs."""
        weight: Tensor = self.weight
        bias: Tensor = self.bias
        if len(inputs) < len(weight):
            weight, bias = weight[: len(inputs)], bias[: len(inputs)]
        outs = weight.shape[2]
        if outs == 1:  # a sum is then faster than a product
            return (inputs * weight.mT).sum(2, keepdim=True).add_(bias)
        if outs < COLUMNS:
            wide = nn.functional.pad(weight, (0, COLUMNS - outs))
            return torch.bmm(inputs, wide)[..., :outs] + bias
        return torch.bmm(inputs, weight).add_(bias)


class Networks(nn.Module):
    """Several multilayer perceptrons of one shape, evaluated at once.

    Linear, optional layer norm, ReLU, ..., linear. On a CPU, evaluating four small networks at once
    is much faster than one after the other. The layer norms (Ba et al. 2016) have no gain and bias,
    since the linear layers around them can represent these.

    Args:
        count: Number of networks.
        sizes: Sizes of the input, the hidden layers and the output.
        generator: Generator of the initial weights.
        norms: Whether hidden layers have layer norm.
        last: Factor on the initial weights of the last layer.
    """

    def __init__(
        self,
        count: int,
        sizes: Sequence[int],
        generator: torch.Generator,
        *,
        norms: bool = False,
        last: float = 1.0,
    ) -> None:
        super().__init__()
        self.count, self.norms = count, norms
        pairs = pairwise(sizes)
        self.layers = nn.ModuleList(Linears(count, a, b, generator) for a, b in pairs)
        with torch.no_grad():
            for parameter in self.layers[-1].parameters():
                parameter.mul_(last)

    def forward(self, inputs: Tensor, first: int | None = None) -> Tensor:
        """Evaluate the networks.

        Args:
            inputs: (n, ins), shared by all networks, or (count, n, ins), one for each.
            first: Evaluate only this many networks.

        Returns:
            (count, n, outs)
        """
        hidden = inputs.expand(first or self.count, *inputs.shape[-2:])
        *inner, last = self.layers
        for layer in inner:
            hidden = layer(hidden)
            if self.norms:
                hidden = nn.functional.layer_norm(hidden, hidden.shape[-1:])
            hidden = hidden.relu_()
        out: Tensor = last(hidden)
        return out


class SharedNetworks(nn.ModuleList):
    """One network per group of agents, with a one-hot input for the agent.

    Args:
        groups: The groups of agents that share a network; within a group, inputs and outputs have
            the same sizes.
        ins: Size of the input, by agent.
        hidden: Units of each hidden layer.
        outs: Size of the output, by agent, in the order of the agents.
        generator: Generator of the initial weights.
        norms: Whether hidden layers have layer norm.
        last: Factor on the initial weights of the last layer.
    """

    def __init__(
        self,
        groups: Sequence[tuple[str, ...]],
        ins: Mapping[str, int],
        hidden: Sequence[int],
        outs: Mapping[str, int],
        generator: torch.Generator,
        *,
        norms: bool = False,
        last: float = 1.0,
    ) -> None:
        super().__init__(
            Networks(
                1,
                (ins[group[0]] + _roles(group), *hidden, outs[group[0]]),
                generator,
                norms=norms,
                last=last,
            )
            for group in groups
        )
        self.groups, self.agents, self.norms = tuple(groups), tuple(outs), norms
        for group in groups:  # (group, 1, group)
            self.register_buffer(_key(group), torch.eye(len(group))[:, None], persistent=False)

    def _pairs(self) -> Iterable[tuple[tuple[str, ...], Any]]:
        """Every group and its network."""
        return zip(self.groups, self, strict=True)

    def forward(self, inputs: Mapping[str, Tensor]) -> Tensor:
        """The outputs of all agents in order: (n, outs), from inputs of (n, ins) each."""
        parts: dict[str, Tensor] = {}
        for group, network in self._pairs():
            stacked = torch.stack([inputs[agent] for agent in group])
            if len(group) > 1:
                roles = self.get_buffer(_key(group)).expand(-1, stacked.shape[1], -1)
                stacked = torch.cat([stacked, roles], 2)
            out = network(stacked.flatten(0, 1))[0]
            parts |= dict(zip(group, out.chunk(len(group)), strict=True))
        return torch.cat([parts[agent] for agent in self.agents], 1)

    def policy(
        self, means: Mapping[str, Array32], scales: Mapping[str, Array32], *, squash: bool
    ) -> dict[str, Network]:
        """A policy with a network for each agent, which takes unnormalised observations.

        Args:
            means: Means of each agent's observations.
            scales: Scales of each agent's observations.
            squash: Whether the networks end in a tanh.
        """
        networks = {}
        for group, own in self._pairs():
            pairs = [
                (as_array(layer.weight[0]), as_array(layer.bias[0, 0])) for layer in layers_of(own)
            ]
            for number, agent in enumerate(group):
                role = np.eye(len(group), dtype=np.float32)[number][: _roles(group)]
                layers = folded(pairs, means[agent], scales[agent], role)
                networks[agent] = Network(layers, squash=squash, norms=self.norms)
        return {agent: networks[agent] for agent in self.agents}

    def take(
        self, policy: TrainedPolicy, means: Mapping[str, Array32], scales: Mapping[str, Array32]
    ) -> None:
        """Copy the networks of a policy; the inverse of `policy`.

        Raises:
            UsageError: Its networks are of another kind or size, or agents share a network here,
                which does not allow a normalisation for each agent.
        """
        for group, own in self._pairs():
            if len(group) > 1:
                raise UsageError("to start from a policy, agents share no actor; set share=false")
            (agent,) = group
            here = layers_of(own)
            sizes = [here[0].weight.shape[1], *(layer.weight.shape[2] for layer in here)]
            check_network(policy, agent, sizes, norms=self.norms)
            layers = unfolded(policy.networks[agent].layers, means[agent], scales[agent])
            with torch.no_grad():
                for layer, (weight, bias) in zip(here, layers, strict=True):
                    layer.weight.copy_(torch.from_numpy(weight)[None])
                    layer.bias.copy_(torch.from_numpy(bias)[None, None])


def layers_of(network: nn.Module) -> list[Any]:
    """The linear layers of one network of `SharedNetworks`, first to last."""
    layers: Any = network.layers
    return list(layers)


def _roles(group: Sequence[str]) -> int:
    """The one-hot inputs of the agents of a group."""
    return len(group) if len(group) > 1 else 0


def _key(group: Sequence[str]) -> str:
    return f"roles of {' '.join(group)}".replace(".", " ")


def as_array(tensor: Tensor) -> Array32:
    """A copy of a tensor as an array."""
    array: Array32 = tensor.detach().cpu().numpy().copy()
    return array


def _uniform(shape: tuple[int, ...], bound: float, generator: torch.Generator) -> Tensor:
    return (torch.rand(shape, generator=generator) * 2.0 - 1.0) * bound


def follow(target: nn.Module, source: nn.Module, share: float) -> None:
    """Polyak averaging: move a target network towards its source by a fraction."""
    with torch.no_grad():
        torch._foreach_lerp_(list(target.parameters()), list(source.parameters()), share)


def make_adam(modules: Iterable[nn.Module], lr: float) -> torch.optim.Adam:
    """PyTorch's fused Adam over the parameters of modules."""
    parameters = [p for module in modules for p in module.parameters()]
    return torch.optim.Adam(parameters, lr=lr, fused=True)


def parameters_of(optimizer: torch.optim.Optimizer) -> list[Tensor]:
    """The parameters of an optimiser, in order."""
    return [p for group in optimizer.param_groups for p in group["params"]]


def set_lr(optimizer: torch.optim.Optimizer, lr: float) -> None:
    """Set the learning rate."""
    for group in optimizer.param_groups:
        group["lr"] = lr


def half_cosine(fraction: float) -> float:
    """A factor on a learning rate that falls from 1 to 0 along half a cosine."""
    return 0.5 * (1.0 + math.cos(math.pi * fraction))


def halved(step: int, half_life: int) -> float:
    """A factor that halves every ``half_life`` steps; with 0, it is always 1."""
    return 0.5 ** (step / half_life) if half_life else 1.0


def minimize(optimizer: torch.optim.Optimizer, loss: Tensor) -> None:
    """Take a gradient step on the optimiser's parameters only."""
    parameters = parameters_of(optimizer)
    gradients = torch.autograd.grad(loss, parameters)
    for parameter, gradient in zip(parameters, gradients, strict=True):
        # Convolutions of images may give gradients with another order in memory, which fused
        # optimisers do not see: they would update the wrong weights.
        parameter.grad = gradient.contiguous()
    optimizer.step()


def optimizer_arrays(optimizer: torch.optim.Optimizer) -> dict[str, NDArray[np.float32]]:
    """An optimiser's moments and step counts, by name."""
    return {
        f"{number}/{name}": value.cpu().numpy().copy()
        for number, parameter in enumerate(parameters_of(optimizer))
        for name, value in optimizer.state.get(parameter, {}).items()
    }


def load_optimizer(
    optimizer: torch.optim.Optimizer, arrays: Mapping[str, NDArray[np.float32]]
) -> None:
    """Restore the state that `optimizer_arrays` returned."""
    optimizer.state.clear()
    parameters = parameters_of(optimizer)
    for name, array in arrays.items():
        number, _, key = name.partition("/")
        parameter = parameters[int(number)]
        value = torch.from_numpy(array.copy()).to(parameter.device)
        optimizer.state[parameter][key] = value


def state_arrays(
    modules: Mapping[str, nn.Module], optimizers: Mapping[str, torch.optim.Optimizer]
) -> dict[str, NDArray[np.float32]]:
    """The state of modules and optimisers, by name."""
    arrays = {
        f"{part}/{name}": as_array(value)
        for part, module in modules.items()
        for name, value in module.state_dict().items()
    }
    for part, optimizer in optimizers.items():
        arrays |= {f"{part}/{name}": a for name, a in optimizer_arrays(optimizer).items()}
    return arrays


def load_state(
    arrays: Mapping[str, NDArray[np.float32]],
    modules: Mapping[str, nn.Module],
    optimizers: Mapping[str, torch.optim.Optimizer],
) -> None:
    """Restore the state that `state_arrays` returned.

    Raises:
        KeyError: Something is missing.
        RuntimeError: Something has another shape.
    """
    for part, module in modules.items():
        names = module.state_dict()
        module.load_state_dict(
            {name: torch.from_numpy(arrays[f"{part}/{name}"].copy()) for name in names}
        )
    for part, optimizer in optimizers.items():
        own = {n: array for n, array in arrays.items() if n.startswith(f"{part}/")}
        load_optimizer(optimizer, {n.removeprefix(f"{part}/"): a for n, a in own.items()})
