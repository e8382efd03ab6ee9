"""Codes of environments, and of their speed: TB52x, TB56x, TB57x and TB58x."""

from __future__ import annotations

from taskbuilder.diagnostics.entry import Code, Example, within

_OURS = " No known task fails this check. If yours does, please report it."

ENTRIES = {
    "TB521": Code(
        "PettingZoo's parallel API test",
        "`parallel_api_test` fails on the environment of the task." + _OURS,
    ),
    "TB522": Code(
        "PettingZoo's AEC tests",
        "`api_test` or `seed_test` fails on the turn-based (AEC) environment of the task." + _OURS,
    ),
    "TB523": Code(
        "Gymnasium's environment checker",
        "`check_env` fails on the joint environment (`JointEnv`), in which one agent controls all "
        "robots. For example, it fails if an episode has only one control step.",
        within(
            "",
            "timing: {control_hz: 10, physics_hz: 120, episode_steps: 1}",
            "timing: {control_hz: 10, physics_hz: 120, episode_steps: 50}",
        ),
    ),
    "TB524": Code(
        "Observation outside its space",
        "An observation does not have the shape or dtype of its space, lies outside the bounds of "
        "the space, or contains NaN. taskbuilder clips observations to these bounds. No known "
        "task fails this check unless its description changes values of the world.",
    ),
    "TB525": Code(
        "Constant observation",
        "The observation of an agent never changes during an episode. Or, when the same actions "
        "are played, the agent's observations are the same in every episode, although the initial "
        "positions differ. The agent cannot learn from such observations.",
        Example(
            "task",
            "observe: {left: [goal.position], right: [self.tcp, cube.position]}",
            "observe: {left: [self.tcp, cube.position], right: [self.tcp, cube.position]}",
        ),
    ),
    "TB526": Code(
        "Observations shared between agents",
        "Two agents have exactly the same observations and neither observes itself, so neither "
        "agent can tell which of the two it is. Or observations share memory. Then writing into "
        "one observation changes another observation or the episode, or the next step changes an "
        "observation that was returned earlier.",
        Example(
            "task",
            "observe: {left: [cube.pose, time_left], right: [cube.pose, time_left]}",
            "observe: {left: [self.tcp, cube.pose], right: [self.tcp, cube.pose]}",
        ),
    ),
    "TB527": Code(
        "Space recreated on every call",
        "`observation_space` or `action_space` returns a new object on every call, so seeding the "
        "space has no effect." + _OURS,
    ),
    "TB561": Code(
        "Speed and cost",
        "Three measurements, which neither pass nor fail. The first is the number of control "
        "steps per second. The second is the overhead of a control step: the time that it takes "
        "in addition to its physics steps, as a multiple of the duration of one physics step. The "
        "third is the median duration of a reset.",
    ),
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
