"""The plan of a training run: its options and settings, checked once and saved with the run."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any, get_args

from taskbuilder.arguments import as_whole, whole
from taskbuilder.data.dataset import Dataset, load_dataset
from taskbuilder.env.options import (
    EnvOptions,
    Options,
    from_json,
    make_options,
    option_infos,
    options_about,
)
from taskbuilder.errors import UsageError, display_path
from taskbuilder.files import write_whole
from taskbuilder.learn.algorithms import check_name, find_algorithm
from taskbuilder.learn.learner import Preset
from taskbuilder.learn.recordings import recorded_options
from taskbuilder.learn.settings import check_values, read_settings
from taskbuilder.policies.runs import FORMAT, RUN_FILE, read_run
from taskbuilder.policies.trained import TrainedPolicy
from taskbuilder.policies.zoo import load_policy
from taskbuilder.schema.choices import LadderChoice
from taskbuilder.wording import excerpt, suggestion

REWARDS = ("team", "local", "sparse", "shaped", "ratchet")

PICTURES = options_about("pictures")
"""Options of the pictures that policies observe."""


def trained_options() -> tuple[str, ...]:
    """The options of environments that a run chooses, besides those of pictures."""
    return options_about("scene", "observed")


_FOR_TRAINING: EnvOptions = {"frame": "base", "rotation": "matrix"}
"""Options with another default in training."""

_PACES = {"paces": True}
"""Metadata of a field that decides when and where a run does what, and not what is learned."""

_PRACTICE = {"practice": True}
"""Metadata of a field of runs that practise in environments; runs on a data set do not use it."""


@dataclass(frozen=True)
class Plan:
    """The options and settings of a training run.

    Attributes:
        task: Name or path of the task.
        algorithm: The algorithm, one of those in `taskbuilder.learn.algorithms`.
        preset: The preset that the settings came from; "" for none.
        reward: The training reward, one of `REWARDS`.
        steps: Control steps, summed over all environments; with a data set, updates.
        seed: Seed of everything random in the run.
        envs: Number of parallel environments.
        workers: Processes for the environments; 0 for this one. Results do not depend on it.
        demos: Number of expert episodes to learn from, or the data set that has them.
        starts: Fraction of the training episodes that begin in a state of an expert episode.
        no_progress_timeout_s: Time without progress after which a training episode ends, in
            seconds. None while it is not measured; in runs of earlier versions, for that of the
            training reward.
        ladder: Where the progress that training sees comes from: ``task`` for the description, or
            ``expert`` for the expert's stages. None if training needs none; in runs of earlier
            versions, for the unscaled progress of the description.
        progress_range: The values of the description's progress that are mapped to 0 and to 1.
        init: The trained policy to start from, by name; "" for none.
        data: The data set to learn from, for algorithms that learn from one; "" for none.
        teachers: The trained policies that played its episodes; none where experts did.
        device: Device of the networks: ``cpu`` or ``cuda``.
        options: Options of the environments. Their reward is that of ``reward``.
        evaluate_every: Control steps between evaluations.
        evaluate_episodes: Episodes per evaluation.
        film_every: Evaluations between films of an episode; 0 for no films.
        checkpoint_every: Control steps between checkpoints.
        stop_at: Stop when, in two evaluations in a row, success holds at the last control step in
            this share of the episodes.
        settings: Settings of the algorithm that differ from its defaults, by name.
    """

    task: str
    algorithm: str = "maddpg"
    preset: str = field(default="", metadata=_PACES)  # its settings are among the settings
    reward: str = field(default="ratchet", metadata=_PRACTICE)
    steps: int = field(default=300_000, metadata=_PACES)
    seed: int = field(default=0, metadata=_PACES)
    envs: int = field(default=4, metadata=_PRACTICE)
    workers: int = field(default=0, metadata=_PACES)
    demos: int | str = field(default=0, metadata=_PRACTICE)
    starts: float = field(default=0.0, metadata=_PRACTICE)
    no_progress_timeout_s: float | None = field(default=None, metadata=_PRACTICE)
    ladder: LadderChoice | None = field(default=None, metadata=_PRACTICE)
    progress_range: tuple[float, float] | None = field(default=None, metadata=_PRACTICE)
    init: str = ""
    data: str = ""
    teachers: tuple[str, ...] = ()
    device: str = field(default="cpu", metadata=_PACES)
    options: Options = field(default_factory=lambda: make_options(**_FOR_TRAINING))
    evaluate_every: int = field(default=10_000, metadata=_PACES)
    evaluate_episodes: int = field(default=20, metadata=_PACES)
    film_every: int = field(default=10, metadata=_PACES)
    checkpoint_every: int = field(default=10_000, metadata=_PACES)
    stop_at: float | None = field(default=None, metadata=_PACES)
    settings: Mapping[str, Any] = field(default_factory=dict)

    @property
    def env(self) -> dict[str, Any]:
        """The options of the environments that a policy of this plan needs."""
        chosen, infos = self.options.chosen, option_infos()
        observed = {name for name in options_about("observed") if not infos[name].disturbs}
        return {
            name: getattr(self.options, name)
            for name in (*trained_options(), *(PICTURES if self.options.cameras else ()))
            if name in chosen or name in observed or name in PICTURES
        }

    @property
    def values(self) -> dict[str, Any]:
        """The fields, with each option of the environments as one of its own."""
        own = {each.name: getattr(self, each.name) for each in fields(self)}
        settings = own.pop("settings")
        del own["options"]
        options = {name: getattr(self.options, name) for name in (*trained_options(), *PICTURES)}
        return {**own, **options, "settings": settings}

    @property
    def experiment(self) -> dict[str, Any]:
        """What two runs have in common that differ only in the seed, or in what paces them."""
        unlike = {each.name for each in fields(self) if "paces" in each.metadata}
        if self.data:
            unlike |= {each.name for each in fields(self) if "practice" in each.metadata}
        return {name: value for name, value in self.values.items() if name not in unlike}

    @property
    def track(self) -> str:
        """The kind of help that the run gets; ``scratch`` if none."""
        helped = {
            "distilled": self.teachers,
            "cloned": self.data,
            "demos": self.demos,
            "resets": self.starts,
            "finetuned": self.init,
        }
        return next((name for name, value in helped.items() if value), "scratch")

    def films_at(self, step: int) -> bool:
        """Whether the evaluation at a step is filmed."""
        return bool(self.film_every) and step // self.evaluate_every % self.film_every == 0

    def check(self) -> None:
        """Check all values.

        Raises:
            UsageError: A value is invalid.
        """
        check_name(self.algorithm)
        _choice("reward", self.reward, REWARDS)
        _choice("device", self.device, ("cpu", "cuda"))
        if self.ladder is not None:
            _choice("ladder", self.ladder, get_args(LadderChoice))
        self.options.check()
        for name in ("steps", "envs", "evaluate_every", "evaluate_episodes", "checkpoint_every"):
            whole(name, getattr(self, name), 1)
        for name in ("seed", "film_every"):
            whole(name, getattr(self, name))
        if not isinstance(self.demos, str):
            whole("demos", self.demos)
        if as_whole(self.workers) is None or not 0 <= self.workers <= self.envs:
            raise UsageError(f"workers is {self.workers}; 0 to {self.envs}, the environments")
        for name in ("evaluate_every", "checkpoint_every"):
            if getattr(self, name) < self.envs:
                raise UsageError(f"{name} is less than the {self.envs} environments' step at once")
        for name in ("starts", "stop_at"):
            value = getattr(self, name)
            if value is not None and not 0.0 <= value <= 1.0:
                raise UsageError(f"{name} is {value}; 0 to 1")
        timeout = self.no_progress_timeout_s
        if timeout is not None and not timeout > 0.0:
            raise UsageError(f"no_progress_timeout_s is {timeout:g}; seconds, more than 0")
        if self.options.variation == "random" and (self.demos or self.starts):
            raise UsageError(
                "the expert plays one variation; give --variation a number where --demos or "
                "--starts need its episodes"
            )


def make_plan(
    task: str,
    settings: Mapping[str, Any] | Sequence[str] = (),
    **given: Any,
) -> Plan:
    """Make a plan from the given values, the preset and the defaults.

    A run that starts from a trained policy takes over its observation options and network sizes.

    Args:
        task: Name or path of the task.
        settings: Settings of the algorithm, as a mapping or as texts such as ``noise=0.2``.
        given: Fields of `Plan`, and options of its environments; None is the same as not given.
            ``data`` may be an open data set.

    Raises:
        UsageError: A name is unknown, a value is invalid, or the algorithm does not support it.
        UnknownNameError: The zoo has no such policy.
    """
    defaults = Plan("").values
    del defaults["settings"]
    for name in given:
        _choice("option", name, tuple(defaults))
    chosen = {name: value for name, value in given.items() if value is not None}
    names = chosen.keys() & {*trained_options(), *PICTURES}
    options = make_options(**{name: chosen[name] for name in names})
    chosen |= {name: getattr(options, name) for name in names}
    algorithm = find_algorithm(chosen.get("algorithm", Plan.algorithm))
    init = load_policy(chosen["init"]) if chosen.get("init") else None
    if not chosen.get("preset"):
        chosen["preset"] = algorithm.default_preset(chosen)
    preset = Preset("")
    if chosen["preset"]:
        if not algorithm.presets:
            raise UsageError(f"{chosen['algorithm']} has no presets; leave --preset out")
        _choice("preset", chosen["preset"], tuple(algorithm.presets))
        preset = algorithm.presets[chosen["preset"]]
    check_source(chosen)
    trained = _env_of(init) if init else {}
    for name in ("data", "demos"):
        opened = chosen.get(name, 0)
        if isinstance(opened, int):
            continue
        dataset = opened if isinstance(opened, Dataset) else load_dataset(opened)
        trained = recorded_options(dataset, chosen) | ({"envs": 1} if name == "data" else {})
        if name == "demos":
            del trained["teachers"]
        chosen[name] = str(Path(dataset.folder).resolve())
    if algorithm.from_data:
        chosen["cameras"] = tuple(chosen.get("cameras", ()))
    plan = plan_of({"task": task, **preset.plan, **trained, **chosen})
    plan.check()
    for name, why in algorithm.refused.items():
        if plan.values[name] != defaults[name]:
            raise UsageError(f"{plan.algorithm} {why}")
    own = read_settings(algorithm.settings, settings)
    fitting = algorithm.settings_of(init) if init else {}
    return replace(plan, settings={**preset.settings, **fitting, **own})


def plan_of(values: Mapping[str, Any]) -> Plan:
    """The plan of some values, with each option of the environments as one of its own."""
    own = {name: value for name, value in values.items() if name in Plan.__dataclass_fields__}
    options = {name: value for name, value in values.items() if name not in own}
    return Plan(**own, options=make_options(**{**_FOR_TRAINING, **options}))


def check_source(chosen: Mapping[str, Any]) -> None:
    """Check that a data set is given if, and only if, the algorithm learns from one.

    Args:
        chosen: The fields of the plan that are given.

    Raises:
        UsageError: It is otherwise.
    """
    name = chosen.get("algorithm") or Plan.algorithm
    algorithm = find_algorithm(name)
    if algorithm.from_data and not chosen.get("data"):
        raise UsageError(
            f"{name} learns from a data set; name one by --data DIR (taskbuilder collect makes one)"
        )
    if algorithm.from_data and chosen.get("envs") is not None:
        raise UsageError(f"{name} learns from the data set alone; leave --envs out")
    for option in ("no_progress_timeout_s", "ladder"):
        if algorithm.from_data and chosen.get(option) is not None:
            flag = f"--{option.replace('_', '-')}"
            raise UsageError(f"{name} learns from the data set alone; leave {flag} out")
    for option in ("data", "cameras"):
        if chosen.get(option) and not algorithm.from_data:
            raise UsageError(f"{name} learns from no data set; --algorithm bc does")


def _env_of(policy: TrainedPolicy) -> dict[str, Any]:
    """The observation options of a trained policy's environment."""
    options = from_json(policy.about.get("env", {}))
    kept = [name for name in trained_options() if option_infos()[name].decides_policy]
    return {name: options[name] for name in kept if name in options and name != "variation"}


