"""Codes of what checking an environment shows: TB57x."""

from __future__ import annotations

from taskbuilder.diagnostics.entry import Code, Example

_OURS = " No known task fails this check. If yours does, please report it."

ENTRIES = {
    "TB571": Code(
        "Render returns no picture",
        "`render` does not return a uint8 array of shape (height, width, 3), or all pixels of the "
        "picture have the same colour." + _OURS,
    ),
    "TB572": Code(
        "Memory leak in reset",
        "Each reset leaves behind saved states of the physics engine or more than 100 KB of "
        "memory, and later resets do not free them. Training would run out of memory." + _OURS,
    ),
    "TB573": Code(
        "Episode without an end",
        "The episode does not end after its `episode_steps` control steps." + _OURS,
    ),
    "TB574": Code(
        "Agent without observation",
        "An agent's observation is missing or empty, so the agent cannot learn from it.",
        Example(
            "task",
            "observe: {left: [], right: [self.tcp, cube.position]}",
            "observe: {left: [self.tcp], right: [self.tcp, cube.position]}",
        ),
    ),
    "TB575": Code(
        "Seed without effect",
        "In the same environment, two episodes with the same seed and actions differ. Or the "
        "resets without a seed that follow these two episodes give different initial "
        "observations. Or every seed gives the same initial positions, although the task places "
        "objects at random." + _OURS,
    ),
    "TB576": Code("Reward not finite", "The reward of an agent is not a finite number." + _OURS),
}
"""Code -> what it stands for."""
