"""Policy servers that do harm, each on a port of its own.

    python benchmarks/hostile_servers.py

Prints a JSON map from names to ports, and serves until standard input ends.
"""

from __future__ import annotations

import json
import math
import os
import socket
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any

import msgpack
import numpy as np
from websockets.server import ServerProtocol
from websockets.sync.server import serve

SIZE = 5
"""Numbers of an action of reach."""

Handler = Callable[[Any], None]


def array(values: Any = None, **changes: Any) -> dict[Any, Any]:
    """An array as messages have it, with lies about it."""
    real = np.zeros((2, SIZE), np.float32) if values is None else np.asarray(values)
    told: dict[Any, Any] = {
        b"__ndarray__": True,
        b"data": real.tobytes(),
        b"dtype": real.dtype.str,
        b"shape": real.shape,
    }
    return told | {name.encode(): value for name, value in changes.items()}


def scalar(data: Any, dtype: str) -> dict[Any, Any]:
    """A number as messages have it."""
    return {b"__npgeneric__": True, b"data": data, b"dtype": dtype}


def nested(depth: int) -> list[Any]:
    """Lists in each other."""
    made: list[Any] = []
    for _ in range(depth):
        made = [made]
    return made


# --- what a server answers


ACTIONS: dict[str, Any] = {
    "nan": array(np.full((1, SIZE), np.nan, np.float32)),
    "infinite": [math.inf] * SIZE,
    "finite in 64 bits": array(np.full((3, SIZE), 1e300)),
    "huge whole numbers": [2**64 - 1] * SIZE,
    "another shape": array(np.zeros((2, SIZE + 1), np.float32)),
    "many axes": array(shape=[1] * 70),
    "a long chunk": array(np.zeros((50_000, SIZE), np.float32)),
    "an empty array of any length": array(data=b"", shape=[0, 10**18]),
    "a shape of text": array(shape="1"),
    "a shape of infinity": array(shape=[math.inf]),
    "a negative shape": array(shape=[-1, -10]),
    "data that is a number": array(data=5),
    "objects": array(dtype="O", data=bytes(8)),
    "a type of many": array(dtype="f4," * 100_000),
    "a number too large for its type": scalar(100_000, "|i1"),
    "a list as a number": scalar([0.0] * SIZE, "<f4"),
    "nothing": None,
    "text": "abc",
    "a map": {"a": 1},
    "ragged lists": [[1.0, 2.0], [3.0]],
    "deep lists": nested(200),
    "one long text": ["x" * 1_000_000, *["y"] * (SIZE - 1)],
    "many lists": [[[]] * 4000] * 500,
}

CONTENTS: dict[str, bytes | str] = {
    "noise": os.urandom(5000),
    "deep nesting": b"\x91" * 100_000 + b"\x01",
    "deep maps": b"\x81\xa1a" * 900 + b"\x01",
    "a list that claims to be long": b"\xdd\x00\x7f\xff\xff" * 900,
    "bytes that claim to be long": b"\xc6\xff\xff\xff\xff",
    "an extension": b"\x81\xa1a\xc7\x05\x01hello",
    "a time": b"\x81\xa1a\xd7\xff" + b"\xff" * 8,
    "many empty lists": b"\xdd\x00\x70\x00\x00" + b"\x90" * 0x700000,
    "escapes": "Traceback\n\x1b[2J\x1b]0;title\x07\x1b[31m \u202e red",
    "long text": "x" * 7_000_000,
}


def answering(content: bytes | str) -> Handler:
    """Answers every observation by the same."""

    def handle(connection: Any) -> None:
        connection.send(msgpack.packb({}))
        for _ in connection:
            connection.send(content)

    return handle


def pieces(piece: bytes, pause: float = 0.0) -> Iterator[bytes]:
    """The parts of a message without end."""
    while True:
        yield piece
        time.sleep(pause)


def endless(piece: bytes, pause: float = 0.0) -> Handler:
    """Answers a message without end."""

    def handle(connection: Any) -> None:
        connection.send(msgpack.packb({}))
        connection.recv()
        connection.send(pieces(piece, pause))

    return handle


def silent(_: Any) -> None:
    """Never says anything."""
    time.sleep(600)


def talkative(connection: Any) -> None:
    """Sends without being asked."""
    connection.send(msgpack.packb({}))
    while True:
        connection.send(msgpack.packb({"actions": array()}))


