"""Sizes of installations: fresh virtual environments of core and of extras, with what is largest.

    python benchmarks/install_size.py [--python python3.13] [--only core render]

Each environment is made in a temporary folder by `pip install` from this checkout with
constraints.txt, and measured without pip itself: the sum of the sizes of all its files, Python's
compiled files left out. Then, in the environment of core, what a slim image can do without is
deleted, and tasks are built with what is left: the symbols of the engine, and those of its data
that no robot of the library uses. Results go to benchmarks/results/install_size.json, and from
there to docs/install.md (`make docs`).
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from machine import describe_machine

ROOT = Path(__file__).resolve().parents[1]
OUT = ROOT / "benchmarks" / "results" / "install_size.json"
CORE, SLIM = "core", "core, slim"
SETS = {
    CORE: "",
    "render": "[render]",
    "train": "[train]",
    "all": "[train,render,film,plot,data,view,import,serve,mcp,ray]",
}
MB = 1e6
LARGEST = 6
"""Packages that are named."""

USED_DATA = ("__init__.py", "franka_panda", "xarm")
"""What the library's robots use of the engine's data."""

TRIED = ("handover", "long_bar_mixed")
"""Tasks that are built in the slim environment."""

PLACES = """
import json, pybullet, pybullet_data
print(json.dumps([pybullet.__file__, pybullet_data.getDataPath()]))
"""

BELONGINGS = """
import json
from importlib.metadata import distributions
print(json.dumps({d.metadata["Name"]: sum(
    f.locate().stat().st_size for f in d.files or () if f.locate().is_file()
) for d in distributions()}))
"""


def size(folder: Path) -> int:
    """Bytes of all files in a folder."""
    return sum(f.lstat().st_size for f in folder.rglob("*") if f.is_file() and not f.is_symlink())


def measured(python: str, name: str) -> dict[str, Any]:
    """The size of a fresh environment, and its packages, in MB."""
    extras = SETS[name]
    with tempfile.TemporaryDirectory(prefix="taskbuilder-size-") as aside:
        venv = Path(aside) / "venv"
        subprocess.run([python, "-m", "venv", venv], check=True)
        before = size(venv)
        pip = [venv / "bin" / "pip", "install", "--quiet", "--no-compile"]
        constraints = ["-c", ROOT / "constraints.txt"]
        subprocess.run([*pip, f"{ROOT}{extras}", *constraints], check=True)
        asked = [venv / "bin" / "python", "-c", BELONGINGS]
        told = subprocess.run(asked, check=True, capture_output=True, text=True).stdout
        packages = {p: b / MB for p, b in json.loads(told).items() if p != "pip"}
        packages.pop("setuptools", None)
        order = sorted(packages, key=lambda name: -packages[name])
        full = {
            "mb": round((size(venv) - before) / MB),
            "packages": len(packages),
            "largest": {name: round(packages[name]) for name in order[:LARGEST]},
        }
        if extras:
            return {name: full}
        slimmed(venv)
        return {name: full, SLIM: {"mb": round((size(venv) - before) / MB)}}


def slimmed(venv: Path) -> None:
    """Delete what the library does without, and build tasks with what is left."""
    asked = [venv / "bin" / "python", "-c", PLACES]
    told = subprocess.run(asked, check=True, capture_output=True, text=True).stdout
    engine, data = json.loads(told.splitlines()[-1])
    subprocess.run(["strip", "--strip-unneeded", engine], check=True)
    for each in Path(data).iterdir():
        if each.name not in USED_DATA:
            shutil.rmtree(each) if each.is_dir() else each.unlink()
    build = [venv / "bin" / "taskbuilder", "validate", *TRIED, "--level", "build"]
    subprocess.run(build, check=True)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--python", default=sys.executable)
    parser.add_argument("--only", nargs="+", choices=SETS, default=list(SETS))
    parser.add_argument("--out", type=Path, default=OUT)
    arguments = parser.parse_args()
    os.environ["PYTHONDONTWRITEBYTECODE"] = "1"
    found = json.loads(arguments.out.read_text()) if arguments.out.is_file() else {}
    version = subprocess.run(
        [arguments.python, "-c", "import platform; print(platform.python_version())"],
        check=True,
        capture_output=True,
        text=True,
    ).stdout.strip()
    found |= {"command": "python benchmarks/install_size.py", "python": version}
    found["machine"] = describe_machine()
    found.setdefault("environments", {})
    for name in arguments.only:
        found["environments"] |= measured(arguments.python, name)
        print(name, found["environments"][name], flush=True)
        arguments.out.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
