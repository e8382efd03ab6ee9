"""Choosing what draws: taskbuilder's rasteriser, Bullet's TinyRenderer, or OpenGL through EGL.

Where EGL does not work, Bullet's plugin ends the whole process. It is therefore tried in another
process before it is loaded in this one.
"""

from __future__ import annotations

import logging
import re
import subprocess
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec

from taskbuilder.errors import SimulationError, UnknownNameError
from taskbuilder.extensions import RENDERERS
from taskbuilder.interpreters import interpreter
from taskbuilder.quiet import HINTS, captured
from taskbuilder.sim.bullet import Calls

Renderer = str
"""What draws: ``raster``, ``tiny`` or ``egl``, or a renderer that another package adds."""

Request = str
"""The same, or ``auto``."""

OWN = ("auto", "raster", "tiny", "egl")
"""The names that need no other package of renderers."""

RASTER_PACKAGES = ("numba", "fast_simplification")
HOW_TO_GET_RASTER = 'pip install "taskbuilder[render]"'

_log = logging.getLogger(HINTS)

PROBE_SECONDS = 30.0
# OpenGL on the CPU: slower than Bullet's own renderer for all but large images.
SOFTWARE = ("llvmpipe", "softpipe", "swrast", "software rasterizer")

_PROBE = """import importlib.util, pybullet as p
p.connect(p.DIRECT)
if p.loadPlugin(importlib.util.find_spec("eglRenderer").origin, "_eglRendererPlugin") < 0:
    raise SystemExit("the plugin does not load")
p.getCameraImage(8, 8)
"""


@dataclass(frozen=True)
class EglProbe:
    """Whether EGL works on this machine.

    Attributes:
        device: OpenGL's name of the device that draws; empty where EGL does not work.
        reason: Why it does not work; empty where it does.
    """

    device: str
    reason: str

    @property
    def works(self) -> bool:
        """Whether images can be drawn through EGL at all."""
        return not self.reason

    @property
    def hardware(self) -> bool:
        """Whether a graphics processor draws, rather than OpenGL in software."""
        return self.works and not any(name in self.device.lower() for name in SOFTWARE)


@cache
def probe_egl() -> EglProbe:
    """Try EGL in a process of its own. The answer holds for the machine, so it is kept."""
    if find_spec("eglRenderer") is None:
        return EglProbe("", "this build of pybullet has no EGL plugin")
    try:
        child = subprocess.run(
            interpreter(_PROBE),
            capture_output=True,
            text=True,
            errors="replace",
            timeout=PROBE_SECONDS,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return EglProbe("", f"drawing one image took longer than {PROBE_SECONDS:g} s")
    device = re.search(r"^GL_RENDERER=(.*)$", child.stdout, re.MULTILINE)
    if child.returncode == 0 and device:
        return EglProbe(device.group(1).strip(), "")
    said = [line for line in (child.stdout + "\n" + child.stderr).splitlines() if line.strip()]
    last = said[-1].strip() if said else "no message"
    return EglProbe("", f"{last} (exit status {child.returncode})")


def choose(requested: Request) -> Renderer:
    """What to draw with.

    Args:
        requested: "auto" takes the rasteriser where its packages are installed, and else Bullet's
            own renderer.

    Raises:
        SimulationError: The renderer that was asked for does not work here, or there is none of
            this name.
        ExtensionError: It is of another package, and cannot be used.
    """
    if requested == "tiny":
        return "tiny"
    if requested == "auto":
        return "raster" if has_raster() else _stand_in()
    if requested == "raster":
        if not has_raster():
            raise SimulationError(f"the renderer raster is not installed; {HOW_TO_GET_RASTER}")
        return "raster"
    if requested != "egl":
        try:
            RENDERERS.part(requested, OWN)  # imported when it first draws
        except UnknownNameError as error:
            raise SimulationError(str(error)) from None
        return requested
    probe = probe_egl()
    if not probe.works:
        raise SimulationError(
            f"EGL does not work here: {probe.reason}; install the driver's EGL library "
            "(libegl1, and libgl1-mesa-dri without a graphics processor), or use tiny"
        )
    return "egl"


@cache
def has_raster() -> bool:
    """Whether the packages of the rasteriser are installed."""
    return all(find_spec(name) is not None for name in RASTER_PACKAGES)


@cache
def _stand_in() -> Renderer:
    """Bullet's own renderer, after it was said once how to get a faster one."""
    _log.warning("pictures are drawn by TinyRenderer; %s draws them faster", HOW_TO_GET_RASTER)
    return "tiny"


def load_egl(bullet: Calls) -> None:
    """Make a client draw through EGL, for good.

    Raises:
        SimulationError: EGL does not work on this machine.
    """
    choose("egl")
    spec = find_spec("eglRenderer")
    with captured() as printed:
        plugin = bullet.loadPlugin(spec and spec.origin, "_eglRendererPlugin")
    if plugin < 0:
        raise SimulationError(f"Bullet's EGL plugin does not load: {printed.text.strip()}")
    with captured():
        for _ in range(2):  # its first two images differ from all later ones
            bullet.getCameraImage(8, 8)
