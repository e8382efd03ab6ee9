"""What a result may depend on besides files: versions, processor, C library, operating system."""

from __future__ import annotations

import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np

from taskbuilder.digests import digest
from taskbuilder.engine import PACKAGES as ENGINES
from taskbuilder.engine import engine_file

PACKAGES = (
    *("taskbuilder", *ENGINES, "numpy", "gymnasium", "pettingzoo"),
    *("pydantic", "PyYAML", "torch"),
)
"""Optional packages, whose versions are listed if they are installed."""


def versions() -> dict[str, str]:
    """Versions of Python and of the packages that playing takes, by name."""
    build = " ".join(platform.python_build())
    python = f"{platform.python_implementation()} {platform.python_version()}"
    found = {"python": python, "python build": f"{build}, {platform.python_compiler()}"}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return {**found, **_engine(), **_algebra()}


def _engine() -> dict[str, str]:
    """The physics engine as it was built: wheels of one version may be compiled differently."""
    file = engine_file()
    return {"pybullet build": digest(file.read_bytes())[:16]} if file else {}


def _algebra() -> dict[str, str]:
    """What multiplies matrices for NumPy: policies are evaluated by it."""
    try:
        blas = np.show_config(mode="dicts")["Build Dependencies"]["blas"]
        return {"numpy blas": f"{blas['name']} {blas['version']}"}
    except (TypeError, KeyError):  # NumPy before 1.26 only prints it
        return {}


def processor() -> dict[str, str]:
    """Architecture, maker, family, model and name of the processor, as far as they are known."""
    told = {"architecture": platform.machine()}
    keys = {"vendor_id": "vendor", "cpu family": "family", "model": "model", "model name": "name"}
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        lines = []
    for line in lines:
        key, _, value = (part.strip() for part in line.partition(":"))
        if not line.strip() and len(told) > 1:
            break  # the first core stands for all
        if key in keys:
            told[keys[key]] = value
    if len(told) == 1 and platform.processor():
        told["name"] = platform.processor()
    return told


def system() -> dict[str, str]:
    """Operating system, its kernel and its C library."""
    library = " ".join(platform.libc_ver()).strip()
    return {
        "system": _distribution(),
        "kernel": f"{platform.system()} {platform.release()}",
        "c library": library or "not known",
    }


def _distribution() -> str:
    try:
        return platform.freedesktop_os_release().get("PRETTY_NAME", platform.system())
    except OSError:
        return f"{platform.system()} {platform.version()}"
