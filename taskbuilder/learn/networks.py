"""Networks: actors, and critics that are evaluated many at once."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn


class Linears(nn.Module):
    """Several linear layers of one shape, applied at once: (count, n, ins) to (count, n, outs)."""

    def __init__(self, count: int, ins: int, outs: int, generator: torch.Generator) -> None:
        super().__init__()
        bound = 1.0 / math.sqrt(ins)  # torch's own, and most libraries', for linear layers
        self.weight = nn.Parameter(_uniform((count, ins, outs), bound, generator))
        self.bias = nn.Parameter(_uniform((count, 1, outs), bound, generator))

    def forward(self, inputs: Tensor) -> Tensor:
        """Apply the layers, the first so many, each to its own part of the inputs."""
        weight, bias = self.weight[: len(inputs)], self.bias[: len(inputs)]
        if weight.shape[2] == 1:  # a product with one column is many times slower than a sum
            return (inputs * weight.mT).sum(2, keepdim=True).add_(bias)
        return torch.bmm(inputs, weight).add_(bias)


class Networks(nn.Module):
    """Several multilayer perceptrons of one shape, evaluated at once.

    Linear, layer norm where wanted, ReLU, ..., linear. On a CPU, four small networks one after the
    other take much longer than all at once. The norms (Ba et al. 2016) have no gain and bias of
    their own, which the linear layers around them make up for.

    Args:
        count: How many.
        sizes: Of the input, the hidden layers and the output.
        generator: Draws the initial weights.
        norms: Whether hidden layers are normalised.
        last: What the initial weights of the last layer are multiplied by.
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
            inputs: (n, ins), the same for each, or (count, n, ins), a part for each.
            first: Only the first so many networks.

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


def _uniform(shape: tuple[int, ...], bound: float, generator: torch.Generator) -> Tensor:
    return (torch.rand(shape, generator=generator) * 2.0 - 1.0) * bound


def follow(target: nn.Module, source: nn.Module, share: float) -> None:
    """Move a target network towards its source by a share of the way."""
    with torch.no_grad():
        torch._foreach_lerp_(list(target.parameters()), list(source.parameters()), share)


class Adam:
    """Adam (Kingma and Ba 2015) over the parameters of modules, in one fused call a step.

    Args:
        modules: What it optimises.
        lr: The step size.

    Attributes:
        parameters: Of the modules, in order.
        lr: The step size from the next step on.
    """

    def __init__(self, modules: Iterable[nn.Module], lr: float) -> None:
        self.parameters = [p for module in modules for p in module.parameters()]
        self.lr = lr
        self._adam = torch.optim.Adam(self.parameters, lr=lr, fused=True)

    def minimize(self, loss: Tensor) -> None:
        """Take a step down the gradient, of these parameters and no others."""
        gradients = torch.autograd.grad(loss, self.parameters)
        for parameter, gradient in zip(self.parameters, gradients, strict=True):
            parameter.grad = gradient
        self._adam.param_groups[0]["lr"] = self.lr
        self._adam.step()

    def arrays(self) -> dict[str, NDArray[np.float32]]:
        """Its moments and step counts, by name."""
        return {
            f"{number}/{name}": value.numpy().copy()
            for number, parameter in enumerate(self.parameters)
            for name, value in self._adam.state[parameter].items()
        }

    def load(self, arrays: Mapping[str, NDArray[np.float32]]) -> None:
        """Take moments and step counts over, in place of what there is."""
        self._adam.state.clear()
        for name, array in arrays.items():
            number, _, key = name.partition("/")
            self._adam.state[self.parameters[int(number)]][key] = torch.from_numpy(array.copy())
