"""The scene in the browser: links that move, and what is drawn around them."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taskbuilder.geometry import Pose
from taskbuilder.view.contacts import Contacts
from taskbuilder.view.links import BrowserLinks, Picked
from taskbuilder.view.marks import WORDS, marks_of, segments
from taskbuilder.view.stage_poses import StagePose
from taskbuilder.view.words import margin_words
from taskbuilder.world.pictures import capture
from taskbuilder.world.segments import FLOOR
from taskbuilder.world.visible import (
    LinkPoses,
    VisibleLink,
    VisibleMesh,
    collision_links,
    visible_links,
)
from taskbuilder.world.world import World

LINE_PX = 2.0
BEHIND = 1.25
"""Browsers begin so many times as far away as the scene's first camera."""

PICTURE_WIDTH = 240
"""Width of the small pictures of what cameras see, in pixels."""

EXPERT = "expert's poses"
"""The switch for the poses that the expert's stages require."""

CONTACTS = "contacts and forces"
"""The switch for what touches what."""

COLLISIONS = "collision shapes"
"""The switch for the shapes by which the physics lets links collide."""

MAGENTA = (219, 39, 119)
GREEN, RED, LIT = (22, 163, 74), (220, 38, 38), (245, 158, 11)
GHOST_COLORS = {"in reach": GREEN, "out of reach": RED, "in collision": RED}
GHOST_OPACITY = 0.55

ROOT, BESIDE = "/scene", "/beside"
"""Paths of the world that is shown, and of the same world beside it."""

SURROUNDINGS = (FLOOR, "distractors")
"""What is not shown again beside it."""

GAP_M = 0.3
"""Between two worlds side by side, in metres."""


class BrowserScene:
    """A world in the scene of a viser server, and perhaps the same world once more beside it.

    Args:
        server: The server.
        picked: Called with the name of a link that was clicked.
    """

    def __init__(self, server: Any, picked: Picked) -> None:
        self._server = server
        self._picked = picked
        self._marks: dict[str, list[Any]] = {}
        self._links = BrowserLinks(server, ROOT, picked)
        self._beside: tuple[Any, BrowserLinks] | None = None
        self._solid: tuple[VisibleLink, ...] = ()

    def show(self, world: World) -> None:
        """Show a world in the place of what was shown before; the viewer's camera stays."""
        with self._server.atomic():
            self._server.scene.reset()
            self._marks, self._beside, self._solid = {}, None, ()
            self._links = BrowserLinks(self._server, ROOT, self._picked)
            self._server.scene.set_up_direction("+z")
            self._server.scene.configure_default_lights()
            for link in visible_links(world):
                self._links.add(link)

    def place(self, poses: NDArray[np.float32]) -> None:
        """Put the links where they are.

        Args:
            poses: (l, 7) of all links; see `LinkPoses.now`.
        """
        with self._server.atomic():
            self._links.place(poses)

    def show_beside(self, world: World | None) -> None:
        """Show a world once more, to the right of itself as its first camera sees it.

        Args:
            world: The world that is shown; None to show it once only.
        """
        if self._beside is not None:
            self._beside[0].remove()
            self._beside = None
        if world is None:
            return
        with self._server.atomic():
            links = [link for link in visible_links(world) if link.name not in SURROUNDINGS]
            root = self._server.scene.add_frame(
                BESIDE, show_axes=False, position=_to_the_right(world, links)
            )
            self._beside = root, BrowserLinks(self._server, BESIDE, self._picked)
            for link in links:
                self._beside[1].add(link)
            self._beside[1].cover(self._solid)

    def place_beside(self, poses: NDArray[np.float32]) -> None:
        """Put the links of the world beside it where they are; see `place`."""
        if self._beside is not None:
            with self._server.atomic():
                self._beside[1].place(poses)

    def show_collisions(self, world: World | None) -> None:
        """Draw the shapes by which links collide over their looks; they follow the links.

        Args:
            world: The world that is shown; None to remove them.
        """
        self._solid = collision_links(world) if world is not None else ()
        with self._server.atomic():
            self._links.cover(self._solid)
            if self._beside is not None:
                self._beside[1].cover(self._solid)

    # --- what is drawn around it

    def switch(self, word: str, world: World | None) -> None:
        """Show or hide frames, grasp points, sites, regions, reach or cameras.

        Args:
            word: One of `WORDS`, or ``cameras``.
            world: The world as it stands, or None to hide them.
        """
        for handle in self._marks.pop(word, []):
            handle.remove()
        if world is not None:
            add = self._cameras(world) if word == "cameras" else self._lines(world, word)
            self._marks[word] = add

    def show_ghosts(self, world: World | None, poses: Sequence[StagePose]) -> None:
        """Draw fingers where the expert needs them: green where a robot gets, and red elsewhere.

        Args:
            world: The world in its initial state; None to remove them.
            poses: The poses that the expert's stages require.
        """
        for handle in self._marks.pop(EXPERT, []):
            handle.remove()
        if world is not None:
            fingers = {name: list(_fingers(world, name)) for name in world.robots}
            self._marks[EXPERT] = [
                handle
                for number, pose in enumerate(poses)
                for handle in self._ghost(number, pose, fingers[pose.robot])
            ]

    def _ghost(
        self, number: int, ghost: StagePose, fingers: Sequence[tuple[Pose, VisibleMesh]]
    ) -> Iterator[Any]:
        scene, color = self._server.scene, GHOST_COLORS[ghost.verdict]
        for part, (offset, mesh) in enumerate(fingers):
            place = ghost.pose @ offset
            x, y, z, w = place.quaternion
            yield scene.add_mesh_simple(
                f"/expert/{number}/{part}",
                mesh.vertices,
                mesh.triangles,
                color=color,
                opacity=GHOST_OPACITY,
                position=place.position,
                wxyz=(w, x, y, z),
            )
        text = f"{ghost.stage} {ghost.robot}: {margin_words(ghost.margin_mm)}"
        yield scene.add_label(f"/expert_names/{number}", text, position=ghost.pose.position)

    def show_contacts(self, contacts: Contacts | None) -> None:
        """Draw the forces of contacts as lines; None to remove them."""
        for handle in self._marks.pop(CONTACTS, []):
            handle.remove()
        if contacts is not None and len(contacts.lines):
            add = self._server.scene.add_line_segments
            self._marks[CONTACTS] = [
                add("/contacts", contacts.lines, MAGENTA, thickness=4.0, thickness_units="screen")
            ]

    def light(self, names: Collection[str]) -> None:
        """Colour objects and robots, and give all others their own colours.

        Args:
            names: Those to colour.
        """
        for name, handle, color in self._links.meshes:
            handle.color = LIT if name.partition(".")[0] in names else color

    def _lines(self, world: World, word: str) -> list[Any]:
        marks = marks_of(world, word)
        lines, colors = segments(marks)
        scene = self._server.scene
        added = []
        if len(lines):
            added.append(
                scene.add_line_segments(
                    f"/{word}/lines", lines, colors, thickness=LINE_PX, thickness_units="screen"
                )
            )
        for number, tag in enumerate(marks.tags):
            added.append(scene.add_label(f"/{word}/{number}", tag.text, position=tag.point))
        return added

    def _cameras(self, world: World) -> list[Any]:
        added = []
        for name in world.scene.cameras:
            view = world.camera(name)
            x, y, z, w = view.pose.quaternion
            path = f"/cameras/{name}"
            added.append(
                self._server.scene.add_camera_frustum(
                    path,
                    float(np.deg2rad(view.fov_deg)),
                    view.width / view.height,
                    scale=0.08,
                    thickness=LINE_PX,
                    thickness_units="screen",
                    position=view.eye,
                    wxyz=(w, x, y, z),
                )
            )
            added.append(
                self._server.scene.add_label(f"/camera_names/{name}", name, position=view.eye)
            )
        return added


