"""The tab of the scene: what is drawn around it, and what a click says of a part of it."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taskbuilder.errors import TaskbuilderError
from taskbuilder.task import Task
from taskbuilder.view.contacts import Contacts
from taskbuilder.view.scene import (
    COLLISIONS,
    CONTACTS,
    EXPERT,
    BrowserScene,
    camera_pictures,
    look_from,
    switches,
)
from taskbuilder.view.stage_poses import stage_poses
from taskbuilder.view.words import contact_forces, expert_poses, plain, pose_yaml
from taskbuilder.world.building import build_world
from taskbuilder.world.visible import LinkPoses
from taskbuilder.world.world import World

Ask = Callable[[Callable[[], None]], None]
"""Has something done in the thread of the page."""


class SceneTab:
    """Shows a world, and switches what is drawn around it.

    Args:
        server: The server of viser.
        tab: The container that the controls stand in.
        ask: Has something done in the thread of the page.
        picked: Called with the name of a part of the scene that was clicked.
        shown: Called after another scene is shown.

    Attributes:
        world: The world that is shown, in its initial state; None if there is none.
        variation: Number of its variation.
    """

    def __init__(
        self,
        server: Any,
        tab: Any,
        *,
        ask: Ask,
        picked: Callable[[str], None],
        shown: Callable[[], None],
    ) -> None:
        self.world: World | None = None
        self.variation = 0
        self._touching: Contacts | None = None
        self._server, self._picked, self._shown = server, picked, shown
        self._scene = BrowserScene(server, lambda name: ask(lambda: self.pick(name)))
        gui = server.gui
        with tab:
            self.boxes = {
                word: gui.add_checkbox(word.capitalize(), initial_value=on)
                for word, on in switches().items()
            }
            self.pictures: list[Any] = []
            self._picture_folder = gui.add_folder("What cameras see", visible=False)
            self.poses = gui.add_markdown("", visible=False)
            self.forces = gui.add_markdown("")
            self.picked = gui.add_markdown("Click a part of the scene to see its name and pose.")
        for word, box in self.boxes.items():
            box.on_update(lambda _, word=word: ask(lambda: self.switch(word)))

    def show(self, task: Task, variation: int, seed: int) -> None:
        """Show the initial state of an episode.

        Args:
            task: The task.
            variation: Number of the variation; that of the last one for numbers beyond.
            seed: Seed of the episode.

        Raises:
            TaskbuilderError: The scene cannot be built, or its objects do not fit.
        """
        first = self.world is None
        self.close()
        self.variation = min(variation, len(task.file.scenes) - 1)
        self.world = build_world(task.file, variation=self.variation)
        self.world.reset(seed)
        if first:
            look_from(self._server, self.world)
        self._touching = None
        self._scene.show(self.world)
        self.place_initially()
        for word, box in self.boxes.items():
            if box.value:
                self.switch(word)
        self._shown()

    def place_initially(self) -> None:
        """Put the links where they are in the initial state."""
        if self.world is not None:
            self.place(LinkPoses(self.world).now())

    def close(self) -> None:
        """Free the world that is shown."""
        if self.world is not None:
            self.world.close()
            self.world = None

    def place(self, poses: NDArray[np.float32]) -> None:
        """Put the links where they are; see `LinkPoses.now`."""
        self._scene.place(poses)

    def show_beside(self, *, on: bool) -> None:
        """Show the world once more beside itself, for another episode, or only once."""
        self._scene.show_beside(self.world if on else None)

    def place_beside(self, poses: NDArray[np.float32]) -> None:
        """Put the links of the world beside it where they are."""
        self._scene.place_beside(poses)

    def pick(self, name: str) -> None:
        """Say what a part of the scene is called, and where it is in the initial state."""
        if self.world is None:
            return
        self._picked(name)
        try:
            pose = self.world.pose(name)
        except (TaskbuilderError, KeyError):
            self.picked.content = f"**{plain(name)}**"
            return
        self.picked.content = f"**{plain(name)}**\n\n{pose_yaml(name, pose)}"

    def switch(self, word: str) -> None:
        """Draw what a switch is for, or remove it."""
        on = self.boxes[word].value and self.world is not None
        if word == EXPERT:
            self._show_expert(self.world if on else None)
            return
        if word == CONTACTS:
            self.touch(self._touching)
            return
        if word == COLLISIONS:
            self._scene.show_collisions(self.world if on else None)
            return
        self._scene.switch(word, self.world if on else None)
        if word == "cameras":
            self._show_pictures(self.world if on else None)

    def touch(self, contacts: Contacts | None) -> None:
        """Show what touches what in an episode, if that is switched on."""
        self._touching = contacts
        on = bool(self.boxes[CONTACTS].value)
        self._scene.show_contacts(contacts if on else None)
        self.forces.content = contact_forces(contacts) if on else ""

    def light(self, names: Collection[str]) -> None:
        """Colour the objects and robots that findings speak of, and no others."""
        self._scene.light(names)

    def _show_expert(self, world: World | None) -> None:
        poses = stage_poses(world) if world is not None else ()
        self._scene.show_ghosts(world, poses)
        self.poses.content = expert_poses(poses)
        self.poses.visible = world is not None

    def _show_pictures(self, world: World | None) -> None:
        for picture in self.pictures:
            picture.remove()
        shown = camera_pictures(world) if world is not None else {}
        self._picture_folder.visible = bool(shown)
        with self._picture_folder:
            self.pictures = [
                self._server.gui.add_image(picture, label=name) for name, picture in shown.items()
            ]
