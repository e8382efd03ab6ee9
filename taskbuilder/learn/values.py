"""The outputs of critics: a value, or a categorical distribution over returns."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any, Protocol

import numpy as np
import torch
from torch import Tensor

from taskbuilder.arrays import Arrays
from taskbuilder.errors import UsageError
from taskbuilder.learn.networks import Networks, layers_of

SMOOTHING = 0.75
"""Standard deviation of target distributions, in bins (Farebrother et al. 2024)."""

TOO_MANY = 0.02
"""Average fraction of targets beyond the range from which on the range is doubled."""

UPDATES = 100
"""Updates over which this fraction is averaged, exponentially."""

UNLIKELY = -10.0
"""Logit of the bins that are added when the range is doubled."""


class Values(Protocol):
    """What critics' outputs mean, and how they are trained."""

    outputs: int
    """Outputs of a critic."""

    def mean(self, out: Tensor) -> Tensor:
        """The values (...) of outputs (..., outputs)."""
        ...

    def errors(self, out: Tensor, targets: Tensor) -> Tensor:
        """The losses (...) of outputs (..., outputs) for target values (...)."""
        ...

    def adapt_(self, targets: Tensor, critics: Iterable[Networks]) -> None:
        """Adapt to the size of the targets; the values of these critics stay what they are."""
        ...

    def arrays(self) -> Arrays:
        """The state, by name."""
        ...

    def load(self, arrays: Mapping[str, Any]) -> None:
        """Restore the state that `arrays` returned."""
        ...


class ScalarValues:
    """Critics with one output, the value, trained by the squared error."""

    outputs = 1

    def mean(self, out: Tensor) -> Tensor:
        """See `Values`."""
        return out[..., 0]

    def errors(self, out: Tensor, targets: Tensor) -> Tensor:
        """See `Values`."""
        return (out[..., 0] - targets).square()

    def adapt_(self, targets: Tensor, critics: Iterable[Networks]) -> None:
        """See `Values`; a scalar has no range."""

    def arrays(self) -> Arrays:
        """See `Values`."""
        return {}

    def load(self, arrays: Mapping[str, Any]) -> None:
        """See `Values`."""


class CategoricalValues:
    """Critics with a categorical distribution over returns, trained by cross-entropy.

    The outputs are the logits of evenly spaced bins; the value is the mean of the distribution. The
    target distribution is a normal distribution around the target value (HL-Gauss, Imani and White
    2018). Its loss is less sensitive to the scale of the values, and to outliers, than the squared
    error (Farebrother et al. 2024). Where targets lie beyond the range of the bins, it is doubled.

    Args:
        bins: Number of bins, a multiple of 4.
        limit: The first range: from -limit to limit.
        device: Device of the critics.

    Raises:
        UsageError: The bins or the limit cannot be used.
    """

    def __init__(self, bins: int, limit: float, device: torch.device) -> None:
        if bins < 4 or bins % 4:
            raise UsageError(f"value_bins={bins}: use a multiple of 4, or 0 for a scalar value")
        if not 0.0 < limit < math.inf:
            raise UsageError(f"value_limit={limit}: use a number above 0")
        self.outputs, self._device = bins, device
        self._set(limit, 0.0)

    def _set(self, limit: float, beyond: float) -> None:
        self._limit, self._beyond = limit, beyond
        self._edges = torch.linspace(-limit, limit, self.outputs + 1, device=self._device)
        self._centres = (self._edges[1:] + self._edges[:-1]) / 2.0
        self._width = 2.0 * limit / self.outputs

    def mean(self, out: Tensor) -> Tensor:
        """See `Values`."""
        return out.softmax(-1) @ self._centres

    def errors(self, out: Tensor, targets: Tensor) -> Tensor:
        """See `Values`; this is the cross-entropy."""
        return -(self.probabilities(targets) * out.log_softmax(-1)).sum(-1)

    def probabilities(self, targets: Tensor) -> Tensor:
        """The target distributions (..., bins) of target values (...)."""
        most = self._limit - self._width
        distances = self._edges - targets.clamp(-most, most)[..., None]
        below = torch.erf(distances / (SMOOTHING * self._width * math.sqrt(2.0)))
        shares = below.diff(dim=-1)
        return shares / (below[..., -1:] - below[..., :1])

    def adapt_(self, targets: Tensor, critics: Iterable[Networks]) -> None:
        """See `Values`."""
        share = float((targets.abs() > self._limit - self._width).float().mean())
        self._beyond += (share - self._beyond) / UPDATES
        if self._beyond > TOO_MANY:
            for networks in critics:
                _halve_bins_(networks)
            self._set(2.0 * self._limit, 0.0)

    def arrays(self) -> Arrays:
        """The range of the bins, and how often targets lay beyond it."""
        return {"value_range": np.array([self._limit, self._beyond])}

    def load(self, arrays: Mapping[str, Any]) -> None:
        """Restore what `arrays` returned.

        Raises:
            KeyError: Something is missing.
        """
        self._set(*(float(number) for number in arrays["value_range"]))


def make_values(bins: int, limit: float, device: torch.device) -> Values:
    """`CategoricalValues`, or `ScalarValues` for no bins.

    Raises:
        UsageError: The bins or the limit cannot be used.
    """
    return CategoricalValues(bins, limit, device) if bins else ScalarValues()


def _halve_bins_(networks: Networks) -> None:
    """Merge pairs of bins into the middle half of the bins of twice the width."""
    last = layers_of(networks)[-1]
    with torch.no_grad():
        for parameter, added in ((last.weight, 0.0), (last.bias, UNLIKELY)):
            merged = parameter.unflatten(-1, (-1, 2)).mean(-1)
            sides = torch.full_like(merged[..., : merged.shape[-1] // 2], added)
            parameter.copy_(torch.cat([sides, merged, sides], -1))
