"""The tab in which people steer robots: each in a browser window, which steers at most one."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from taskbuilder.errors import TaskbuilderError, display_path
from taskbuilder.geometry import Pose
from taskbuilder.steering.operator import GRIP, KEYS, Operator
from taskbuilder.steering.session import Session, State
from taskbuilder.view.gamepads import PATH, Gamepads, PadClient, PadWindow
from taskbuilder.view.scene_tab import Ask
from taskbuilder.view.words import keys_table, plain, steered

NONE = "none"
BEGIN, KEEP, AGAIN = "Begin", "Keep", "Discard and try again"
BUTTONS = {BEGIN: "enter", KEEP: "home", AGAIN: "backspace"}
"""The buttons of the tab, and the key of each in windows that steer."""

PAD_BUTTONS = {"begin": BEGIN, "keep": KEEP, "again": AGAIN}
"""The same buttons, as gamepads press them."""

NO_TASK = "the task has errors; see the tab Findings"

MOST_NAME = 40
"""Longest name of a person, in letters."""


class Window:
    """A browser window: the robot that its person steers, and the keys and the gizmo for it.

    Args:
        client: The client of viser.
        robots: The robots of the task.
        tab: The container that the controls stand in.
        take: Called with the name of a robot, or `NONE`, when it is chosen.
        do: Called with the name of a button whose key was pressed.
        ask: Has something done in the thread of the page.
    """

    def __init__(
        self,
        client: Any,
        robots: tuple[str, ...],
        tab: Any,
        take: Callable[[str], None],
        do: Callable[[str], None],
        ask: Ask,
    ) -> None:
        self.client, self._ask, self._do = client, ask, do
        self._keys: list[Any] = []
        self._gizmo: Any = None
        self._dragged = False
        self._steered = ""
        with tab:
            self._name = client.gui.add_text("Your name", initial_value="", order=0.1)
            # Buttons, because keys that are pressed in a field do not count.
            self._choice = client.gui.add_button_group("You steer", (*robots, NONE), order=0.2)
            self._words = client.gui.add_markdown("", order=0.3)
        self._controls = [self._name, self._choice, self._words]
        self._choice.on_click(lambda _: ask(partial(take, self._choice.value)))

    @property
    def name(self) -> str:
        """The name of the person; "" if it was not given."""
        name: str = self._name.value
        return name

    @property
    def robot(self) -> str:
        """The robot that is steered by this window's keys, or ""."""
        return self._steered

    def say(self, words: str, *, wrong: bool = False) -> None:
        """Show a text to this person alone."""
        self._words.content = f"{'✗ ' * wrong}{plain(words)}"

    def steer(self, operator: Operator | None, robot: str = "") -> None:
        """Steer a robot by this window's keys and gizmo, or none."""
        for each in (*self._keys, self._gizmo):
            if each is not None:
                each.remove()
        self._keys, self._gizmo, self._dragged = [], None, False
        self._steered = robot
        if operator is None:
            return
        add = self.client.gui.add_command
        for key, jog in KEYS.items():
            for fine in (False, True) if key != GRIP else (False,):
                command = add(
                    f"{robot}: {jog.words}{', a little' * fine}",
                    hotkey=key,
                    modifier="shift" if fine else None,
                )
                press = partial(self._press, operator, key, fine=fine)
                command.on_trigger(lambda _, press=press: self._ask(press))
                self._keys.append(command)
        for label, hotkey in BUTTONS.items():
            command = add(label, hotkey=hotkey)
            command.on_trigger(lambda _, label=label: self._ask(lambda: self._do(label)))
            self._keys.append(command)
        self._gizmo = self.client.scene.add_transform_controls(
            "/steered_tool", scale=0.2, depth_test=False, visible=False
        )
        self._gizmo.on_update(partial(self._dragging, operator))

    def close(self) -> None:
        """Remove the controls; the window itself may be gone."""
        for each in (*self._keys, *self._controls, self._gizmo):
            if each is not None:
                each.remove()

    def follow(self, tool: Pose) -> None:
        """Put the gizmo where the tool is, unless it is being dragged."""
        if self._gizmo is not None and not self._dragged:
            x, y, z, w = tool.quaternion
            self._gizmo.position, self._gizmo.wxyz = tool.position, (w, x, y, z)
            self._gizmo.visible = True

    def _press(self, operator: Operator, key: str, *, fine: bool) -> None:
        operator.press(key, heading=self._heading(), fine=fine)

    def _heading(self) -> float:
        """Direction in which this window looks at the scene, about the vertical from x, in rad."""
        camera = self.client.camera
        x, y, _ = camera.look_at - camera.position
        return math.atan2(y, x)

    def _dragging(self, operator: Operator, event: Any) -> None:
        (x, y, z), (w, qx, qy, qz) = event.target.position.tolist(), event.target.wxyz.tolist()
        tool = Pose((x, y, z), (qx, qy, qz, w))
        ends = event.phase == "end"

        def drag() -> None:
            self._dragged = not ends
            operator.drag(tool)

        self._ask(drag)


def on_one_line(name: str) -> str:
    """The name of a person, as data sets have it."""
    return " ".join("".join(c for c in name if c.isprintable()).split())[:MOST_NAME]


