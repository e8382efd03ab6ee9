"""The physical course of an episode: a world, and the actions that are carried out in it.

The seed and the actions determine it, so it can be played again. The evaluation of an episode by a
description is no part of it, except that conditions lock and free joints.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from taskbuilder.env.actions import RobotActions
from taskbuilder.env.options import Options
from taskbuilder.errors import ExplosionError, UsageError
from taskbuilder.interpreters import Lineage
from taskbuilder.schema.agents import ActionSpec
from taskbuilder.schema.task import LOOK_PARTS, LookPart
from taskbuilder.sim.single import Single
from taskbuilder.task import Task
from taskbuilder.world.building import build_world
from taskbuilder.world.forces import Pair
from taskbuilder.world.randomness import EpisodeRandomness, delay_of, longest_delay
from taskbuilder.world.world import World

ActionNumbers = Mapping[str, NDArray[np.float64]]
"""The numbers of every agent's action."""

Conditions = Mapping[str, bool]
"""Whether each condition of the description holds; empty where no joint has a lock."""


class Course(Single):
    """Resets and moves the world of an episode, and can do so again.

    Args:
        task: The task.
        options: The options of the environment.
        force_pairs: Pairs of bodies whose contact forces are measured.

    Attributes:
        file: The task file, with what the options change.
        agents: The robots, in file order.
        actions: The actions of each agent.
        force_pairs: Pairs of bodies whose contact forces are measured.
        seed: Seed of this episode.
        variation: Number of the variation of this episode.
        past_actions: All actions since the reset.
        locking: The conditions that held after the reset and after each control step.
        waiting: The actions of each delayed robot that it has yet to carry out.
        quantities: Values in this episode of what the task lists under ``randomize``.
    """

    def __init__(self, task: Task, options: Options, force_pairs: tuple[Pair, ...]) -> None:
        self.file = options.applied(task)
        self.agents = task.agents
        self.force_pairs = force_pairs
        self.seed = 0
        self.variation = 0 if options.variation == "random" else options.variation
        self.past_actions: list[ActionNumbers] = []
        self.locking: list[Conditions] = []
        self.waiting: dict[str, tuple[NDArray[np.float64], ...]] = {}
        self._options = options
        self._worlds: dict[int, World] = {}
        self._closed = False
        self._forks = Lineage.forks
        self.actions = self._make_actions()
        self.quantities = self.world.quantities

    # --- the world

    @property
    def world(self) -> World:
        """The world of the current variation, built on first use.

        Raises:
            UsageError: The environment was closed.
        """
        self.check_usable()
        if self.variation not in self._worlds:
            world = build_world(
                self.file,
                variation=self.variation,
                renderer=self._options.renderer,
                disturbances=self._options.disturbances,
            )
            world.watch_forces(self.force_pairs)
            self._worlds[self.variation] = world
        return self._worlds[self.variation]

    @property
    def standing(self) -> World:
        """The world as it stands, which a forked process may read, too.

        Raises:
            UsageError: The environment was closed.
        """
        self._check_open()
        return self._worlds[self.variation]

    @property
    def closed(self) -> bool:
        """Whether it was closed."""
        return self._closed

    def check_usable(self) -> None:
        """Check that the environment is open, and was made in this process.

        Raises:
            UsageError: It cannot be used here.
        """
        self._check_open()
        if Lineage.forks != self._forks:
            what = "this environment is used in another process than the one that made it"
            raise UsageError(f"{what}; make one there")

    def _check_open(self) -> None:
        if self._closed:
            raise UsageError("this environment is closed; make another")

    def meter(self, pairs: Sequence[Pair]) -> None:
        """Also measure the contact forces between these pairs of bodies."""
        self.force_pairs += tuple(pairs)
        for world in self._worlds.values():
            world.watch_forces(self.force_pairs)

    def set_variation(self, variation: int) -> None:
        """Go to the world of a variation."""
        if variation != self.variation:
            self.variation = variation
            self.actions = self._make_actions()

    def discard_world(self) -> None:
        """Close a world whose physics diverged, if that was not done; the next one is new."""
        if self.variation in self._worlds:
            self._worlds.pop(self.variation).close()
            self.actions = self._make_actions()

    def close(self) -> None:
        """Close the physics engine."""
        for world in self._worlds.values():
            world.close()
        self._worlds.clear()
        self._closed = True

    # --- an episode

    def begin(self, seed: int) -> None:
        """Reset the world.

        Raises:
            PlacementError: The objects do not fit.
            ExplosionError: The physics diverged at once.
        """
        self.seed, self.past_actions, self.locking = seed, [], []
        if self._options.variation == "random":
            drawn = EpisodeRandomness(seed).variation().integers(len(self.file.scenes))
            self.set_variation(int(drawn))
        self._reset()

    def step(self, actions: ActionNumbers) -> None:
        """Carry out actions for a control step.

        Raises:
            ExplosionError: The physics diverged.
        """
        self.past_actions.append(actions)
        order = self.world.contact_order
        try:
            self._carry_out(actions)
        except ExplosionError:
            if not order.uncertain:
                raise
            self.discard_world()
        if order.uncertain:
            self.replay()

    def lock(self, conditions: Conditions) -> None:
        """Lock and free joints, after the reset and after each control step."""
        conditions = conditions if self.world.has_locks else {}
        self.locking.append(conditions)
        self.world.set_locks(conditions)

    def replay(self) -> None:
        """Go through the episode again, from its reset to where it is now.

        Raises:
            ExplosionError: The physics diverged.
        """
        self._reset()
        for step, conditions in enumerate(self.locking):
            self.world.set_locks(conditions)
            if step < len(self.past_actions):
                self._carry_out(self.past_actions[step])

    def _reset(self) -> None:
        self.waiting = {}
        self.world.reset(self.seed, randomized=self._options.draws_quantities, looks=self._looks)
        self.quantities = self.world.quantities

    def _carry_out(self, actions: ActionNumbers) -> None:
        targets: dict[str, Sequence[float]] = {}
        for agent, values in self._due(actions).items():
            target = self.actions[agent].command(self.physical(agent, values))
            if target is not None:
                targets[agent] = target
        self.world.step(targets)

    @property
    def _looks(self) -> tuple[LookPart, ...]:
        """The parts of the look that are drawn in each episode."""
        if self._options.randomize in ("looks", "all"):
            return LOOK_PARTS
        return self.world.spec.looks if self._options.randomize else ()

    # --- actions

    def delay(self, agent: str) -> int:
        """After how many control steps a robot carries out its actions in this episode."""
        return delay_of(agent, self.quantities)

    @property
    def longest_delay(self) -> int:
        """The longest delay that any robot can have with these options, in control steps."""
        listed = self.world.spec.randomize if self._options.draws_quantities else {}
        longest = max(longest_delay(agent, listed) for agent in self.agents)
        return max(longest, int(self._options.disturbance_levels.get("delay", 0)))

    def physical(self, agent: str, values: NDArray[np.float64]) -> list[float]:
        """The numbers of an agent's action in physical units, within their bounds."""
        mode, numbers = self.actions[agent], values.tolist()
        return mode.physical(numbers) if self._options.normalize else mode.clipped(numbers)

    def _due(self, actions: ActionNumbers) -> ActionNumbers:
        """The actions to carry out now: those given, or earlier ones where a robot has a delay."""
        if not any(map(self.delay, self.agents)):
            return actions
        due: dict[str, NDArray[np.float64]] = {}
        for agent, values in actions.items():
            waiting = (*self.waiting.get(agent, ()), values)
            if len(waiting) > self.delay(agent):
                due[agent], *rest = waiting
                waiting = tuple(rest)
            self.waiting[agent] = waiting
        return due

    def _make_actions(self) -> dict[str, RobotActions]:
        dt = 1.0 / self.file.spec.timing.control_hz
        scene = self.file.scenes[self.variation]
        return {
            name: RobotActions(self.world, robot, self._framed(scene.robots[name].action), dt)
            for name, robot in self.world.robots.items()
        }

    def _framed(self, action: ActionSpec) -> ActionSpec:
        if self._options.frame == "base" and action.frame == "world":
            return action.model_copy(update={"frame": "base"})
        return action
