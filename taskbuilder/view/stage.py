"""The task on the page: its environment, who plays in it, and what is wrong with its files."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack, closing
from dataclasses import dataclass
from pathlib import Path

from taskbuilder.data.growing import GrowingDataset
from taskbuilder.env.parallel import TaskEnv, parallel_env
from taskbuilder.errors import (
    FileError,
    Finding,
    Location,
    PlacementError,
    TaskbuilderError,
    UnknownNameError,
)
from taskbuilder.policies.grammar import parse_policy
from taskbuilder.policies.zoo import zoo_names
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.used_files import used_files
from taskbuilder.steering.session import Session, steering_plan
from taskbuilder.steering.steering import Steering
from taskbuilder.task import Task, load_task
from taskbuilder.validate.polling import Polled
from taskbuilder.view.recording import RecordedState, Recording, record

SCRIPTED = ("expert", "hold", "random")

MISSING_FILE = (
    "cannot be read: it is no longer there; the page goes on when it is back under this name"
)
"""What is said of a task file that is deleted or renamed while it is shown."""


@dataclass(frozen=True)
class Choice:
    """What is to be played.

    Attributes:
        player: Who plays; see `taskbuilder.policies.grammar`.
        seed: Seed of the episode.
        variation: Number of the variation.
    """

    player: str = "expert"
    seed: int = 0
    variation: int = 0


class Stage:
    """A task that is loaded again when its files change.

    Args:
        reference: Name of the task, or path of its YAML file.
        catalogue: The catalogue that names are looked up in.
        record: Folder of the data set that steered episodes are recorded in, or None.
        horizon: Length of steered episodes in control steps; see `options_for_people`.

    Attributes:
        task: The task as it was last read without errors; None before that.
        findings: What is wrong with its files now.
    """

    def __init__(
        self,
        reference: str,
        catalogue: Catalogue,
        *,
        record: Path | None = None,
        horizon: int | None = None,
    ) -> None:
        self._reference, self._catalogue = reference, catalogue
        self._record, self._horizon = record, horizon
        self._polled = Polled()
        self._file: Path | None = None
        self.task: Task | None = None
        self.findings: tuple[Finding, ...] = ()
        self.load()

    def load(self) -> bool:
        """Read the files again; whether they could be read.

        Raises:
            UnknownNameError: There is no such task, and there was none before.
        """
        catalogue = Catalogue(self._catalogue.folders)
        try:
            entry = catalogue.task(self._reference)
        except UnknownNameError:
            if self._file is None:
                raise
            self.findings = (Finding("TB001", MISSING_FILE, location=Location(self._file)),)
            return False
        self._file = entry.file
        self._polled.watch(used_files(entry, catalogue) | self._polled.files)
        try:
            self.task = load_task(self._reference, catalogue=catalogue)
        except FileError as error:
            self.findings = error.findings
            return False
        self.findings = ()
        return True

    def changed(self) -> bool:
        """Whether a file has changed since this was asked last."""
        return bool(self._polled.changed())

    @property
    def players(self) -> tuple[str, ...]:
        """Who can play this task: its expert, if it has one, and pretrained policies."""
        if self.task is None:
            return SCRIPTED
        scripted = SCRIPTED if self.task.file.spec.expert else SCRIPTED[1:]
        own = (name for name in zoo_names() if name.startswith(f"zoo:{self.task.name}/"))
        return (*scripted, *own)

    def env(self, choice: Choice) -> TaskEnv:
        """An environment as a player needs it.

        Raises:
            TaskbuilderError: It cannot be built.
        """
        if self.task is None:
            raise FileError(self.findings)
        options = dict(parse_policy(choice.player).options)
        return parallel_env(self.task, **{**options, "variation": choice.variation})

    def play(self, choice: Choice, shown: Callable[[RecordedState], None]) -> Recording:
        """Play and record an episode.

        Args:
            choice: What is to be played.
            shown: Called with each state as soon as it is reached.

        Raises:
            TaskbuilderError: It cannot be played.
        """
        with ExitStack() as stack:
            env = stack.enter_context(closing(self.env(choice)))
            policy = parse_policy(choice.player).prepare(env, stack)
            return record(env, choice.player, policy, choice.seed, shown)

    def session(self, player: str) -> Session | None:
        """A session in which people steer the task; None while it has errors.

        Args:
            player: Who plays the robots that nobody steers, to begin with.

        Raises:
            TaskbuilderError: Its episodes cannot be recorded.
        """
        task = self.task
        if task is None:
            return None
        dataset = None
        if self._record is not None:
            plan = steering_plan(task, player, self._catalogue, self._horizon)
            dataset = GrowingDataset(plan, self._record, task)
        steering = Steering(task.agents)
        return Session(task, steering, horizon=self._horizon, dataset=dataset)

    def explain(self, error: TaskbuilderError) -> tuple[Finding, ...]:
        """An error as findings, if it has any."""
        return error.findings if isinstance(error, FileError | PlacementError) else ()
