"""One physics client: a world of its own, stepped at a fixed rate."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from taskbuilder.errors import SimulationError
from taskbuilder.geometry import Vec3
from taskbuilder.quiet import captured
from taskbuilder.shapes import Part
from taskbuilder.sim.bullet import Calls, p
from taskbuilder.sim.renderers import Renderer, load_egl
from taskbuilder.sim.scenery import Scenery
from taskbuilder.sim.single import Single

# Thirty let a held stick slip by a centimetre where 60 do by half a millimetre; a hundred take a
# third more time while something is held, and gain nothing (benchmarks/solver.py).
SOLVER_ITERATIONS = 60
# What the solver may leave unsolved when it stops early. Bullet's 1e-7 takes a tenth more time;
# with 1e-5 a held cube slips by another millimetre.
RESIDUAL = 1e-6


class Client(Single):
    """A Bullet world without a window.

    Any number can live in one process; each takes about 29 MB. Use it as a context manager or
    call `close`.

    Args:
        physics_hz: Physics steps a second.
        gravity: Acceleration in m/s².
        renderer: What draws its pictures; see `renderers.choose`.

    Attributes:
        bullet: Pybullet's functions, bound to this client.
        id: Bullet's number for this client.
        physics_hz: Physics steps a second.
        renderer: What draws its pictures.
        snapshots: How many snapshots of it are kept.
        scenery: What is drawn beside the bodies; count its changes in `looks`, too.
        looks: How often the look of a body was changed.
        drawn: What the rasteriser keeps of its bodies, for its next picture.
        meshes: The mesh that the rasteriser draws for one that Bullet knows, by Bullet's name.
        surfaces: The part of each link that collides by the whole surface of a mesh, by Bullet's
            number of the body and the index of the link.
        holders: Its links that can hold others; see `attachments`.

    Raises:
        SimulationError: Bullet refuses a connection, or the EGL renderer does not load.
    """

    def __init__(
        self,
        *,
        physics_hz: int,
        gravity: Vec3 = (0.0, 0.0, -9.81),
        renderer: Renderer = "tiny",
    ) -> None:
        if physics_hz <= 0:
            raise SimulationError(f"physics_hz must be above 0, not {physics_hz}")
        self.physics_hz = physics_hz
        self.renderer = renderer
        self.snapshots = 0
        self.scenery = Scenery()
        self.looks = 0
        self.drawn: object = None
        self.meshes: dict[str, Path] = {}
        self.surfaces: dict[tuple[int, int], Part] = {}
        self.holders: list[Any] = []
        self.id: int = p.connect(p.DIRECT)
        if self.id < 0:
            raise SimulationError("Bullet opens no more clients in this process; close some first")
        self.bullet = Calls(self.id)
        self._open = True
        try:
            self._configure(gravity)
            if renderer == "egl":
                load_egl(self.bullet)
        except BaseException:
            self.close()
            raise

    @property
    def dt(self) -> float:
        """Length of a physics step in seconds."""
        return 1.0 / self.physics_hz

    def step(
        self,
        substeps: int,
        drives: Sequence[Iterator[object]] = (),
        watches: Sequence[Callable[[], object]] = (),
        holds: Sequence[Callable[[], object]] = (),
    ) -> None:
        """Advance by physics steps.

        Args:
            substeps: How many.
            drives: Each is advanced before each step, for commands that change within a control
                step or last a single physics step.
            watches: Each is called after each step; it must change nothing.
            holds: Each is called after each step, for what the engine does not hold.
        """
        advance = self.bullet.stepSimulation
        for _ in range(substeps):
            for drive in drives:
                next(drive)
            advance()
            for hold in holds:
                hold()
            for watch in watches:
                watch()

    def advance(self) -> None:
        """Take one physics step, and nothing else."""
        self.bullet.stepSimulation()

    def set_gravity(self, gravity: Vec3) -> None:
        """Change the acceleration of everything that is free to move, in m/s²."""
        self.bullet.setGravity(*gravity)

    def collide(self) -> None:
        """Find contacts afresh: they are stale after a body was placed or a snapshot restored.

        The trajectory does not depend on whether this was called.
        """
        self.bullet.performCollisionDetection()

    def close(self) -> None:
        """Free the world. Closing twice is fine; using it afterwards raises."""
        if self._open:
            self._open = False
            self.bullet.retire()
            with captured():  # the EGL window says goodbye
                p.disconnect(self.id)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _configure(self, gravity: Vec3) -> None:
        # Pairs of links that are near each other are found by comparing all with all, which hardly
        # takes longer with a hundred links. Bullet's tree forgets only a tenth of the old pairs at
        # a time, so the order of solving contacts would depend on all that moved before.
        self.bullet.resetSimulation(p.RESET_USE_SIMPLE_BROADPHASE)
        self.bullet.setPhysicsEngineParameter(
            fixedTimeStep=self.dt,
            numSolverIterations=SOLVER_ITERATIONS,
            solverResidualThreshold=RESIDUAL,
            deterministicOverlappingPairs=1,
            # The cache is keyed by path and shared by the process: an edited mesh would stay old.
            enableFileCaching=0,
        )
        self.set_gravity(gravity)
