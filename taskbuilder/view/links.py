"""The links of a world in the browser: frames that move, with what they look like in them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taskbuilder.world.visible import Color, VisibleLink, VisibleMesh

Picked = Callable[[str], None]


class BrowserLinks:
    """The links of a world in the browser.

    Args:
        server: The server of viser.
        root: The path under which they stand.
        picked: Called with the name of a link that was clicked.

    Attributes:
        meshes: The name, the handle and the colour of each mesh that links look like.
    """

    def __init__(self, server: Any, root: str, picked: Picked) -> None:
        self._scene, self._root, self._picked = server.scene, root, picked
        self._frames: dict[int, dict[str, Any]] = {}
        self._known: NDArray[np.float32] | None = None
        self._cover: list[Any] = []
        self.meshes: list[tuple[str, Any, Color]] = []

    def add(self, link: VisibleLink) -> None:
        """Add a link."""
        path = self._frame(link)
        for number, mesh in enumerate(link.meshes):
            handle = self._mesh(link.name, f"{path}/mesh_{number}", mesh)
            self.meshes.append((link.name, handle, mesh.color))

    def cover(self, links: Sequence[VisibleLink]) -> None:
        """Draw other meshes in the same links, in the place of those that were drawn so before.

        Args:
            links: The links, which may be others than those that were added, too.
        """
        for handle in self._cover:
            handle.remove()
        self._cover = [
            self._mesh(link.name, f"{path}/shape_{number}", mesh)
            for link in links
            for path in (self._frame(link),)
            for number, mesh in enumerate(link.meshes)
        ]

    def place(self, poses: NDArray[np.float32]) -> None:
        """Put them where they are; see `LinkPoses.now`."""
        for row, frames in self._frames.items():
            if self._known is not None and np.array_equal(poses[row], self._known[row]):
                continue
            for frame in frames.values():
                frame.position, frame.wxyz = poses[row, :3], poses[row, 3:]
        self._known = poses

    def _frame(self, link: VisibleLink) -> str:
        """The path of a link's frame, which is added if it is not there."""
        path = f"{self._root}/{link.name.replace('.', '/')}"
        frames = self._frames.setdefault(link.row, {})
        if path not in frames:
            frames[path] = self._scene.add_frame(path, show_axes=False)
            if self._known is not None:
                frames[path].position = self._known[link.row, :3]
                frames[path].wxyz = self._known[link.row, 3:]
        return path

    def _mesh(self, name: str, path: str, mesh: VisibleMesh) -> Any:
        handle = self._scene.add_mesh_simple(
            path,
            mesh.vertices,
            mesh.triangles,
            color=mesh.color,
            opacity=None if mesh.opacity >= 1.0 else mesh.opacity,
            side="double" if mesh.opacity < 1.0 else "front",
            cast_shadow=mesh.opacity >= 1.0,
        )
        handle.on_click(lambda _: self._picked(name))
        return handle