def closing(connection: Any) -> None:
    """Closes at once."""
    connection.close(1011, "\x1b[31mred\x1b[0m")


# --- below WebSockets


def drip(connection: socket.socket) -> None:
    """Takes for ever to shake hands."""
    connection.sendall(b"HTTP/1.1 101 X\r\n")
    while True:
        connection.sendall(b"a")
        time.sleep(0.3)


def long_head(connection: socket.socket) -> None:
    """Sends headers without end."""
    connection.sendall(b"HTTP/1.1 101 X\r\n")
    while True:
        connection.sendall(b"A: b\r\n" * 1000)


def other_protocol(connection: socket.socket) -> None:
    """Speaks something else."""
    connection.sendall(b"SSH-2.0-OpenSSH_9\r\n" + os.urandom(1000))


def redirect(connection: socket.socket) -> None:
    """Sends whoever comes to another server."""
    connection.recv(4096)
    connection.sendall(b"HTTP/1.1 302 Found\r\nLocation: ws://127.0.0.1:1/\r\n\r\n")


def deflated(connection: socket.socket) -> None:
    """Compresses a message that nobody has asked to be compressed."""
    import zlib

    shaken(connection)
    packer = zlib.compressobj(9, wbits=-15)
    bomb = packer.compress(bytes(200 << 20)) + packer.flush(zlib.Z_SYNC_FLUSH)
    connection.sendall(b"\xc2\x7f" + len(bomb).to_bytes(8, "big") + bomb)
    time.sleep(600)


def huge_frame(connection: socket.socket) -> None:
    """Claims that a message has exbibytes."""
    shaken(connection)
    connection.sendall(b"\x82\x7f" + (2**62).to_bytes(8, "big") + bytes(1 << 20))
    time.sleep(600)


def deaf(connection: socket.socket) -> None:
    """Shakes hands and never reads again."""
    protocol = shaken(connection)
    protocol.send_binary(msgpack.packb({}))
    for data in protocol.data_to_send():
        connection.sendall(data)
    time.sleep(600)


def shaken(connection: socket.socket) -> ServerProtocol:
    """Shake hands as a server of WebSockets."""
    protocol = ServerProtocol()
    while not (events := protocol.events_received()):
        protocol.receive_data(connection.recv(65536))
    protocol.send_response(protocol.accept(events[0]))
    for data in protocol.data_to_send():
        connection.sendall(data)
    return protocol


BEHAVIOURS: dict[str, Handler] = {
    **{f"actions: {n}": answering(msgpack.packb({"actions": v})) for n, v in ACTIONS.items()},
    **{f"message: {name}": answering(content) for name, content in CONTENTS.items()},
    "an endless message": endless(bytes(1 << 20)),
    "an endless message of nothing": endless(b""),
    "a trickle": endless(b"\x00", 0.2),
    "silent": silent,
    "talkative": talkative,
    "closing": closing,
}
"""Servers of WebSockets."""

RAW: dict[str, Handler] = {
    handle.__name__: handle
    for handle in (drip, long_head, other_protocol, redirect, deflated, huge_frame, deaf)
}
"""Servers of TCP."""

SOUND = "sound"


def main() -> None:
    ports = {name: _raw(handle) for name, handle in RAW.items()}
    sound = answering(msgpack.packb({"actions": array()}))
    for name, handle in {SOUND: sound, **BEHAVIOURS}.items():
        server = serve(_quiet(handle), "127.0.0.1", 0, compression=None, max_size=None)
        threading.Thread(target=server.serve_forever, daemon=True).start()
        ports[name] = server.socket.getsockname()[1]
    print(json.dumps(ports), flush=True)
    sys.stdin.read()
    os._exit(0)


def _raw(handle: Handler) -> int:
    listening = socket.create_server(("127.0.0.1", 0))

    def accept() -> None:
        while True:
            connection, _ = listening.accept()
            threading.Thread(target=served, args=(connection,), daemon=True).start()

    def served(connection: socket.socket) -> None:
        with connection:
            _quiet(handle)(connection)

    threading.Thread(target=accept, daemon=True).start()
    port: int = listening.getsockname()[1]
    return port


def _quiet(handle: Handler) -> Handler:
    def quiet(connection: Any) -> None:
        with suppress(Exception):  # whoever was served has gone
            handle(connection)

    return quiet


if __name__ == "__main__":
    main()
