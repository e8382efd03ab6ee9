"""Encoders of pictures, evaluated without torch: where in a picture its learned features are."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from taskbuilder.policies.trained import Array32

KERNELS = (5, 3, 3)
STRIDES = (2, 2, 1)
"""Sizes and strides of the convolutions, which have no padding."""

SHARPNESS = 10.0
"""Factor on the feature maps before the softmax, so that it is not flat at the beginning."""


@dataclass(frozen=True)
class PictureEncoder:
    """Convolutions with ReLU between them, and a spatial softmax (Finn et al. 2016).

    Attributes:
        layers: Weight (channels in, kernel, kernel, channels out) and bias of each convolution.
    """

    layers: tuple[tuple[Array32, Array32], ...]

    def __post_init__(self) -> None:
        shapes = [weight.shape for weight, _ in self.layers]
        ins = (3, *(shape[-1] for shape in shapes))
        fits = [(i, kernel, kernel) for i, kernel in zip(ins, KERNELS, strict=False)]
        biases = [bias.shape for _, bias in self.layers]
        if [s[:3] for s in shapes] != fits or [s[3:] for s in shapes] != biases:
            raise ValueError("the convolutions do not fit each other")

    @property
    def size(self) -> int:
        """Number of features."""
        return 2 * len(self.layers[-1][1])

    def __call__(self, picture: NDArray[np.uint8]) -> Array32:
        """The expected position of each feature map: (2 maps,), x of all and then y, from -1 to 1.

        Args:
            picture: (height, width, 3) uint8.
        """
        hidden = picture.astype(np.float32) / np.float32(255.0) - np.float32(0.5)
        for number, (weight, bias) in enumerate(self.layers):
            hidden = np.maximum(hidden, 0.0) if number else hidden
            hidden = _convolved(hidden, weight, STRIDES[number]) + bias
        height, width, maps = hidden.shape
        flat = hidden.reshape(-1, maps) * np.float32(SHARPNESS)
        share = np.exp(flat - flat.max(0))
        share = (share / share.sum(0)).reshape(height, width, maps)
        x = np.linspace(-1.0, 1.0, width, dtype=np.float32) @ share.sum(0)
        y = np.linspace(-1.0, 1.0, height, dtype=np.float32) @ share.sum(1)
        return np.concatenate([x, y]).astype(np.float32)

    def arrays(self, camera: str) -> dict[str, Array32]:
        """Its arrays by name, for a file."""
        return {
            f"{camera}{_OF}/{number}/{kind}": array
            for number, layer in enumerate(self.layers)
            for kind, array in zip(("weight", "bias"), layer, strict=True)
        }


_OF = " encoder"
"""What the names of an encoder's arrays have after the camera; no robot has a space in its name."""


def is_of_encoder(name: str) -> bool:
    """Whether an array of a file belongs to an encoder."""
    return name.split("/")[0].endswith(_OF)


def read_encoder(arrays: Mapping[str, Array32], camera: str) -> PictureEncoder:
    """Make the encoder of a camera from the arrays of a file.

    Raises:
        KeyError: Arrays are missing.
        ValueError: They do not fit each other, or are of another kind.
    """
    names = [f"{camera}{_OF}/{number}" for number in range(len(KERNELS))]
    layers = tuple((arrays[f"{name}/weight"], arrays[f"{name}/bias"]) for name in names)
    if any(array.dtype.kind != "f" for layer in layers for array in layer):
        raise ValueError("an encoder has numbers of another kind")
    return PictureEncoder(layers)


def _convolved(picture: Array32, weight: Array32, stride: int) -> Array32:
    """A convolution without padding: (height, width, channels) to the same."""
    kernel = weight.shape[1]
    windows = sliding_window_view(picture, (kernel, kernel), axis=(0, 1))[::stride, ::stride]
    height, width = windows.shape[:2]
    columns = windows.reshape(height * width, -1)
    return (columns @ weight.reshape(-1, weight.shape[3])).reshape(height, width, -1)
