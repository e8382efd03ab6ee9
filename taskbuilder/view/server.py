"""The server of the page, which only talks to browsers that were given its address.

Viser serves the page and keeps the browsers up to date. A web page of another site may also open a
connection to this machine; browsers then say from which site, and such a connection is closed
before anything is sent or read.
"""

from __future__ import annotations

import io
import socket
from collections.abc import Sequence
from contextlib import redirect_stdout
from typing import Any
from urllib.parse import urlsplit

from taskbuilder.errors import UsageError

LOCAL = "127.0.0.1"
PORT = 8765
LOCAL_NAMES = ("127.0.0.1", "localhost", "::1")
REFUSED = 1008
"""The close code of WebSocket for what a policy forbids."""

HOW_TO_GET = 'the page needs viser; install it with: pip install "taskbuilder[view]"'


class PageServer:
    """A page on this machine.

    Args:
        port: The port; 0 for any that is free.

    Attributes:
        viser: The server of viser.
        port: The port.

    Raises:
        UsageError: Viser is not installed, or the port is taken.
    """

    def __init__(self, port: int = PORT) -> None:
        try:
            import viser
        except ModuleNotFoundError:
            raise UsageError(HOW_TO_GET) from None
        if port:
            _check_free(port)
        with redirect_stdout(io.StringIO()):  # the command says where the page is
            self.viser: Any = viser.ViserServer(LOCAL, port, verbose=False)
        self.port: int = self.viser.get_port()
        self._refuse_other_sites()
        self.viser.gui.configure_theme(
            control_width="large",
            show_logo=False,
            show_share_button=False,
        )
        self.viser.gui.main_panel.dock_right()

    @property
    def address(self) -> str:
        """The address of the page."""
        return f"http://{LOCAL}:{self.port}"

    def close(self) -> None:
        """Stop serving."""
        with redirect_stdout(io.StringIO()):
            self.viser.stop()

    def _refuse_other_sites(self) -> None:
        from viser import _messages  # viser has no public way to leave out its sharing

        connections = self.viser._websock_server
        # A browser must not be able to make this page public through a server elsewhere.
        connections.unregister_handler(_messages.ShareUrlRequest)
        connections.unregister_handler(_messages.ShareUrlDisconnect)

        async def check(client: Any) -> None:
            connection = connections._live_connections.get(client.client_id)
            if connection is None or not self._is_own(connection.request.headers):
                await connection.close(REFUSED, "this page does not talk to other sites")

        connections.on_client_connect(check)

    def _is_own(self, headers: Any) -> bool:
        """Whether a connection comes from this page, or from no web page at all."""
        return _is_local(f"//{headers.get('Host', '')}", (self.port,)) and all(
            _is_local(origin, (self.port,)) for origin in headers.get_all("Origin")
        )


def _is_local(url: str, ports: Sequence[int]) -> bool:
    try:
        parts = urlsplit(url)
        host, port = parts.hostname, parts.port
    except ValueError:
        return False
    return host in LOCAL_NAMES and port in ports


def _check_free(port: int) -> None:
    with socket.socket() as tried:
        tried.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            tried.bind((LOCAL, port))
        except OSError:
            raise UsageError(
                f"port {port} is taken; choose another with --port, or --port 0 for any"
            ) from None
