"""The page follows the files, plays episodes and is closed to other sites; no browser is needed."""

from __future__ import annotations

import asyncio
import re
import socket
import time
from pathlib import Path

import numpy as np
import pytest
import viser
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed

from taskbuilder.errors import UsageError
from taskbuilder.view import server as server_module
from taskbuilder.view.scene import COLLISIONS, EXPERT, GREEN, LIT, RED
from taskbuilder.view.server import PageServer
from taskbuilder.view.stage import Choice


def turn(page, until, seconds=60.0):
    """Turn the page's loop until something is so."""
    end = time.monotonic() + seconds
    page.run(lambda: until() or time.monotonic() > end)
    assert until()


def parts(server):
    """The names in the scene of the server."""
    return set(server.viser.scene._handle_from_node_name)


def test_the_scene_is_shown_under_its_dotted_names(page_of, touch, server):
    page_of(touch)
    names = parts(server)
    assert {"/scene/cube", "/scene/arm/panda_link3"} <= names
    assert any(name.startswith("/scene/cube/mesh_") for name in names)


def test_an_episode_is_played_paused_and_scrubbed(page_of, touch):
    page = page_of(touch)
    page.ask(page.episode.play)
    turn(page, lambda: page.episode.recording is not None and page.episode.step >= 3)
    recording = page.episode.recording
    assert recording.rollout.success
    assert len(page.episode.charts) == 1  # one robot, so no force between robots
    page.ask(page.episode.play_or_pause)
    turn(page, lambda: not page.episode.playing)
    page.ask(lambda: page.episode.go_to(7, pause=True))
    turn(page, lambda: page.episode.step == 7)
    assert "step 7 of 30" in page.episode.outcome.content
    assert re.search(r"Near.*cm, within 3 cm", page.episode.lamps.content)
    page.ask(lambda: page.episode.go_to(1000, pause=True))
    turn(page, lambda: page.episode.step == recording.rollout.steps)


def test_the_page_follows_its_files(page_of, touch, server):
    page = page_of(touch)
    text = touch.read_text()
    touch.write_text(text.replace("cube:", "block:"))
    turn(page, lambda: "/scene/block" in parts(server))
    assert "/scene/cube" not in parts(server)


def test_findings_stand_on_the_page_until_they_are_mended(page_of, touch, server):
    page = page_of(touch)
    text = touch.read_text()
    touch.write_text(text.replace("model: panda", "model: pandaa"))
    turn(page, lambda: "TB" in page.findings.content)
    assert "touch.yaml" in page.findings.content.replace("\\", "")
    assert ":5:" in page.findings.content
    assert "panda" in page.findings.content
    assert "/scene/cube" in parts(server)  # what was there last is still to be seen
    touch.write_text(text)
    turn(page, lambda: "No findings" in page.findings.content)


def test_a_task_with_errors_opens_and_shows_them(page_of, touch):
    touch.write_text(touch.read_text().replace("shape:", "shap:"))
    page = page_of(touch)
    assert "shap" in page.findings.content


def test_a_file_that_is_deleted_while_it_is_shown_is_a_finding(page_of, touch):
    page = page_of(touch)
    touch.with_suffix(".py").unlink()
    turn(page, lambda: "No findings" not in page.findings.content)


def test_a_task_file_that_is_deleted_while_it_is_shown_is_a_finding_until_it_is_back(
    page_of, touch, server
):
    told = []
    server.notify = told.append
    page = page_of(touch)
    text = touch.read_text()
    touch.unlink()
    turn(page, lambda: "no longer there" in page.findings.content)
    assert "1 finding" in page.episode.outcome.content
    assert "this is the task as it was" in page._heading.content
    assert "/scene/cube" in parts(server)  # what was there last is still to be seen
    page.ask(page.episode.play)
    turn(page, lambda: page.episode.recording is not None)  # and can be played
    touch.write_text(text.replace("cube:", "block:"))
    turn(page, lambda: "/scene/block" in parts(server))
    assert "No findings" in page.findings.content
    assert "as it was" not in page._heading.content
    gone, back = told
    assert re.search(r"touch\.yaml: error\[TB001\] cannot be read: it is no longer there", gone)
    assert back == "the files have no errors any more"


def test_the_terminal_says_what_the_page_says_of_errors_but_only_once(page_of, touch, server):
    told = []
    server.notify = told.append
    touch.write_text(touch.read_text().replace("mass: 0.1", "mass: -1"))
    page = page_of(touch)
    assert len(told) == 1
    assert "touch.yaml:7:" in told[0]
    touch.write_text(touch.read_text() + "# saved again\n")
    page._reload()
    assert len(told) == 1


