"""What to train and how: a plan, checked once, and kept beside its results."""

from __future__ import annotations

import hashlib
import json
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from typing import Any

from taskbuilder.errors import UsageError, display_path
from taskbuilder.files import write_whole
from taskbuilder.learn.algorithms import check_name, find_algorithm
from taskbuilder.learn.learner import Preset
from taskbuilder.learn.policy import TrainedPolicy
from taskbuilder.learn.zoo import load_policy
from taskbuilder.wording import suggestion

FORMAT = 1
"""Of a run's folder; another one is not understood."""

RUN_FILE = "run.json"

_LATER = ("preset", "init", "device", "randomize")
"""Fields of a plan that the files of version 0.1 do not have."""

RENAMED_SETTINGS = {
    "cloning": "bc_updates",
    "judging": "critic_warmup_updates",
    "renew": "reset_networks_after",
}
"""Settings of maddpg by the names that they had in version 0.1, which still work in this one."""

REWARDS = ("team", "local", "shaped", "ratchet")


@dataclass(frozen=True)
class Plan:
    """What to train and how.

    Attributes:
        task: Its name or path.
        algorithm: One of those in `taskbuilder.learn.algorithms`.
        preset: Of the algorithm, that the settings came from; "" for none.
        reward: The training reward, one of `REWARDS`.
        steps: Control steps of all environments together.
        seed: Decides everything that chance decides.
        envs: Environments that are stepped at once.
        workers: Processes that run them; 0 for this one. Results do not depend on it.
        demos: Expert episodes that are mixed into learning.
        starts: Share of the training episodes that begin in a state of an expert episode.
        init: The trained policy to start from, by name; "" for none.
        device: Where networks are trained: ``cpu`` or ``cuda``.
        observe, frame, rotation, variation, randomize: Of the environments; see `Options`.
        evaluate_every: Control steps between evaluations.
        evaluate_episodes: Episodes of an evaluation.
        checkpoint_every: Control steps between checkpoints.
        stop_at: Stop once this success rate was reached by two evaluations in a row.
        settings: What is chosen of the algorithm's own, by name.
    """

    task: str
    algorithm: str = "maddpg"
    preset: str = ""
    reward: str = "ratchet"
    steps: int = 300_000
    seed: int = 0
    envs: int = 4
    workers: int = 0
    demos: int = 0
    starts: float = 0.0
    init: str = ""
    device: str = "cpu"
    observe: str = "task"
    frame: str = "base"
    rotation: str = "matrix"
    variation: int | str = 0
    randomize: bool = False
    evaluate_every: int = 10_000
    evaluate_episodes: int = 20
    checkpoint_every: int = 10_000
    stop_at: float | None = None
    settings: Mapping[str, Any] = field(default_factory=dict)

    @property
    def env(self) -> dict[str, Any]:
        """The options of the environments that a policy of this plan needs."""
        names = ("observe", "frame", "rotation", "variation")
        randomized = {"randomize": True} if self.randomize else {}
        return {**{name: getattr(self, name) for name in names}, **randomized}

    @property
    def track(self) -> str:
        """What helped: ``demos``, ``resets``, ``finetuned``, or nothing: ``scratch``."""
        helped = {"demos": self.demos, "resets": self.starts, "finetuned": self.init}
        return next((name for name, value in helped.items() if value), "scratch")

    def check(self) -> None:
        """Refuse what cannot be.

        Raises:
            UsageError: A value does not fit.
        """
        check_name(self.algorithm)
        _choice("reward", self.reward, REWARDS)
        _choice("device", self.device, ("cpu", "cuda"))
        for name in ("steps", "envs", "evaluate_every", "evaluate_episodes", "checkpoint_every"):
            if getattr(self, name) < 1:
                raise UsageError(f"{name} is {getattr(self, name)}; at least 1")
        if not 0 <= self.workers <= self.envs:
            raise UsageError(f"workers is {self.workers}; 0 to {self.envs}, the environments")
        for name in ("evaluate_every", "checkpoint_every"):
            if getattr(self, name) < self.envs:
                raise UsageError(f"{name} is less than the {self.envs} environments' step at once")
        if self.demos < 0 or self.seed < 0:
            raise UsageError("demos and seed are at least 0")
        for name in ("starts", "stop_at"):
            value = getattr(self, name)
            if value is not None and not 0.0 <= value <= 1.0:
                raise UsageError(f"{name} is {value}; 0 to 1")
        if self.variation == "random" and (self.demos or self.starts):
            raise UsageError(
                "the expert plays one variation; give --variation a number where --demos or "
                "--starts need its episodes"
            )


