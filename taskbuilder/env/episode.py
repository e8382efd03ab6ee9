"""The episode: one world and one referee, stepped by the actions of all agents.

All views of an environment (multi-agent, joint, vector) wrap an `Episode`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taskbuilder.description.description import Outcome, Referee
from taskbuilder.env.actions import RobotActions
from taskbuilder.env.options import Options
from taskbuilder.errors import ExplosionError, UsageError
from taskbuilder.interpreters import Lineage
from taskbuilder.schema.instructions import fill, longest_instruction
from taskbuilder.schema.scene import ActionSpec
from taskbuilder.schema.task import LOOK_PARTS, LookPart
from taskbuilder.sim.single import Single
from taskbuilder.task import Task
from taskbuilder.world.building import build_world
from taskbuilder.world.randomness import EpisodeRandomness, delay_of, longest_delay
from taskbuilder.world.state import WorldState
from taskbuilder.world.world import World

Actions = Mapping[str, NDArray[np.float64]]


@dataclass(frozen=True)
class EpisodeState:
    """A saved state of an episode, for the same environment and process."""

    seed: int
    variation: int
    world: WorldState
    memory: Any
    steps: int
    outcome: Outcome
    succeeded: bool
    failed: bool
    over: bool
    previous: Mapping[str, NDArray[np.float64]]
    noise: Mapping[str, Any]
    waiting: Mapping[str, tuple[NDArray[np.float64], ...]]


class Episode(Single):
    """Runs a task: reset, step, evaluate, save and restore.

    Attributes:
        task: The task.
        options: The options of the environment.
        agents: The robots, in file order.
        actions: The actions of each agent.
        outcome: The referee's outcome of the current control step.
        steps: Control steps taken in this episode.
        succeeded: Success has held at a control step of this episode, before any failure.
        failed: Failure has held at some control step of this episode, or after its reset.
        exploded: The physics diverged; the episode is over and its world is discarded.
        over: No further step is possible before a reset.
        begun: A reset has succeeded.
        taken: All actions since the reset; None if they do not lead to the current state.
        noise_rng: Generator of the observation noise.
        quantities: Values in this episode of what the task lists under ``randomize``.
    """

    def __init__(self, task: Task, options: Options) -> None:
        self.task = task
        self.options = options
        self._file = options.applied(task)
        self.agents = task.agents
        self._worlds: dict[int, World] = {}
        self._closed = False
        self._forks = Lineage.forks
        self._variation = 0 if options.variation == "random" else options.variation
        self._referee = Referee(task.description, self.agents)
        self._force_pairs = self._referee.force_pairs
        self.seed = 0
        self.steps = 0
        self.succeeded = self.failed = self.exploded = False
        self.over = True
        self.begun = False
        self.taken: list[Actions] | None = []
        self.noise_rng = np.random.default_rng(0)
        self.actions = self._make_actions()
        self._previous = {agent: np.zeros(self.actions[agent].size) for agent in self.agents}
        self._waiting: dict[str, tuple[NDArray[np.float64], ...]] = {}
        self.outcome = self._referee.start(self.world)
        self.quantities = self.world.quantities

    # --- stepping

    @property
    def world(self) -> World:
        """The world of the current variation, built on first use.

        Raises:
            UsageError: The environment was closed.
        """
        self.check_usable()
        if self._variation not in self._worlds:
            world = build_world(
                self._file, variation=self._variation, renderer=self.options.renderer
            )
            world.watch_forces(self._force_pairs)
            self._worlds[self._variation] = world
        return self._worlds[self._variation]

    def check_usable(self) -> None:
        """Check that the environment is open, and was made in this process.

        Raises:
            UsageError: It cannot be used here.
        """
        if self._closed:
            raise UsageError("this environment is closed; make another")
        if Lineage.forks != self._forks:
            what = "this environment is used in another process than the one that made it"
            raise UsageError(f"{what}; make one there")

    @property
    def referee(self) -> Referee:
        """The referee, which also explains its outcome."""
        return self._referee

    def meter_robots(self) -> None:
        """Also measure the forces between all pairs of robots; nothing else changes."""
        known = {frozenset(pair) for pair in self._force_pairs}
        pairs = [pair for pair in combinations(self.agents, 2) if frozenset(pair) not in known]
        if pairs:
            self._force_pairs += tuple(pairs)
            for world in self._worlds.values():
                world.watch_forces(self._force_pairs)

    def robot_force(self) -> float:
        """The largest force between two robots in the last control step, in newtons.

        Raises:
            UsageError: It is not measured; see `meter_robots`.
        """
        pairs = combinations(self.agents, 2)
        return max((self.world.contact_force(*pair) for pair in pairs), default=0.0)

    @property
    def variation(self) -> int:
        """The variation of this episode."""
        return self._variation

    @property
    def horizon(self) -> int:
        """Length of an episode in control steps."""
        return self._file.spec.timing.episode_steps

    @property
    def instruction(self) -> str:
        """The instruction of this episode: one of the task's, drawn by the seed and filled in.

        It is the summary of a task without instructions.
        """
        texts = self._file.spec.instructions
        if not texts:
            return self._file.spec.summary
        chosen = int(EpisodeRandomness(self.seed).instruction().integers(len(texts)))
        return fill(texts[chosen], self._file.scenes[self._variation], self.quantities)

    @property
    def longest_instruction(self) -> int:
        """An upper bound of the length of any episode's instruction, in bytes of UTF-8."""
        return longest_instruction(self._file.spec, self._file.scenes)

    @property
    def terminated(self) -> bool:
        """Whether the episode ended by success or failure (see `ends_on`), or by divergence."""
        ends = self._file.spec.timing.ends_on
        won = self.outcome.success and "success" in ends
        lost = self.outcome.failure and "failure" in ends
        return won or lost or self.exploded

    @property
    def truncated(self) -> bool:
        """Whether the episode ended by its length only."""
        return self.steps >= self.horizon and not self.terminated

    def reset(self, seed: int) -> None:
        """Begin an episode; the seed determines everything random in it.

        Raises:
            PlacementError: The objects do not fit.
            ExplosionError: The physics diverged at once.
        """
        self.check_usable()
        randomness = EpisodeRandomness(seed)
        self.over, self.begun = True, False  # until the reset has succeeded
        self.taken = []
        if self.options.variation == "random":
            count = len(self._file.scenes)
            before = self._variation
            self._variation = int(randomness.variation().integers(count))
            if self._variation != before:
                self.actions = self._make_actions()
        self.seed = seed
        self.exploded = self.succeeded = False
        self.steps = 0
        self._waiting = {}
        self.noise_rng = randomness.noise()
        self._previous = {agent: np.zeros(self.actions[agent].size) for agent in self.agents}
        try:
            self.world.reset(seed, randomized=self.options.draws_quantities, looks=self._looks)
        except ExplosionError:
            self._give_up()
            raise
        self.quantities = self.world.quantities
        self.outcome = self._referee.start(self.world)
        self.world.set_locks(self.outcome.conditions)
        self.failed = self.outcome.failure
        self.over, self.begun = False, True

    @property
    def _looks(self) -> tuple[LookPart, ...]:
        """The parts of the look that are drawn in each episode."""
        if self.options.randomize in ("looks", "all"):
            return LOOK_PARTS
        return self.world.spec.looks if self.options.randomize else ()

    def step(self, actions: Mapping[str, NDArray[np.float64]]) -> None:
        """Run one control step, and evaluate the description.

        Args:
            actions: Each agent's numbers, which must be finite and of the right size; from -1 to 1
                or in physical units, depending on the options.
        """
        self.check_usable()
        targets: dict[str, Sequence[float]] = {}
        for agent, values in self._due(actions).items():
            target = self.actions[agent].command(self._physical(agent, values))
            if target is not None:
                targets[agent] = target
        self._previous = dict(actions)
        if self.taken is not None:
            self.taken.append(self._previous)
        self.steps += 1
        try:
            self.world.step(targets)
        except ExplosionError:
            self._give_up()
            return
        self.outcome = self._referee.judge(self.world)
        self.world.set_locks(self.outcome.conditions)
        self.failed = self.failed or self.outcome.failure
        self.succeeded = self.succeeded or (self.outcome.success and not self.failed)
        self.over = self.terminated or self.truncated

    def delay(self, agent: str) -> int:
        """After how many control steps a robot carries out its actions in this episode."""
        return delay_of(agent, self.quantities)

    @property
    def longest_delay(self) -> int:
        """The longest delay that any robot can have with these options, in control steps."""
        listed = self.world.spec.randomize if self.options.draws_quantities else {}
        return max(longest_delay(agent, listed) for agent in self.agents)

    def waiting(self, agent: str) -> list[list[float]]:
        """The actions of a delayed robot that it has yet to carry out, in physical units."""
        return [self._physical(agent, values) for values in self._waiting.get(agent, ())]

    def _physical(self, agent: str, values: NDArray[np.float64]) -> list[float]:
        mode, numbers = self.actions[agent], values.tolist()
        return mode.physical(numbers) if self.options.normalize else mode.clipped(numbers)

    def _due(self, actions: Actions) -> Actions:
        """The actions to carry out now: those given, or earlier ones where a robot has a delay."""
        if not any(map(self.delay, self.agents)):
            return actions
        due: dict[str, NDArray[np.float64]] = {}
        for agent, values in actions.items():
            waiting = (*self._waiting.get(agent, ()), values)
            if len(waiting) > self.delay(agent):
                due[agent], *rest = waiting
                waiting = tuple(rest)
            self._waiting[agent] = waiting
        return due

    def close(self) -> None:
        """Close the physics engine."""
        for world in self._worlds.values():
            world.close()
        self._worlds.clear()
        self.over = self._closed = True

    def _give_up(self) -> None:
        """End an episode whose physics diverged, and discard its corrupted client."""
        self.exploded = self.over = True
        self._worlds.pop(self._variation).close()
        self.actions = self._make_actions()

    def _make_actions(self) -> dict[str, RobotActions]:
        dt = 1.0 / self._file.spec.timing.control_hz
        scene = self._file.scenes[self._variation]
        return {
            name: RobotActions(self.world, robot, self._framed(scene.robots[name].action), dt)
            for name, robot in self.world.robots.items()
        }

    def _framed(self, action: ActionSpec) -> ActionSpec:
        if self.options.frame == "base" and action.frame == "world":
            return action.model_copy(update={"frame": "base"})
        return action

    # --- for observations

    @property
    def time_left(self) -> float:
        """Remaining fraction of the episode, from 1 to 0."""
        return max(0.0, 1.0 - self.steps / self.horizon)

    def holding(self, robot: str) -> float:
        """1.0 while the robot holds an object, or a moving link of a fixed one, else 0.0."""
        world = self.world
        return float(any(world.held(name, robot) for name in world.holdable))

    def forces(self, robot: str) -> Sequence[float]:
        """Force of each finger, or of the tool, on what it touches most, in newtons.

        As with `holding`, that is an object, or a moving link of a fixed one.
        """
        world = self.world
        pressed = [world.grip_forces(name, robot) for name in world.holdable]
        tips = len(world.robots[robot].gripper.tips)
        return max(pressed, key=sum, default=()) or (0.0,) * tips

    def previous_action(self, robot: str) -> Sequence[float]:
        """The last action, from -1 to 1; zeros after reset."""
        values = self._previous[robot]
        if not self.options.normalize:
            mode = self.actions[robot]
            values = np.clip(values, mode.low, mode.high)
            values = 2.0 * (values - mode.low) / (mode.high - mode.low) - 1.0
        numbers: list[float] = np.clip(values, -1.0, 1.0).tolist()
        return numbers

    # --- saving and restoring

    def save(self) -> EpisodeState:
        """Save the state of the episode.

        Raises:
            UsageError: There was no reset yet, or the physics diverged.
        """
        if self._closed or self.exploded or not self.begun:
            raise UsageError("there is no state to save; reset first")
        return EpisodeState(
            self.seed,
            self._variation,
            self.world.save(),
            self._referee.memory,
            self.steps,
            self.outcome,
            self.succeeded,
            self.failed,
            self.over,
            dict(self._previous),
            self.noise_rng.bit_generator.state,
            dict(self._waiting),
        )

    def load(self, state: EpisodeState) -> None:
        """Restore a saved state of this environment.

        Raises:
            UsageError: The world of the state no longer exists.
        """
        self.check_usable()
        world = self._worlds.get(state.variation)
        if world is None or state.world.snapshot.client is not world.client:
            raise UsageError("the state belongs to another environment, or to a world given up")
        if state.variation != self._variation:
            self._variation = state.variation
            self.actions = self._make_actions()
        self.seed = state.seed
        world.restore(state.world)
        self.quantities = world.quantities
        self._referee.memory = state.memory
        self.steps, self.outcome = state.steps, state.outcome
        self.succeeded, self.failed = state.succeeded, state.failed
        self.over, self.exploded = state.over, False
        self.begun, self.taken = True, None
        self._previous = dict(state.previous)
        self.noise_rng.bit_generator.state = state.noise
        self._waiting = dict(state.waiting)
