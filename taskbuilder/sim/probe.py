"""Loading an asset in a process of its own first, because some assets end the process.

Reading a file in Python finds what is known to be harmful; this finds the rest. Nothing of it
imports pybullet except in the child process.
"""

from __future__ import annotations

import hashlib
import os
import re
import signal
import subprocess
import sys
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, Literal

from taskbuilder.assets import codes
from taskbuilder.assets.paths import AssetError, require_readable
from taskbuilder.engine import engine_versions
from taskbuilder.files import cache_folder
from taskbuilder.interpreters import interpreter
from taskbuilder.quiet import captured
from taskbuilder.sim.engine_output import import_pybullet, warnings

AssetKind = Literal["urdf", "mesh"]

# Part of every cache key: raise it when the probe tries more than it did.
_REVISION = 1
_STEPS = 5
_LOADED = "loaded"
_REFUSED = 3
# All that a child needs to find its libraries and its home.
_ENVIRONMENT = ("PATH", "HOME", "LD_LIBRARY_PATH", "SYSTEMROOT")
_START = "from taskbuilder.sim.probe import main; sys.exit(main(sys.argv[1:]))"
_FILE_NAME = re.compile(rb"filename\s*=\s*[\"']([^\"']*)[\"']")
_MATERIAL_FILE = re.compile(rb"^\s*mtllib\s+(\S+)", re.MULTILINE)


def probe(path: Path, *, kind: AssetKind, timeout_s: float = 20.0) -> None:
    """Loads an asset in a fresh interpreter and takes a few simulation steps with it.

    Success is remembered in the user's cache folder by the content of the file and of all the
    files it names, so that an unchanged asset is tried once.

    Args:
        path: A URDF whose file names are absolute, as `taskbuilder.assets.resolved_text` writes
            them, or a mesh.
        kind: Which of the two it is.
        timeout_s: How long loading may take.

    Raises:
        AssetError: The asset cannot be read, ended the interpreter, took too long, or was
            refused.
    """
    require_readable(path, path.name)
    path = path.resolve()
    key = _content_key(path, kind)
    marker = cache_folder("probed") / key if key else None
    if marker and _exists(marker):
        return
    _try_out(path, kind, timeout_s)
    if marker:
        # A cache that cannot be written costs a second the next time, nothing else.
        with suppress(OSError):
            marker.parent.mkdir(parents=True, exist_ok=True)
            marker.touch()


def main(arguments: Sequence[str]) -> int:
    """What the child process runs: loads the asset, says so, and returns its exit status."""
    kind, path = arguments
    _forbid_core_dumps()
    bullet = import_pybullet()
    complaint = ""
    with captured() as printed:
        try:
            _load(bullet, Path(path), kind)
        except (bullet.error, ValueError) as error:
            complaint = str(error)
    if complaint:
        sys.stdout.write("; ".join((complaint.rstrip("."), *warnings(printed.text))))
        return _REFUSED
    sys.stdout.write(_LOADED)
    return 0


def _try_out(path: Path, kind: AssetKind, timeout_s: float) -> None:
    """Runs the child and explains how it ended.

    Raises:
        AssetError: It did not end well.
    """
    try:
        child = subprocess.run(
            interpreter(_START, kind, str(path), isolated=True),
            env={name: os.environ[name] for name in _ENVIRONMENT if name in os.environ},
            cwd=path.parent,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=timeout_s,
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        message = f"{path.name} was not loaded within {timeout_s:g} s; simplify its meshes"
        raise AssetError(codes.CRASHED, message) from error
    said = child.stdout.decode(errors="replace").strip()
    # The word counts and not the status alone: Bullet may end a process with status 0.
    if child.returncode == 0 and said == _LOADED:
        return
    raise AssetError(codes.CRASHED, f"{path.name} {_ending(child, said)}")


def _ending(child: subprocess.CompletedProcess[bytes], said: str) -> str:
    if child.returncode == _REFUSED:
        return f"was refused by the physics engine: {said or 'no reason given'}"
    if child.returncode < 0:
        how = _signal_name(-child.returncode)
    else:
        how = f"exit status {child.returncode}"
    details = child.stderr.decode(errors="replace").strip().splitlines()
    because = f": {details[-1][:200]}" if details and child.returncode > 0 else ""
    return f"ended the physics engine ({how}{because}); simplify the asset until it loads"


def _signal_name(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"


def _load(bullet: Any, path: Path, kind: str) -> None:
    """Loads the asset above a floor, lets it fall for some steps, and draws it once.

    Raises:
        ValueError: It was loaded as nothing.
        pybullet.error: It was refused.
    """
    bullet.connect(bullet.DIRECT)
    bullet.setGravity(0, 0, -9.81)
    floor = bullet.createCollisionShape(bullet.GEOM_PLANE)
    bullet.createMultiBody(0, floor, basePosition=(0, 0, -1))
    if kind == "urdf":
        body = bullet.loadURDF(str(path), flags=bullet.URDF_USE_INERTIA_FROM_FILE)
    else:
        body = _mesh_body(bullet, str(path))
    if body < 0:
        raise ValueError("it was loaded as nothing")
    for _ in range(_STEPS):
        bullet.stepSimulation()
    bullet.getCameraImage(32, 32, renderer=bullet.ER_TINY_RENDERER)


def _mesh_body(bullet: Any, name: str) -> int:
    collision = bullet.createCollisionShape(bullet.GEOM_MESH, fileName=name)
    visual = bullet.createVisualShape(bullet.GEOM_MESH, fileName=name)
    if collision < 0 or visual < 0:
        raise ValueError("the mesh gives no shape")
    return int(bullet.createMultiBody(1.0, collision, visual))


def _forbid_core_dumps() -> None:
    with suppress(ImportError, ValueError, OSError):
        import resource  # POSIX only

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def _content_key(path: Path, kind: AssetKind) -> str:
    """A name for the content of a file and all it names; "" if something it names is not found."""
    files = _content_files(path, kind)
    if not all(file.is_file() for file in files):
        return ""
    digest = hashlib.sha256(f"{_REVISION} {kind} {_engine_version()} {sys.version}".encode())
    for file in files:
        content = file.read_bytes()
        digest.update(f" {len(content)} ".encode())
        digest.update(content)
    return digest.hexdigest()


def _content_files(path: Path, kind: AssetKind) -> list[Path]:
    """The file, the meshes and textures of a URDF, and the materials of the meshes."""
    meshes = [path]
    if kind == "urdf":
        names = _FILE_NAME.findall(path.read_bytes())
        meshes += [path.parent / os.fsdecode(name) for name in dict.fromkeys(names)]
    materials = []
    for mesh in meshes:
        if mesh.suffix.lower() == ".obj" and mesh.is_file():
            named = _MATERIAL_FILE.findall(mesh.read_bytes())
            materials += [mesh.parent / os.fsdecode(name) for name in named]
    return [*meshes, *(material for material in materials if material.is_file())]


def _engine_version() -> str:
    return " ".join(" ".join(item) for item in engine_versions().items()) or "unknown"


def _exists(marker: Path) -> bool:
    try:
        return marker.is_file()
    except OSError:
        return False
