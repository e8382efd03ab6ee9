"""What is handed out: the archive of the sources, and the text of a package index."""

from __future__ import annotations

import re
import subprocess
import sys
import tarfile
import zipfile
from email import message_from_bytes
from pathlib import Path

import pytest
import yaml

from taskbuilder._version import __version__

ROOT = Path(__file__).resolve().parents[1]
MOST_SDIST_BYTES = 10e6
MOST_TREE_BYTES = 60e6
"""What a clone has to hold beside its history."""
BUILD = "import sys; from setuptools import build_meta; build_meta.build_{}(sys.argv[1])"
PAGES = [file.name for file in (ROOT / "taskbuilder/validate/html").glob("*.*")]
"""Code, templates and style sheet of reports."""


def own_files() -> list[str]:
    """The files of a checkout, or of an unpacked archive."""
    command = ["git", "ls-files", "-co", "--exclude-standard"]
    listed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    if listed.returncode == 0:
        return listed.stdout.splitlines()
    parts = ("taskbuilder", "tasks", "robots", "objects", "tests", "docs", "examples", "benchmarks")
    files = [file for part in parts for file in (ROOT / part).rglob("*")]
    return [str(file.relative_to(ROOT)) for file in (*ROOT.glob("*"), *files)]


def built(kind: str, folder: Path) -> Path:
    """What is made of the files of a checkout: a source archive or a wheel."""
    for name in own_files():
        if (ROOT / name).is_file():
            (folder / "src" / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / "src" / name).write_bytes((ROOT / name).read_bytes())
    command = [sys.executable, "-c", BUILD.format(kind), str(folder)]
    subprocess.run(command, cwd=folder / "src", check=True, capture_output=True)
    (file,) = (file for file in folder.iterdir() if file.is_file())
    return file


@pytest.fixture(scope="module")
def archive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The archive of sources."""
    return built("sdist", tmp_path_factory.mktemp("built"))


@pytest.fixture(scope="module")
def sources(archive: Path) -> dict[str, bytes]:
    """The files of the archive of sources, by their paths in it."""
    with tarfile.open(archive) as file:
        members = [member for member in file.getmembers() if member.isfile()]
        return {
            member.name.partition("/")[2]: file.extractfile(member).read()  # type: ignore[union-attr]
            for member in members
        }


def test_the_archive_of_sources_is_whole(sources):
    needed = {
        *("constraints.txt", "CHANGELOG.md", "CITATION.cff", "CONTRIBUTING.md", "LICENSE"),
        *("Makefile", "docs/conf.py", "docs/quickstart.md", "benchmarks/results/zoo.json"),
        *("tests/conftest.py", "tests/made_runs.py", "tests/learn/test_maddpg.py"),
        *("tests/interop/run.sh", "tasks/handover.yaml"),
        *("robots/ur5e/robot.yaml", "objects/mug/mug.png", "taskbuilder/py.typed"),
        *(f"taskbuilder/validate/html/{name}" for name in PAGES),
    }
    assert needed <= set(sources)
    assert not [name for name in sources if "__pycache__" in name or "_build/" in name]


def test_the_repository_and_the_archive_of_sources_are_light(archive):
    assert archive.stat().st_size <= MOST_SDIST_BYTES
    files = [ROOT / name for name in own_files()]
    assert sum(file.stat().st_size for file in files if file.is_file()) <= MOST_TREE_BYTES


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What `pip install` unpacks."""
    folder = tmp_path_factory.mktemp("wheel")
    with zipfile.ZipFile(built("wheel", folder)) as file:
        file.extractall(folder / "unpacked")
    return folder / "unpacked"


def test_a_wheel_has_every_module(wheel):
    modules = list((ROOT / "taskbuilder").rglob("*.py"))
    assert len(modules) > 400
    assert [
        str(file.relative_to(ROOT))
        for file in modules
        if not (wheel / file.relative_to(ROOT)).is_file()
    ] == []


def test_a_wheel_has_all_that_is_read_as_data(wheel):
    needed = {"py.typed", "tasks/handover.yaml", *(f"validate/html/{name}" for name in PAGES)}
    needed |= {"policies/models/handover/demos.npz", "objects/mug/object.yaml"}
    needed |= {
        f"visual/fonts/{name}" for name in ("DejaVuSans.ttf", "DejaVuSans-Bold.ttf", "LICENSE")
    }
    assert [name for name in needed if not (wheel / "taskbuilder" / name).is_file()] == []


PLAYED_FROM = """
import sys
sys.path.insert(0, sys.argv.pop(1))
import taskbuilder
from taskbuilder.cli import main
print(taskbuilder.__file__)
sys.exit(main(sys.argv[1:]))
"""
EVALUATE = ("evaluate", "zoo:handover/demos", "--episodes", "1", "--controls", "0", "--jobs", "1")


def test_what_a_wheel_installs_plays_away_from_the_checkout(wheel, tmp_path):
    command = [sys.executable, "-c", PLAYED_FROM, str(wheel), *EVALUATE]
    ran = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
    assert ran.stdout.startswith(str(wheel))


def test_the_text_of_a_package_index_leads_nowhere_that_an_index_has_not(sources):
    metadata = message_from_bytes(sources["PKG-INFO"])
    assert metadata["Description-Content-Type"] == "text/markdown"
    text = metadata.get_payload()
    assert "# taskbuilder" in text
    assert "Two arms hand a stick over" in text
    targets = re.findall(r"\]\(([^)]*)\)", text)
    assert [target for target in targets if not re.match(r"https?://|#", target)] == []


def test_the_citation_is_of_this_version():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert citation["version"] == __version__
    assert {"cff-version", "message", "title", "authors"} <= citation.keys()
