"""Saving and loading rollouts, several in one file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

from taskbuilder.arrays import Arrays, StoreError, read_arrays, write_arrays
from taskbuilder.description.reasons import Reason
from taskbuilder.env.options import from_json, make_options
from taskbuilder.errors import UsageError, display_path
from taskbuilder.rollout.record import BY_STATE, BY_STEP, ON_REQUEST, Rollout, ScriptLog, Trouble

FORMAT = 1
"""Version of the file format; others are refused."""

_KIND = "rollouts"
_ARRAYS = (*BY_STEP, *BY_STATE, *ON_REQUEST)


def save_rollouts(path: Path, rollouts: Sequence[Rollout]) -> None:
    """Write rollouts to a file, atomically.

    Args:
        path: Path of the file.
        rollouts: The rollouts; `load_rollouts` returns them in this order.

    Raises:
        OSError: It cannot be written.
    """
    arrays: Arrays = {}
    for number, rollout in enumerate(rollouts):
        for name in _ARRAYS:
            arrays |= dict(_leaves(f"{number}/{name}", getattr(rollout, name)))
    about = {"kind": _KIND, "format": FORMAT, "rollouts": [_about(r) for r in rollouts]}
    write_arrays(path, arrays, about)


def load_rollouts(path: Path) -> tuple[Rollout, ...]:
    """Read the rollouts of a file.

    Raises:
        StoreError: It is damaged, of another kind, or of an unsupported version.
        OSError: It cannot be read.
    """
    arrays, about = read_arrays(path, _KIND)
    if about.get("format") != FORMAT:
        found = about.get("format")
        raise StoreError(f"{display_path(path)}: has format {found}; this version reads {FORMAT}")
    try:
        parts: list[dict[str, Any]] = [{} for _ in about["rollouts"]]
        for name, array in arrays.items():
            number, _, rest = name.partition("/")
            _put(parts[int(number)], rest, array)
        pairs = zip(about["rollouts"], parts, strict=True)
        return tuple(_rollout(told, held) for told, held in pairs)
    except (KeyError, ValueError, TypeError, IndexError, UsageError) as error:
        raise StoreError(f"{display_path(path)}: lacks parts of a rollout ({error})") from None


def _leaves(name: str, value: Any) -> Sequence[tuple[str, Any]]:
    """All arrays, by their path of names."""
    if not isinstance(value, Mapping):
        return [(name, value)]
    return [leaf for key, part in value.items() for leaf in _leaves(f"{name}/{key}", part)]


def _put(parts: dict[str, Any], name: str, array: Any) -> None:
    """Insert an array at its path; only observations are nested twice."""
    field, _, key = name.partition("/")
    if not key:
        parts[field] = array
        return
    agent, _, channel = key.partition("/")
    group = parts.setdefault(field, {})
    if field == "observations" and channel:
        group.setdefault(agent, {})[channel] = array
    else:
        group[key] = array


def _about(rollout: Rollout) -> dict[str, Any]:
    """The fields of a rollout that are not arrays."""
    told = {
        f.name: getattr(rollout, f.name)
        for f in fields(Rollout)
        if f.name not in (*_ARRAYS, "options", "log", "why")
    }
    log = asdict(rollout.log) if rollout.log else None
    why = [asdict(reason) for reason in rollout.why]
    return {**told, "options": rollout.options.chosen, "log": log, "why": why}


def _rollout(about: Mapping[str, Any], arrays: Mapping[str, Any]) -> Rollout:
    log = about["log"]
    if log is not None:
        trouble = Trouble(**log["trouble"]) if log["trouble"] else None
        log = ScriptLog(tuple(log["stage_ends"]), trouble, log["planning_s"])
    options = make_options(**from_json(about["options"]))
    told = {**about, "stages": tuple(about["stages"]), "options": options}
    told["log"] = log
    told["why"] = tuple(Reason(**reason) for reason in about.get("why", ()))
    by_name = ("agent_rewards", "terms", "conditions", "observations", "pictures")
    empty: dict[str, Any] = {name: {} for name in by_name}
    return Rollout(**{**empty, **told, **arrays})
