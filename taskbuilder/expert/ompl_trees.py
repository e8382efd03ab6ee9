"""RRT-Connect of the Open Motion Planning Library, in place of the own one.

Only for arms that are commanded by their joints, where a posture does not depend on the way there.
The library's seed is one for the whole process: it is set anew for each search, so that a search
repeats itself; but not while other threads use the library.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from importlib import import_module
from typing import Any

import numpy as np

from taskbuilder.errors import UsageError
from taskbuilder.expert.parts import FINE_JOINT, METRES_PER_JOINT_RADIAN, Coordinates
from taskbuilder.expert.spaces import Point, Space
from taskbuilder.expert.trees import STRIDE_M

MOST_LOOKS = 20_000
"""How many postures are looked at before the search is given up."""


def connect(
    space: Space,
    ends: tuple[Point, Point],
    free: Callable[[Point], bool],
    rng: np.random.Generator,
) -> Iterator[list[Coordinates]]:
    """A line with corners from one point to another, if one is found; see `trees.connect`.

    Raises:
        UsageError: The library is not installed.
    """
    base, geometric, util = _library()
    util.setLogLevel(util.LogLevel.LOG_NONE)
    util.RNG.setSeed(int(rng.integers(1, 2**31)))
    looks = 0

    def valid(state: Any) -> bool:
        nonlocal looks
        looks += 1
        return free(space.step(ends[0], _coordinates(space, state)))

    states = base.RealVectorStateSpace(len(space.begin))
    states.setBounds(_bounds(base, space))
    about = base.SpaceInformation(states)
    about.setStateValidityChecker(valid)
    fine = FINE_JOINT * METRES_PER_JOINT_RADIAN
    about.setStateValidityCheckingResolution(fine / states.getMaximumExtent())
    about.setup()
    problem = base.ProblemDefinition(about)
    problem.setStartAndGoalStates(*(_state(states, space, end.at) for end in ends))
    planner = geometric.RRTConnect(about)
    planner.setRange(STRIDE_M)
    planner.setProblemDefinition(problem)
    planner.setup()
    planner.solve(base.PlannerTerminationCondition(lambda: looks > MOST_LOOKS))
    if problem.hasExactSolution():
        found = [_coordinates(space, state) for state in problem.getSolutionPath().getStates()]
        yield [*found[:-1], ends[1].at]


def check_installed() -> None:
    """Refuse to go on without the library.

    Raises:
        UsageError: It is not installed.
    """
    _library()


def _library() -> tuple[Any, Any, Any]:
    try:
        modules = [import_module(f"ompl.{name}") for name in ("base", "geometric", "util")]
    except ImportError as error:
        message = 'planning with OMPL needs the package ompl: pip install "taskbuilder[plan]"'
        raise UsageError(message) from error
    return modules[0], modules[1], modules[2]


def _bounds(base: Any, space: Space) -> Any:
    low, high = (space.weights * ends for ends in space.bounds)
    bounds = base.RealVectorBounds(len(low))
    for index, (least, most) in enumerate(zip(low.tolist(), high.tolist(), strict=True)):
        bounds.setLow(index, least)
        bounds.setHigh(index, most)
    return bounds


def _state(states: Any, space: Space, at: Coordinates) -> Any:
    state = states.allocState()
    for index, value in enumerate((space.weights * at).tolist()):
        state[index] = value
    return state


def _coordinates(space: Space, state: Any) -> Coordinates:
    weights = space.weights.tolist()
    return tuple(state[index] / weight for index, weight in enumerate(weights))
