"""Saving and loading policies: of a training run, by path, or of the zoo in the package."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from taskbuilder.arrays import StoreError, read_arrays, write_arrays
from taskbuilder.errors import UnknownNameError, UsageError, display_path
from taskbuilder.policies.about import problem_of
from taskbuilder.policies.chunk_policy import CHUNKS, ChunkPolicy
from taskbuilder.policies.runs import RUN_FILE
from taskbuilder.policies.trained import TrainedPolicy
from taskbuilder.wording import suggestion

ZOO = Path(__file__).parent / "models"
"""Folder of the pretrained policies: a folder for each task, a file for each policy."""

CHECKPOINTS = "checkpoints"
"""Folder of a run that has its checkpoints."""

POLICY_FILE = "policy.npz"
"""File of the policy in the folder of a training run."""

LARGEST = 64 << 20
"""Maximum size of a policy's file in bytes, hundreds of times the size of those in the zoo."""

_KIND = "policy"
ZOO_PREFIX = "zoo:"


def save_policy(path: Path, policy: TrainedPolicy) -> None:
    """Write a policy to a file.

    Raises:
        OSError: It cannot be written.
    """
    write_arrays(path, policy.arrays(), {**policy.about, "kind": _KIND, **policy.traits()})


def load_policy(name: str) -> TrainedPolicy:
    """Load a policy.

    Args:
        name: Name of a pretrained policy, such as ``zoo:handover/demos``, or the path of a
            training run's folder or of a policy file.

    Raises:
        UnknownNameError: The zoo has no policy of this name.
        UsageError: There is no such folder or file, or the folder has no policy yet.
        StoreError: The file is damaged, is not a policy, or contains values that are not finite.
    """
    path = policy_file(name)
    arrays, about = read_arrays(path, _KIND, largest=LARGEST)
    for part, array in arrays.items():
        if not np.isfinite(array).all():
            raise StoreError(f"{display_path(path)}: {part} has numbers that are not finite")
    if problem := problem_of(about):
        raise StoreError(f"{display_path(path)}: {problem}")
    try:
        if CHUNKS in about:
            return ChunkPolicy.read(arrays, about)
        norms = bool(about.get("norms", False))  # files from before there were any do not say
        return TrainedPolicy.of(arrays, about, squash=bool(about["squash"]), norms=norms)
    except (KeyError, ValueError, TypeError):
        raise StoreError(f"{display_path(path)}: lacks parts of a policy") from None


def policy_file(name: str) -> Path:
    """The file of a policy; see `load_policy`.

    Raises:
        UnknownNameError: The zoo has no policy of this name.
        UsageError: There is no such folder or file, or no policy in it yet.
    """
    return _zoo_file(name) if name.startswith(ZOO_PREFIX) else _file(name)


def zoo_names() -> tuple[str, ...]:
    """Names of the pretrained policies, such as ``zoo:handover/demos``."""
    files = sorted(ZOO.glob("*/*.npz"))
    return tuple(f"{ZOO_PREFIX}{file.parent.name}/{file.stem}" for file in files)


def _zoo_file(name: str) -> Path:
    names = zoo_names()
    if name not in names:
        help_ = suggestion(name, names, what="the zoo has")
        raise UnknownNameError(f'no policy "{name}"; {help_}')
    return ZOO / f"{name.removeprefix(ZOO_PREFIX)}.npz"


def _file(name: str) -> Path:
    path = Path(name)
    if path.is_file():
        run = path.resolve().parent.parent
        if path.resolve().parent.name == CHECKPOINTS and (run / RUN_FILE).is_file():
            raise UsageError(
                f"{display_path(path)} is a checkpoint, from which training is resumed; name the "
                f"run, {display_path(run)}, for its policy"
            )
        return path
    if not path.is_dir():
        raise UsageError(
            f'no policy "{name}"; name the folder of a training run, a policy\'s file, or one of '
            f"{', '.join(zoo_names())}"
        )
    if not (path / POLICY_FILE).is_file() and not (path / RUN_FILE).is_file():
        what = "is a data set" if (path / "dataset.json").is_file() else "is no training run"
        raise UsageError(f"{display_path(path)} {what}; it has no {RUN_FILE} and no {POLICY_FILE}")
    if not (path / POLICY_FILE).is_file():
        raise UsageError(f"{display_path(path)} has no {POLICY_FILE}; it comes with an evaluation")
    if (path / POLICY_FILE).is_symlink():
        raise UsageError(f"{display_path(path / POLICY_FILE)} is a link; name the file itself")
    return path / POLICY_FILE
