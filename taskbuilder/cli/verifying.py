"""`taskbuilder evaluate --verify`: a certificate is played again and compared to the bit."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from taskbuilder.cli.env_options import asked_options
from taskbuilder.cli.evaluated import DISTURBANCES, Evaluated, check_plays, evaluated, named_player
from taskbuilder.cli.output import paint, print_json, print_table
from taskbuilder.cli.tasks import catalogue_of
from taskbuilder.cli.trials import play_arms, trial_of
from taskbuilder.digests import digest
from taskbuilder.errors import TaskbuilderError, UnknownNameError, UsageError, display_path
from taskbuilder.learn.evaluation import env_options
from taskbuilder.learn.zoo import LARGEST, POLICY_FILE, policy_file
from taskbuilder.schema.catalogue import Catalogue, looks_like_path
from taskbuilder.schema.choices import OtherRobots
from taskbuilder.schema.other_robots import other_robots
from taskbuilder.sources import digests_of_library, digests_of_task
from taskbuilder.trial.arms import jobs_of
from taskbuilder.trial.certificate import (
    certificate,
    read_certificate,
)
from taskbuilder.trial.verification import (
    Point,
    compare_claims,
    compare_episodes,
    compare_files,
    compare_machines,
    compare_seals,
)
from taskbuilder.untrusted import place_within, read_plain
from taskbuilder.wording import excerpt


def verify(arguments: argparse.Namespace) -> int:
    """Say whether a certificate holds here, and if not, what differs."""
    file: Path = arguments.verify
    data = read_certificate(file)
    if not arguments.json:
        print(paint(excerpt(f"{data['task']} · {data['policy']}"), "bold"))
        made = f"certificate of {len(data['seeds'])} episodes, made {excerpt(data['made'])}"
        print(f"  {made}\n", flush=True)
    points = list(_points(file, data, arguments))
    wrong = [point.about for point in points if point.decides and not point.same]
    if arguments.json:
        told = {point.about: list(point.differs) for point in points}
        print_json({"verified": not wrong, "certificate": display_path(file), "differs": told})
    else:
        print_table([[point.about, str(point)] for point in points], indent="  ")
        print(f"\n{_verdict(wrong, points, data)}")
    return 1 if wrong else 0


def _points(file: Path, data: Mapping[str, Any], arguments: argparse.Namespace) -> list[Point]:
    """Everything that was compared, in the order in which it is told."""
    catalogue = catalogue_of(arguments)
    name = _policy(arguments.policy or data["policy"], file, given=bool(arguments.policy))
    sealed = compare_seals(data)
    machines = compare_machines(data)
    here: dict[str, Any] = {"library": digests_of_library(), "policy": {}}
    if named_player(name) is None:
        content = read_plain(policy_file(name), LARGEST)
        here["policy"] = {data["policy"]: digest(content)}
    try:
        robots = asked_options(arguments).get("robots") or _robots(data, catalogue)
        found = _found(name, data, catalogue, robots, given=bool(arguments.policy))
        here["task"] = digests_of_task(found.task)
        files = compare_files(data, here)
        check_plays(found)
        trial = trial_of(found, file, data["seeds"], data["controls_seeds"])
        jobs = jobs_of(trial.seeds, trial.compared)
        again = certificate(trial, play_arms(found.config, jobs, arguments), "")
    except UsageError as error:
        if "task" not in here:
            raise  # it is not said where it is
        played = _unplayed(str(error))
    except TaskbuilderError as error:
        files = compare_files(data, here)
        played = _unplayed(str(error))
    else:
        claims = compare_claims(data, again, policy_given=bool(arguments.policy))
        played = (claims, *compare_episodes(data, again))
    return [*files, *sealed, *machines, *played]


def _unplayed(error: str) -> tuple[Point, ...]:
    return (Point("episodes", (f"cannot be played: {excerpt(error)}",)),)


def _policy(name: str, certificate: Path, *, given: bool) -> str:
    """Who is to play: as the command line says, or else as the certificate does.

    A certificate may be anybody's: it names files within its own folder alone.
    """
    if given or name.startswith("zoo:") or named_player(name) is not None:
        return name
    try:
        file = place_within(certificate.resolve().parent, name)
    except OSError:  # it leads to another folder, or is not there
        raise UsageError(
            f"where is the policy {excerpt(name)}? Name its file: taskbuilder evaluate POLICY "
            f"--verify {display_path(certificate)}"
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


def _found(
    name: str,
    data: Mapping[str, Any],
    catalogue: Catalogue,
    robots: OtherRobots,
    *,
    given: bool,
) -> Evaluated:
    """Who plays what; the task is the catalogue's, whatever files the certificate names.

    Raises:
        UsageError: The task is nowhere that the user has named, or its options are none.
    """
    task: str | None
    if given and named_player(name) is not None:
        task = None  # the command line says it
    else:
        try:
            task = str(catalogue.named_task(data["task"]).file)
        except UnknownNameError as error:
            hint = "name the folder of its files by --task-path"
            raise UsageError(f"its task is not here ({error}); {hint}") from None
    told = data["options"]
    return evaluated(
        name,
        catalogue,
        task=task,
        options=env_options(told),
        disturbances={key: told[key] for key in DISTURBANCES if key in told},
        robots=robots,
        grasp=told.get("grasp"),
    )


def _verdict(wrong: list[str], points: list[Point], data: Mapping[str, Any]) -> str:
    if wrong:
        said = paint("not verified", "red")
        return f"{said}: {', '.join(dict.fromkeys(wrong))} differ{'s' * (len(set(wrong)) == 1)}"
    count = sum(len(played) for played in data["episodes"].values())
    said = f"{paint('verified', 'green')}: {count} episodes played again, the same to the bit"
    others = [point.about for point in points if not point.same]
    return f"{said}, with another {' and '.join(others)}" if others else said
