"""Who connects from elsewhere needs the token: real sockets, and what attackers would send."""

from __future__ import annotations

import asyncio
import gzip
import http.client
import re
from contextlib import closing, suppress

import pytest
import viser
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed, InvalidStatus

from taskbuilder.cli import main
from taskbuilder.errors import UsageError
from taskbuilder.view.gate import COOKIE
from taskbuilder.view.page import LivePage
from taskbuilder.view.page_end import NO_WEBGL, NO_WEBGL_PATH, PAGE_END, TITLE
from taskbuilder.view.server import PageServer

PATHS = ("/", "/index.html", "/gamepad", "/nothing", "/?token=", "/?token=wrong", "/..%2f..%2fetc")


@pytest.fixture(scope="module")
def open_server():
    """A page that anybody in the network can reach."""
    with closing(PageServer(0, "0.0.0.0")) as made:
        yield made


def got(server, path, **headers):
    """The status, the headers and the text that the server answers to a request."""
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=20)
    with closing(connection):
        connection.request("GET", path, headers=headers)
        answer = connection.getresponse()
        return answer.status, answer.headers, answer.read().decode(errors="replace")


def greeted(server, path="/", **headers):
    """Whether the server talks to a socket: None if it refuses to open it."""

    async def ask():
        address = f"ws://127.0.0.1:{server.port}{path}"
        try:
            async with connect(
                address,
                subprotocols=[f"viser-v{viser.__version__}"],
                additional_headers=headers,
                max_size=None,
            ) as connection:
                await asyncio.wait_for(connection.recv(), 10.0)
                return True
        except (InvalidStatus, ConnectionClosed):
            return False

    return asyncio.run(ask())


def test_the_token_is_in_the_address_and_made_anew(open_server):
    token = open_server.gate.token
    assert len(token) >= 32
    assert open_server.address.endswith(f":{open_server.port}/?token={token}")
    assert not open_server.address.startswith("http://0.0.0.0")
    with closing(PageServer(0, "0.0.0.0")) as other:
        assert other.gate.token != token


@pytest.mark.parametrize("path", PATHS)
def test_nothing_is_served_without_the_token(path, open_server):
    status, headers, text = got(open_server, path)
    assert status == 403
    assert text == (
        "This page needs the whole address that taskbuilder view has printed, with its token, and "
        "talks to no other site.\n"
    )
    assert "Set-Cookie" not in headers


@pytest.mark.parametrize("end", ["", "x"])
def test_a_part_of_the_token_or_more_is_not_the_token(end, open_server):
    token = open_server.gate.token[: None if end else -1] + end
    assert got(open_server, f"/?token={token}")[0] == 403
    assert not greeted(open_server, f"/?token={token}")


def test_the_page_is_served_with_the_token_and_keeps_it_as_a_cookie(open_server):
    status, headers, text = got(open_server, f"/?token={open_server.gate.token}")
    assert status == 200
    assert "<html" in text
    assert headers["Referrer-Policy"] == "no-referrer"
    cookie = headers["Set-Cookie"]
    assert {"HttpOnly", "SameSite=Strict", "Path=/"} <= set(cookie.split("; "))
    kept = cookie.partition(";")[0]
    assert got(open_server, "/", Cookie=f"other=1; {kept}")[0] == 200
    assert greeted(open_server, Cookie=kept)


def test_a_socket_needs_the_token_and_a_page_of_ours(open_server):
    token, port = open_server.gate.token, open_server.port
    assert not greeted(open_server)
    assert not greeted(open_server, Cookie=f"{COOKIE}_{port}=wrong")
    assert not greeted(open_server, Cookie=f"{COOKIE}_{port}=")
    assert greeted(open_server, f"/?token={token}")
    own = f"http://127.0.0.1:{port}"
    assert greeted(open_server, f"/?token={token}", Origin=own)
    for origin in (
        "https://elsewhere.example",
        "null",
        "http://[::1",
        f"http://127.0.0.1:{port + 1}",
    ):
        assert not greeted(open_server, f"/?token={token}", Origin=origin)


def test_headers_that_are_no_headers_open_nothing(open_server):
    for name, value in (("Cookie", ";;=;" * 500), ("Cookie", "ä=ö"), ("Host", "")):
        assert got(open_server, "/", **{name: value})[0] == 403
    with suppress(http.client.HTTPException, OSError):
        assert got(open_server, "/?token=" + 100_000 * "a")[0] >= 400
    assert got(open_server, f"/?token={open_server.gate.token}")[0] == 200  # it goes on


def test_on_this_machine_alone_no_token_is_needed(server):
    assert server.gate.token is None
    assert server.address == f"http://127.0.0.1:{server.port}"
    status, headers, _ = got(server, "/")
    assert status == 200
    assert "Set-Cookie" not in headers
    assert greeted(server)
    assert got(server, "/../../../../etc/passwd")[0] == 404


def test_the_page_has_our_title_and_our_script_however_it_is_sent(server):
    status, headers, text = got(server, "/")
    assert status == 200
    assert int(headers["Content-Length"]) == len(text.encode())
    assert f"<title>{TITLE}</title>" in text
    assert text.count(PAGE_END) == 1
    assert text.rstrip().endswith("</body>\n</html>")
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=20)
    with closing(connection):
        connection.request("GET", "/", headers={"Accept-Encoding": "gzip"})
        zipped = connection.getresponse().read()
    assert gzip.decompress(zipped).decode() == text


def test_the_terminal_is_told_of_a_browser_without_webgl(open_server):
    told = []
    with closing(PageServer(0, notify=told.append)) as server:
        assert got(server, NO_WEBGL_PATH, Origin="https://elsewhere.example")[0] == 403
        assert told == []
        assert got(server, NO_WEBGL_PATH)[0] == 200
    assert told == [NO_WEBGL]
    assert got(open_server, NO_WEBGL_PATH)[0] == 403  # without the token


@pytest.mark.parametrize("errors", [False, True])
def test_the_command_prints_the_address_and_what_is_wrong(errors, touch, capsys, monkeypatch):
    def interrupted(page):
        page._server.notify("something")
        page._server.notify("something")
        raise KeyboardInterrupt

    monkeypatch.setattr(LivePage, "run", interrupted)
    if errors:
        touch.write_text(touch.read_text().replace("shape:", "shap:"))
    assert main(["view", str(touch), "--port", "0"]) == 0
    printed = capsys.readouterr()
    assert re.search(r"http://127\.0\.0\.1:\d+ shows .*touch\.yaml; Ctrl-C ends it", printed.out)
    assert printed.err.endswith("something\n")
    assert printed.err.count("something") == 1
    assert ("touch.yaml:7:" in printed.err) is errors


@pytest.mark.parametrize("host", ["192.0.2.77", "no such host", "", "x" * 300, "::2"])
def test_a_host_that_is_none_of_this_machine_is_told(host, touch, capsys):
    assert main(["view", str(touch), "--host", host, "--port", "0"]) == 2
    assert re.search(r"is no address of this machine; write --host 127", capsys.readouterr().err)


def test_viser_that_starts_its_server_otherwise_is_refused(monkeypatch):
    class Other:
        def __init__(self, *_, **__):
            """Start a server in another way."""

    monkeypatch.setattr(viser, "ViserServer", Other)
    with pytest.raises(UsageError, match="not known"):
        PageServer(0, "0.0.0.0")
