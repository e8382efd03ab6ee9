"""Spaces of observations and actions, and conversion of values."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from taskbuilder.cameras import CameraView, Image, point_cloud
from taskbuilder.env.actions import RobotActions
from taskbuilder.env.errors import ActionError
from taskbuilder.env.observations import View
from taskbuilder.schema.channels import Channel
from taskbuilder.wording import excerpt

VECTOR = "vector"
"""Key of the numbers in an observation that also has images."""


def observation_space(
    view: View,
    sizes: Mapping[str, tuple[int, int]],
    furthest: Mapping[str, float],
    segments: int,
    *,
    flat: bool,
) -> spaces.Space[Any]:
    """The observation space of a view: a box, or a dictionary if it has images or is not flat.

    Args:
        view: What is observed.
        sizes: Width and height of the images of each camera.
        furthest: The far plane of each camera, m.
        segments: How many names masks have.
        flat: Whether the numbers are one vector.
    """
    images = {
        f"{c.subject}.{c.quantity}": _image_space(
            c, sizes[c.subject], furthest[c.subject], segments
        )
        for c in view.cameras
    }
    numbers = spaces.Box(view.low, view.high, dtype=np.float32)
    if flat:
        return spaces.Dict({VECTOR: numbers, **images}) if images else numbers
    channels = {}
    start = 0
    for reading in view.readings:
        part = slice(start, start + reading.size)
        channels[reading.name] = spaces.Box(view.low[part], view.high[part], dtype=np.float32)
        start += reading.size
    return spaces.Dict({**channels, **images})


def _image_space(channel: Channel, size: tuple[int, int], far: float, segments: int) -> spaces.Box:
    width, height = size
    match channel.quantity:
        case "rgb":
            return spaces.Box(0, 255, (height, width, 3), np.uint8)
        case "depth":
            return spaces.Box(0.0, far, (height, width), np.float32)
        case "mask":
            return spaces.Box(0, segments - 1, (height, width), np.int16)
        case _:
            return spaces.Box(-200.0, 200.0, (height * width, 3), np.float32)


def image_values(channel: Channel, image: Image, view: CameraView) -> NDArray[Any]:
    """The values of a camera channel, in a new array."""
    match channel.quantity:
        case "rgb":
            return image.rgb.copy()
        case "depth":
            return image.depth.copy()
        case "mask":
            return image.mask.copy()
        case _:
            return np.clip(point_cloud(image, view), -200.0, 200.0)


def action_space(actions: RobotActions, *, flat: bool, normalize: bool) -> spaces.Space[Any]:
    """The action space of an agent: a box, or a dictionary of arm and, if it has one, gripper."""
    ones = np.ones(actions.size, dtype=np.float32)
    low = -ones if normalize else actions.low.astype(np.float32)
    high = ones if normalize else actions.high.astype(np.float32)
    if flat:
        return spaces.Box(low, high, dtype=np.float32)
    arm = slice(actions.arm_size)
    parts: dict[str, spaces.Space[Any]] = {"arm": spaces.Box(low[arm], high[arm], dtype=np.float32)}
    if actions.size > actions.arm_size:
        parts["gripper"] = spaces.Box(low[-1:], high[-1:], dtype=np.float32)
    return spaces.Dict(parts)


ACTION_PARTS = ("arm", "gripper")
"""Keys of actions that are dictionaries, in the order of flat ones; some robots lack a gripper."""


def read_action(agent: str, action: Any, space: spaces.Space[Any]) -> NDArray[np.float64]:
    """Convert an agent's action to a vector of numbers.

    Numbers beyond the bounds are accepted and clipped later, because Gaussian policies send them.

    Raises:
        ActionError: It is not of the space's kind or shape, or not finite.
    """
    if isinstance(space, spaces.Dict):
        if not isinstance(action, Mapping) or set(action) != set(space.spaces):
            raise ActionError(agent, space, "is not a mapping with these keys")
        parts = [
            read_action(agent, action[key], space[key])
            for key in ACTION_PARTS
            if key in space.spaces
        ]
        return np.concatenate(parts)
    try:
        array = np.asarray(action)
    except (TypeError, ValueError, RuntimeError) as error:  # such as of PyTorch, with a remedy
        what = f"is {type(action).__name__}, not numbers ({excerpt(error)})"
        raise ActionError(agent, space, what) from None
    if array.dtype.kind not in "fiub":
        own = isinstance(action, np.ndarray)
        kind = f"an array of {array.dtype}" if own else type(action).__name__
        raise ActionError(agent, space, f"is {kind}, not numbers")
    values = array.astype(np.float64)  # a copy: callers use their arrays again
    if values.shape != space.shape:
        raise ActionError(agent, space, f"has shape {values.shape}")
    if not all(map(math.isfinite, values.tolist())):
        raise ActionError(agent, space, "has numbers that are not finite")
    return values
