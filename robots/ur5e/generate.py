"""Generate the UR5e: its URDF and its low-poly meshes, all own work.

Run it as ``python robots/ur5e/generate.py``; it rewrites ``ur5e.urdf`` and ``meshes/*.obj`` beside
itself, byte for byte the same on every run. Everything is drawn from the tables in
``ur5e_generator``: the manufacturer's published kinematics, limits, masses and inertias, and
outlines drawn by hand after the look of the arm. No mesh of the manufacturer is used.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

# The robot library is data and not imported, so the generators are found by their folders.
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "generator"))
sys.path.insert(0, str(Path(__file__).resolve().parent))

from robot_modelling.urdf import mesh_files
from ur5e_generator.robot import links
from ur5e_generator.urdf import urdf_text


def generated_files() -> dict[str, str]:
    """Return every generated file's text by its path relative to this folder."""
    files = {"ur5e.urdf": urdf_text()}
    for link in links():
        files |= mesh_files(link)
    return files


def main() -> None:
    """Write all files into the folder given, by default this one."""
    parser = argparse.ArgumentParser(description="Generate the UR5e's URDF and meshes.")
    parser.add_argument("--output", type=Path, default=Path(__file__).parent)
    output: Path = parser.parse_args().output
    files = generated_files()
    meshes = output / "meshes"
    meshes.mkdir(parents=True, exist_ok=True)
    for stale in sorted(meshes.glob("*.obj")):
        if f"meshes/{stale.name}" not in files:
            stale.unlink()
    for name, text in files.items():
        (output / name).write_text(text, encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main()
