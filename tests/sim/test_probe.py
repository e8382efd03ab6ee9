"""Trying assets in another process."""

from pathlib import Path

import pytest

from taskbuilder.assets import AssetError, codes
from taskbuilder.sim import probe as module
from taskbuilder.sim.probe import probe

PART = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
BALL = '<link name="{}"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>'
MESH = (
    '<robot name="r"><link name="a"><visual><geometry><mesh filename="part.obj"/></geometry>'
    "</visual></link></robot>"
)


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "taskbuilder" / "probed"


def urdf(tmp_path: Path, *links: str) -> Path:
    path = tmp_path / "robot.urdf"
    path.write_text(f'<robot name="r">{"".join(links)}</robot>')
    return path


def forbid_children(monkeypatch: pytest.MonkeyPatch) -> None:
    """Makes every further child a failure of the test."""

    def run(*arguments: object, **options: object) -> None:
        pytest.fail("a child was started")

    monkeypatch.setattr(module.subprocess, "run", run)


def test_a_good_asset_is_tried_once(
    tmp_path: Path, cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = urdf(tmp_path, BALL.format("a"))
    probe(path, kind="urdf")
    assert len(list(cache.iterdir())) == 1
    forbid_children(monkeypatch)
    probe(path, kind="urdf")


def test_a_changed_mesh_is_tried_again(tmp_path: Path, cache: Path) -> None:
    mesh, path = tmp_path / "part.obj", tmp_path / "robot.urdf"
    mesh.write_text(PART)
    path.write_text(MESH)
    probe(path, kind="urdf")
    probe(mesh, kind="mesh")
    assert len(list(cache.iterdir())) == 2
    mesh.write_text(PART + "f 1 2 900000000\n")
    for changed, kind in ((path, "urdf"), (mesh, "mesh")):
        with pytest.raises(AssetError, match="SIGSEGV"):
            probe(changed, kind=kind)  # type: ignore[arg-type]
    assert len(list(cache.iterdir())) == 2


def test_a_crash_of_the_engine_is_an_error_here(tmp_path: Path, cache: Path) -> None:
    with pytest.raises(AssetError, match="ended the physics engine") as caught:
        probe(urdf(tmp_path, BALL.format("a"), BALL.format("b")), kind="urdf")  # two roots
    assert caught.value.code == codes.CRASHED
    assert not cache.exists()


def test_a_refusal_says_why(tmp_path: Path) -> None:
    (tmp_path / "robot.urdf").write_text(MESH)
    with pytest.raises(AssetError, match=r"refused .* cannot find 'part\.obj'"):
        probe(tmp_path / "robot.urdf", kind="urdf")


def test_a_hang_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(AssetError, match="not loaded within") as caught:
        probe(urdf(tmp_path, BALL.format("a")), kind="urdf", timeout_s=0.01)
    assert caught.value.code == codes.CRASHED


def test_a_missing_file_and_a_folder_are_refused_here(tmp_path: Path) -> None:
    for path in (tmp_path, tmp_path / "missing.urdf"):
        with pytest.raises(AssetError):
            probe(path, kind="urdf")


def test_an_unwritable_cache_does_no_harm(tmp_path: Path, cache: Path) -> None:
    (tmp_path / "cache").write_text("a file where a folder should be")
    probe(urdf(tmp_path, BALL.format("a")), kind="urdf")
    assert not cache.exists()


def test_what_lies_in_the_working_directory_is_not_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "pybullet.py").write_text("raise SystemExit(9)")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    probe(urdf(tmp_path, BALL.format("a")), kind="urdf")
