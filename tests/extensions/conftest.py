"""Packages that extend the library: the example package, and small ones made by tests."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import pytest

from taskbuilder import extensions

ROOT = Path(__file__).resolve().parents[2]
EXAMPLE = ROOT / "examples" / "taskbuilder-extras"

Install = Callable[..., Path]


@pytest.fixture(scope="session")
def example_site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder into which pip has installed the example package."""
    source = tmp_path_factory.mktemp("source") / "extras"
    shutil.copytree(EXAMPLE, source)  # pip builds in the folder of the package
    site = tmp_path_factory.mktemp("site")
    command = ("pip", "install", "--quiet", "--no-deps", "--no-build-isolation", "--no-index")
    words = [sys.executable, "-m", *command, "--disable-pip-version-check", "--target", str(site)]
    subprocess.run([*words, str(source)], check=True)
    return site


@pytest.fixture
def extras(example_site: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The example package, installed for a test."""
    monkeypatch.syspath_prepend(example_site)
    yield
    forget_packages()


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Install]:
    """Writes packages as pip leaves them, and puts them on the path."""

    def write(name: str, parts: Mapping[str, Mapping[str, str]], code: str = "") -> Path:
        """Install version 1.0 of a package of one module.

        Args:
            name: Name of the package and the module; it begins with "lab_".
            parts: Attribute of the module by name, by group.
            code: The module.
        """
        site = tmp_path / f"site-{name}"
        info = site / f"{name}-1.0.dist-info"
        info.mkdir(parents=True)
        (site / f"{name}.py").write_text(code)
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
        groups = (
            "\n".join((f"[{group}]", *(f"{part} = {name}:{at}" for part, at in named.items())))
            for group, named in parts.items()
        )
        (info / "entry_points.txt").write_text("\n\n".join(groups) + "\n")
        monkeypatch.syspath_prepend(site)
        return site

    yield write
    forget_packages()


def forget_packages() -> None:
    """Forget the modules of packages that tests have installed, and what was found of them."""
    for name in [name for name in sys.modules if name.startswith(("taskbuilder_extras", "lab_"))]:
        del sys.modules[name]
    extensions.forget()


OWN_TASK = """\
task: mine
summary: The arm brings its tool to the ball.
timing: {control_hz: 10, physics_hz: 120, episode_steps: 30}
scene:
  robots:
    arm:
      model: panda
      base: {position: [-0.6, 0, 0.4]}
      home: {tcp: {position: [-0.15, 0, 0.9], rpy_deg: [180, 0, 0]}}
      action: {arm: ARM}
  objects:
    table: {shape: {box: [1.4, 1.0, 0.4]}, fixed: true, position: [0, 0, 0.2], color: wood}
    cube: {shape: {box: [0.05, 0.05, 0.05]}, mass: 0.1, position: [0.1, 0.3, 0.425], color: teal}
    block: {shape: {box: [0.05, 0.05, 0.05]}, mass: 0.1, position: [0.1, -0.3, 0.425], color: teal}
  sites:
    target: {marker: {sphere: 0.025}, position: [0.02, 0, 0.6]}
observe:
  arm: [self.joints, self.tcp, target.position, CHANNEL, time_left]
expert:
  - arm: {reach: target, tolerance: 0.008}
"""

OWN_DESCRIPTION = """\
IMPORT
from taskbuilder.description import Bonus, Description, Distance, Near


class Mine(Description):
    there = Near("arm.tcp", "target", within=0.02)
    success = there & CONDITION
    stages = {"there": there}
    reward = (Distance("reach", "arm.tcp", "target"), Bonus("there", there, 1.0))
"""


@pytest.fixture
def own_task(tmp_path: Path) -> Callable[..., Path]:
    """Writes a task whose arm, channel and condition a test chooses."""

    def write(
        arm: str = "tcp_delta",
        channel: str = "cube.position",
        condition: str = "there",
        imports: str = "",
    ) -> Path:
        file = tmp_path / "mine.yaml"
        file.write_text(OWN_TASK.replace("ARM", arm).replace("CHANNEL", channel))
        text = OWN_DESCRIPTION.replace("IMPORT", imports).replace("CONDITION", condition)
        file.with_suffix(".py").write_text(text)
        return file

    return write
