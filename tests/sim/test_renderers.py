from __future__ import annotations

import subprocess
import sys

import pytest

from taskbuilder.errors import SimulationError
from taskbuilder.sim import renderers
from taskbuilder.sim.client import Client
from taskbuilder.sim.renderers import choose, probe_egl


@pytest.fixture
def fresh_probe():
    probe_egl.cache_clear()
    yield
    probe_egl.cache_clear()


def test_the_probe_says_either_what_draws_or_why_nothing_does():
    probe = probe_egl()
    assert bool(probe.device) != bool(probe.reason)


def test_auto_takes_the_rasteriser_where_it_is_installed():
    assert choose("auto") == choose("raster") == "raster"


@pytest.fixture
def without_numba(monkeypatch):
    """A machine on which the rasteriser's packages are missing."""
    monkeypatch.setattr(renderers, "RASTER_PACKAGES", ("no_such_package",))
    renderers.has_raster.cache_clear()
    renderers._stand_in.cache_clear()
    yield
    renderers.has_raster.cache_clear()


def test_bullets_own_renderer_stands_in_and_says_once_how_to_get_the_other(without_numba, caplog):
    assert [choose("auto"), choose("auto")] == ["tiny", "tiny"]
    (record,) = caplog.records
    assert 'pip install "taskbuilder[render]"' in record.getMessage()
    with pytest.raises(SimulationError, match=r"raster is not installed; pip install"):
        choose("raster")


def test_egl_that_does_not_work_is_refused_with_the_way_out(monkeypatch, fresh_probe):
    monkeypatch.setenv("__EGL_VENDOR_LIBRARY_DIRS", "/nonexistent")
    monkeypatch.setenv("EGL_VISIBLE_DEVICES", "99")
    with pytest.raises(SimulationError, match=r"EGL does not work here: .*use tiny"):
        choose("egl")
    with pytest.raises(SimulationError, match="EGL does not work here"):
        Client(physics_hz=120, renderer="egl")


def test_an_unknown_renderer_is_refused():
    with pytest.raises(SimulationError, match="one of: auto, raster, tiny, egl"):
        choose("vulkan")


def test_tiny_needs_no_probe(monkeypatch):
    monkeypatch.setattr(renderers, "probe_egl", None)
    assert choose("tiny") == "tiny"


@pytest.mark.skipif(not probe_egl().works, reason=f"no EGL: {probe_egl().reason}")
def test_drawing_through_egl_prints_nothing():
    script = """
from taskbuilder.sim.bodies import create_body
from taskbuilder.shapes import BoxShape, Part
from taskbuilder.cameras import CameraView
from taskbuilder.sim.pictures import capture
from taskbuilder.sim.client import Client
with Client(physics_hz=120, renderer="egl") as client:
    for _ in range(3):
        create_body(client, {"box": Part(BoxShape((1, 1, 1)))})
        capture(client, CameraView((3, 3, 3), (0, 0, 0)))
"""
    child = subprocess.run([sys.executable, "-c", script], capture_output=True, check=True)
    assert (child.stdout, child.stderr) == (b"", b"")
