"""Cutting a mesh into convex pieces by CoACD, in a child process, because some meshes end it."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from taskbuilder.extras import extra_needed
from taskbuilder.importing.surfaces import Floats, Integers, welded_mesh
from taskbuilder.interpreters import interpreter

MOST_PIECES = 16
_TRIANGLES = 1500
# Of the processors, so that a busy machine cuts the same pieces; on the clock, only as a last end.
_MOST_CPU_S = {"off": 20, "on": 60}
_TIMEOUT_S = 900.0
_START = "from taskbuilder.importing.pieces import main; sys.exit(main(*sys.argv[1:]))"
_ENVIRONMENT = ("PATH", "HOME", "LD_LIBRARY_PATH", "SYSTEMROOT", "OMP_NUM_THREADS")


def decomposed(points: Floats, faces: Integers) -> list[Floats]:
    """The corners of convex pieces, the same for the same mesh; none if it cannot be cut.

    Raises:
        UsageError: The extra is not installed.
    """
    with extra_needed("import", "cutting meshes into convex pieces"):
        import coacd  # noqa: F401 - only to see whether it is there
    if len(faces) > _TRIANGLES:
        with extra_needed("import", "decimating meshes"):
            import fast_simplification
        points, faces = fast_simplification.simplify(
            points.astype(np.float32), faces.astype(np.int32), target_count=_TRIANGLES
        )
        points, faces = welded_mesh(np.asarray(points, np.float64), np.asarray(faces, np.int64))
    with tempfile.TemporaryDirectory(prefix="taskbuilder-") as folder:
        given, made = Path(folder, "mesh.npz"), Path(folder, "pieces.npz")
        np.savez(given, points=points, faces=faces)
        # Without preprocessing it takes a tenth of the time, where it does not crash.
        for mode in ("off", "on"):
            if _ran(given, made, mode):
                with np.load(made) as pieces:
                    return [pieces[name] for name in sorted(pieces.files)]
    return []


def _ran(given: Path, made: Path, mode: str) -> bool:
    try:
        child = subprocess.run(
            interpreter(_START, str(given), str(made), mode),
            env={name: os.environ[name] for name in _ENVIRONMENT if name in os.environ},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=_TIMEOUT_S,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return False
    return child.returncode == 0 and made.exists()


def main(given: str, made: str, mode: str) -> int:
    """What the child process runs."""
    import coacd

    _limit_time(_MOST_CPU_S[mode])
    with np.load(given) as mesh:
        points, faces = mesh["points"], mesh["faces"]
    coacd.set_log_level("off")
    pieces = coacd.run_coacd(
        coacd.Mesh(points, faces.astype(np.int32)),
        threshold=0.08,
        max_convex_hull=MOST_PIECES,
        preprocess_mode=mode,
        preprocess_resolution=25,
        resolution=500,
        mcts_nodes=4,  # with more nodes and rounds, a mug takes six times as long and is no better
        mcts_iterations=8,
        mcts_max_depth=1,
        seed=0,
    )
    arrays: dict[str, Any] = {f"{n:03}": corners for n, (corners, _) in enumerate(pieces)}
    np.savez(made, **arrays)
    sys.stdout.flush()
    return 0


def _limit_time(most_s: int) -> None:
    """End this process when it has used so many seconds of the processors."""
    try:
        import resource
    except ImportError:  # not on this system
        return
    resource.setrlimit(resource.RLIMIT_CPU, (most_s, most_s))
