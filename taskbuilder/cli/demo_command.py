"""`taskbuilder demo`."""

from __future__ import annotations

import argparse
import statistics
import sys
from collections.abc import Callable, Generator, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

from taskbuilder.cli.env_options import asked_options
from taskbuilder.cli.output import paint, print_json, progress, say, show_finding
from taskbuilder.cli.tasks import catalogue_of, check_views, make_folder
from taskbuilder.cli.trained import EnvFactory, is_trained
from taskbuilder.cli.why import ASIDE, reasons_of
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.errors import UsageError, display_path
from taskbuilder.expert.named import policy_named
from taskbuilder.expert.script.player import Expert
from taskbuilder.files import write_whole
from taskbuilder.jobs import workers
from taskbuilder.learn.evaluation import check_fits, options_for
from taskbuilder.learn.zoo import load_policy
from taskbuilder.processes import cores
from taskbuilder.rollout.play import Policy, play
from taskbuilder.rollout.record import Rollout
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.task import Task, load_task
from taskbuilder.visual.film import save_film
from taskbuilder.visual.still import save_image
from taskbuilder.visual.strip import film_strip
from taskbuilder.world.inertias import doubtful_inertias


def run(arguments: argparse.Namespace) -> int:
    """Play episodes, say how each went, and show the first."""
    catalogue = catalogue_of(arguments)
    asked = asked_options(arguments)
    task = load_task(
        arguments.task,
        catalogue=catalogue,
        robots=dict(asked.get("robots", ())),
        grasp=asked.get("grasp", "task"),
    )
    _check(task, arguments)
    for finding in (*task.warnings, *doubtful_inertias(task.file)):
        print(show_finding(finding), file=sys.stderr)
    factory = _factory(catalogue, arguments)
    make_folder(arguments.out)
    seeds = range(arguments.seed, arguments.seed + arguments.episodes)
    jobs = min(arguments.jobs or cores(), len(seeds))
    played = []
    with closing(_play_all(factory, seeds, jobs)) as episodes:
        for _, episode in zip(progress(seeds, "episodes"), episodes, strict=True):
            played.append(episode)
            if not arguments.json:
                say(_line(episode, len(str(seeds[-1]))))
                for reason in reasons_of(episode):
                    say(f"{ASIDE}{reason}")
    if not arguments.json:
        print(_summary(played))
    files = [display_path(file) for file in _show(task, played[0], factory, arguments)]
    if arguments.json:
        print_json({**_as_data(task, played), "files": files})
    else:
        print("\n".join(files))
    return 0 if all(episode.success for episode in played) else 1


def _check(task: Task, arguments: argparse.Namespace) -> None:
    """Refuse what cannot be played or shown before anything is."""
    check_views(task, arguments)
    if not is_trained(arguments.policy):
        policy_named(arguments.policy)
    if arguments.policy == "expert" and not task.file.spec.expert:
        file = display_path(task.file.entry.file)
        raise UsageError(
            f"{task.name} has no expert; write its stages under expert: in {file}, or let "
            "--policy random play"
        )


def _factory(catalogue: Catalogue, arguments: argparse.Namespace) -> PlayerFactory:
    """Who plays where; a trained policy that does not fit is refused."""
    asked, trained = asked_options(arguments), is_trained(arguments.policy)
    options = {**asked, "variation": arguments.variation}
    if trained:
        options = options_for(load_policy(arguments.policy), options, arguments.policy)
    make_env = EnvFactory(arguments.task, catalogue, tuple(options.items()))
    factory = PlayerFactory(make_env, arguments.policy, any_grasp="grasp" in asked)
    if trained:
        with ExitStack() as stack:
            factory.make_player(stack)
    return factory


# Playing


@dataclass(frozen=True)
class PlayerFactory:
    """Who plays where, in a form that other processes can be told.

    Attributes:
        make_env: Makes the environment.
        policy: Who plays.
        any_grasp: Whether a trained one may play with another rule of grasping than in training.
    """

    make_env: EnvFactory
    policy: str
    any_grasp: bool

    def make_player(self, stack: ExitStack) -> Callable[[int], Rollout]:
        """What plays an episode from a seed; it is freed by the stack.

        Raises:
            UsageError: A trained policy does not fit the task.
        """
        env = stack.enter_context(closing(self.make_env()))
        return partial(play, env, self._policy(env, stack), explain=True)

    def _policy(self, env: TaskEnv, stack: ExitStack) -> Policy:
        if is_trained(self.policy):
            trained = load_policy(self.policy)
            check_fits(trained, env, self.policy, any_grasp=self.any_grasp)
            return trained.player()
        made = policy_named(self.policy)(env)
        if isinstance(made, Expert):
            stack.callback(made.close)
        return made


