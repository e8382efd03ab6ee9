"""The gate of the page: which connections are let in, and what is served beside viser's own page.

Viser answers requests by itself, and has no place for a check before it does. So the gate stands in
the server of `websockets` that viser starts: it sees each request before viser does.
"""

from __future__ import annotations

import gzip
import hmac
import http
import logging
import secrets
import threading
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any
from urllib.parse import parse_qs, urlsplit

from taskbuilder.errors import UsageError

LOCAL_NAMES = ("127.0.0.1", "localhost", "::1")
"""Names of this machine for itself; who listens under one of them alone needs no token."""

COOKIE = "taskbuilder_view"
"""Beginning of the name of the cookie that keeps the token, which the port follows."""

TOKEN_BYTES = 24

REFUSED = (
    "This page needs the whole address that taskbuilder view has printed, with its token, and "
    "talks to no other site.\n"
)

Socket = Callable[[Any], Awaitable[None]]
"""Talks to a connection until one of both ends it."""

_lock = threading.Lock()  # who starts a server meanwhile waits for the real `serve`


class Gate:
    """Lets connections in, or refuses them before anything is sent.

    Args:
        local: Whether only this machine can connect. Otherwise, each request needs the token.

    Attributes:
        token: What the address of the page must contain; None for none.
        port: The port of the server, as soon as it is known.
        holds: Whether a server was started through this gate.
    """

    def __init__(self, *, local: bool) -> None:
        self.token = None if local else secrets.token_urlsafe(TOKEN_BYTES)
        self.port = 0
        self.holds = False
        self._pages: dict[str, tuple[bytes, Callable[[], None]]] = {}
        self._replacements: dict[str, str] = {}
        self._rewritten: dict[bool, bytes] = {}
        self._sockets: dict[str, Socket] = {}

    def add_page(self, path: str, html: str, on_request: Callable[[], None] = lambda: None) -> None:
        """Serve a page of our own.

        Args:
            path: Its path, such as ``/gamepad``.
            html: The page.
            on_request: Called when a browser asks for it.
        """
        self._pages[path] = html.encode(), on_request

    def replace_text(self, old: str, new: str) -> None:
        """Serve viser's own page with another text in it.

        Args:
            old: A text of the page.
            new: What stands in its place.
        """
        self._replacements[old] = new

    def add_socket(self, path: str, socket: Socket) -> None:
        """Serve a socket of our own, to our own pages and to programs.

        Args:
            path: Its path.
            socket: Talks to each connection.
        """
        self._sockets[path] = socket

    @contextmanager
    def installed(self) -> Iterator[None]:
        """Stand in every server of `websockets` that is started in this block."""
        from websockets.asyncio import server

        with _lock:
            real = server.serve
            # `serve` is declared as a class, whose name is not to be given to something else.
            server.serve = partial(self._serve, real)  # type: ignore[assignment,misc]
            try:
                yield
            finally:
                server.serve = real  # type: ignore[misc]  # mypy lets no class be assigned to, not even itself
        if not self.holds:
            raise UsageError("this version of viser is not known here; install viser==1.1.1")

    def is_own(self, headers: Any) -> bool:
        """Whether a connection comes from a page of ours, or from no web page at all.

        Args:
            headers: The headers of its request.
        """
        hosts, origins = headers.get_all("Host"), headers.get_all("Origin")
        if len(hosts) != 1:
            return False
        if self.token is None:
            return all(self._is_local(url) for url in (f"//{hosts[0]}", *origins))
        return all(_netloc(origin) == hosts[0] for origin in origins)

    # --- requests

    def _serve(self, real: Any, handler: Socket, *where: Any, **options: Any) -> Any:
        self.holds = True
        options["process_request"] = partial(self._answer, options["process_request"])
        options["logger"] = _quiet_logger()
        return real(partial(self._talk, handler), *where, **options)

    def _answer(self, viser: Callable[[Any, Any], Any], connection: Any, request: Any) -> Any:
        """The response to a request, or None to open a socket."""
        try:
            url = urlsplit(request.path)
        except ValueError:
            return connection.respond(http.HTTPStatus.BAD_REQUEST, "This is no address.\n")
        own = url.path in self._pages or url.path in self._sockets
        given = parse_qs(url.query).get("token", [""])[0]
        if self.token is not None and not self._knows(given, request.headers):
            return connection.respond(http.HTTPStatus.FORBIDDEN, REFUSED)
        if (own or self.token is not None) and not self.is_own(request.headers):
            return connection.respond(http.HTTPStatus.FORBIDDEN, REFUSED)
        if url.path in self._sockets:
            return None
        response = self._page(connection, url.path)
        if response is None:
            response = self._with_replacements(viser(connection, request))
        if response is not None and self.token is not None:
            response.headers["Referrer-Policy"] = "no-referrer"
            if given:
                response.headers["Set-Cookie"] = (
                    f"{COOKIE}_{self.port}={self.token}; Path=/; HttpOnly; SameSite=Strict"
                )
        return response

    def _page(self, connection: Any, path: str) -> Any:
        if path not in self._pages:
            return None
        response = connection.respond(http.HTTPStatus.OK, "")
        response.body, on_request = self._pages[path]
        _set(response, "Content-Type", "text/html; charset=utf-8")
        _set(response, "Content-Length", str(len(response.body)))
        on_request()
        return response

    def _with_replacements(self, response: Any) -> Any:
        """Viser's answer, whose page has the texts that stand in the place of its own."""
        if response is None or response.status_code != http.HTTPStatus.OK:
            return response
        if not response.headers["Content-Type"].startswith("text/html"):
            return response
        zipped = response.headers.get("Content-Encoding") == "gzip"
        if zipped not in self._rewritten:
            html = (gzip.decompress(response.body) if zipped else response.body).decode()
            for old, new in self._replacements.items():
                html = html.replace(old, new)
            self._rewritten[zipped] = gzip.compress(html.encode()) if zipped else html.encode()
        response.body = self._rewritten[zipped]
        _set(response, "Content-Length", str(len(response.body)))
        return response

    async def _talk(self, viser: Socket, connection: Any) -> None:
        own = self._sockets.get(urlsplit(connection.request.path).path)
        await (own or viser)(connection)

    def _knows(self, given: str, headers: Any) -> bool:
        """Whether a request has the token, in its address or as a cookie."""
        name = f"{COOKIE}_{self.port}"
        cookies = (each for line in headers.get_all("Cookie") for each in line.split(";"))
        pairs = (cookie.strip().partition("=") for cookie in cookies)
        tried = [given, *(value for key, _, value in pairs if key == name)]
        token = (self.token or "").encode()
        known = False
        for each in tried:  # each in a time that does not depend on how much of it is right
            known |= hmac.compare_digest(each.encode(), token)
        return known

    def _is_local(self, url: str) -> bool:
        try:
            parts = urlsplit(url)
            host, port = parts.hostname, parts.port
        except ValueError:
            return False
        return host in LOCAL_NAMES and port == self.port


def _set(response: Any, name: str, value: str) -> None:
    """Give a header of a response its only value."""
    del response.headers[name]
    response.headers[name] = value


def _netloc(origin: str) -> str:
    """Host and port of an origin; one that is no address has none that would be the same."""
    try:
        return urlsplit(origin).netloc or "?"
    except ValueError:
        return "?"


def _quiet_logger() -> logging.Logger:
    """A logger that prints nothing: what scanners and leaving browsers do is not worth a word."""
    logger = logging.getLogger("taskbuilder.view.gate")
    logger.addHandler(logging.NullHandler())
    logger.propagate = False
    return logger
