"""Bring the assets of a task into a client, and what the engine says of them into findings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Literal

from taskbuilder.assets.looks import with_looks
from taskbuilder.assets.model import Urdf
from taskbuilder.assets.paths import AssetError
from taskbuilder.assets.urdf import resolved_text
from taskbuilder.errors import FileError, Finding, SimulationError
from taskbuilder.geometry import Pose
from taskbuilder.quiet import captured
from taskbuilder.schema.load import TaskFile
from taskbuilder.schema.objects import ObjectSpec
from taskbuilder.shapes import MeshShape, Part
from taskbuilder.sim.bodies import create_body, load_urdf
from taskbuilder.sim.body import Body
from taskbuilder.sim.client import Client
from taskbuilder.sim.engine_output import warnings
from taskbuilder.sim.probe import probe
from taskbuilder.sim.redrawn import redrawn
from taskbuilder.world.weights import mass_of


@dataclass(frozen=True)
class Loader:
    """Loads the assets of one task into one client.

    Assets that are not part of an installed package are probed in a child process first.

    Attributes:
        client: Where bodies are made.
        task: The task file, for the places of findings.
        folder: Where what Bullet reads is written; every asset has files of its own there.
        heard: What the engine said while it loaded assets that people can mend.
    """

    client: Client
    task: TaskFile
    folder: Path
    heard: list[Finding] = field(default_factory=list)

    def urdf(self, urdf: Urdf, name: str, pose: Pose, *, fixed: bool, size: float = 1.0) -> Body:
        """Load a URDF by way of a copy in which every path is absolute.

        The rasteriser reads the meshes that are looked at by itself, when it first draws them. So
        Bullet gets a triangle for each: the meshes of a Panda would take 60 MB in every world.

        Raises:
            FileError: The engine dies of the asset or refuses it.
        """
        copy = self.folder / f"{name}-{urdf.path.name}"
        if self.client.renderer != "raster":
            urdf = with_looks(urdf, partial(redrawn, folder=self.folder), painted=True)
        elif self._trusts(name):
            looks = _stand_ins(urdf, copy)
            self.client.meshes.update({str(new): old for old, new in looks.items()})
            urdf = with_looks(urdf, lambda look: [replace(look, file=looks[look.file], color=None)])
        copy.write_text(resolved_text(urdf), encoding="utf-8")
        self._probe(copy, "urdf", name)
        with self._listening(name):
            return load_urdf(self.client, copy, name=name, pose=pose, fixed_base=fixed, scale=size)

    def body(self, parts: Mapping[str, Part], name: str, spec: ObjectSpec) -> Body:
        """Make a body of parts.

        Raises:
            FileError: The engine dies of a mesh or refuses a part.
        """
        for part in parts.values():
            for shape in (part.shape, part.look):
                if isinstance(shape, MeshShape):
                    self._probe(shape.path, "mesh", name)
        with self._listening(name):
            return create_body(
                self.client,
                parts,
                name=name,
                mass=mass_of(spec, parts),
                pose=spec.pose,
                friction=spec.friction,
                rolling_friction=spec.rolling_friction,
                restitution=spec.restitution,
            )

    def finding(self, code: str, message: str, *path: str) -> Finding:
        """A finding at a place of the task file."""
        return Finding(code, message, ".".join(path), self.task.source.locate(path))

    def _trusts(self, name: str) -> bool:
        model = self.task.robots.get(name) or self.task.models.get(name)
        return model.entry.trusted if model else self.task.entry.trusted

    def _place(self, name: str) -> tuple[str, ...]:
        if name in self.task.robots:
            return ("scene", "robots", name, "model")
        return ("scene", "objects", name, "object" if name in self.task.models else "shape")

    def _probe(self, path: Path, kind: Literal["urdf", "mesh"], name: str) -> None:
        if self._trusts(name):
            return
        try:
            probe(path, kind=kind)
        except AssetError as error:
            finding = self.finding(error.code, error.message, *self._place(name))
            raise FileError([finding]) from error

    @contextmanager
    def _listening(self, name: str) -> Iterator[None]:
        """Keep what Bullet prints off the terminal; what it warns of becomes findings."""
        place = self._place(name)
        try:
            with captured() as printed:
                yield
        except SimulationError as error:
            raise FileError([self.finding("TB407", str(error), *place)]) from error
        if not self._trusts(name):
            for sentence in warnings(printed.text):
                location = self.task.source.locate(place)
                self.heard.append(Finding("TB407", sentence, ".".join(place), location, "warning"))


def _stand_ins(urdf: Urdf, copy: Path) -> dict[Path, Path]:
    """A file with one triangle for every mesh of a visual shape, beside the copy of the URDF."""
    shown = {shape.mesh for link in urdf.links for shape in link.visuals if shape.mesh}
    made = {mesh: Path(f"{copy}-{number}.obj") for number, mesh in enumerate(sorted(shown))}
    for path in made.values():
        path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", encoding="utf-8")
    return made
