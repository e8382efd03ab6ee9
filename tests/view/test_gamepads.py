"""Robots are steered by gamepads over sockets, which are held to their rules."""

from __future__ import annotations

import asyncio
import json
from contextlib import contextmanager, suppress

import pytest
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect as connect_now

from taskbuilder.view.gamepads import PadMessage, read_message
from tests.view.browser import turning, wait_until
from tests.view.test_gate import got

ATTACKS = (
    "",
    "null",
    "[1, 2]",
    "not JSON",
    '{"take": 3}',
    '{"name": ["x"], "take": "arm"}',
    '{"move": [1, 2]}',
    '{"move": [NaN, 0, 0]}',
    '{"move": [1e999, 0, 0]}',
    '{"move": [1' + "0" * 400 + ", 0, 0]}",
    '{"turn": ["1", 0, 0]}',
    '{"turn": {"0": 1}}',
    '{"unplugged": "yes"}',
    "[" * 400,
    '{"name": "' + "x" * 600 + '"}',
    b"\x00\x01",
)


class Hand:
    """A window that steers, without a browser."""

    def __init__(self, connection):
        self._connection = connection
        self.told = {}

    def send(self, **message):
        self._connection.send(json.dumps(message))

    def until(self, holds):
        """Wait until what the server told last is so."""
        while not holds(self.told):
            self.told = json.loads(self._connection.recv(timeout=60.0))
        return self.told


@contextmanager
def hand(server):
    address = f"ws://127.0.0.1:{server.port}/gamepad/socket"
    with connect_now(address, origin=f"http://127.0.0.1:{server.port}") as connection:
        made = Hand(connection)
        made.until(lambda told: told.get("robots"))
        yield made


def test_a_message_says_what_a_gamepad_does():
    text = '{"move": [2, -0.5, 0], "turn": [0, 0, 1], "press": "grip"}'
    assert read_message(text) == PadMessage(None, "", "grip", (1.0, -0.5, 0.0), (0.0, 0.0, 1.0))
    assert read_message('{"take": "arm", "name": "A"}') == PadMessage("arm", "A")
    assert read_message('{"unplugged": true}') == PadMessage(unplugged=True)


@pytest.mark.parametrize("text", ATTACKS)
def test_what_breaks_the_rules_is_no_message(text):
    assert read_message(text) is None


def test_a_robot_is_steered_and_stands_still_when_the_gamepad_is_unplugged(page_of, touch, server):
    with turning(page_of(touch)) as page, hand(server) as anna:
        assert anna.told["robots"] == ["arm", "none"]
        anna.send(take="arm", name="Anna")
        assert anna.until(lambda told: told["robot"] == "arm")["said"] == "You steer arm as Anna."
        anna.send(press="begin")
        wait_until(lambda: page.steering.runs)
        world = page.steering.session.env.episode.world
        height = world.position("arm.tcp")[2]

        def raised():
            anna.send(move=[0, 0, 1])
            return world.position("arm.tcp")[2] > height + 0.03

        wait_until(raised)
        anna.send(unplugged=True)
        status = page.steering._status
        wait_until(lambda: "gamepad of Anna is unplugged: arm stands still" in status.content)
        steps = page.steering.session.env.episode.steps
        wait_until(lambda: page.steering.session.env.episode.steps > steps + 5)
        stood = world.position("arm.tcp")
        wait_until(lambda: page.steering.session.env.episode.steps > steps + 10)
        assert world.position("arm.tcp") == pytest.approx(stood, abs=1e-3)
        anna.send(unplugged=False)
        wait_until(lambda: "unplugged" not in status.content)
    assert page.steering.session.lag_ms is not None


def test_a_robot_of_another_person_is_refused_and_a_window_that_is_gone_lets_it_stand(
    page_of, two_arms, server
):
    with turning(page_of(two_arms)) as page, hand(server) as ben:
        with hand(server) as anna:
            anna.send(take="arm", name="Anna <b>")
            anna.until(lambda told: told.get("robot") == "arm")
            ben.send(take="arm", name="Ben")
            told = ben.until(lambda told: told.get("wrong"))
            assert "arm is steered by Anna <b>; choose another robot" in told["said"]
            ben.send(take="nobody's")
            ben.until(lambda told: 'no robot "nobody' in told.get("said", ""))
            ben.send(take="other", name="Ben")
            ben.until(lambda told: told.get("robot") == "other")
            ben.send(press="begin")
            wait_until(lambda: page.steering.runs)
        wait_until(lambda: "arm" in page.steering.session.steering.standing)
        assert "its person has left" in page.steering._status.content.replace("\\", "")
        ben.send(take="none")
        ben.until(lambda told: told.get("robot") == "")


def test_the_page_of_gamepads_is_not_for_other_sites(page_of, touch, server):
    page_of(touch)
    status, headers, text = got(server, "/gamepad")
    assert status == 200
    assert headers["Content-Type"] == "text/html; charset=utf-8"
    assert "getGamepads" in text
    assert got(server, "/gamepad", Origin="https://elsewhere.example")[0] == 403
    assert got(server, "/gamepad/../gamepad/socket/x")[0] == 404


@pytest.mark.parametrize("origin", ["https://elsewhere.example", "http://127.0.0.1:1", "null"])
def test_sockets_of_other_sites_are_refused(origin, page_of, touch, server):
    page_of(touch)

    async def ask():
        async with connect(
            f"ws://127.0.0.1:{server.port}/gamepad/socket", additional_headers={"Origin": origin}
        ):
            """It must not come to this."""

    with pytest.raises(InvalidStatus, match="403"):
        asyncio.run(ask())


@pytest.mark.parametrize("message", ['{"take": 3}', "x" * 10_000_000, b"\xff" * 10])
def test_a_window_that_breaks_the_rules_is_closed_and_the_others_go_on(
    message, page_of, touch, server
):
    with turning(page_of(touch)), hand(server) as anna:
        anna.send(take="arm", name="Anna")
        anna.until(lambda told: told.get("robot") == "arm")
        with hand(server) as mallory:
            with suppress(ConnectionClosed):
                mallory._connection.send(message)
            with pytest.raises(ConnectionClosed):
                mallory.until(lambda told: told.get("robot") == "arm")
        anna.send(take="none")
        anna.until(lambda told: told.get("robot") == "")