def make_plan(
    task: str,
    settings: Mapping[str, Any] | Sequence[str] = (),
    **given: Any,
) -> Plan:
    """A plan, what is not given being its preset's or the default.

    A run that starts from a trained policy takes over how that observes and acts, and the sizes
    of its networks.

    Args:
        task: Its name or path.
        settings: What is chosen of the algorithm's own: by name, or as on a command line.
        given: Fields of `Plan`; None stands for what is not given.

    Raises:
        UsageError: A name is unknown, a value does not fit, or the algorithm cannot do it.
        UnknownNameError: The zoo has no such policy.
    """
    known = {f.name: f.default for f in fields(Plan) if f.name != "settings"}
    for name in given:
        _choice("option", name, tuple(known))
    chosen = {name: value for name, value in given.items() if value is not None}
    algorithm = find_algorithm(chosen.get("algorithm", Plan.algorithm))
    init = load_policy(chosen["init"]) if chosen.get("init") else None
    if not chosen.get("preset"):
        chosen["preset"] = algorithm.default_preset(bool(chosen.get("demos")), init is not None)
    preset = Preset("")
    if chosen["preset"]:
        if not algorithm.presets:
            raise UsageError(f"{chosen['algorithm']} has no presets; leave --preset out")
        _choice("preset", chosen["preset"], tuple(algorithm.presets))
        preset = algorithm.presets[chosen["preset"]]
    trained = _env_of(init) if init else {}
    plan = Plan(**{"task": task, **preset.plan, **trained, **chosen})
    plan.check()
    for name, why in algorithm.cannot.items():
        if getattr(plan, name) != known[name]:
            raise UsageError(f"{plan.algorithm} {why}")
    own = (
        _checked_settings(algorithm.settings, settings)
        if isinstance(settings, Mapping)
        else read_settings(algorithm.settings, settings)
    )
    fitting = algorithm.settings_of(init) if init else {}
    return replace(plan, settings={**preset.settings, **fitting, **own})


def _env_of(policy: TrainedPolicy) -> dict[str, Any]:
    """How the environment of a trained policy is observed and acted in."""
    options = policy.about.get("env", {})
    return {name: options[name] for name in ("observe", "frame", "rotation") if name in options}


def _checked_settings(kind: type[Any], chosen: Mapping[str, Any]) -> dict[str, Any]:
    return read_settings(kind, [f"{name}={json.dumps(value)}" for name, value in chosen.items()])


def read_settings(kind: type[Any], texts: Sequence[str]) -> dict[str, Any]:
    """Settings as they are written on a command line: ``noise=0.2``, ``hidden=[64,64]``.

    Args:
        kind: The dataclass that has them.
        texts: Name, "=", and a value in JSON.

    Raises:
        UsageError: There is no such setting, or the value is of another kind.
    """
    known = {f.name: f.default for f in fields(kind)}
    chosen = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if name in RENAMED_SETTINGS and RENAMED_SETTINGS[name] in known:
            name = renamed(name)
        _choice("setting", name, tuple(known))
        if not equals:
            raise UsageError(f'"{text}" sets nothing; write {name}={json.dumps(known[name])}')
        chosen[name] = _value(name, value, known[name])
    return chosen


def renamed(setting: str) -> str:
    """A setting's present name; warns where it had another."""
    name = RENAMED_SETTINGS.get(setting, setting)
    if name != setting:
        warnings.warn(
            f"the setting {setting} is called {name} now; the old name goes with the next version",
            FutureWarning,
            stacklevel=2,
        )
    return name


def _value(name: str, text: str, default: Any) -> Any:
    try:
        value = json.loads(text)
    except json.JSONDecodeError:
        value = None
    if isinstance(default, tuple) and isinstance(value, list):
        if value and all(isinstance(item, int) and item > 0 for item in value):
            return tuple(value)
    elif isinstance(default, bool) or isinstance(value, bool):
        if isinstance(value, bool) and isinstance(default, bool):
            return value
    elif isinstance(default, int) and isinstance(value, int):
        return value
    elif isinstance(default, float) and isinstance(value, int | float):
        return float(value)
    raise UsageError(f'{name} is "{text}"; something like {json.dumps(default)}')


def make_settings(kind: type[Any], chosen: Mapping[str, Any]) -> Any:
    """An algorithm's settings, the chosen ones in place of its own."""
    tuples = {k: tuple(v) if isinstance(v, list) else v for k, v in chosen.items()}
    return replace(kind(), **tuples)


def save_plan(folder: Path, plan: Plan, more: Mapping[str, Any]) -> None:
    """Write the plan, and more about the run, into its folder.

    Raises:
        OSError: It cannot be written.
    """
    about = {"format": FORMAT, **asdict(plan), "env": plan.env, "track": plan.track, **more}
    text = json.dumps(about, indent=1) + "\n"
    write_whole(folder / RUN_FILE, text.encode(), sync=True)


def load_plan(folder: Path) -> tuple[Plan, dict[str, Any]]:
    """Read the plan of a run, and what else its file says.

    Raises:
        UsageError: There is no run, or one that this version does not understand.
    """
    file, name = folder / RUN_FILE, display_path(folder)
    if not file.is_file():
        raise UsageError(f"{name} is no training run; it has no {RUN_FILE}")
    try:
        about = json.loads(file.read_text(encoding="utf-8"))
        found = about["format"]
        if found == FORMAT:
            later = {name: getattr(Plan, name) for name in _LATER if name not in about}
            plan = Plan(**{f.name: {**later, **about}[f.name] for f in fields(Plan)})
            settings = {renamed(name): value for name, value in plan.settings.items()}
            plan = replace(plan, settings=settings)
    except (ValueError, KeyError, TypeError) as error:
        raise UsageError(f"{display_path(file)} is damaged: {error}") from None
    if found != FORMAT:
        raise UsageError(f"{name} is a run of format {found}; this version reads {FORMAT}")
    plan.check()
    return plan, about


def digest(files: Sequence[Path]) -> str:
    """A short fingerprint of files, to notice that a task is another by now."""
    sha = hashlib.sha256()
    for file in files:
        sha.update(file.read_bytes())
    return sha.hexdigest()[:16]


def _choice(name: str, value: str, choices: Sequence[str]) -> None:
    if value not in choices:
        raise UsageError(f'no {name} "{value}"; {suggestion(str(value), choices, what="one of")}')
