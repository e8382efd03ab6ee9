"""What is to be collected, and what a data set says of itself."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import asdict, dataclass, field
from pathlib import Path
from secrets import token_hex
from typing import Any

from taskbuilder.arguments import SEED_LIMIT, as_whole, whole
from taskbuilder.carried import carry, digests_of
from taskbuilder.data.layout import FORMAT, KIND
from taskbuilder.data.machines import machine_changes, machine_here
from taskbuilder.data.recording import Cameras
from taskbuilder.data.videos import LARGEST_SIDE
from taskbuilder.digests import differences, digest_of
from taskbuilder.env.options import Renderer, make_options
from taskbuilder.env.parallel import TaskEnv, parallel_env
from taskbuilder.errors import UsageError, display_path
from taskbuilder.policies.mixture import PolicyShare, policy_of, round_of
from taskbuilder.schema.catalogue import Catalogue, looks_like_path
from taskbuilder.schema.expert import stage_labels
from taskbuilder.schema.grasping import rules_of
from taskbuilder.sources import digests_of_library, digests_of_task
from taskbuilder.task import Task, load_task


@dataclass(frozen=True, eq=False)
class CollectPlan:
    """What is to be collected; picklable for other processes.

    Attributes:
        tasks: Names or paths of the tasks.
        episodes: Episodes of each task, or of each of its variations.
        per_variation: Whether ``episodes`` are those of each variation.
        policies: Who plays; they take turns.
        cameras: What is recorded of the cameras.
        options: Options of the environment, by name, besides the variation.
        renderer: What draws the pictures.
        variations: Variations to play, in turn; None for all of each task.
        first_seed: Seed of the first attempt; later ones have the next seeds.
        keep_failures: Keep episodes without success, too.
        until_success: Control steps to record after success was reached; None for whole episodes.
        license: Licence that the card states.
        policy_digests: Digest of the file of each trained policy, by its name.
        catalogue: The catalogue that tasks are looked up in.
        token: Identifies the plan in processes that receive it more than once.
    """

    tasks: tuple[str, ...]
    episodes: int
    policies: tuple[PolicyShare, ...] = (PolicyShare("expert"),)
    cameras: Cameras = field(default_factory=Cameras)
    options: Mapping[str, Any] = field(default_factory=dict)
    renderer: Renderer = "auto"
    variations: tuple[int, ...] | None = (0,)
    first_seed: int = 0
    keep_failures: bool = False
    per_variation: bool = False
    until_success: int | None = None
    license: str = "MIT"
    policy_digests: Mapping[str, str] = field(default_factory=dict)
    catalogue: Catalogue = field(default_factory=Catalogue.discover)
    token: str = field(default_factory=lambda: token_hex(8))

    def make_env(self, task: Task, variation: int) -> TaskEnv:
        """Make the environment of a task and a variation."""
        return parallel_env(task, variation=variation, renderer=self.renderer, **self.options)

    def played(self, task: Task) -> tuple[int, ...]:
        """The variations of a task that are played."""
        return self.variations or tuple(range(len(task.file.scenes)))

    def machine(self) -> dict[str, Any]:
        """What the bits of episodes depend on that are played on this machine."""
        return machine_here(pictures=bool(self.cameras.names))

    def load(self, reference: str) -> Task:
        """Load a task of the plan."""
        return load_task(reference, catalogue=self.catalogue)


@dataclass(frozen=True)
class Attempt:
    """An episode to play; it is kept if it succeeds, or if failures are kept.

    Attributes:
        reference: Name or path of the task.
        task: Its id.
        seed: Seed passed to `reset`.
        variation: The variation.
        policy: Who plays.
    """

    reference: str
    task: str
    seed: int
    variation: int
    policy: str

    @property
    def name(self) -> str:
        """The name of the episode, and of its folder."""
        return f"{self.task.replace('/', '-')}-{self.seed:09d}"


def attempt_of(plan: CollectPlan, reference: str, task: Task, number: int) -> Attempt:
    """An attempt at an episode of a task, counted from 0; its variations take turns."""
    variations = plan.played(task)
    turn = number // round_of(plan.policies)
    return Attempt(
        reference,
        task.name,
        plan.first_seed + number,
        variations[turn % len(variations)],
        policy_of(plan.policies, number),
    )


def attempt_at(
    plan: CollectPlan, reference: str, task: Task, variation: int, number: int
) -> Attempt:
    """An attempt at an episode of one variation, counted from 0 for each variation.

    No two attempts have the same seed, because seeds alternate between the variations.
    """
    variations = plan.played(task)
    seed = plan.first_seed + number * len(variations) + variations.index(variation)
    return Attempt(reference, task.name, seed, variation, policy_of(plan.policies, number))


# --- checking


def check_plan(plan: CollectPlan, tasks: Sequence[Task]) -> None:
    """Refuse what cannot be collected before anything is.

    Raises:
        UsageError: A number is out of bounds, a task has no such variation, or a picture has an
            odd size.
        UnknownNameError: A task has no such camera.
    """
    whole("episodes", plan.episodes)  # none where people record as many as they like
    whole("first_seed", plan.first_seed, 0, SEED_LIMIT - 1)
    if plan.until_success is not None:
        whole("until_success", plan.until_success)
    if plan.cameras.depth and not plan.cameras.names:
        raise UsageError("depth images are those of cameras, and none is named; name some")
    if not isinstance(plan.license, str):
        raise UsageError(f"the licence is {plan.license!r}; a name, such as MIT")
    if not plan.license.isprintable() or not 1 <= len(plan.license) <= 200:
        raise UsageError("the licence is a name on one line, of at most 200 letters, such as MIT")
    names = [task.name for task in tasks]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice:
        raise UsageError(f"{twice} is named twice")
    for robot, model in make_options(**plan.options).robots:
        if looks_like_path(model):
            raise UsageError(
                f"--robot {robot}={display_path(Path(model))}: a data set names robots of the "
                f"catalogue, which others can look up; name the folder of its file by --task-path, "
                f"and give --robot {robot}=NAME"
            )
    for task in tasks:
        _check_task(plan, task)


def _check_task(plan: CollectPlan, task: Task) -> None:
    scenes = task.file.scenes
    for variation in plan.variations or ():
        if as_whole(variation) not in range(len(scenes)):
            raise UsageError(
                f"{task.name} has no variation {variation!r}; it has 0 to {len(scenes) - 1}"
            )
    cameras = task.file.spec.scene.cameras
    task.file.check_cameras(plan.cameras.names)
    for name in plan.cameras.names:
        width, height = plan.cameras.size or cameras[name].size
        if width % 2 or height % 2:
            raise UsageError(
                f"{name} has {width}x{height} pixels; videos need an even width and height, so "
                "give another --size"
            )
        if max(width, height) > LARGEST_SIDE:
            raise UsageError(
                f"{name} has {width}x{height} pixels; videos have at most {LARGEST_SIDE} in width "
                "and height, so give another --size"
            )
    make_options(**plan.options).applied(task)


# --- the description


def describe(plan: CollectPlan, tasks: Sequence[Task]) -> dict[str, Any]:
    """What a data set says of itself; the same for the same plan, files and machine."""
    described = dict(_described(plan, task) for task in tasks)
    drawn = {about.pop("renderer") for about in described.values()}
    return {
        "kind": KIND,
        "format": FORMAT,
        "license": plan.license,
        "collected": {
            "episodes": plan.episodes,
            "policies": [asdict(share) for share in plan.policies],
            "policy_digests": dict(plan.policy_digests),
            "cameras": list(plan.cameras.names),
            "size": list(plan.cameras.size) if plan.cameras.size else None,
            "depth": plan.cameras.depth,
            "variations": list(plan.variations) if plan.variations is not None else "all",
            "first_seed": plan.first_seed,
            "keep_failures": plan.keep_failures,
            "per_variation": plan.per_variation,
            "until_success": plan.until_success,
        },
        "options": _listed(plan.options),
        "renderer": drawn.pop() if plan.cameras.names else None,
        "tasks": described,
        "library": digest_of(digests_of_library()),
        **plan.machine(),
    }


def _listed(options: Mapping[str, Any]) -> dict[str, Any]:
    return {n: list(v) if isinstance(v, tuple) else v for n, v in options.items()}


def _described(plan: CollectPlan, task: Task) -> tuple[str, dict[str, Any]]:
    spec = task.file.spec
    with closing(plan.make_env(task, (plan.variations or (0,))[0])) as env:
        world = env.episode.world
        return task.name, {
            "task_version": task.version,
            "summary": spec.summary,
            "instructions": list(spec.instructions),
            "agents": list(env.possible_agents),
            "control_hz": env.options.control_hz or spec.timing.control_hz,
            "physics_hz": spec.timing.physics_hz,
            "max_episode_steps": env.max_episode_steps,
            "variations": len(task.file.scenes),
            "stages": list(task.description.stages),
            "terms": list(env.episode.outcome.terms),
            "conditions": list(env.episode.outcome.conditions),
            "expert": list(stage_labels(spec.expert)),
            "robots": {name: _robot(env, name) for name in env.possible_agents},
            "objects": list(world.movable),
            "state_names": list(env.state_names),
            "cameras": {name: _camera(plan, env, name) for name in plan.cameras.names},
            "files": dict(digests_of_task(task)),
            "carried": _carried(task),
            "renderer": world.client.renderer,
        }


def _carried(task: Task) -> dict[str, Any] | None:
    """What is recorded of a task that comes with the data set; None if a package has it."""
    carried = carry(task)
    if carried is None:
        return None
    files = digests_of(carried.files)
    return {"file": carried.file, "folders": list(carried.folders), "files": files}


def _robot(env: TaskEnv, name: str) -> dict[str, Any]:
    world, actions = env.episode.world, env.episode.actions[name]
    robot = world.robots[name]
    return {
        "model": robot.model.name,
        "grasp": rules_of(world.scene, world.task.robots).get(name),
        "action": world.scene.robots[name].action.model_dump(mode="json"),
        "action_names": list(actions.names),
        "action_low": actions.low.tolist(),
        "action_high": actions.high.tolist(),
        "observation_names": list(env.observation_names[name]),
        "joint_names": [f"{name}.joint_{n}" for n in range(1, robot.dof + 1)],
        "urdf_joints": [joint.name for joint in robot.model.arm],
    }


def _camera(plan: CollectPlan, env: TaskEnv, name: str) -> dict[str, Any]:
    spec = env.episode.world.scene.cameras[name]
    width, height = plan.cameras.size or spec.size
    return {"width": width, "height": height, "fov_deg": spec.fov_deg, "mount": spec.mount}


# --- comparing


def changes(there: Mapping[str, Any], here: Mapping[str, Any]) -> Iterator[str]:
    """Why a data set that was begun cannot be continued, in words.

    Args:
        there: What it says of itself.
        here: What it would say if it were begun now.
    """
    was, now = there.get("collected", {}), here["collected"]
    for name in dict.fromkeys((*was, *now)):
        if was.get(name) != now.get(name):
            yield f"{name} is {now.get(name)} now and was {was.get(name)}"
    for name in ("options", "license", "renderer"):
        if there.get(name) != here[name]:
            yield f"{name} is {here[name]} now and was {there.get(name)}"
    yield from _task_changes(there.get("tasks", {}), here["tasks"])
    if there.get("library") != here["library"]:
        yield "taskbuilder's own files changed"
    for what, was_, now_ in machine_changes(there, here):
        yield f"{what} is {now_} now and was {was_}"


def _task_changes(there: Mapping[str, Any], here: Mapping[str, Any]) -> Iterator[str]:
    if list(there) != list(here):
        yield f"the tasks are {', '.join(here)} now and were {', '.join(there)}"
        return
    for name, about in here.items():
        changed = differences(there[name].get("files", {}), about["files"])
        if changed:
            yield f"files of {name} changed: {', '.join(changed)}"
