"""Recorded data sets as training data: what a run takes from one, and whether it fits the run."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from gymnasium.spaces import Dict
from numpy.typing import NDArray

from taskbuilder.data import layout
from taskbuilder.data.dataset import Dataset, RecordedEpisode
from taskbuilder.data.environment import options_of_dataset
from taskbuilder.env.options import Options, flag_of, make_options, options_about
from taskbuilder.env.parallel import TaskEnv, parallel_env
from taskbuilder.env.spaces import VECTOR
from taskbuilder.errors import UsageError, display_path
from taskbuilder.learn.demonstration import Demonstration
from taskbuilder.learn.demonstrations import explicit_gripper
from taskbuilder.learn.replayed import Replayer, joined
from taskbuilder.learn.turning import Turns, turns_of
from taskbuilder.policies.grammar import is_word
from taskbuilder.policies.trained import Array32
from taskbuilder.schema.grasping import rules_of
from taskbuilder.task import Task
from taskbuilder.wording import suggestion

SMALLEST_PICTURE = 24
"""Minimum width and height of pictures; the convolutions leave two by two positions of it."""

LARGEST_PICTURE = 512
"""Maximum width and height of pictures, all of which are held in memory."""


@dataclass(frozen=True)
class Demonstrations:
    """Successful episodes of a data set, one after the other: a row for each control step.

    Attributes:
        observations: (n, numbers) by agent.
        actions: (n, numbers) by agent; commands to binary grippers are repeated at every step.
        ends: (n,) the row after the last of each row's episode.
        own: (numbers,) bool by agent: whether a number is of the robot itself or the time left,
            and not of the rest of the scene.
        pictures: (n, height, width, 3) uint8 by camera.
        turns: Which numbers of each robot turn with the scene; None where that is not known.
    """

    observations: Mapping[str, Array32]
    actions: Mapping[str, Array32]
    ends: NDArray[np.int64]
    own: Mapping[str, NDArray[np.bool_]]
    pictures: Mapping[str, NDArray[np.uint8]] = field(default_factory=dict)
    turns: Mapping[str, Turns | None] = field(default_factory=dict)

    @property
    def agents(self) -> tuple[str, ...]:
        """The agents, in order."""
        return tuple(self.observations)


def read_demonstrations(
    dataset: Dataset,
    task: str,
    cameras: Sequence[str] = (),
    observed: Mapping[str, Sequence[str]] | None = None,
    replayer: Replayer | None = None,
) -> Demonstrations:
    """Read the episodes of a data set in which success holds at the last control step.

    Args:
        dataset: The data set.
        task: Id of the task; only its episodes are read.
        cameras: Cameras whose pictures are read.
        observed: Names of the observed numbers to read, by agent; by default all that were
            recorded.
        replayer: Plays the episodes again for numbers that were not recorded.

    Raises:
        UsageError: It has no such episodes, or they do not happen again as they were recorded.
        UnknownNameError: A camera was not recorded.
        StoreError: It is damaged.
        VideoError: A video is damaged.
    """
    episodes = successes(dataset, task)
    robots = dataset.about["tasks"][task]["robots"]
    binary = {agent for agent, robot in robots.items() if _has_binary_gripper(robot)}
    agents = tuple(robots)
    ends = np.cumsum([episode.steps for episode in episodes])
    names = {agent: robot["observation_names"] for agent, robot in robots.items()}
    observed = names if observed is None else observed
    if replayer is not None and any(set(observed[agent]) - set(names[agent]) for agent in agents):
        observations = joined(list(replayer.observations(episodes)))
    else:
        columns = {a: [names[a].index(name) for name in observed[a]] for a in agents}
        observations = {
            a: _joined(e.observations[a][:-1, columns[a]] for e in episodes) for a in agents
        }
    return Demonstrations(
        observations,
        {
            agent: _joined(
                explicit_gripper(e.actions[agent]) if agent in binary else e.actions[agent]
                for e in episodes
            )
            for agent in agents
        },
        np.repeat(ends, [episode.steps for episode in episodes]),
        {agent: _own(agent, observed[agent]) for agent in agents},
        {c: np.concatenate([e.images(c)[:-1] for e in episodes]) for c in cameras},
        {
            agent: turns_of(agent, observed[agent], robot["action_names"])
            for agent, robot in robots.items()
            if options_of_dataset(dataset.about, cameras=False).get("frame") == "base"
        },
    )


def recorded_demonstrations(
    dataset: Dataset, task: str, variation: int
) -> tuple[Demonstration, ...]:
    """The episodes of a variation in which success holds at the last control step.

    Raises:
        UsageError: There are none.
        StoreError: The data set is damaged.
    """
    robots = dataset.about["tasks"][task]["robots"]
    binary = {agent for agent, robot in robots.items() if _has_binary_gripper(robot)}
    episodes = [each for each in successes(dataset, task) if each.variation == variation]
    if not episodes:
        where = display_path(dataset.folder)
        raise UsageError(f"{where} has no successful episode of variation {variation} of {task}")
    return tuple(
        Demonstration(
            each.seed,
            {a: explicit_gripper(v) if a in binary else v for a, v in each.actions.items()},
            each.first_success,
        )
        for each in episodes
    )


def _own(agent: str, names: Sequence[str]) -> NDArray[np.bool_]:
    """Which of the numbers that a robot observes are its own, or the time left."""
    return np.array([name.startswith(f"{agent}.") or name == "time_left" for name in names])


def _has_binary_gripper(robot: Mapping[str, Any]) -> bool:
    """Whether a robot, as a data set describes it, has a gripper that is told to open or close."""
    name: str = robot["action_names"][-1]
    return bool(robot["action"]["gripper"] == "binary") and name.endswith(".gripper")


def _joined(parts: Iterable[NDArray[Any]]) -> Array32:
    return np.concatenate(list(parts)).astype(np.float32)


def successes(dataset: Dataset, task: str) -> Sequence[RecordedEpisode]:
    """The episodes of a task in which success holds at the last control step.

    Raises:
        UsageError: There are none.
    """
    lines = [line for line in dataset.contents["episodes"] if line["task"] == task]
    good = {line["name"] for line in lines if line.get("success_at_end", line["success"])}
    episodes = [episode for episode in dataset if episode.name in good]
    if not episodes:
        raise UsageError(
            f"{display_path(dataset.folder)} has no episode of {task} in which success holds at "
            "the last step, and others are not learned from; taskbuilder collect "
            f"{task} --out DIR collects some of the expert"
        )
    return episodes


# --- what fits


def task_in(dataset: Dataset) -> str:
    """The name of the only task of a data set.

    Raises:
        UsageError: It has several tasks.
    """
    names = list(dataset.about["tasks"])
    if len(names) != 1:
        where = display_path(dataset.folder)
        raise UsageError(f"{where} has several tasks; name one before --data: {', '.join(names)}")
    return str(names[0])


def recorded_options(dataset: Dataset, asked: Mapping[str, Any]) -> dict[str, Any]:
    """The fields of a plan that a data set determines.

    Args:
        dataset: The data set.
        asked: Fields of the plan that were asked for.

    Raises:
        UsageError: It was recorded otherwise than is asked for.
    """
    where = display_path(dataset.folder)
    recorded = _recorded_values(dataset)
    for name, value in recorded.items():
        less = name == "observe" and asked.get(name) == "task"  # a part of what was recorded
        if name in asked and asked[name] != value and not less and name != "variation":
            raise UsageError(
                f"{where} was recorded with {name} {_word(value)}, not {_word(asked[name])}; "
                f"leave {flag_of(name)} out, or collect another data set"
            )
    played = [policy["name"] for policy in dataset.about["collected"]["policies"]]
    recorded["teachers"] = tuple(name for name in played if not is_word(name))
    return {**recorded, **_pictures(dataset.about, where, asked.get("cameras") or ())}


def unlike_recorded(dataset: Dataset, options: Options) -> Iterator[str]:
    """The options of a run that differ, on request, from those that its data set has, in words."""
    for name, value in _recorded_values(dataset).items():
        chosen = getattr(options, name)
        if chosen != value:
            where = display_path(dataset.folder)
            yield f"{flag_of(name)} {_word(chosen)}, where {where} has {_word(value)}"


def _recorded_values(dataset: Dataset) -> dict[str, Any]:
    """The values of all options of the scene and of observations in a data set."""
    options = make_options(**options_of_dataset(dataset.about, cameras=False))
    values = {name: getattr(options, name) for name in options_about("scene", "observed")}
    variations = dataset.about["collected"]["variations"]
    return {**values, "variation": "random" if variations == "all" else variations[0]}


def _word(value: Any) -> str:
    """The value of an option in words."""
    if isinstance(value, tuple):
        return ", ".join("=".join(pair) for pair in value) or "as in the task file"
    return "as in the task file" if value is None else str(value)


def _pictures(about: Mapping[str, Any], where: str, asked: Sequence[str]) -> dict[str, Any]:
    """Size and renderer of the recorded cameras that are asked for.

    Raises:
        UsageError: One was not recorded, or not all have the same size.
    """
    if not asked:
        return {}
    tasks = about["tasks"].values()
    recorded = about["collected"]["cameras"]
    for camera in asked:
        if camera not in recorded:
            help_ = suggestion(camera, recorded, what="it has") if recorded else "it has none"
            raise UsageError(f'{where} has no pictures of "{camera}"; {help_}')
    sizes = {(t["cameras"][c]["width"], t["cameras"][c]["height"]) for t in tasks for c in asked}
    if len(sizes) > 1:
        raise UsageError(
            f"{where} has pictures of several sizes; collect them in one by --size, such as 128"
        )
    (size,) = sizes
    if min(size) < SMALLEST_PICTURE:
        raise UsageError(
            f"{where} has pictures of {size[0]}x{size[1]} pixels; bc needs at least "
            f"{SMALLEST_PICTURE}x{SMALLEST_PICTURE}"
        )
    if max(size) > LARGEST_PICTURE:
        raise UsageError(
            f"{where} has pictures of {size[0]}x{size[1]} pixels; bc takes at most "
            f"{LARGEST_PICTURE}x{LARGEST_PICTURE}; collect smaller ones by --size, such as 128"
        )
    return {"camera_size": size, "renderer": about["renderer"]}


def check_recorded(
    dataset: Dataset, task: Task, options: Mapping[str, Any]
) -> Mapping[str, Sequence[str]]:
    """Check that a data set is of a task as it is now.

    Args:
        dataset: The data set.
        task: The task.
        options: Options of the environment that a policy will play in.

    Returns:
        The names of the numbers that robots observe with these options.

    Raises:
        UsageError: It is of another task, has no successful episodes, or its robots act or observe
            in another way. With the option ``observe: task``, they may observe what was not
            recorded.
    """
    where = display_path(dataset.folder)
    if task.name not in dataset.tasks:
        raise UsageError(
            f"{where} is of {', '.join(dataset.tasks)}, not of {task.name}; leave the task out, "
            f"or collect episodes of {task.name}"
        )
    successes(dataset, task.name)
    about = dataset.about["tasks"][task.name]
    recorded = {"observe": Options.observe, **options_of_dataset(dataset.about, cameras=False)}
    with closing(parallel_env(task, **options)) as env:
        longest, rate = about["max_episode_steps"], env.options.control_hz
        if longest > env.max_episode_steps:
            raise UsageError(
                f"{where} does not fit {task.name} as it is now: its episodes may have {longest} "
                f"control steps, and the task has {env.max_episode_steps}; collect anew"
            )
        if about["control_hz"] != (rate or task.file.spec.timing.control_hz):
            raise UsageError(
                f"{where} does not fit {task.name} as it is now: it was recorded with control_hz "
                f"{about['control_hz']}; collect anew"
            )
        names = dict(env.observation_names)
        same = recorded["observe"] == env.options.observe
        observed = names if same else _observed(task, recorded)
        for difference in _differences(about["robots"], env, observed):
            raise UsageError(f"{where} does not fit {task.name} as it is now: {difference}")
        _check_pictures(env, recorded=True)
        return names


def check_pictures(task: Task, options: Mapping[str, Any]) -> None:
    """Check that robots observe no pictures, for a run that learns from none.

    Args:
        task: The task.
        options: Options of the environment that a policy will play in.

    Raises:
        UsageError: The task file lists some.
    """
    with closing(parallel_env(task, **options)) as env:
        _check_pictures(env, recorded=False)


def _check_pictures(env: TaskEnv, *, recorded: bool) -> None:
    """Check that robots observe no pictures but those that a run learns from."""
    cameras = env.options.cameras
    for agent, space in env.observation_spaces.items():
        listed = [name for name in space if name != VECTOR] if isinstance(space, Dict) else []
        others = [name for name in listed if name.removesuffix(".rgb") not in cameras]
        if not others:
            continue
        advice = "training learns from numbers here; give --observe scene"
        if recorded and all(name.endswith(".rgb") for name in others):
            names = (*cameras, *(name.removesuffix(".rgb") for name in others))
            advice = f"give --cameras {','.join(names)}, or --observe scene"
        raise UsageError(f"{agent} observes {', '.join(others)}; {advice}")


def _observed(task: Task, options: Mapping[str, Any]) -> dict[str, Sequence[str]]:
    """Names of the numbers that agents observe with some options of the environment."""
    with closing(parallel_env(task, **options)) as env:
        return dict(env.observation_names)


def _differences(
    recorded: Mapping[str, Mapping[str, Any]], env: TaskEnv, observed: Mapping[str, Sequence[str]]
) -> Iterable[str]:
    """How robots differ from those of a data set, in words.

    Args:
        recorded: What the data set says of its robots.
        env: The environment.
        observed: Names of the numbers that robots observe there as in the data set.
    """
    if list(recorded) != env.possible_agents:
        there, here = ", ".join(recorded), ", ".join(env.possible_agents)
        yield f"it has {there}, and the task {here}; collect anew"
        return
    world = env.episode.world
    rules = rules_of(world.scene, world.task.robots)
    for agent, robot in recorded.items():
        if (model := world.robots[agent].model.name) != robot["model"]:
            yield f"{agent} was a {robot['model']}, and is a {model} in the task file; collect anew"
        action = world.scene.robots[agent].action.model_dump(mode="json")
        for name in (name for name in action if action[name] != robot["action"].get(name)):
            yield (
                f"action: {name} of {agent} was {robot['action'].get(name)} and is now "
                f"{action[name]}; collect anew, or put the task file back"
            )
        if (rule := rules.get(agent)) != (was_rule := robot.get("grasp", rule and "friction")):
            yield (
                f"{agent} held objects by {was_rule}, and does by {rule} now; collect anew, or put "
                "the task file back"
            )
        now = observed[agent]
        was = robot["observation_names"]
        missing, new = ([n for n in a if n not in b] for a, b in ((was, now), (now, was)))
        if missing or new or list(was) != list(now):
            changed = ", ".join((missing or new)[:3]) or "their order"
            verb = "no longer observes" if missing else "observes more or in another order:"
            yield f"{agent} {verb} {changed}; collect anew, or put the task file back"


def identity(dataset: Dataset) -> str:
    """What tells a data set from any other: the seal of its manifest."""
    return str(layout.read_manifest(dataset.folder)["seal"])
