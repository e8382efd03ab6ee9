"""The episode: one world and one referee, stepped by the actions of all agents.

All views of an environment (multi-agent, joint, vector) wrap an `Episode`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taskbuilder.description.description import Outcome, Referee
from taskbuilder.env.actions import RobotActions
from taskbuilder.env.course import ActionNumbers, Course
from taskbuilder.env.episode_state import EpisodeState, fingerprint, snapshot_of
from taskbuilder.env.options import Options
from taskbuilder.env.rewording import longest_reworded, reworded
from taskbuilder.errors import ExplosionError, UsageError
from taskbuilder.geometry import total
from taskbuilder.schema.instructions import fill, longest_instruction
from taskbuilder.sim.single import Single
from taskbuilder.task import Task
from taskbuilder.world.randomness import EpisodeRandomness
from taskbuilder.world.world import World


class Episode(Single):
    """Runs a task: reset, step, evaluate, save and restore.

    Attributes:
        task: The task.
        options: The options of the environment.
        agents: The robots, in file order.
        outcome: The referee's outcome of the current control step.
        steps: Control steps taken in this episode.
        succeeded: Success has held at a control step of this episode, before any failure.
        failed: Failure has held at some control step of this episode, or after its reset.
        exploded: The physics diverged; the episode is over and its world is discarded.
        over: No further step is possible before a reset.
        begun: A reset has succeeded.
        noise_rng: Generator of the observation noise.
    """

    def __init__(self, task: Task, options: Options) -> None:
        self.task = task
        self.options = options
        self.agents = task.agents
        self._referee = Referee(task.description, self.agents)
        self._course = Course(task, options, self._referee.force_pairs)
        self._file = self._course.file
        self.steps = 0
        self.succeeded = self.failed = self.exploded = False
        self.over = True
        self.begun = False
        self.noise_rng = np.random.default_rng(0)
        self._previous = self._no_actions()
        self.outcome = self._referee.start(self.world)

    # --- the course of the episode

    @property
    def world(self) -> World:
        """The world of the current variation, built on first use.

        Raises:
            UsageError: The environment was closed.
        """
        return self._course.world

    @property
    def closed(self) -> bool:
        """Whether it was closed."""
        return self._course.closed

    def check_usable(self) -> None:
        """Check that the environment is open, and was made in this process.

        Raises:
            UsageError: It cannot be used here.
        """
        self._course.check_usable()

    @property
    def actions(self) -> Mapping[str, RobotActions]:
        """The actions of each agent."""
        return self._course.actions

    @property
    def seed(self) -> int:
        """The seed of this episode."""
        return self._course.seed

    @property
    def variation(self) -> int:
        """The variation of this episode."""
        return self._course.variation

    @property
    def quantities(self) -> Mapping[str, Any]:
        """Values in this episode of what the task lists under ``randomize``."""
        return self._course.quantities

    @property
    def disturbed(self) -> Mapping[str, Any]:
        """What this episode drew for disturbances, by axis, as JSON can hold it."""
        drawn = self._course.world.disturbed
        if "instruction" not in self.options.disturbance_levels:
            return drawn
        return {**drawn, "instruction": self.instruction}

    def delay(self, agent: str) -> int:
        """After how many control steps a robot carries out its actions in this episode."""
        return self._course.delay(agent)

    @property
    def longest_delay(self) -> int:
        """The longest delay that any robot can have with these options, in control steps."""
        return self._course.longest_delay

    def waiting(self, agent: str) -> list[list[float]]:
        """The actions of a delayed robot that it has yet to carry out, in physical units."""
        course = self._course
        return [course.physical(agent, values) for values in course.waiting.get(agent, ())]

    # --- stepping

    @property
    def referee(self) -> Referee:
        """The referee, which also explains its outcome."""
        return self._referee

    def meter_robots(self) -> None:
        """Also measure the forces between all pairs of robots; nothing else changes."""
        measured = {frozenset(pair) for pair in self._course.force_pairs}
        pairs = [pair for pair in combinations(self.agents, 2) if frozenset(pair) not in measured]
        if pairs:
            self._course.meter(pairs)

    def robot_force(self) -> float:
        """The largest force between two robots in the last control step, in newtons.

        Raises:
            UsageError: It is not measured; see `meter_robots`.
        """
        pairs = combinations(self.agents, 2)
        return max((self.world.contact_force(*pair) for pair in pairs), default=0.0)

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
        randomness = EpisodeRandomness(self.seed)
        chosen = int(randomness.instruction().integers(len(texts)))
        text = fill(texts[chosen], self._file.scenes[self.variation], self.quantities)
        if "instruction" in self.options.disturbance_levels:
            return reworded(text, randomness.rewording())
        return text

    @property
    def longest_instruction(self) -> int:
        """An upper bound of the length of any episode's instruction, in bytes of UTF-8."""
        longest = longest_instruction(self._file.spec, self._file.scenes)
        reworded = "instruction" in self.options.disturbance_levels
        return longest_reworded(longest) if reworded else longest

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
        self.over, self.begun = True, False  # until the reset has succeeded
        self.exploded = self.succeeded = False
        self.steps = 0
        self.noise_rng = EpisodeRandomness(seed).noise()
        try:
            self._course.begin(seed)
        except ExplosionError:
            self._give_up()
            raise
        self._previous = self._no_actions()
        self._take(self._referee.start(self.world))
        self.failed = self.outcome.failure
        self.over, self.begun = False, True

    def step(self, actions: Mapping[str, NDArray[np.float64]]) -> None:
        """Run one control step, and evaluate the description.

        Args:
            actions: Each agent's numbers, which must be finite and of the right size; from -1 to 1
                or in physical units, depending on the options.
        """
        self.check_usable()
        self._previous = dict(actions)
        self.steps += 1
        try:
            self._course.step(self._previous)
        except ExplosionError:
            self._give_up()
            return
        self._take(self._referee.judge(self.world))
        self.failed = self.failed or self.outcome.failure
        self.succeeded = self.succeeded or (self.outcome.success and not self.failed)
        self.over = self.terminated or self.truncated

    def close(self) -> None:
        """Close the physics engine."""
        self._course.close()
        self.over = True

    def _take(self, outcome: Outcome) -> None:
        self.outcome = outcome
        self._course.lock(outcome.conditions)

    def _give_up(self) -> None:
        """End an episode whose physics diverged, and discard its corrupted client."""
        self.exploded = self.over = True
        self._course.discard_world()

    def _no_actions(self) -> ActionNumbers:
        return {agent: np.zeros(self.actions[agent].size) for agent in self.agents}

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
        return max(pressed, key=total, default=()) or (0.0,) * tips

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

    def save(self, *, snapshot: bool = True) -> EpisodeState:
        """Save the state of the episode.

        Args:
            snapshot: Whether to take a snapshot of the physics engine, where it is of use.

        Raises:
            UsageError: There was no reset yet, or the physics diverged; or a snapshot is to be
                taken in a forked process.
        """
        if self._course.closed or self.exploded or not self.begun:
            raise UsageError("there is no state to save; reset first")
        course = self._course
        return EpisodeState(
            task=self.task.name,
            options=self.options.decisive,
            seed=course.seed,
            variation=course.variation,
            actions=tuple(course.past_actions),
            locking=tuple(course.locking),
            memory=self._referee.memory,
            outcome=self.outcome,
            succeeded=self.succeeded,
            failed=self.failed,
            over=self.over,
            noise=self.noise_rng.bit_generator.state,
            waiting=dict(course.waiting),
            fingerprint=fingerprint(course.standing),
            snapshot=snapshot_of(course.world) if snapshot else None,
        )

    def load(self, state: EpisodeState) -> None:
        """Go back to a saved state: by its snapshot, or by carrying out its actions again.

        Raises:
            UsageError: The state is of another task, or of other options, or its actions do not
                lead to it.
        """
        self.check_usable()
        state.check_fits(self.task, self.options)
        self.over, self.begun, self.exploded = True, False, False  # until it is done
        course = self._course
        course.set_variation(state.variation)
        course.seed, course.past_actions, course.locking = (
            state.seed,
            [*state.actions],
            [*state.locking],
        )
        if not state.restored(course.world):
            self._replay(state.fingerprint)
        course.waiting, course.quantities = dict(state.waiting), course.world.quantities
        self._referee.memory, self.outcome = state.memory, state.outcome
        self.steps = len(state.actions)
        self.succeeded, self.failed = state.succeeded, state.failed
        self.over, self.begun = state.over, True
        self._previous = state.actions[-1] if state.actions else self._no_actions()
        self.noise_rng.bit_generator.state = state.noise

    def _replay(self, wanted: str) -> None:
        """Play the physics of a saved state again, whose fingerprint is then the wanted one."""
        try:
            self._course.replay()
        except ExplosionError:
            self._give_up()
        if self.exploded or fingerprint(self.world) != wanted:
            raise UsageError(
                "the actions of the saved state do not lead to it: something else moved the world "
                "before it was saved, or the task has changed since (other processors calculate "
                "otherwise, too); reset the environment to go on"
            )
