"""Films of episodes, played before or played for the film."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Unpack

from taskbuilder.env.keywords import takes_options
from taskbuilder.env.options import EnvOptions
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.evaluation.subject import find_subject
from taskbuilder.policies.grammar import PolicyLike
from taskbuilder.rollout.play import play
from taskbuilder.rollout.record import Rollout
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.task import Task, load_task
from taskbuilder.visual.film import save_film


@takes_options
def film(
    episode: Rollout | str | Path | Task,
    out: str | Path | None = None,
    *,
    policy: PolicyLike = "expert",
    seed: int = 0,
    task: str | Path | Task | None = None,
    camera: str | Sequence[str] = (),
    size: tuple[int, int] | None = None,
    gif: bool = True,
    catalogue: Catalogue | None = None,
    **options: Unpack[EnvOptions],
) -> tuple[Path, ...]:
    """Film an episode.

    Args:
        episode: The record of an episode; or a task, of which an episode is played.
        out: Path of the film, such as ``films/handover.mp4``; by default the name of the task with
            the seed, in the folder ``films``.
        policy: Who plays, if ``episode`` is a task: anything that `parse_policy` reads.
        seed: Seed of the episode, if ``episode`` is a task.
        task: The task of a record, if the catalogue does not have it.
        camera: The camera, or several side by side; by default the first of the scene.
        size: Width and height of each picture; by default 480 wide.
        gif: Whether to write a GIF, too.
        catalogue: Where tasks are looked up; by default the catalogue of this installation.
        options: Options of the environment, if ``episode`` is a task; see `Options`.

    Returns:
        The files: an MP4, and the GIF.

    Raises:
        UsageError: The policy does not fit the task.
        UnknownNameError: There is no such task, policy or camera.
        OSError: A file cannot be written.
    """
    with ExitStack() as stack:
        if isinstance(episode, Rollout):
            place = task if task is not None else episode.task
            loaded = place if isinstance(place, Task) else load_task(place, catalogue=catalogue)
            env = stack.enter_context(closing(TaskEnv(loaded, episode.options)))
        else:
            subject = find_subject(policy, task=episode, options=options, catalogue=catalogue)
            env = stack.enter_context(closing(subject.make_env()))
            made = subject.player.prepare(env, stack, any_grasp=subject.any_grasp)
            episode = play(env, made, seed)
        name = f"{episode.task.replace('/', '-')}-{episode.seed}"
        stem = Path("films") / name if out is None else Path(out)
        if stem.suffix in (".mp4", ".gif"):
            stem = stem.with_suffix("")
        stem.parent.mkdir(parents=True, exist_ok=True)
        named = [camera] if isinstance(camera, str) else camera
        return save_film(env, episode, named, stem, size=size, gif=gif)
