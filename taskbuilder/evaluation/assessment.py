"""Evaluating any policy: playing its episodes and those of its baselines, and certifying them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import closing
from dataclasses import replace
from os.path import relpath
from pathlib import Path
from typing import Unpack

from taskbuilder.arguments import a_seed, several, whole
from taskbuilder.env.keywords import takes_options
from taskbuilder.env.options import EnvOptions
from taskbuilder.errors import UsageError
from taskbuilder.evaluation.arms import SUBJECT, Episodes, by_arm, jobs_of, play_all
from taskbuilder.evaluation.certificate import Trial, certificate_of, write_certificate
from taskbuilder.evaluation.comparison import Arms, compare
from taskbuilder.evaluation.disturbed import applicable, under
from taskbuilder.evaluation.subject import Subject, find_subject
from taskbuilder.evaluation.summary import EPISODES, SEED, EvaluationSummary, summarise
from taskbuilder.jobs import Map, workers
from taskbuilder.policies.grammar import PolicyLike
from taskbuilder.policies.zoo import ZOO_PREFIX
from taskbuilder.processes import cores
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.disturbances import DisturbancesGiven, each_disturbance
from taskbuilder.task import Task

COMPARED = 20
"""Default number of seeds that the baselines play, unless there is a certificate."""

Track = Callable[[Iterable[Episodes], int], Iterable[Episodes]]
"""Wraps episodes as they are played, given their number."""


@takes_options
def evaluate(
    policy: PolicyLike,
    episodes: int = EPISODES,
    *,
    task: str | Path | Task | None = None,
    seeds: Iterable[int] | None = None,
    first_seed: int = SEED,
    baselines: bool | int = False,
    certificate: str | Path | None = None,
    disturb: DisturbancesGiven = (),
    jobs: int | None = None,
    catalogue: Catalogue | None = None,
    trust: bool = False,
    **options: Unpack[EnvOptions],
) -> EvaluationSummary:
    """Evaluate a policy without exploration, by default in episodes that training did not use.

    Args:
        policy: The policy: a text such as ``expert``, ``random``, ``zoo:handover/demos`` or the
            folder of a run; a trained policy; or your own `Policy`, class of policies, or function
            from observations to actions. See `parse_policy`.
        episodes: Number of episodes, with consecutive seeds.
        task: The task to play; by default the task that the policy names, or was trained on.
        seeds: Seeds of the episodes, in place of ``episodes`` and ``first_seed``.
        first_seed: Seed of the first episode.
        baselines: Whether the expert, random actions, holding still and stalls also play the first
            20 seeds (all seeds, with a certificate), for comparison; or the number of these seeds.
        certificate: File for a certificate, which others can verify by playing it again; with
            ``disturb``, of the episodes under its one disturbance.
        disturb: Disturbances that are also played, one by one, from the same seeds: ``"all"``, a
            text such as ``"mass=0.5"``, several, or a mapping from axes to levels.
        jobs: Number of processes; by default one for each CPU core, and this process for a policy
            of your own.
        catalogue: Where tasks are looked up; by default the catalogue of this installation.
        trust: Whether to run the task at the path that the folder of a run records, if the
            catalogue does not have it. A task is a Python program.
        options: Options of the environment that differ from those used in training; see `Options`.

    Returns:
        The success rate with its confidence interval, the returns, and the stages reached; with
        ``baselines``, the comparison with them; with ``disturb``, the results under each
        disturbance. It has the record of every episode.

    Raises:
        UsageError: The policy does not fit the task, its file does not exist, nothing says which
            task to play, or the task is not in the catalogue or not trusted; there can be no
            certificate; or there is no such disturbance, or none of them applies.
        UnknownNameError: There is no policy of this name, or ``task`` names an unknown task.
    """
    subject = find_subject(policy, task=task, options=options, catalogue=catalogue, trust=trust)
    played = _seeds(episodes, first_seed, seeds)
    if not isinstance(baselines, bool):
        whole("baselines", baselines)
    if jobs is not None:
        whole("jobs", jobs, 1)
    asked = each_disturbance(disturb)
    compared = compared_seeds(baselines, len(played), certified=certificate is not None)
    if certificate is not None:
        check_certifiable(subject, played, asked)
    subject.check()
    rows = applicable(subject, asked)
    if jobs is None:
        jobs = 1 if subject.player.kind == "own" else cores()
    with workers(min(jobs, len(played))) as spread:
        trials = [(subject, play_arms(subject, played, compared, spread))]
        for row in rows:
            if not row.why_not:
                other = under(subject, row.axis, row.level)
                trials.append((other, play_arms(other, played, compared, spread)))
    if certificate is not None:
        command = f"taskbuilder.evaluate({subject.name!r})"
        certify(Path(certificate), *trials[-1], played, compared, command)
    plain, *under_each = (summary_of(*trial) for trial in trials)
    results = iter(under_each)
    rows = tuple(row if row.why_not else replace(row, summary=next(results)) for row in rows)
    return replace(plain, disturbed=rows)


def _seeds(count: int, first: int, given: Iterable[int] | None) -> list[int]:
    """The seeds of the episodes, each once: what is played again is no other episode."""
    if given is None:
        first = a_seed(first)
        return [*range(first, first + whole("episodes", count, 1))]
    seeds = [a_seed(seed) for seed in several("seeds", given)]
    if not seeds:
        raise UsageError("there are no seeds; an evaluation has at least one episode")
    if len(set(seeds)) < len(seeds):
        twice = next(seed for seed in seeds if seeds.count(seed) > 1)
        raise UsageError(f"the seed {twice} is named twice; the episode would be the same")
    return seeds


def compared_seeds(asked: int | None, count: int, *, certified: bool) -> int:
    """The number of first seeds that the baselines play, too.

    Args:
        asked: What is asked for; None or True for the default.
        count: Number of all seeds.
        certified: Whether the evaluation gets a certificate; then the default is all seeds.
    """
    if asked is None or asked is True:
        asked = count if certified else COMPARED
    return min(int(asked), count)


def play_arms(
    subject: Subject,
    seeds: Sequence[int],
    compared: int,
    spread: Map = map,
    track: Track = lambda episodes, _: episodes,
) -> Arms:
    """Play the episodes of a policy and of its baselines.

    Args:
        subject: Who is evaluated, and where.
        seeds: Seeds of all episodes.
        compared: Number of first seeds that the baselines play too.
        spread: A map, perhaps over several processes.
        track: Wraps episodes as they are played.
    """
    jobs = jobs_of(seeds, compared)
    with closing(play_all(subject.config, jobs, spread)) as episodes:
        return by_arm(track(episodes, len(jobs)))


def summary_of(subject: Subject, arms: Arms) -> EvaluationSummary:
    """What the episodes of an evaluation say together."""
    own = tuple(arms[SUBJECT])
    comparison = compare(arms) if len(arms) > 1 else None
    return replace(
        summarise(own, len(subject.stages) - 1),
        task_version=subject.task.version,
        baselines=comparison,
        rollouts=own,
    )


def check_certifiable(
    subject: Subject, seeds: Sequence[int], disturb: Sequence[tuple[str, float]] = ()
) -> None:
    """Refuse an evaluation that nobody else could play again, or that is of more than one trial.

    Args:
        subject: Who is evaluated, and where.
        seeds: Seeds of the episodes.
        disturb: Disturbances that are played one by one.

    Raises:
        UsageError: So it is.
    """
    if len(disturb) > 1:
        raise UsageError("a certificate is of one disturbance; name one axis, such as mass=0.5")
    player = subject.player
    if player.kind == "served":
        raise UsageError(
            "the policy of a server has no certificate: nobody else could play it again; "
            "--out DIR writes the result"
        )
    if not player.is_word and player.file is None:
        raise UsageError(
            f"{player.name} has no file, so it has no certificate: nobody else could play it again"
        )
    if [*seeds] != [*range(seeds[0], seeds[0] + len(seeds))]:
        raise UsageError("the seeds of a certificate follow each other; give episodes=N instead")


def certify(
    file: Path,
    subject: Subject,
    arms: Arms,
    seeds: Sequence[int],
    compared: int,
    command: str,
) -> None:
    """Write the certificate of an evaluation.

    Args:
        file: File of the certificate.
        subject: Who was evaluated, and where.
        arms: All episodes.
        seeds: Their seeds.
        compared: Number of first seeds that the baselines played too.
        command: The command that made it.

    Raises:
        OSError: It cannot be written.
    """
    trial = trial_of(subject, file, seeds, compared)
    write_certificate(file, certificate_of(trial, arms, command))


def trial_of(subject: Subject, beside: Path, seeds: Sequence[int], compared: int) -> Trial:
    """What a certificate in a file is about; a policy's file is named from its folder on.

    Args:
        subject: Who is evaluated.
        beside: The certificate.
        seeds: Of all episodes.
        compared: From how many of them all arms played.
    """
    player, name = subject.player, subject.player.name
    if player.is_word:
        name = f"{name}:{subject.task.name}"
    elif not name.startswith(ZOO_PREFIX):
        name = Path(relpath(Path(name).resolve(), beside.resolve().parent)).as_posix()
    return Trial(subject.task, name, player.file, subject.options, tuple(seeds), compared)
