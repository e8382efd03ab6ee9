"""The expert: plays the stages of a task file in an environment."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence

from taskbuilder.env.parallel import TaskEnv
from taskbuilder.errors import UsageError
from taskbuilder.expert.demonstration import Demonstration, Trouble, Watch
from taskbuilder.expert.performance import Performance, StageError
from taskbuilder.expert.planning import Planner
from taskbuilder.expert.recording import EpisodeOver, Recording
from taskbuilder.spec.expert import ExpertStage


class Expert:
    """Plays an environment's task as its file says; deterministic in the seed.

    Use it as often as you like; it keeps a second world for planning, which `close` frees.

    Args:
        env: Any environment of a task, its actions flat and its variation fixed.

    Raises:
        UsageError: An arm's action mode cannot be planned for.
    """

    def __init__(self, env: TaskEnv) -> None:
        self.env = env
        self._planner = Planner(env)

    def play(
        self,
        seed: int,
        *,
        stages: Sequence[ExpertStage] | None = None,
        without: Collection[str] = (),
        persist: bool = False,
        finish: bool = True,
        after_stage: Callable[[int], None] = lambda _: None,
        watch: Watch = lambda _: None,
    ) -> Demonstration:
        """Play one episode.

        Args:
            seed: Of the reset.
            stages: What to do in place of the stages of the task file.
            without: Robots that stay home: their parts of all stages are left out.
            persist: Go on with the next stage after one that could not be done.
            finish: Hold still until the episode is over once the stages are done.
            after_stage: Called with a stage's number, from 1, when it is done and the next has
                not begun; the environment may be saved there, and must be left as it was.
            watch: Called after reset and after each control step.

        Raises:
            UsageError: The task has no expert.
        """
        script = tuple(self.env.task.file.spec.expert if stages is None else stages)
        if not script:
            raise UsageError(
                f"{self.env.task.name} has no expert; write its stages under expert: in "
                f"{self.env.task.file.entry.file.name}"
            )
        recording = Recording(self.env, seed, watch)
        performance = Performance(self.env, recording, self._planner, frozenset(without), seed)
        trouble: Trouble | None = None
        ends: list[int] = []
        for number, stage in enumerate(script, start=1):
            try:
                performance.play(stage)
            except (StageError, EpisodeOver) as problem:
                trouble = trouble or _trouble(problem, number, stage, recording)
                if persist and not recording.over:
                    continue
                break
            ends.append(recording.steps)
            after_stage(number)
        while finish and not recording.over:
            recording.step(performance.driver.hold())
        return recording.demonstration(
            stage_ends=tuple(ends), trouble=trouble, planning_s=performance.planning_s
        )

    def close(self) -> None:
        """Free the world that is kept for planning."""
        self._planner.close()


def _trouble(
    problem: StageError | EpisodeOver, number: int, stage: ExpertStage, recording: Recording
) -> Trouble | None:
    """What to say of a stage that was not done; None if the episode ended in success."""
    episode = recording.env.episode
    if isinstance(problem, StageError):
        order, robot, cause, message = problem.order, problem.robot, problem.cause, str(problem)
    elif episode.exploded:
        order, robot, cause = words(stage), "", "physics diverged"
        message = "the physics diverged"
    elif episode.succeeded:
        return None
    else:
        order, robot, cause = words(stage), "", "no time left"
        message = f"the episode's {recording.steps} control steps are over"
    return Trouble(number, order, robot, cause, message, recording.steps)


def words(stage: ExpertStage) -> str:
    """A stage in words: ``left: release, right: bring stick to goal``."""
    if isinstance(stage, dict):
        return ", ".join(f"{robot}: {order}" for robot, order in stage.items())
    robots = getattr(stage, "together", ())
    return f"{' and '.join(robots)}: {stage}" if robots else str(stage)
