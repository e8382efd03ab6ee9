"""What Bullet prints, in sentences."""

import subprocess
import sys
from pathlib import Path

import pytest

from taskbuilder.quiet import captured
from taskbuilder.sim.engine_output import import_pybullet, warnings


@pytest.mark.parametrize("preparation", ["", "sys.stdout = sys.stderr = None; ", "os.close(1); "])
def test_pybullet_is_imported_in_silence(preparation: str) -> None:
    code = (
        f"import os, sys; {preparation}"
        "from taskbuilder.sim.engine_output import import_pybullet; "
        "import_pybullet().DIRECT; import_pybullet()"
    )
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, check=False)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, b"", b"")


def test_real_warnings_become_sentences(tmp_path: Path) -> None:
    bullet = import_pybullet()
    path = tmp_path / "a.urdf"
    path.write_text(
        '<robot name="r"><link name="palm"><collision><geometry><box size="1 1 1"/></geometry>'
        '</collision><visual><geometry><mesh filename="nope.obj"/></geometry></visual></link>'
        "</robot>"
    )
    client = bullet.connect(bullet.DIRECT)
    with captured() as printed, pytest.raises(bullet.error):
        bullet.loadURDF(str(path), physicsClientId=client)
    bullet.disconnect(client)
    assert warnings(printed.text)[:3] == (
        "link palm has no <inertial>; Bullet takes a mass of 1 kg",
        "cannot find 'nope.obj' in any directory in urdf path",
        "a <visual> of link palm was not understood",
    )


def test_ordinary_lines_are_no_warnings() -> None:
    assert warnings("") == ()
    assert warnings("pybullet build time: Jan 29 2025\nnumActiveThreads = 0\n") == ()
    assert warnings("convex hull of 3 points failed\n" * 2) == ("convex hull of 3 points failed",)
    assert warnings("b3Warning[x.cpp,1]:\nodd b3Warning[x.cpp,1]:\n") == ("odd",)
