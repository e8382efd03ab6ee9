"""Executing the stages of an expert in an episode, phase by phase."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import count, product

import numpy as np

from taskbuilder.env.action_encoder import ActionEncoder, Actions
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.expert.planning.planner import Move, Planner, PlanningError, Trajectory
from taskbuilder.expert.script.orders import bring, phases
from taskbuilder.expert.script.situation import (
    Foreseen,
    Go,
    Grip,
    NotHeldError,
    Phase,
    Situation,
)
from taskbuilder.expert.script.troubles import (
    StageError,
    grip_missed,
    lost_on_the_way,
    not_arrived,
)
from taskbuilder.geometry import Pose
from taskbuilder.schema.expert import ExpertStage, Repeat, Together, Wait, listed
from taskbuilder.schema.order import Order
from taskbuilder.schema.scene import SceneSpec
from taskbuilder.world.world import World

SETTLE_S = 0.6
"""Time for a motion to arrive after its last command, in seconds."""

DISTURBED_S = 1.5
"""The same where actions are disturbed: a disturbed step takes another one to correct."""

GRIP_S = 1.0
"""Time for a gripper to hold or release an object, in seconds."""

PART_S = 0.4
"""Time for which an open gripper may still touch a released object, in seconds."""

OPEN = 0.5
"""Opening from which a gripper counts as open; it opens further while the arm moves."""

LOST_STEPS = 2
"""Control steps without a grip after which a load counts as lost; one may be a bump."""

BY_HAND = 0.05
"""Tolerance of what people do by hand: metres, or rad for a joint that turns."""

CORRECTIONS = 2
"""Maximum number of corrections for a load that has slipped in the gripper."""


ScriptStep = tuple[Order | Together, Phase]
"""A phase, and the order that it is of."""


class Executor:
    """Plays stages in a running episode: yields actions and checks their results.

    It is the `orders.Situation` of its orders.

    Args:
        env: The environment; the caller steps it with each action before asking for the next.
        planner: Plans its motions.
        without: Robots that do not take part.
        seed: Seed of the planner.
        steered: Robots that people steer; the executor waits until their orders are done.
        disturbed: Whether others are carried out than the actions that it yields.

    Attributes:
        encoder: Encodes commands as actions.
        planning_s: Wall time of planning so far, in seconds.
    """

    def __init__(
        self,
        env: TaskEnv,
        planner: Planner,
        without: frozenset[str],
        seed: int,
        steered: frozenset[str] = frozenset(),
        *,
        disturbed: bool = False,
    ) -> None:
        self.encoder = ActionEncoder(env, corrects=disturbed)
        self.planning_s = 0.0
        self._env = env
        self._planner = planner
        self._without = without | steered
        self._steered = steered
        self._disturbed = disturbed
        self._rng = np.random.default_rng([seed, 1])
        self._stopped: set[str] = set()

    # --- the situation

    @property
    def world(self) -> World:
        """The world of the episode."""
        return self._env.episode.world

    @property
    def scene(self) -> SceneSpec:
        """The scene that was built."""
        return self.world.scene

    def pose(self, frame: str) -> Pose:
        """A named frame in the world."""
        return self._env.episode.world.pose(frame)

    def tool(self, robot: str) -> Pose:
        """The commanded pose of a robot's tcp, in the world."""
        arm = self._env.episode.actions[robot].arm
        return arm.base_from_world.inverse() @ arm.ik.forward(arm.robot.commanded())

    def load(self, robot: str) -> str | None:
        """The object that a robot holds."""
        world = self._env.episode.world
        return next((name for name in world.movable if world.held(name, robot)), None)

    def handle(self, robot: str) -> str | None:
        """The link of an articulated object that a robot holds, such as ``chest.lid``."""
        links = (
            f"{name}.{link}"
            for name, obj in self.world.objects.items()
            if obj.joints
            for link in obj.boxes
        )
        return next((link for link in links if self.world.held(link, robot)), None)

    def joint(self, name: str) -> float:
        """Position of an articulated object's joint, in rad or m."""
        return self.world.joint(name)

    def is_open(self, robot: str) -> bool:
        """Whether a robot's gripper is open."""
        return self._env.episode.world.robots[robot].opening() > OPEN

    # --- stages

    def play(self, stage: ExpertStage) -> Iterator[Actions]:
        """Play a stage.

        Raises:
            StageError: It cannot be done.
        """
        if isinstance(stage, Together):
            yield from self._together(stage)
        elif isinstance(stage, Wait):
            yield from self._wait(stage)
        elif isinstance(stage, Repeat):
            for _ in range(stage.repeat):
                if stage.unless is not None and self._holds(stage.unless):
                    return
                begun = self._env.episode.steps
                for inner in stage.stages:
                    yield from self.play(inner)
                if self._env.episode.steps == begun:
                    return  # nothing moved, so another round would change nothing
        else:
            theirs = {r: listed(o)[-1] for r, o in stage.items() if r in self._steered}
            yield from self._await(phases(robot, order) for robot, order in theirs.items())
            yield from self._each({r: o for r, o in stage.items() if r not in self._without})

    def _each(self, orders: Mapping[str, Order | tuple[Order, ...]]) -> Iterator[Actions]:
        """Play orders in parallel: the first phases of all, then the second, and so on."""
        queues: dict[str, deque[ScriptStep]] = {
            robot: deque((order, phase) for order in listed(own) for phase in phases(robot, order))
            for robot, own in orders.items()
        }
        while any(queues.values()):
            # Orders with `bring` come first, so that the others find objects at their goals.
            waiting = (item for item in queues.items() if item[1])
            first = sorted(waiting, key=lambda item: not item[1][0][0].bring)
            yield from self._act(dict(first))

    def _together(self, stage: Together) -> Iterator[Actions]:
        robots = tuple(robot for robot in stage.together if robot not in self._without)
        if self._steered.intersection(stage.together):
            yield from self._await([[partial(bring, robots=stage.together, order=stage)]])
        elif robots:
            name = " and ".join(robots)
            phase = partial(bring, robots=robots, order=stage)
            yield from self._act({name: deque([(stage, phase)])})

    def _wait(self, stage: Wait) -> Iterator[Actions]:
        patience = count() if self._steered else range(self._steps(stage.within))
        for _ in patience:
            if self._holds(stage.until):
                return
            yield self.encoder.hold()
        if not self._holds(stage.until):
            message = f'"{stage.until}" did not become true within {stage.within:g} s'
            raise StageError(f"wait {stage}", "", "timed out", message)

    def _await(self, people: Iterable[Sequence[Phase]]) -> Iterator[Actions]:
        """Hold still until people have done what orders, given by their phases, lead to."""
        waiting = list(people)
        while not all(map(self._is_done, waiting)):
            yield self.encoder.hold()

    def _is_done(self, order: Sequence[Phase]) -> bool:
        """Whether the last phase is done that concerns more than where a tool is."""
        for phase in reversed(order):
            try:
                act = phase(self)
            except NotHeldError:
                return False
            if isinstance(act, Grip):
                return self._has_gripped(act)
            if act is None or act.until:
                return act is None or self._holds(act.until)
            if act.subject:
                return self._gap(act) <= max(act.tolerance or 0.0, BY_HAND)
        return True

    def _holds(self, condition: str) -> bool:
        return self._env.episode.outcome.conditions[condition]

    def _steps(self, seconds: float) -> int:
        return max(1, math.ceil(seconds * self._env.episode.world.spec.timing.control_hz))

    # --- phases

    def _act(self, queues: Mapping[str, deque[ScriptStep]]) -> Iterator[Actions]:
        """Play the next phase of several orders at the same time."""
        acts, steps = self._next(queues)
        labels = {who: f"{who}: {order}" for who, (order, _) in steps.items()}
        goes = {who: act for who, act in acts.items() if isinstance(act, Go)}
        grips = {who: act for who, act in acts.items() if isinstance(act, Grip)}
        if grips:
            yield self.encoder.actions(openings={g.robot: g.opening for g in grips.values()})
            for _ in range(self._env.episode.longest_delay):
                yield self.encoder.hold()
        self._stopped.clear()
        if goes:
            yield from self._go(goes, labels)
            for _ in range(CORRECTIONS):
                if not (wrong := self._corrections(goes, steps)):
                    break
                yield from self._go(wrong, labels)
            self._check_arrived(goes, labels)
        yield from self._check_grips(grips, labels)

    def _next(
        self, queues: Mapping[str, deque[ScriptStep]]
    ) -> tuple[dict[str, Go | Grip], dict[str, ScriptStep]]:
        """The next motions and grips, and their phases.

        Phases that are already done are skipped. What one robot moves is predicted at its goal for
        the others.
        """
        acts: dict[str, Go | Grip] = {}
        steps: dict[str, ScriptStep] = {}
        moved: dict[str, Pose] = {}
        for who, queue in queues.items():
            act = None
            while queue and act is None:
                steps[who] = queue.popleft()
                act = _next_act(who, steps[who], Foreseen(self, moved))
            if act is not None:
                acts[who] = act
            if isinstance(act, Go) and act.brings:
                (robot, _), *_ = act.choices[0].carriers.items()
                moved[self.load(robot) or act.brings] = act.choices[0].goal
            elif isinstance(act, Go):
                moved |= act.moved(self)
        return acts, steps

    def _go(self, goes: Mapping[str, Go], labels: Mapping[str, str]) -> Iterator[Actions]:
        """Play motions in parallel, until all have arrived or have failed to."""
        moves, trajectory = self._plan(goes, labels)
        loads = {r: load for move in moves for r in move.carriers if (load := self.load(r))}
        handles = {r: go for go in goes.values() for r in go.choices[0].carriers if go.holds}
        loads |= {robot: go.holds for robot, go in handles.items()}
        missed = dict.fromkeys(loads, 0)
        for step in range(trajectory.steps):
            still = self._stop(goes)
            joints = {r: path[step] for r, path in trajectory.joints.items() if r not in still}
            if not joints:
                break
            yield self.encoder.actions(joints)
            self._check_loads(loads, handles, missed, labels)
        # Policies do not observe the delay of an episode, so demonstrations must not depend on it.
        late = self._env.episode.longest_delay
        for waited in range(late + self._steps(DISTURBED_S if self._disturbed else SETTLE_S)):
            self._stop(goes)
            if waited >= late and all(self._has_arrived(who, go) for who, go in goes.items()):
                break
            yield self.encoder.hold()
            self._check_loads(loads, handles, missed, labels)

    def _plan(
        self, goes: Mapping[str, Go], labels: Mapping[str, str]
    ) -> tuple[tuple[Move, ...], Trajectory]:
        """The first combination of choices for which a plan is found."""
        held = {robot: load for robot in self._env.possible_agents if (load := self.load(robot))}
        first: PlanningError | None = None
        started = time.perf_counter()
        for moves in product(*(go.choices for go in goes.values())):
            try:
                trajectory = self._planner.plan(moves, held=held, rng=self._rng)
            except PlanningError as blocked:
                first = first or blocked
            else:
                return moves, trajectory
            finally:
                self.planning_s += time.perf_counter() - started
                started = time.perf_counter()
        if first is None:
            raise ValueError("a motion has at least one way to be done")
        raise StageError(
            _whose(first.robot, labels), first.robot, first.cause, str(first)
        ) from None

    # --- checks during and after motions

    def _check_loads(
        self,
        loads: Mapping[str, str],
        handles: Mapping[str, Go],
        missed: dict[str, int],
        labels: Mapping[str, str],
    ) -> None:
        world = self._env.episode.world
        for robot, load in loads.items():
            missed[robot] = 0 if world.held(load, robot) else missed[robot] + 1
            if missed[robot] > LOST_STEPS:
                message = lost_on_the_way(world, robot, load, handles.get(robot))
                raise StageError(_whose(robot, labels), robot, "lost on the way", message)

    def _corrections(
        self, goes: Mapping[str, Go], steps: Mapping[str, ScriptStep]
    ) -> dict[str, Go]:
        """Corrected motions of loads, pushed objects and joints that have not arrived."""
        late = [who for who, go in goes.items() if go.subject and not self._has_arrived(who, go)]
        corrections = {}
        for who in late:
            act = _next_act(who, steps[who], self)
            if isinstance(act, Go):
                corrections[who] = replace(act, tolerance=goes[who].tolerance)
        return corrections

    def _stop(self, goes: Mapping[str, Go]) -> set[str]:
        """Stop motions whose condition holds now; the robots whose motions have stopped."""
        self._stopped |= {who for who, go in goes.items() if go.until and self._holds(go.until)}
        stopped = (go for who, go in goes.items() if who in self._stopped)
        return {robot for go in stopped for robot in go.choices[0].carriers}

    def _has_arrived(self, who: str, go: Go) -> bool:
        if go.until:
            return who in self._stopped
        return go.tolerance is None or self._gap(go) <= go.tolerance

    def _gap(self, go: Go) -> float:
        """The remaining distance of a motion, in metres, or in rad for a joint that turns."""
        if go.gap is not None:
            return go.gap(self)
        move = go.choices[0]
        (robot, offset), *_ = move.carriers.items()
        if not go.brings:
            at = self.pose(f"{robot}.tcp").position
            return math.dist(at, (move.goal @ offset).position)
        load = self.load(robot)
        return math.dist(self.pose(load).position, move.goal.position) if load else math.inf

    def _check_arrived(self, goes: Mapping[str, Go], labels: Mapping[str, str]) -> None:
        for who, go in goes.items():
            if not self._has_arrived(who, go):
                robot = next(iter(go.choices[0].carriers))
                message = not_arrived(self.world, robot, go, self._gap(go))
                message += f'; "{go.until}" does not hold' if go.until else ""
                raise StageError(labels[who], robot, "not arrived", message)

    def _check_grips(
        self, grips: Mapping[str, Grip], labels: Mapping[str, str]
    ) -> Iterator[Actions]:
        """Wait until grippers hold or have released their objects."""
        world = self._env.episode.world
        for waited in range(self._steps(GRIP_S)):
            late = waited >= self._steps(PART_S)
            if all(
                self._has_gripped(grip) and (late or self._has_parted(grip))
                for grip in grips.values()
            ):
                break
            yield self.encoder.hold()
        for who, grip in grips.items():
            if not self._has_gripped(grip):
                cause = "still held" if grip.releases else "grasp missed"
                raise StageError(labels[who], grip.robot, cause, grip_missed(world, grip))

    def _has_gripped(self, grip: Grip) -> bool:
        world = self._env.episode.world
        gripper = world.robots[grip.robot].gripper
        if grip.releases:
            held = bool(grip.load) and world.held(grip.load, grip.robot)
            return not held and (not gripper.moves() if grip.inside else self.is_open(grip.robot))
        if grip.load:
            return world.held(grip.load, grip.robot) and not gripper.closes()
        return not gripper.moves()

    def _has_parted(self, grip: Grip) -> bool:
        """Whether a gripper that lets go no longer touches the object that it held."""
        world = self._env.episode.world
        return not (grip.releases and grip.load) or not world.fingers_touch(grip.load, grip.robot)


def _next_act(who: str, step: ScriptStep, now: Situation) -> Go | Grip | None:
    """The motion or grip of a phase.

    Raises:
        StageError: A robot does not hold what its order takes.
    """
    order, phase = step
    try:
        return phase(now)
    except NotHeldError as error:
        cause, message = "lost on the way", str(error)
        raise StageError(f"{who}: {order}", error.robot, cause, message) from None


def _whose(robot: str, labels: Mapping[str, str]) -> str:
    """The order of a robot."""
    mine = [text for who, text in labels.items() if robot in who.split(" and ")]
    return mine[0] if mine else ", ".join(labels.values())
