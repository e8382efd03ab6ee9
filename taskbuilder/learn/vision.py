"""Encoders of pictures as they are trained; those of `taskbuilder.policies` are the same."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, cast

import torch
from torch import Tensor, nn

from taskbuilder.learn.networks import as_array
from taskbuilder.policies.pictures import KERNELS, SHARPNESS, STRIDES, PictureEncoder
from taskbuilder.policies.trained import Array32


class PictureEncoders(nn.ModuleDict):
    """An encoder for each camera: convolutions, and the positions of their feature maps.

    Args:
        cameras: The cameras.
        channels: Channels of each convolution.
        generator: Generator of the initial weights.
    """

    def __init__(
        self, cameras: Sequence[str], channels: Sequence[int], generator: torch.Generator
    ) -> None:
        super().__init__({camera: _convolutions(channels, generator) for camera in cameras})
        self.size = 2 * channels[-1] * len(cameras)

    def forward(self, pictures: Mapping[str, Tensor]) -> Tensor:
        """Features of all cameras: (n, size), from pictures of (n, height, width, 3) uint8."""
        features = [
            _positions(self[camera](_scaled(images))) for camera, images in pictures.items()
        ]
        return torch.cat(features, 1)

    def frozen(self) -> dict[str, PictureEncoder]:
        """The encoders for a policy, by camera."""
        return {camera: PictureEncoder(_layers(module)) for camera, module in self.items()}


def _layers(module: Any) -> tuple[tuple[Array32, Array32], ...]:
    """Weight (channels in, kernel, kernel, channels out) and bias of each convolution."""
    convolutions = [layer for layer in module if isinstance(layer, nn.Conv2d)]
    return tuple(
        (as_array(layer.weight.permute(1, 2, 3, 0)), as_array(cast(Tensor, layer.bias)))
        for layer in convolutions
    )


def _convolutions(channels: Sequence[int], generator: torch.Generator) -> nn.Sequential:
    layers: list[nn.Module] = []
    ins = 3
    for outs, kernel, stride in zip(channels, KERNELS, STRIDES, strict=True):
        layer = nn.Conv2d(ins, outs, kernel, stride)
        nn.init.kaiming_uniform_(layer.weight, nonlinearity="relu", generator=generator)
        nn.init.zeros_(cast(Tensor, layer.bias))
        layers += [layer, nn.ReLU()]
        ins = outs
    return nn.Sequential(*layers[:-1])


def _scaled(pictures: Tensor) -> Tensor:
    return pictures.permute(0, 3, 1, 2).float() / 255.0 - 0.5


def _positions(maps: Tensor) -> Tensor:
    """The spatial softmax: the expected position of each map, x of all and then y."""
    height, width = maps.shape[2:]
    share = (maps.flatten(2) * SHARPNESS).softmax(2).reshape(maps.shape)
    x = share.sum(2) @ torch.linspace(-1.0, 1.0, width, device=maps.device)
    y = share.sum(3) @ torch.linspace(-1.0, 1.0, height, device=maps.device)
    return torch.cat([x, y], 1)
