"""The server of the page, which only talks to browsers that were given its address.

Viser serves the page and keeps the browsers up to date. A web page of another site may also open a
connection to this machine; browsers then say from which site, and such a connection is closed
before anything is sent or read. Who can connect at all is for the `gate` to say.
"""

from __future__ import annotations

import io
import socket
from collections.abc import Callable
from contextlib import closing, redirect_stdout
from typing import Any

from taskbuilder.errors import UsageError
from taskbuilder.view.gate import LOCAL_NAMES, Gate
from taskbuilder.view.page_end import NO_WEBGL, NO_WEBGL_PATH, PAGE_END, TITLE

LOCAL = "127.0.0.1"
PORT = 8765
ANYWHERE = ("0.0.0.0", "::")  # noqa: S104 - only if the user says so, and then with a token
REFUSED = 1008
"""The close code of WebSocket for what a policy forbids."""

HOW_TO_GET = 'the page needs viser; install it with: pip install "taskbuilder[view]"'


class PageServer:
    """A page on this machine.

    Args:
        port: The port; 0 for any that is free.
        host: The address that it listens on. On another one than 127.0.0.1, each connection needs
            a token, which is made anew and is a part of `address`.
        notify: Called with what people at the terminal have to know, in a thread of the server.

    Attributes:
        viser: The server of viser.
        gate: Lets connections in.
        notify: What it was made with.
        host: The address that it listens on.
        port: The port.

    Raises:
        UsageError: Viser is not installed, the host is none of this machine, or the port is taken.
    """

    def __init__(
        self, port: int = PORT, host: str = LOCAL, *, notify: Callable[[str], None] = lambda _: None
    ) -> None:
        try:
            import viser
        except ModuleNotFoundError:
            raise UsageError(HOW_TO_GET) from None
        _check_free(host, port)
        self.host, self.notify = host, notify
        self.gate = Gate(local=host in LOCAL_NAMES)
        self.gate.replace_text("<title>Viser</title>", f"<title>{TITLE}</title>")
        self.gate.replace_text("</body>", f"{PAGE_END}</body>")
        self.gate.add_page(NO_WEBGL_PATH, "", lambda: self.notify(NO_WEBGL))
        # The command says where the page is.
        with redirect_stdout(io.StringIO()), self.gate.installed():
            self.viser: Any = viser.ViserServer(host, port, verbose=False)
        self.port: int = self.viser.get_port()
        self.gate.port = self.port
        self._refuse_other_sites()
        self.viser.gui.configure_theme(
            control_width="large",
            show_logo=False,
            show_share_button=False,
        )
        self.viser.gui.main_panel.dock_right()

    @property
    def address(self) -> str:
        """The address of the page, with its token if it needs one."""
        return self.address_of("")

    def address_of(self, path: str) -> str:
        """The address of something beside the page.

        Args:
            path: Its path, such as ``/gamepad``, or "".
        """
        name = self.host
        if name in ANYWHERE:
            name = _own_address()
        name = f"[{name}]" if ":" in name else name
        token = f"{path or '/'}?token={self.gate.token}" if self.gate.token else path
        return f"http://{name}:{self.port}{token}"

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
            if connection is None or not self.gate.is_own(connection.request.headers):
                await connection.close(REFUSED, "this page does not talk to other sites")

        connections.on_client_connect(check)


def _own_address() -> str:
    """The address of this machine in its network; nothing is sent to find it."""
    with closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as asked:
        try:
            asked.connect(("192.0.2.1", 9))  # an address for documentation, which nobody has
        except OSError:
            return LOCAL
        name: str = asked.getsockname()[0]
        return name


def _check_free(host: str, port: int) -> None:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    with socket.socket(family) as tried:
        tried.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            tried.bind((host or "nowhere.invalid", 0))  # no name means all addresses here
        except (OSError, UnicodeError):
            raise UsageError(
                f'"{host}" is no address of this machine; write --host {LOCAL}, or --host 0.0.0.0 '
                "for all of its addresses"
            ) from None
    with socket.socket(family) as tried:
        tried.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            tried.bind((host, port))
        except OSError:
            raise UsageError(
                f"port {port} is taken; choose another with --port, or --port 0 for any"
            ) from None
