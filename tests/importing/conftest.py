"""Small files as makers ship them, written by the tests themselves."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib.util import find_spec
from pathlib import Path

import pytest

if find_spec("trimesh") is None:  # of the extra "import"
    collect_ignore_glob = ["test_*.py"]


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """A ROS package with the usual folders."""
    folder = tmp_path / "ws" / "src" / "my_robot_description"
    for name in ("urdf", "meshes"):
        (folder / name).mkdir(parents=True)
    (folder / "package.xml").write_text("<package><name>my_robot_description</name></package>")
    return folder


@pytest.fixture
def write(package: Path) -> Callable[..., Path]:
    """Write a URDF into the package, and meshes by name."""

    def write_files(
        inside: str, meshes: Mapping[str, bytes] | None = None, name: str = "arm.urdf"
    ) -> Path:
        for file, content in (meshes or {}).items():
            (package / "meshes" / file).write_bytes(content)
        path = package / "urdf" / name
        path.write_text(f'<robot name="my_arm">{inside}</robot>')
        return path

    return write_files


@pytest.fixture(autouse=True)
def _here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "work").mkdir()
    monkeypatch.chdir(tmp_path / "work")