def _play_all(
    factory: PlayerFactory, seeds: Sequence[int], jobs: int
) -> Generator[Rollout, None, None]:
    """Episodes in the order of their seeds, each as soon as it has been played."""
    if jobs > 1:
        with workers(jobs) as spread:
            yield from spread(partial(_play_elsewhere, factory), seeds)
        return
    with ExitStack() as stack:
        yield from map(factory.make_player(stack), seeds)


def _play_elsewhere(factory: PlayerFactory, seed: int) -> Rollout:
    return _player_made_once(factory)(seed)


@lru_cache(maxsize=1)
def _player_made_once(factory: PlayerFactory) -> Callable[[int], Rollout]:
    """A policy in its environment that is kept for as long as its process lives."""
    return factory.make_player(ExitStack())


# Saying


def _line(episode: Rollout, digits: int) -> str:
    verdict = paint("success", "green") if episode.success else paint("failed ", "red")
    start = f"seed {episode.seed:{digits}}  {verdict}  return {episode.team_return:8.2f}"
    return f"{start}  {_how_it_went(episode)}"


def _how_it_went(episode: Rollout) -> str:
    """Steps to success, or where it failed and why."""
    if episode.first_success is not None:
        return f"{episode.first_success} of {episode.horizon} steps"
    trouble, furthest = episode.trouble, episode.furthest_stage
    if trouble is not None:
        return f"in stage {trouble.stage} ({trouble.order}): {trouble.message}"
    return f"furthest stage: {furthest}" if furthest else "no stage reached"


def _summary(episodes: Sequence[Rollout]) -> str:
    steps = _steps_to_success(episodes)
    share = len(steps) / len(episodes)
    parts = [f"{len(steps)} of {len(episodes)} succeeded ({share:.0%})"]
    if steps:
        parts.append(f"median {statistics.median(steps):g} steps")
    planning = statistics.median(_planning_s(episode) for episode in episodes)
    if planning:
        parts.append(f"median planning time {planning:.2f} s")
    return paint(" · ".join(parts), "bold")


def _planning_s(episode: Rollout) -> float:
    return episode.log.planning_s if episode.log else 0.0


def _steps_to_success(episodes: Sequence[Rollout]) -> list[int]:
    return [e.first_success for e in episodes if e.first_success is not None]


def _as_data(task: Task, episodes: Sequence[Rollout]) -> dict[str, Any]:
    return {
        "task": task.name,
        "success_rate": len(_steps_to_success(episodes)) / len(episodes),
        "episodes": [
            {
                "seed": episode.seed,
                "success": episode.success,
                "success_at_end": episode.success_at_end,
                "return": episode.team_return,
                "steps": episode.first_success or episode.steps,
                "stage": episode.furthest_stage,
                "trouble": vars(episode.trouble) if episode.trouble else None,
                "why": [vars(reason) for reason in episode.why],
                "planning_s": round(_planning_s(episode), 4),
            }
            for episode in episodes
        ],
    }


# Showing


def _show(
    task: Task, episode: Rollout, factory: PlayerFactory, arguments: argparse.Namespace
) -> list[Path]:
    """Write what an episode looked like, and say where."""
    from taskbuilder.visual.charts import Mark, reward_chart  # a second, when all else is in order

    stem = arguments.out / task.name.replace("/", "-")
    strip, chart = (stem.with_name(f"{stem.name}-{what}.png") for what in ("strip", "rewards"))
    cameras = arguments.camera or [next(iter(task.file.scenes[episode.variation].cameras))]
    cameras = list(dict.fromkeys(cameras))
    subtitle = _subtitle(episode, arguments.policy)
    with closing(factory.make_env(renderer=arguments.renderer or "auto")) as env:
        size = arguments.size
        page = film_strip(env, episode, cameras, subtitle=subtitle, size=size)
        save_image(strip, page)
        marks = [Mark(step, name) for name, step in episode.reached.items()]
        if episode.first_success is not None:
            marks.append(Mark(episode.first_success, "success", good=True))
        write_whole(chart, reward_chart(task.name, subtitle, episode.terms, episode.rewards, marks))
        films: tuple[Path, ...] = ()
        if arguments.video:
            films = save_film(
                env,
                episode,
                cameras,
                stem,
                size=size,
                progress=lambda frames, count: progress(frames, "filming", count),
            )
    return [strip, chart, *films]


def _subtitle(episode: Rollout, policy: str) -> str:
    verdict = "success after" if episode.success else "failed,"
    parts = [policy] if policy != "expert" else []
    parts += [f"seed {episode.seed}", f"return {episode.team_return:.2f}"]
    return " · ".join([*parts, f"{verdict} {_how_it_went(episode)}"])
