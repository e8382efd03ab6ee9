"""People who steer by gamepad: the sockets of their windows, and what they send.

A message says what a gamepad does at a moment, and counts in the next control step, once, like a
key. So a robot stands still as soon as its gamepad is unplugged, or its window is gone.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from itertools import count
from typing import Any, NamedTuple

from taskbuilder.geometry import Vec3
from taskbuilder.steering.operator import GRIP, Operator
from taskbuilder.view.gamepad_page import GAMEPAD_HTML
from taskbuilder.view.gate import Gate

PATH = "/gamepad"

MOST_TEXT = 500
"""Longest message of a window, in characters."""

LARGEST = 1e6
"""Largest number of a direction that is taken for one, before it is brought to -1 to 1."""

SHORTEST_S = 0.01
"""Between two messages of a window; those that come sooner wait."""

UNREADABLE = 1008
"""The close code of WebSocket for a message that breaks the rules."""

STILL: Vec3 = (0.0, 0.0, 0.0)


class PadMessage(NamedTuple):
    """What a window sends.

    Attributes:
        take: The robot that is chosen, or None.
        name: The name of the person who chooses.
        press: The button that was pressed, or "".
        shift: Where the sticks point: forwards, left and up, each -1 to 1.
        turn: How they turn the tool about its axes, each -1 to 1.
        unplugged: Whether the gamepad is unplugged; None for no news.
    """

    take: str | None = None
    name: str = ""
    press: str = ""
    shift: Vec3 = STILL
    turn: Vec3 = STILL
    unplugged: bool | None = None


def read_message(text: object) -> PadMessage | None:
    """A message of a window; None for one that breaks the rules.

    Args:
        text: What came from the socket.
    """
    if not isinstance(text, str) or len(text) > MOST_TEXT:
        return None
    try:
        data = json.loads(text)
    except (ValueError, RecursionError):
        return None
    if not isinstance(data, dict):
        return None
    take, unplugged = data.get("take"), data.get("unplugged")
    name, press = data.get("name", ""), data.get("press", "")
    shift, turn = _direction(data.get("move")), _direction(data.get("turn"))
    if not isinstance(name, str) or not isinstance(press, str) or shift is None or turn is None:
        return None
    if not isinstance(take, str | None) or not isinstance(unplugged, bool | None):
        return None
    return PadMessage(take, name, press, shift, turn, unplugged)


def _direction(values: object) -> Vec3 | None:
    """Three numbers from -1 to 1; those that are beyond are the nearest of these."""
    if values is None:
        return STILL
    if not isinstance(values, list) or len(values) != len(STILL):
        return None
    if not all(isinstance(v, int | float) and abs(v) <= LARGEST for v in values):
        return None
    x, y, z = (min(max(float(v), -1.0), 1.0) for v in values)
    return (x, y, z)


class PadClient:
    """The socket of a window.

    Args:
        connection: The connection of `websockets`.

    Attributes:
        heard: Called with each message, in the thread of the page.
    """

    def __init__(self, connection: Any) -> None:
        self.heard: Callable[[PadMessage], None] = lambda _: None
        self._connection = connection
        self._loop = asyncio.get_running_loop()
        self._news = asyncio.Event()
        self._latest = ""

    def tell(self, state: Mapping[str, Any]) -> None:
        """Send a state to the window; one that it has not taken yet is replaced."""
        self._latest = json.dumps(state)
        with suppress(RuntimeError):  # the server has stopped
            self._loop.call_soon_threadsafe(self._news.set)

    async def send(self) -> None:
        """Send the latest state, again and again."""
        while True:
            await self._news.wait()
            self._news.clear()
            await self._connection.send(self._latest)


class Gamepads:
    """The windows in which people steer by gamepad.

    Args:
        gate: Serves their page and their sockets.
        ask: Has something done in the thread of the page.

    Attributes:
        clients: The sockets of the windows, by what identifies them.
    """

    def __init__(self, gate: Gate, ask: Callable[[Callable[[], None]], None]) -> None:
        self.clients: dict[int | str, PadClient] = {}
        self._ask, self._numbers = ask, count()
        gate.add_page(PATH, GAMEPAD_HTML)
        gate.add_socket(f"{PATH}/socket", self._talk)

    async def _talk(self, connection: Any) -> None:
        from websockets.exceptions import ConnectionClosed

        client, key = PadClient(connection), f"gamepad {next(self._numbers)}"
        self.clients[key] = client
        sender = asyncio.create_task(client.send())
        try:
            while True:
                message = read_message(await connection.recv())
                if message is None:
                    await connection.close(UNREADABLE, "this is no message of a gamepad")
                    return
                self._ask(partial(self._hear, client, message))
                await asyncio.sleep(SHORTEST_S)
        except ConnectionClosed:
            pass
        finally:
            self.clients.pop(key, None)
            sender.cancel()
            with suppress(asyncio.CancelledError, ConnectionClosed):
                await sender

    @staticmethod
    def _hear(client: PadClient, message: PadMessage) -> None:
        client.heard(message)


class PadWindow:
    """A window whose person steers by gamepad.

    Args:
        client: Its socket.
        robots: What can be chosen.
        take: Called with the name of a robot when it is chosen.
        press: Called with the button that was pressed: ``begin``, ``keep`` or ``again``.
        heading: Direction that counts as forwards, about the vertical from x, in rad.

    Attributes:
        name: The name of the person; "" if it was not given.
        robot: The robot that is steered, or "".
        unplugged: Whether the gamepad is unplugged.
    """

    def __init__(
        self,
        client: PadClient,
        robots: Sequence[str],
        take: Callable[[str], None],
        press: Callable[[str], None],
        heading: Callable[[], float],
    ) -> None:
        self.name = self.robot = ""
        self.unplugged = False
        self._client, self._robots = client, tuple(robots)
        self._take, self._do, self._heading = take, press, heading
        self._operator: Operator | None = None
        client.heard = self._hear
        self.say("Choose a robot.")

    def say(self, words: str, *, wrong: bool = False) -> None:
        """Show a text to this person."""
        self._client.tell(
            {"robot": self.robot, "robots": self._robots, "said": words, "wrong": wrong}
        )

    def steer(self, operator: Operator | None, robot: str = "") -> None:
        """Steer a robot by this window's gamepad, or none."""
        self._operator, self.robot = operator, robot

    def follow(self, tool: object) -> None:
        """Nothing of this window is at the tool."""

    def close(self) -> None:
        """Steer nothing any more."""
        self._client.heard = lambda _: None

    def _hear(self, message: PadMessage) -> None:
        if message.unplugged is not None:
            self.unplugged = message.unplugged
            self._do("")
        if message.take is not None:
            self.name = message.name
            self._take(message.take)
        if self._operator is not None:
            if message.press == "grip":
                self._operator.press(GRIP)
            elif message.press:
                self._do(message.press)
            if (message.shift, message.turn) != (STILL, STILL):
                self._operator.push(message.shift, message.turn, heading=self._heading())