def test_a_data_set_that_the_changed_task_does_not_fit_is_told_and_kept(
    page_of, touch, tmp_path, server
):
    told = []
    server.notify = told.append
    page = page_of(touch, record=tmp_path / "data")
    before = (tmp_path / "data" / "dataset.json").read_bytes()
    text = touch.read_text()
    touch.write_text(text.replace("mass: 0.1", "mass: 0.2"))
    turn(page, lambda: page.steering.session is None)
    assert "begun in another way" in page.steering._status.content.replace("\\", "")
    assert "begun in another way" in told[-1]
    assert (tmp_path / "data" / "dataset.json").read_bytes() == before
    touch.write_text(text)
    turn(page, lambda: page.steering.session is not None)


def test_a_data_set_of_another_task_is_refused(page_of, touch, tmp_path):
    page_of(touch, record=tmp_path / "data").close()
    other = tmp_path / "other.yaml"
    other.write_text(touch.read_text().replace("task: touch", "task: other"))
    other.with_suffix(".py").write_text(touch.with_suffix(".py").read_text())
    with pytest.raises(UsageError, match=r"begun in another way[\s\S]*tasks"):
        page_of(other, record=tmp_path / "data")


def test_an_expert_that_cannot_do_its_stages_is_told(page_of, touch):
    touch.write_text(touch.read_text().replace("[0.45, 0, 0.4]", "[3.0, 0, 0.4]"))
    page = page_of(touch)
    page.ask(page.episode.play)
    turn(page, lambda: page.episode.recording is not None)
    assert "failed in stage 1" in page.episode.recording.verdict()


def test_marks_are_switched_on_and_off(page_of, touch, server):
    page = page_of(touch)
    for word in ("frames", "sites", "cameras"):
        page.scene.boxes[word].value = True
        page.ask(lambda word=word: page.scene.switch(word))
    turn(page, lambda: {"/frames/lines", "/sites/lines", "/cameras/front"} <= parts(server))
    assert len(page.scene.pictures) == 1
    page.scene.boxes["cameras"].value = False
    page.ask(lambda: page.scene.switch("cameras"))
    turn(page, lambda: "/cameras/front" not in parts(server))


def test_collision_shapes_are_drawn_in_the_links_and_follow_them(page_of, touch, server):
    page = page_of(touch)

    def place_of(name):
        frame = server.viser.scene._handle_from_node_name[name]
        return tuple(frame.position)

    def shapes(root):
        return {name for name in parts(server) if re.match(rf"/{root}/.*/shape_\d", name)}

    page.scene.boxes[COLLISIONS].value = True
    page.ask(lambda: page.scene.switch(COLLISIONS))
    turn(page, lambda: "/scene/cube/shape_0" in parts(server))
    drawn = server.viser.scene._handle_from_node_name["/scene/cube/shape_0"]
    assert 0.0 < drawn.opacity < 1.0
    assert np.ptp(drawn.vertices, axis=0) == pytest.approx([0.042] * 3, abs=1e-3)
    assert "/scene/arm/panda_hand/shape_0" in parts(server)
    before = place_of("/scene/arm/panda_hand")
    page.episode.other.value = "hold"
    page.ask(page.episode.play)
    turn(page, lambda: page.episode.step >= 12)
    assert place_of("/scene/arm/panda_hand") != before  # the frame that the shapes are in
    assert {name.replace("/beside", "/scene") for name in shapes("beside")} == shapes("scene")

    touch.write_text(touch.read_text().replace("[0.04, 0.04, 0.04]", "[0.04, 0.04, 0.06]"))
    turn(page, lambda: page.episode.recording is None)
    drawn = server.viser.scene._handle_from_node_name["/scene/cube/shape_0"]
    assert np.ptp(drawn.vertices, axis=0) == pytest.approx([0.042, 0.042, 0.062], abs=1e-3)
    page.scene.boxes[COLLISIONS].value = False
    page.ask(lambda: page.scene.switch(COLLISIONS))
    turn(page, lambda: not shapes("scene"))


def test_the_poses_that_the_expert_needs_are_drawn_and_follow_the_files(page_of, touch, server):
    page = page_of(touch)
    page.scene.boxes[EXPERT].value = True
    page.ask(lambda: page.scene.switch(EXPERT))
    turn(page, lambda: "/expert/0/0" in parts(server))
    ghost = server.viser.scene._handle_from_node_name["/expert/0/0"]
    assert tuple(ghost.color) == GREEN
    assert "in reach" in page.scene.poses.content
    touch.write_text(touch.read_text().replace("[0.45, 0, 0.4]", "[3.0, 0, 0.4]"))
    turn(page, lambda: "out of reach" in page.scene.poses.content)
    ghost = server.viser.scene._handle_from_node_name["/expert/0/0"]
    assert tuple(ghost.color) == RED
    page.scene.boxes[EXPERT].value = False
    page.ask(lambda: page.scene.switch(EXPERT))
    turn(page, lambda: "/expert/0/0" not in parts(server))


def test_findings_light_up_what_they_speak_of(page_of, touch, server):
    page = page_of(touch)
    text = touch.read_text()

    def color(name):
        (first, *_) = sorted(part for part in parts(server) if part.startswith(f"/scene/{name}/m"))
        return tuple(server.viser.scene._handle_from_node_name[first].color)

    own = color("cube")
    touch.write_text(text.replace("mass: 0.1", "mass: -1"))
    turn(page, lambda: "TB" in page.findings.content)
    assert color("cube") == LIT
    touch.write_text(text)
    turn(page, lambda: "No findings" in page.findings.content)
    assert color("cube") == own


