"""The observation of one agent that moves all robots: their numbers in a row, each image once."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal, get_args

import numpy as np
from gymnasium import spaces

from taskbuilder.env.spaces import VECTOR
from taskbuilder.errors import UsageError

PixelLayout = Literal["flat", "nested"]

AGENT_POS = "agent_pos"
"""Key of the numbers in an observation that also has images."""

PIXELS = "pixels"
"""Key of the images in an observation with nested pixels."""

_GROUPS = {"rgb": PIXELS}  # other images are grouped under their own names, such as depth


class JointObservation:
    """Joins the flat observations of all robots.

    Without images it is one vector. With images it is a dictionary of ``agent_pos`` and of the
    images, whose keys are ``pixels/CAMERA``, ``depth/CAMERA`` and so on. With nested pixels there
    is a dictionary by camera under ``pixels``, under ``depth`` and so on.

    Args:
        observed: The observation space of every robot: a box, or a dictionary with images.
        pixels: ``flat`` or ``nested``.

    Attributes:
        space: The observation space.
    """

    def __init__(self, observed: Mapping[str, spaces.Space[Any]], pixels: PixelLayout) -> None:
        self._nested = pixels == "nested"
        self._shown_to: dict[str, str] = {}  # by image, the first robot that observes it
        images: dict[str, spaces.Space[Any]] = {}
        for agent, space in observed.items():
            for name, image in _images(space).items():
                if name not in images:
                    images[name] = image
                    self._shown_to[name] = agent
        numbers = joined_boxes({agent: _numbers(space) for agent, space in observed.items()})
        self.space: spaces.Space[Any] = numbers
        if images:
            self.space = _as_space(self._arranged(numbers, images))

    def join(self, observations: Mapping[str, Any]) -> Any:
        """The joint observation.

        Args:
            observations: The observation of every robot, or arrays of many of them.
        """
        numbers = np.concatenate([_numbers(seen) for seen in observations.values()], axis=-1)
        if not self._shown_to:
            return numbers
        images = {name: observations[agent][name] for name, agent in self._shown_to.items()}
        return self._arranged(numbers, images)

    def _arranged(self, numbers: Any, images: Mapping[str, Any]) -> dict[str, Any]:
        joined: dict[str, Any] = {AGENT_POS: numbers}
        for name, image in images.items():
            camera, _, quantity = name.rpartition(".")
            group = _GROUPS.get(quantity, quantity)
            if self._nested:
                joined.setdefault(group, {})[camera] = image
            else:
                joined[f"{group}/{camera}"] = image
        return joined


def check_pixels(pixels: str, *, flat: bool) -> None:
    """Check how images are to be arranged, before anything is built.

    Raises:
        UsageError: There is no such arrangement, or it does not go with ``flat=False``.
    """
    if pixels not in get_args(PixelLayout):
        raise UsageError(f'pixels is {pixels!r}; "flat" or "nested"')
    if pixels == "nested" and not flat:
        raise UsageError('pixels="nested" does not go with flat=False, whose keys are robots')


def joined_boxes(boxes: Mapping[str, spaces.Space[Any]]) -> spaces.Box:
    """Concatenate boxes in order."""
    parts = [box for box in boxes.values() if isinstance(box, spaces.Box)]
    low = np.concatenate([box.low for box in parts])
    high = np.concatenate([box.high for box in parts])
    return spaces.Box(low, high, dtype=np.float32)


def _images(space: spaces.Space[Any]) -> dict[str, spaces.Space[Any]]:
    if not isinstance(space, spaces.Dict):
        return {}
    return {name: image for name, image in space.items() if name != VECTOR}


def _numbers(seen: Any) -> Any:
    """The vector of a flat observation, or the box of a flat space."""
    return seen[VECTOR] if isinstance(seen, dict | spaces.Dict) else seen


def _as_space(arranged: Mapping[str, Any]) -> spaces.Dict:
    return spaces.Dict(
        {key: _as_space(one) if isinstance(one, dict) else one for key, one in arranged.items()}
    )