class SteeringTab:
    """Lets people steer the robots of a task, and records what they do.

    Args:
        server: The server of viser.
        tab: The container that the controls stand in.
        ask: Has something done in the thread of the page.
        pads: The windows of those who steer by gamepad.
        begin: Begins an episode of the session with what is chosen on the page.

    Attributes:
        session: The session, or None.
    """

    def __init__(
        self,
        server: Any,
        tab: Any,
        *,
        ask: Ask,
        pads: Gamepads,
        begin: Callable[[Session, int | None], None],
    ) -> None:
        self._server, self._tab, self._ask, self._begin = server, tab, ask, begin
        self.session: Session | None = None
        self._pads = pads
        self._windows: dict[int | str, Window | PadWindow] = {}
        self._due = 0.0
        self._said = ""
        gui = server.gui
        with tab:
            self._status = gui.add_markdown("")
            buttons = gui.add_button_group("", tuple(BUTTONS))
            gui.add_markdown(keys_table(KEYS, BUTTONS))
            gui.add_markdown(f"Gamepads steer on [a page of their own]({PATH}).")
        buttons.on_click(lambda _: ask(partial(self._do, buttons.value)))

    # --- the task

    def show(self, session: Session | None, why_not: str = NO_TASK) -> None:
        """Steer the robots of a session from now on.

        Args:
            session: The session, or None.
            why_not: Why there is none.
        """
        self.close()
        for window in self._windows.values():
            window.close()
        self._windows = {}
        self.session, self._said = session, "" if session else f"✗ {plain(why_not)}"
        self._say()

    def close(self) -> None:
        """End the session; an episode that has succeeded is kept."""
        if self.session is not None:
            self.session.close()
            self.session = None

    @property
    def runs(self) -> bool:
        """Whether an episode runs."""
        return self.session is not None and self.session.state == State.RUNNING

    def advance(self, now: float) -> float:
        """Run a control step if it is due.

        Args:
            now: Seconds of a clock that never goes back.

        Returns:
            When the next one is due, or infinity.

        Raises:
            TaskbuilderError: The player cannot go on; the episode is discarded.
        """
        session = self.session
        if session is None:
            return math.inf
        self._follow_clients(session)
        if session.state != State.RUNNING or session.env is None:
            return math.inf
        if now >= self._due:
            self._due = max(self._due + 1.0 / session.control_hz, now)
            try:
                session.step()
            except TaskbuilderError:
                session.discard()
                raise
            finally:
                self._say()
                self._follow_tools(session)
        return self._due

    # --- people

    def _follow_clients(self, session: Session) -> None:
        """Give each new window its controls, and let the robots of closed ones stand still."""
        clients: dict[int | str, Any] = {**self._server.get_clients(), **self._pads.clients}
        for number in self._windows.keys() - clients.keys():
            self._windows.pop(number)
            session.steering.leave(number)
            self._say()
        for number in clients.keys() - self._windows.keys():
            self._windows[number] = self._window(session, number, clients[number])

    def _window(self, session: Session, number: int | str, client: Any) -> Window | PadWindow:
        """A window that is new, with its controls."""
        robots, take = session.steering.robots, partial(self._take, number)
        if isinstance(client, PadClient):
            return PadWindow(client, (*robots, NONE), take, self._press, self._heading)
        return Window(client, robots, self._tab, take, self._do, self._ask)

    def _press(self, button: str) -> None:
        """A button of a gamepad was pressed, or it was plugged in or unplugged."""
        if button in PAD_BUTTONS:
            self._do(PAD_BUTTONS[button])
        self._say()

    def _heading(self) -> float:
        """Direction in which browsers look at first, about the vertical from x, in rad."""
        camera = self._server.initial_camera
        x, y, _ = np.asarray(camera.look_at) - np.asarray(camera.position)
        return math.atan2(y, x)

    def _take(self, number: int | str, robot: str) -> None:
        """A person chose a robot; another person may have it."""
        session, window = self.session, self._windows.get(number)
        if session is None or window is None or robot == window.robot:
            return
        session.steering.let_go(number)
        window.steer(None)
        if robot == NONE:
            window.say("")
        else:
            try:
                operator = session.steering.take(number, robot, on_one_line(window.name))
            except TaskbuilderError as error:
                window.say(str(error), wrong=True)
            else:
                window.steer(operator, robot)
                window.say(f"You steer {robot} as {operator.name}.")
        self._follow_tools(session)
        self._say()

    def _follow_tools(self, session: Session) -> None:
        if session.env is None:
            return
        world = session.env.episode.world
        for window in self._windows.values():
            if window.robot in world.robots:
                window.follow(world.pose(f"{window.robot}.tcp"))

    # --- episodes

    def _do(self, label: str) -> None:
        """What a button or its key does."""
        session = self.session
        if session is None:
            return
        try:
            self._said = self._done(session, label)
        except TaskbuilderError as error:
            self._said = f"✗ {plain(str(error))}"
        self._say()

    def _done(self, session: Session, label: str) -> str:
        if label == KEEP:
            name = session.keep()
            return f"Kept as {plain(name)}." if name else "Kept, but not recorded."
        again = session.discard() if label == AGAIN else None
        if label == AGAIN and again is None:
            return "There is no episode that could be discarded."
        if session.state != State.RUNNING:
            self._begin(session, again)
            self._due = 0.0
            self._follow_tools(session)
        return ""

    def _say(self) -> None:
        session = self.session
        if session is None:
            self._status.content = self._said
            return
        where = display_path(session.folder) if session.folder else ""
        unplugged = (
            f"✗ The gamepad of {plain(window.name or 'a person')} is unplugged: "
            f"{plain(window.robot)} stands still."
            for window in self._windows.values()
            if isinstance(window, PadWindow) and window.unplugged and window.robot
        )
        words = (steered(session, where), *unplugged, self._said)
        self._status.content = "\n\n".join(filter(None, words))