def test_a_click_names_a_part_and_its_pose(page_of, touch):
    page = page_of(touch)
    page.ask(lambda: page.scene.pick("cube"))
    turn(page, lambda: "yaml" in page.scene.picked.content)
    assert "position: [0.5, 0.2, 0.02]" in page.scene.picked.content


def test_requests_of_a_browser_that_floods_the_page_are_dropped(page_of, touch):
    page = page_of(touch)
    for _ in range(10_000):
        page.ask(lambda: None)
    turn(page, page.requests.empty)


# --- the server


def greeted(server, **headers):
    """Whether the server talks to a connection with these headers."""

    async def ask():
        protocol = f"viser-v{viser.__version__}"
        address = f"ws://127.0.0.1:{server.port}"
        async with connect(
            address, subprotocols=[protocol], additional_headers=headers, max_size=None
        ) as connection:
            try:
                await asyncio.wait_for(connection.recv(), 10.0)
            except ConnectionClosed:
                return False
            return True

    return asyncio.run(ask())


def test_the_page_itself_and_programs_are_talked_to(page_of, touch, server):
    page_of(touch)
    assert greeted(server)
    assert greeted(server, Origin=f"http://127.0.0.1:{server.port}")
    assert greeted(server, Origin=f"http://localhost:{server.port}")


@pytest.mark.parametrize(
    "origin", ["https://elsewhere.example", "http://127.0.0.1:1", "null", "http://[::1"]
)
def test_pages_of_other_sites_are_not_talked_to(origin, page_of, touch, server):
    page_of(touch)
    assert not greeted(server, Origin=origin)


def test_names_that_lead_here_from_elsewhere_are_not_served(page_of, touch, server):
    page_of(touch)

    async def ask():
        reader, writer = await asyncio.open_connection("127.0.0.1", server.port)
        writer.write(
            b"GET / HTTP/1.1\r\nHost: rebound.example\r\nUpgrade: websocket\r\n"
            b"Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
            b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
            b"Sec-WebSocket-Protocol: viser-v" + viser.__version__.encode() + b"\r\n\r\n"
        )
        await reader.readuntil(b"\r\n\r\n")
        frame = await asyncio.wait_for(reader.read(4), 10.0)
        writer.close()
        return frame[0] & 0x0F

    assert asyncio.run(ask()) == 8  # the first frame closes the connection


def test_only_this_machine_can_connect(server):
    assert server.address.startswith("http://127.0.0.1:")
    (listening,) = {
        line.split()[1]
        for line in Path("/proc/net/tcp").read_text().splitlines()[1:]
        if line.split()[3] == "0A" and int(line.split()[1].split(":")[1], 16) == server.port
    }
    assert listening.split(":")[0] == "0100007F"


def test_the_page_cannot_be_shared_through_other_servers(server):
    from viser import _messages

    assert _messages.ShareUrlRequest not in server.viser._websock_server._incoming_handlers


def test_a_port_that_is_taken_is_said():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(UsageError, match=rf"port {port} is taken; choose another with --port"):
            PageServer(port)


def test_without_viser_it_is_said_how_to_get_it(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "viser", None)
    with pytest.raises(UsageError, match=r'pip install "taskbuilder\[view\]"'):
        PageServer(0)


def test_the_choice_begins_with_the_task_as_written():
    assert Choice() == Choice("expert", 0, 0)
    assert server_module.LOCAL == "127.0.0.1"


def test_two_players_are_shown_side_by_side(page_of, touch, server):
    page = page_of(touch)
    page.episode.other.value = "hold"
    page.ask(page.episode.play)
    turn(page, lambda: page.episode.beside is not None)
    page.ask(lambda: page.episode.go_to(12, pause=True))
    turn(page, lambda: page.episode.step == 12)
    assert page.episode.beside.rollout.seed == page.episode.recording.rollout.seed
    assert re.search(
        r"expert: success.*\n\nbeside it, hold: no success", page.episode.outcome.content
    )
    names = parts(server)
    assert {"/beside", "/beside/cube", "/beside/arm/panda_link3"} <= names
    assert "/scene/world/floor" in names
    assert "/beside/world/floor" not in names
    one, other = (
        server.viser.scene._handle_from_node_name[f"/{root}/arm/panda_hand"]
        for root in ("scene", "beside")
    )
    assert (
        np.linalg.norm(one.position - other.position) > 0.05
    )  # one reaches, the other holds still
    page.ask(lambda: page.episode.go_to(1000, pause=True))
    turn(page, lambda: page.episode.step == page.episode.steps)
    page.episode.other.value = "nobody"
    page.ask(page.episode.play)
    turn(page, lambda: "/beside" not in parts(server))
    assert page.episode.beside is None