def save_plan(folder: Path, plan: Plan, more: Mapping[str, Any]) -> None:
    """Write the plan and other information about the run into its folder.

    Raises:
        OSError: It cannot be written.
    """
    about = {"format": FORMAT, **plan.values, "env": plan.env, "track": plan.track, **more}
    text = json.dumps(about, indent=1) + "\n"
    write_whole(folder / RUN_FILE, text.encode(), sync=True)


def load_plan(folder: Path) -> tuple[Plan, dict[str, Any]]:
    """Read the plan of a run, and the other contents of its file.

    Raises:
        UsageError: There is no run, or its format is not supported.
    """
    about = read_run(folder)
    try:
        values = from_json({n: about[n] for n in Plan.__dataclass_fields__ if n in about})
        # No default would be what the run was begun with.
        check_values(Plan, values, needed=("task", "steps", "seed"))
        plan = plan_of({**values, **from_json(about["env"])})
    except (ValueError, KeyError, TypeError) as error:
        where = display_path(folder / RUN_FILE)
        raise UsageError(f"{where} is damaged: {excerpt(error)}") from None
    _check_package(plan.algorithm, about.get("algorithm_package"))
    plan.check()
    return plan, about


def _check_package(algorithm: str, package: Any) -> None:
    """Name the package that a run's algorithm is of, if it is not there.

    Raises:
        UsageError: It is not there.
    """
    try:
        check_name(algorithm)
    except UsageError as error:
        if not isinstance(package, str) or not package:
            raise
        raise UsageError(
            f'the algorithm "{algorithm}" of this run is of the package {package}, which is not '
            "here; install it first"
        ) from error


def digest(files: Sequence[Path]) -> str:
    """A short digest of files, to detect that a task has changed."""
    sha = hashlib.sha256()
    for file in files:
        sha.update(file.read_bytes())
    return sha.hexdigest()[:16]


def _choice(name: str, value: str, choices: Sequence[str]) -> None:
    if value not in choices:
        raise UsageError(f'no {name} "{value}"; {suggestion(str(value), choices, what="one of")}')
