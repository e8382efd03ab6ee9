"""The tab in which things are moved by hand, and the task file is changed accordingly."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from taskbuilder.errors import TaskbuilderError, UsageError, display_path
from taskbuilder.fixes import Correction
from taskbuilder.geometry import Pose
from taskbuilder.schema.rewrite import rewritten
from taskbuilder.view.placing import Movable, Placing, movables
from taskbuilder.view.regions import RegionPlacing
from taskbuilder.view.scene import PICTURE_WIDTH
from taskbuilder.view.scene_tab import Ask, SceneTab
from taskbuilder.view.words import difference, placed, plain, region_placed
from taskbuilder.world.pictures import capture
from taskbuilder.world.visible import LinkPoses

REGION_COLOR = (147, 51, 234)

NOTHING = "nothing"
WRITE, UNDO, BACK = "Write", "Undo", "Put it back"
BUTTONS = (WRITE, UNDO, BACK)


class PlaceTab:
    """Moves things of the scene that is shown, and writes where they are into the task file.

    Args:
        server: The server of viser.
        tab: The container that the controls stand in.
        ask: Has something done in the thread of the page.
        scene: The tab of the scene.
        stop: Stops what is played, so that the scene stands still; whether that can be done.

    Attributes:
        placing: What is moved now, or None.
        words: What is said about it.
    """

    def __init__(
        self, server: Any, tab: Any, *, ask: Ask, scene: SceneTab, stop: Callable[[], bool]
    ) -> None:
        self._server, self._tab, self._ask = server, tab, ask
        self._scene, self._stop = scene, stop
        self.placing: Placing | RegionPlacing | None = None
        self._things: dict[str, Movable] = {}
        self._gizmo: Any = None
        self._corner: Any = None
        self._edges: Any = None
        self._poses: LinkPoses | None = None
        self._done: list[Correction] = []
        gui = server.gui
        with tab:
            self.choice = gui.add_dropdown("Move", (NOTHING,))
            self.words = gui.add_markdown("Choose what to move, then drag it by the arrows.")
            self._picture_folder = gui.add_folder("What the camera sees", visible=False)
            self._picture: Any = None
            buttons = gui.add_button_group("", BUTTONS)
        self.choice.on_update(lambda _: ask(lambda: self.take(self.choice.value)))
        buttons.on_click(lambda _: ask(lambda: self.do(buttons.value)))

    def show(self) -> None:
        """Move things of the scene that is shown now."""
        world = self._scene.world
        # With the scene, what was drawn in it has gone.
        self.placing = self._gizmo = self._corner = self._edges = self._poses = None
        self._things = {str(thing): thing for thing in movables(world)} if world else {}
        chosen = self.choice.value
        self.choice.options = (NOTHING, *self._things)
        self.choice.value = chosen if chosen in self._things else NOTHING
        self.take(self.choice.value, keep_words=True)

    def take(self, label: str, *, keep_words: bool = False) -> None:
        """Take what is to be moved.

        Args:
            label: The thing, as the list of choices says it; `NOTHING` to let go.
            keep_words: Whether what was said last stays.
        """
        for drawn in (self._gizmo, self._corner, self._edges):
            if drawn is not None:
                drawn.remove()
        self._gizmo = self._corner = self._edges = None
        self.placing, world = None, self._scene.world
        self._see(None)
        thing = self._things.get(label)
        if world is None or thing is None:
            return
        if not self._stop():
            self.words.content = "✗ People steer this episode; end it before you move things."
            return
        self._poses = LinkPoses(world)
        make = RegionPlacing if thing.sort == "region" else Placing
        self.placing = make(world, self._scene.variation, thing)
        if not keep_words:
            self._say()
        self._add_gizmos()
        self._follow()
        self._see(self.placing)

    def pick(self, name: str) -> None:
        """Take what was clicked, if it can be moved."""
        for label, thing in self._things.items():
            if thing.name == name.partition(".")[0] and thing.sort in ("object", "base"):
                self.choice.value = label  # which takes it

    def move(self, pose: Pose) -> None:
        """Move the chosen thing.

        Args:
            pose: Where to, in the world.
        """
        if self.placing is None or self._poses is None:
            return
        self.placing.move(pose)
        self._scene.place(self._poses.now())
        self._follow_region(dragged=self._gizmo)
        self._say()

    def resize(self, corner: Pose) -> None:
        """Resize the chosen region.

        Args:
            corner: Where to move its corner, in the world.
        """
        if isinstance(self.placing, RegionPlacing):
            self.placing.move_corner(corner)
            self._follow_region(dragged=self._corner)
            self._say()

    def do(self, button: str) -> None:
        """What a button does."""
        try:
            said = {WRITE: self.write, UNDO: self.undo, BACK: self.put_back}[button]()
        except (TaskbuilderError, OSError) as error:
            said = f"✗ {plain(str(error))}"
        self.words.content = said

    def write(self) -> str:
        """Write where the thing is into the task file; returns what was done.

        Raises:
            UsageError: Nothing has moved, or the file has changed meanwhile, or a value in it
                cannot be changed alone.
            OSError: The file cannot be written.
        """
        correction = self._correction()
        correction.write()
        self._done.append(correction)
        return f"Written to {plain(display_path(correction.file))}. *Undo* takes it back."

    def undo(self) -> str:
        """Take the last change of the file back; returns what was done.

        Raises:
            UsageError: There is none, or the file has changed since.
            OSError: The file cannot be written.
        """
        if not self._done:
            raise UsageError("nothing has been written that could be undone")
        last = self._done[-1]
        Correction(last.file, last.after, last.before).write()
        self._done.pop()
        return f"{plain(display_path(last.file))} is as it was before."

    def put_back(self) -> str:
        """Put the thing back where it was; returns what is said then."""
        if self.placing is None:
            return "Nothing is being moved."
        self.placing.put_back()
        if self._poses is not None:
            self._scene.place(self._poses.now())
        self._follow()
        return self._words_of(self.placing)

    # --- display

    def _add_gizmos(self) -> None:
        """The arrows by which the thing is dragged; a region on a surface has none upwards."""
        region, add = self.placing, self._server.scene.add_transform_controls
        if isinstance(region, RegionPlacing):
            axes = True, True, not region.is_flat
            options = {"depth_test": False, "disable_rotations": True, "active_axes": axes}
            self._gizmo = add("/placed", scale=0.2, **options)
            self._corner = add("/corner", scale=0.1, **options)
            self._corner.on_update(self._resized)
        else:
            self._gizmo = add("/placed", scale=0.25, depth_test=False)
        self._gizmo.on_update(self._dragged)

    def _dragged(self, event: Any) -> None:
        pose, ends = _pose_of(event.target), event.phase == "end"

        def drag() -> None:
            self.move(pose)
            if ends:
                self._see(self.placing)
                self._follow_region()

        self._ask(drag)

    def _resized(self, event: Any) -> None:
        pose, ends = _pose_of(event.target), event.phase == "end"

        def drag() -> None:
            self.resize(pose)
            if ends:
                self._follow_region()

        self._ask(drag)

    def _follow(self) -> None:
        """Put the gizmo where the thing is."""
        if self._gizmo is not None and self.placing is not None:
            _put(self._gizmo, self.placing.pose)
        self._follow_region()

    def _follow_region(self, dragged: Any = None) -> None:
        """Draw the region that is moved, with its gizmos.

        Args:
            dragged: The gizmo that is in somebody's hand, which stays where it is.
        """
        region = self.placing
        if not isinstance(region, RegionPlacing):
            return
        scene = self._server.scene
        with self._server.atomic():
            if self._edges is not None:
                self._edges.remove()
            self._edges = scene.add_line_segments(
                "/region", region.edges(), REGION_COLOR, thickness=3.0, thickness_units="screen"
            )
            for gizmo, pose in ((self._gizmo, region.pose), (self._corner, region.corner)):
                if gizmo is not None and gizmo is not dragged:
                    _put(gizmo, pose)

    def _see(self, placing: Placing | RegionPlacing | None) -> None:
        """Show what a camera that is moved sees."""
        if self._picture is not None:
            self._picture.remove()
            self._picture = None
        world = self._scene.world
        view = placing.view(PICTURE_WIDTH) if isinstance(placing, Placing) else None
        self._picture_folder.visible = view is not None
        if view is not None and world is not None:
            with self._picture_folder:
                self._picture = self._server.gui.add_image(capture(world, view).rgb)

    def _say(self) -> None:
        if self.placing is None:
            return
        words = self._words_of(self.placing)
        try:
            if self.placing.values:
                words = f"{words}\n\n{difference(self._correction())}"
        except (TaskbuilderError, OSError) as error:
            words = f"{words}\n\n✗ {plain(str(error))}"
        self.words.content = words

    @staticmethod
    def _words_of(placing: Placing | RegionPlacing) -> str:
        return region_placed(placing) if isinstance(placing, RegionPlacing) else placed(placing)

    def _correction(self) -> Correction:
        """The task file with what the thing's place makes of it.

        Raises:
            UsageError: Nothing has moved, or a value cannot be changed alone.
            OSError: The file cannot be read.
        """
        world = self._scene.world
        if world is None or self.placing is None or not self.placing.values:
            raise UsageError("nothing has moved")
        file = world.task.entry.file
        before = file.read_bytes().decode("utf-8")
        return Correction(file, before, rewritten(before, self.placing.values))


def _pose_of(gizmo: Any) -> Pose:
    """Where a gizmo is, in the world."""
    (x, y, z), (w, qx, qy, qz) = gizmo.position.tolist(), gizmo.wxyz.tolist()
    return Pose((x, y, z), (qx, qy, qz, w))


def _put(gizmo: Any, pose: Pose) -> None:
    x, y, z, w = pose.quaternion
    gizmo.position, gizmo.wxyz = pose.position, (w, x, y, z)
