"""The expert: a policy that plays the stages of a task file."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from typing import Any, Literal

from taskbuilder.env.action_encoder import Actions
from taskbuilder.env.actions import can_be_planned
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.errors import UsageError
from taskbuilder.expert.planning.planner import Planner
from taskbuilder.expert.script.executor import Executor
from taskbuilder.expert.script.troubles import StageError
from taskbuilder.rollout.play import Watch, play
from taskbuilder.rollout.record import Rollout, ScriptLog, Trouble
from taskbuilder.schema.expert import ExpertStage, in_words
from taskbuilder.task import Task

Finish = bool | Literal["undecided"]
"""Whether to hold still until the episode is over once the stages are done; ``"undecided"``: no
longer than until success is reached, and not after a stage that could not be done."""


class Expert:
    """Plays the expert's script in a task file; deterministic for a given seed.

    An `Expert` is a `Policy` for the environment ``env``. Its method `play` has more options than
    `taskbuilder.play`. An `Expert` can play any number of episodes. It plans motions in a second
    physics simulation, which `close` frees.

    Args:
        env: An environment of the task, with flat actions and a fixed variation.
        disturbed: Whether its actions are changed before they are carried out, for example by
            noise. At the end of a motion, it then commands the goal until it is reached.

    Raises:
        UsageError: The environment draws a random variation in each episode.
    """

    def __init__(self, env: TaskEnv, *, disturbed: bool = False) -> None:
        if not isinstance(env, TaskEnv):
            raise UsageError(
                f"an expert plays in a TaskEnv, which parallel_env makes, not {type(env).__name__}"
            )
        if env.options.variation == "random":
            raise UsageError(
                "an expert plans for one variation; make the environment with a fixed variation"
            )
        self.env = env
        self._planner = Planner(env)
        self._disturbed = disturbed
        self._script: _Script | None = None

    def play(
        self,
        seed: int,
        *,
        stages: Sequence[ExpertStage] | None = None,
        without: Collection[str] = (),
        persist: bool = False,
        finish: Finish = True,
        until_decided: bool = False,
        after_stage: Callable[[int], None] = lambda _: None,
        observations: bool = False,
        cameras: Sequence[str] = (),
        size: tuple[int, int] | None = None,
        forces: bool = False,
        explain: bool = False,
        watch: Watch | None = None,
    ) -> Rollout:
        """Play one episode.

        Args:
            seed: Seed passed to `reset`.
            stages: Stages to play instead of those of the task file.
            without: Names of robots that hold still; all orders to these robots are left out of the
                stages.
            persist: Whether to continue with the next stage when a stage fails.
            finish: What happens after the last stage that is played. True: all robots hold still
                until the episode is over. False: playing ends. ``"undecided"``: if a
                stage has failed, playing ends at once; otherwise, all robots hold still until
                success is reached or the episode is over.
            until_decided: Whether to stop playing as soon as it is certain whether the episode
                succeeds: when success is reached, or when failure holds.
            after_stage: Function that is called with the number of each completed stage (counting
                from 1) before the next stage begins. The function may save the state of the
                environment, but must not change the state.
            observations: Whether to record the observations of every agent.
            cameras: Names of the cameras whose images are recorded.
            size: Width and height of the images in pixels; by default, those of each camera.
            forces: Whether to record, for each control step, the largest contact force between two
                robots, in `Rollout.robot_force`.
            explain: Whether to record why success is false, if it is false at the end.
            watch: Function that is called with the environment after reset and after each control
                step.

        Raises:
            UsageError: The task has no expert, the environment has dictionary actions
                (``flat=False``), or motions cannot be planned for the action mode of an arm.
            UnknownNameError: The scene has no such camera.
        """
        script = _Script(
            self.env,
            self._planner,
            self._stages(stages),
            without=frozenset(without),
            persist=persist,
            finish=finish,
            until_decided=until_decided,
            after_stage=after_stage,
            disturbed=self._disturbed,
        )
        return play(
            self.env,
            script,
            seed,
            observations=observations,
            cameras=cameras,
            size=size,
            forces=forces,
            explain=explain,
            watch=watch,
        )

    def reset(self, env: TaskEnv, seed: int) -> None:
        """Prepare to play the task file's stages from the first one on.

        Raises:
            UsageError: The expert was made for another environment, or the task has no expert.
        """
        if env is not self.env:
            raise UsageError("an expert plays in the environment that it was made for")
        self._script = _Script(
            self.env, self._planner, self._stages(None), disturbed=self._disturbed
        )
        self._script.reset(env, seed)

    def act(self, observations: Mapping[str, Any]) -> Actions | None:
        """The next actions, which depend on the state of the simulation, not on the observations.

        Raises:
            UsageError: No episode has begun.
        """
        return self._begun().act(observations)

    def leave_out(self, robots: Collection[str]) -> None:
        """Leave robots to people from now on, and take back those that are not named.

        The current stage begins again, and what is already done in it is skipped. In each stage,
        the expert's robots hold still until the orders to the other robots are done: an object is
        held or released, or is within 5 cm of its goal. They do not wait for a tool that is only
        to be somewhere. Then they do their own, and what fails is tried again after a second.

        Raises:
            UsageError: No episode has begun.
        """
        self._begun().leave_out(frozenset(robots))

    def log(self) -> ScriptLog:
        """The log of the stages in the current episode.

        Raises:
            UsageError: No episode has begun.
        """
        return self._begun().log()

    def close(self) -> None:
        """Free the simulation in which the expert plans."""
        self._planner.close()

    def _begun(self) -> _Script:
        if self._script is None:
            raise UsageError("no episode has begun; call reset, or play")
        return self._script

    def _stages(self, stages: Sequence[ExpertStage] | None) -> tuple[ExpertStage, ...]:
        script = tuple(self.env.task.file.spec.expert if stages is None else stages)
        if not script:
            raise UsageError(
                f"{self.env.task.name} has no expert; write its stages under expert: in "
                f"{self.env.task.file.entry.file.name}"
            )
        return script


class _Script:
    """A policy that plays the stages of one episode. For the arguments see `Expert`."""

    def __init__(
        self,
        env: TaskEnv,
        planner: Planner,
        stages: Sequence[ExpertStage],
        *,
        without: frozenset[str] = frozenset(),
        persist: bool = False,
        finish: Finish = True,
        until_decided: bool = False,
        after_stage: Callable[[int], None] = lambda _: None,
        disturbed: bool = False,
    ) -> None:
        self._env, self._planner, self._stages = env, planner, stages
        self._without, self._persist, self._finish = without, persist, finish
        self._until_decided = until_decided
        self._after_stage, self._disturbed = after_stage, disturbed
        self._stage = 0
        self._ends: list[int] = []
        self._trouble: Trouble | None = None

    def reset(self, env: TaskEnv, seed: int) -> None:
        self._seed = seed
        self.leave_out(frozenset())

    def leave_out(self, steered: frozenset[str]) -> None:
        """Play on from the current stage, without robots that people steer."""
        self._trouble, self._steered = None, steered
        self._executor = Executor(
            self._env,
            self._planner,
            self._without,
            self._seed,
            steered,
            disturbed=self._disturbed,
        )
        self._actions = self._play(len(self._ends))

    def act(self, observations: Mapping[str, Any]) -> Actions | None:
        episode = self._env.episode
        if self._until_decided and (episode.succeeded or episode.failed):
            return None
        return next(self._actions, None)

    def log(self) -> ScriptLog:
        # The last action has been executed but not checked; its result may complete a stage.
        if self._env.episode.over and next(self._actions, None) and self._stage:
            self._note(self._out_of_time())
        return ScriptLog(tuple(self._ends), self._trouble, self._executor.planning_s)

    def _play(self, done: int) -> Iterator[Actions]:
        """Yield the actions of the episode, after the stages that are done."""
        for number, stage in enumerate(self._stages[done:], start=done + 1):
            self._stage = number
            try:
                yield from self._attempts(stage)
            except StageError as error:
                self._note(self._trouble_of(error))
                if self._persist and not self._env.episode.over:
                    continue
                break
            self._ends.append(self._env.episode.steps)
            self._after_stage(number)
        self._stage = 0
        while self._finish is True or (self._finish and not self._is_decided):
            yield self._executor.encoder.hold()

    def _attempts(self, stage: ExpertStage) -> Iterator[Actions]:
        """Play a stage; beside people, try it again until what they do lets it succeed.

        Raises:
            StageError: It cannot be done, and nobody steers.
        """
        while True:
            try:
                yield from self._executor.play(stage)
            except StageError as error:
                if not self._steered or self._env.episode.over:
                    raise
                self._trouble = self._trouble_of(error)
                for _ in range(self._env.task.file.spec.timing.control_hz):
                    yield self._executor.encoder.hold()
            else:
                self._trouble = None if self._steered else self._trouble
                return

    def _trouble_of(self, error: StageError) -> Trouble:
        steps = self._env.episode.steps
        return Trouble(self._stage, error.order, error.robot, error.cause, str(error), steps)

    @property
    def _is_decided(self) -> bool:
        """Whether it is known what the episode comes to."""
        return self._env.episode.succeeded or self._trouble is not None

    def _note(self, trouble: Trouble | None) -> None:
        self._trouble = self._trouble or trouble

    def _out_of_time(self) -> Trouble | None:
        """Why a stage was not done when the episode ended; None if it ended with success."""
        episode, stage = self._env.episode, in_words(self._stages[self._stage - 1])
        if episode.exploded:
            cause, message = "physics diverged", "the physics diverged"
        elif episode.succeeded:
            return None
        else:
            cause = "no time left"
            message = f"the episode ended after {episode.steps} control steps"
        return Trouble(self._stage, stage, "", cause, message, episode.steps)


def has_expert(task: Task) -> bool:
    """Whether a task has an expert whose action modes can be planned for."""
    spec = task.file.spec
    robots = spec.scene.robots.values()
    return bool(spec.expert) and all(can_be_planned(robot.action) for robot in robots)
