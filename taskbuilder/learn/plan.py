"""What to train and how: a plan, checked once, and kept beside its results."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from typing import Any

from taskbuilder.errors import UsageError, display_path
from taskbuilder.files import write_whole
from taskbuilder.wording import suggestion

FORMAT = 1
"""Of a run's folder; another one is not understood."""

RUN_FILE = "run.json"

ALGORITHMS = ("maddpg", "maddpg_openai")
WITH_DEMOS = {"noise": 0.1, "final_noise": 0.05, "lr_half_life": 30_000, "regulariser": 0.005}
"""What learning with demonstrations changes of maddpg's settings: it begins with a policy that is
almost right, which much noise would hide, and that moves as fast as experts do."""

FROM_NOTHING = {"discount": 0.95, "actor_norms": True, "renew": 50_000}
"""What learning without demonstrations changes: what is met early is unlike what is met late."""

REWARDS = ("team", "local", "shaped", "ratchet")


@dataclass(frozen=True)
class Plan:
    """What to train and how.

    Attributes:
        task: Its name or path.
        algorithm: One of `ALGORITHMS`.
        reward: What learners are paid, one of `REWARDS`.
        steps: Control steps of all environments together.
        seed: Decides everything that chance decides.
        envs: Environments that are stepped at once.
        workers: Processes that run them; 0 for this one. Results do not depend on it.
        demos: Expert episodes that are mixed into learning.
        starts: Share of the training episodes that begin in a state of an expert episode.
        observe, frame, rotation, variation: Of the environments; see `Options`.
        evaluate_every: Control steps between evaluations.
        evaluate_episodes: Episodes of an evaluation.
        checkpoint_every: Control steps between checkpoints.
        stop_at: Stop once this success rate was reached by two evaluations in a row.
        settings: What is chosen of the algorithm's own, by name.
    """

    task: str
    algorithm: str = "maddpg"
    reward: str = "ratchet"
    steps: int = 300_000
    seed: int = 0
    envs: int = 4
    workers: int = 0
    demos: int = 0
    starts: float = 0.0
    observe: str = "task"
    frame: str = "base"
    rotation: str = "matrix"
    variation: int | str = 0
    evaluate_every: int = 10_000
    evaluate_episodes: int = 20
    checkpoint_every: int = 10_000
    stop_at: float | None = None
    settings: Mapping[str, Any] = field(default_factory=dict)

    @property
    def env(self) -> dict[str, Any]:
        """The options of the environments that a policy of this plan needs."""
        names = ("observe", "frame", "rotation", "variation")
        return {name: getattr(self, name) for name in names}

    @property
    def preset(self) -> Mapping[str, Any]:
        """What this kind of learning changes of the algorithm's settings."""
        if self.algorithm == "maddpg":
            return WITH_DEMOS if self.demos else FROM_NOTHING
        return {}

    @property
    def track(self) -> str:
        """What helped: ``demos``, ``resets``, or nothing: ``scratch``."""
        return "demos" if self.demos else "resets" if self.starts else "scratch"

    def check(self) -> None:
        """Refuse what cannot be.

        Raises:
            UsageError: A value does not fit.
        """
        _choice("algorithm", self.algorithm, ALGORITHMS)
        _choice("reward", self.reward, REWARDS)
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
        if self.algorithm == "maddpg_openai" and self.demos:
            raise UsageError("maddpg_openai learns from no demonstrations; maddpg does")


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
        _choice("setting", name, tuple(known))
        if not equals:
            raise UsageError(f'"{text}" sets nothing; write {name}={json.dumps(known[name])}')
        chosen[name] = _value(name, value, known[name])
    return chosen


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
            plan = Plan(**{f.name: about[f.name] for f in fields(Plan)})
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
        help_ = suggestion(str(value), choices, what="one of")
        raise UsageError(f'no {name} "{value}"; {help_}')
