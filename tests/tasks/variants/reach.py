"""Reach: success and reward."""

from taskbuilder.description import (
    Bonus,
    Closeness,
    Description,
    Distance,
    Ladder,
    Near,
    Sustained,
)


class Reach(Description):
    """The tool is within 3 cm of the ball, and stays there for a second."""

    at_goal = Near("arm.tcp", "goal", within=0.03)

    success = Sustained(at_goal, seconds=1.0)
    stages = {"at goal": at_goal, "kept there": success}
    reward = (
        Distance("reach", "arm.tcp", "goal", agent="arm"),
        Bonus("at goal", at_goal, 0.5, agent="arm"),
    )
    progress = Ladder(Closeness("arm.tcp", "goal", scale=0.3), (at_goal, 2.0), (success, 3.0))
