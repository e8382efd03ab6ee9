"""Verifying a certificate: its trial is played again, and everything is compared bit for bit."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from taskbuilder.digests import digest
from taskbuilder.errors import TaskbuilderError, UnknownNameError, UsageError, display_path
from taskbuilder.evaluation.assessment import Track, play_arms, trial_of
from taskbuilder.evaluation.certificate import certificate_of, read_certificate
from taskbuilder.evaluation.subject import DISTURBANCES, Subject, find_subject
from taskbuilder.evaluation.verification import (
    Point,
    compare_claims,
    compare_episodes,
    compare_files,
    compare_machines,
    compare_sample,
    compare_seals,
    compare_version,
)
from taskbuilder.jobs import Map, workers
from taskbuilder.policies.fitting import env_options
from taskbuilder.policies.grammar import Player, parse_policy, read_word
from taskbuilder.policies.zoo import LARGEST, POLICY_FILE, ZOO_PREFIX, policy_file
from taskbuilder.processes import cores
from taskbuilder.schema.catalogue import Catalogue, looks_like_path
from taskbuilder.schema.choices import OtherRobots
from taskbuilder.schema.other_robots import other_robots
from taskbuilder.sources import digests_of_library, digests_of_task
from taskbuilder.untrusted import place_within, read_plain
from taskbuilder.wording import excerpt


@dataclass(frozen=True)
class Verification:
    """What came of verifying a certificate.

    Attributes:
        file: The certificate.
        data: Its contents.
        points: Everything that was compared, in order.
    """

    file: Path
    data: Mapping[str, Any]
    points: tuple[Point, ...]

    @property
    def verified(self) -> bool:
        """Whether nothing differs that decides."""
        return not self.wrong

    @property
    def wrong(self) -> tuple[str, ...]:
        """The subjects of the differences that decide."""
        return tuple(point.about for point in self.points if point.decides and not point.same)

    def __repr__(self) -> str:
        held = "verified" if self.verified else f"not verified: {', '.join(self.wrong)}"
        return f"<Verification of {display_path(self.file)}: {held}>"


def verify(
    certificate: str | Path,
    policy: str | Path | None = None,
    *,
    robots: Mapping[str, str | Path] | OtherRobots = (),
    catalogue: Catalogue | None = None,
    jobs: int | None = None,
) -> Verification:
    """Verify a certificate: play its episodes again, and compare everything bit for bit.

    A certificate may be anybody's. It decides neither which files are read outside its own folder,
    nor which programs are run: its task and robots are looked up by name.

    Args:
        certificate: File of the certificate.
        policy: The policy, if its file is not where the certificate says.
        robots: Models of robots by name, if the certificate names files.
        catalogue: Where tasks and robots are looked up; by default the catalogue of this
            installation.
        jobs: Number of processes; by default one for each CPU core.

    Returns:
        Whether the certificate holds here, and everything that differs.

    Raises:
        UsageError: It is no certificate; or its policy, task or robots are not where they should
            be, and have to be named.
        OSError: A file cannot be read.
    """
    file = Path(certificate)
    data = read_certificate(file)
    count = len(data["seeds"])
    with workers(min(cores() if jobs is None else jobs, count)) as spread:
        return verify_data(file, data, policy, robots=robots, catalogue=catalogue, spread=spread)


def verify_data(
    file: Path,
    data: Mapping[str, Any],
    policy: str | Path | None = None,
    *,
    robots: Mapping[str, str | Path] | OtherRobots = (),
    catalogue: Catalogue | None = None,
    spread: Map = map,
    track: Track = lambda episodes, _: episodes,
    sample: Sequence[int] | None = None,
) -> Verification:
    """Verify a certificate that has been read; see `verify`.

    Args:
        file: The certificate.
        data: Its contents.
        policy: The policy, if its file is not where the certificate says.
        robots: Models of robots by name, if the certificate names files.
        catalogue: Where tasks and robots are looked up.
        spread: A map, perhaps over several processes.
        track: Wraps episodes as they are played.
        sample: Seeds of the only episodes of the policy to play; by default, all episodes of the
            policy and of the baselines are played.
    """
    catalogue = catalogue or Catalogue.discover()
    given = policy is not None
    name = str(policy) if policy is not None else _named(data["policy"], file)
    sealed = compare_seals(data)
    machines = compare_machines(data)
    here: dict[str, Any] = {"library": digests_of_library(), "policy": {}}
    if read_word(name) is None:
        here["policy"] = {data["policy"]: digest(read_plain(policy_file(name), LARGEST))}
    try:
        player = parse_policy(name)
        chosen = other_robots(robots) or _robots(data, catalogue)
        subject = _subject(player, data, catalogue, chosen, given=given)
        here["task"] = digests_of_task(subject.task)
        files = (compare_version(data, subject.task.version), *compare_files(data, here))
        subject.check()
        trial = trial_of(subject, file, data["seeds"], data["controls_seeds"])
        seeds, compared = trial.seeds, trial.compared
        if sample is not None:
            seeds, compared = sample, 0
        again = certificate_of(trial, play_arms(subject, seeds, compared, spread, track), "")
    except UsageError as error:
        if "task" not in here:
            raise  # it is not said where it is
        played = _unplayed(str(error))
    except TaskbuilderError as error:
        files = compare_files(data, here)
        played = _unplayed(str(error))
    else:
        claims = compare_claims(data, again, policy_given=given)
        compare = compare_episodes if sample is None else compare_sample
        played = (claims, *compare(data, again))
    return Verification(file, data, (*files, *sealed, *machines, *played))


def _unplayed(error: str) -> tuple[Point, ...]:
    return (Point("episodes", (f"cannot be played: {excerpt(error)}",)),)


def _named(name: str, certificate: Path) -> str:
    """The policy that a certificate names.

    A certificate may be anybody's: it names files within its own folder alone.
    """
    if name.startswith(ZOO_PREFIX) or read_word(name) is not None:
        return name
    try:
        file = place_within(certificate.resolve().parent, name)
    except OSError:  # it leads to another folder, or is not there
        raise UsageError(
            f"where is the policy {excerpt(name)}? Name its file: taskbuilder evaluate POLICY "
            f"--verify {shlex.quote(display_path(certificate))}"
        ) from None
    if file.is_dir():
        place_within(file, POLICY_FILE)
    return str(file)


def _robots(data: Mapping[str, Any], catalogue: Catalogue) -> OtherRobots:
    """The other models that a certificate names; those of the catalogue, never files.

    Raises:
        UsageError: It names a file.
        UnknownNameError: There is no such robot.
    """
    robots = other_robots(data["options"].get("robots", ()))
    for name, model in robots:
        if looks_like_path(model):
            raise UsageError(
                f"where is the robot {excerpt(model)}? Name its file: --robot {name}=FILE"
            )
        catalogue.robot(model, Path())
    return robots


def _subject(
    player: Player,
    data: Mapping[str, Any],
    catalogue: Catalogue,
    robots: OtherRobots,
    *,
    given: bool,
) -> Subject:
    """Who plays what; the task is the catalogue's, whatever files the certificate names.

    Raises:
        UsageError: The task is nowhere that the user has named, or its options are none.
    """
    task: Path | None = None
    if not (given and player.task):  # else the user names it
        player = replace(player, task="")
        try:
            task = catalogue.named_task(data["task"]).file
        except UnknownNameError as error:
            hint = "name the folder of its files by --task-path"
            raise UsageError(f"its task is not here ({error}); {hint}") from None
    certified = data["options"]
    asked = {key: certified[key] for key in (*DISTURBANCES, "grasp") if key in certified}
    if robots:
        asked["robots"] = robots
    # What the certificate leaves out is as in training, and is then a difference.
    trained = {**player.options, **env_options(certified)}
    return find_subject(player, task=task, trained=trained, options=asked, catalogue=catalogue)
