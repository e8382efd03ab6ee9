"""The package that provides the physics engine.

PyBullet's own wheels end at CPython 3.11. Elsewhere the same engine comes from a rebuild, a package
of another name that contains the same modules. ``setup.cfg`` says which package is needed where.
"""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path

from taskbuilder.errors import EngineError

MODULE = "pybullet"
DATA_MODULE = "pybullet_data"
PACKAGES = ("pybullet", "pybullet-arm64")
"""The engine as its authors publish it, and its rebuild for further versions of Python."""


def engine_versions() -> dict[str, str]:
    """The installed packages that provide the engine, with their versions: one, if all is well."""
    installed = {}
    for name in PACKAGES:
        try:
            installed[name] = version(name)
        except PackageNotFoundError:
            continue
    return installed


def engine_file() -> Path | None:
    """The compiled module of the engine, found without importing it; None if not installed."""
    spec = find_spec(MODULE)
    return Path(spec.origin) if spec and spec.origin else None


def check_engine() -> None:
    """Check that exactly one package provides the engine.

    Raises:
        EngineError: None is installed, or several are, which overwrite each other's files.
    """
    installed = engine_versions()
    if len(installed) > 1:
        names = " and ".join(f"{name} {number}" for name, number in installed.items())
        raise EngineError(
            f"{names} are both installed, and each overwrites the other's files; run "
            f"`pip uninstall -y {' '.join(installed)}`, then install taskbuilder again"
        )
    if engine_file() is None:
        raise EngineError(
            "the physics engine is not installed; install taskbuilder again with pip, which "
            f"chooses between {' and '.join(PACKAGES)} for this version of Python"
        )
