"""Networks: actors, and critics that are evaluated many at once."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.optim.adam import adam

COLUMNS = 16
"""A matrix product with fewer columns takes two to three times as long as one with so many."""


class Linears(nn.Module):
    """Several linear layers of one shape, applied at once: (count, n, ins) to (count, n, outs)."""

    def __init__(self, count: int, ins: int, outs: int, generator: torch.Generator) -> None:
        super().__init__()
        bound = 1.0 / math.sqrt(ins)  # torch's own, and most libraries', for linear layers
        self.weight = nn.Parameter(_uniform((count, ins, outs), bound, generator))
        self.bias = nn.Parameter(_uniform((count, 1, outs), bound, generator))

    def forward(self, inputs: Tensor) -> Tensor:
        """Apply the layers, the first so many, each to its own part of the inputs."""
        weight: Tensor = self.weight
        bias: Tensor = self.bias
        if len(inputs) < len(weight):
            weight, bias = weight[: len(inputs)], bias[: len(inputs)]
        outs = weight.shape[2]
        if outs == 1:  # then a sum takes less time than any product
            return (inputs * weight.mT).sum(2, keepdim=True).add_(bias)
        if outs < COLUMNS:
            wide = nn.functional.pad(weight, (0, COLUMNS - outs))
            return torch.bmm(inputs, wide)[..., :outs] + bias
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
        self.parameters: list[Tensor] = [p for module in modules for p in module.parameters()]
        self.lr = lr
        self._moments: dict[str, list[Tensor]] = {}

    def minimize(self, loss: Tensor) -> None:
        """Take a step down the gradient, of these parameters and no others."""
        gradients = list(torch.autograd.grad(loss, self.parameters))
        if not self._moments:
            self._moments = _beginning(self.parameters)
        with torch.no_grad():
            # The optimiser's function: its class takes longer than that does for small networks.
            adam(
                self.parameters,
                gradients,
                self._moments["exp_avg"],
                self._moments["exp_avg_sq"],
                [],
                self._moments["step"],
                fused=True,
                amsgrad=False,
                beta1=0.9,
                beta2=0.999,
                lr=self.lr,
                weight_decay=0.0,
                eps=1e-8,
                maximize=False,
            )

    def arrays(self) -> dict[str, NDArray[np.float32]]:
        """Its moments and step counts, by name."""
        return {
            f"{number}/{name}": value.numpy().copy()
            for name, values in self._moments.items()
            for number, value in enumerate(values)
        }

    def load(self, arrays: Mapping[str, NDArray[np.float32]]) -> None:
        """Take moments and step counts over, in place of what there is."""
        self._moments = _beginning(self.parameters) if arrays else {}
        for name, array in arrays.items():
            number, _, key = name.partition("/")
            self._moments[key][int(number)] = torch.from_numpy(array.copy())


def _beginning(parameters: Sequence[Tensor]) -> dict[str, list[Tensor]]:
    """Steps so far, and both moments, of every parameter."""
    return {
        "step": [torch.zeros(()) for _ in parameters],
        "exp_avg": [torch.zeros_like(parameter) for parameter in parameters],
        "exp_avg_sq": [torch.zeros_like(parameter) for parameter in parameters],
    }
