"""Codes of what checking an environment shows: TB57x and TB58x."""

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
    "TB577": Code(
        "Observation differs from the scene",
        "A number that an agent observes, or a number of the state, is not what its name says: "
        "the physics engine has another value at this control step. For example, observations "
        "are one step late, agents have each other's observations, or the state never changes."
        + _OURS,
    ),
    "TB578": Code(
        "Picture differs from the camera's",
        "An observed picture, or that of `render`, is not what its camera sees at this control "
        "step. For example, it never changes although the robots move in it." + _OURS,
    ),
    "TB579": Code(
        "Reward or info differs from the description",
        "The reward of an agent, or an info such as `team_reward`, is not what the description "
        "gives at this control step. For example, infos have another reward than the one that is "
        "returned." + _OURS,
    ),
    "TB581": Code(
        "Wrong termination or truncation",
        "`terminated` is true although neither success nor failure ends the episode, or the other "
        "way round; or `truncated` is true although the episode has not reached its length, or "
        "the other way round. Learners value the state after a truncation, but not after a "
        "termination." + _OURS,
    ),
    "TB582": Code(
        "Wrong success or failure in infos",
        "An info about success or failure is not what the description says of this episode. For "
        "example, `failed` is still 1 after a reset." + _OURS,
    ),
    "TB583": Code(
        "Actions not carried out",
        "A robot is commanded to do something else than its action says. For example, actions are "
        "halved, or the joint action is divided among the robots in another order than that of "
        "`action_names`." + _OURS,
    ),
    "TB584": Code(
        "Vector environment differs",
        "With the same seed and actions, a row of a vector environment returns something else "
        "than a single environment." + _OURS,
    ),
}
"""Code -> what it stands for."""