def _to_the_right(world: World, links: Sequence[VisibleLink]) -> NDArray[np.float64]:
    """(3,) by how much a world has to be moved to stand beside itself."""
    view = world.camera(next(iter(world.scene.cameras)))
    ahead = np.array(view.target) - np.array(view.eye)
    right = np.array([ahead[1], -ahead[0], 0.0])
    length = float(np.linalg.norm(right))
    right = right / length if length > 1e-6 else np.array([1.0, 0.0, 0.0])
    poses = LinkPoses(world).now()
    spread = [
        _moved(mesh.vertices, poses[link.row]) @ right for link in links for mesh in link.meshes
    ]
    return (float(max(map(np.max, spread)) - min(map(np.min, spread))) + GAP_M) * right


def _moved(points: NDArray[np.float32], pose: NDArray[np.float32]) -> NDArray[np.float64]:
    """(n, 3) points of a link in the world; its pose as in `LinkPoses.now`."""
    x, y, z, w, *axis = pose.astype(np.float64)
    turn = np.cross(axis, points.astype(np.float64))
    moved: NDArray[np.float64] = points + 2.0 * (np.cross(axis, turn) + w * turn) + (x, y, z)
    return moved


def camera_pictures(world: World) -> Mapping[str, NDArray[np.uint8]]:
    """What every camera of a world sees, small: (height, width, 3) uint8 by name."""
    pictures = {}
    for name, spec in world.scene.cameras.items():
        height = round(PICTURE_WIDTH * spec.size[1] / spec.size[0])
        view = world.camera(name, (PICTURE_WIDTH, height))
        pictures[name] = capture(world, view).rgb
    return pictures


def switches() -> Mapping[str, bool]:
    """What can be shown and hidden, and whether it is shown at first."""
    return dict.fromkeys((*WORDS, "cameras", COLLISIONS, CONTACTS, EXPERT), False)


def _fingers(world: World, robot: str) -> Iterator[tuple[Pose, VisibleMesh]]:
    """The meshes of a robot's fingers, each with the place of its link in the tool."""
    names = {f"{robot}.{link}" for link in world.robots[robot].tip_links}
    poses, tool = LinkPoses(world).now(), world.pose(f"{robot}.tcp")
    for link in visible_links(world):
        if link.name in names:
            x, y, z, w, qx, qy, qz = poses[link.row].tolist()
            offset = tool.inverse() @ Pose((x, y, z), (qx, qy, qz, w))
            yield from ((offset, mesh) for mesh in link.meshes)


def look_from(server: Any, world: World) -> None:
    """Let browsers begin a little behind where the first camera of a scene stands."""
    view = world.camera(next(iter(world.scene.cameras)))
    eye, target = np.array(view.eye), np.array(view.target)
    camera = server.initial_camera
    camera.position, camera.look_at = target + BEHIND * (eye - target), target
    camera.up, camera.fov = view.up, float(np.deg2rad(view.fov_deg))
