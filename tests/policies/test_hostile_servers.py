"""Policy servers that were made to do harm: bounded in memory and time, and told in one line."""

from __future__ import annotations

import math
import resource
import socket
import threading
import time
from contextlib import closing, contextmanager, suppress

import msgpack
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from websockets.sync.server import serve

from taskbuilder.cli import main
from taskbuilder.env.parallel import parallel_env
from taskbuilder.policies import messages
from taskbuilder.policies.messages import MessageError, packed, unpacked
from taskbuilder.policies.served import PolicyServer, ServerError, read_server

SIZE = 5
"""Numbers of an action of reach: a move, a turn and a gripper."""

FLOAT = {b"__ndarray__": True, b"data": bytes(4), b"dtype": "<f4", b"shape": [1]}


@pytest.fixture(scope="module")
def env():
    with closing(parallel_env("reach", horizon=5)) as made:
        yield made


@contextmanager
def serving(handle):
    """A server whose connections are handled by a function."""

    def quiet(connection):
        try:
            handle(connection)
        except Exception:  # whoever it serves has gone
            return

    with serve(quiet, "127.0.0.1", 0, compression=None, max_size=None) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield f"ws://127.0.0.1:{server.socket.getsockname()[1]}"
        finally:
            server.shutdown()
            thread.join()


@contextmanager
def raw(handle):
    """A server of plain TCP; its first connection is handled by a function."""

    def accept():
        try:
            connection, _ = listening.accept()
            with connection:
                handle(connection)
        except OSError:
            return

    with socket.create_server(("127.0.0.1", 0)) as listening:
        threading.Thread(target=accept, daemon=True).start()
        yield f"ws://127.0.0.1:{listening.getsockname()[1]}"


def refused(address, env, timeout_s=10.0):
    """What is said of a server that is played once."""
    with pytest.raises(ServerError) as failed:  # noqa: PT012  # it may be any of both
        policy = PolicyServer(address, "reach", timeout_s=timeout_s)(env)
        try:
            observations, _ = env.reset(seed=0)
            policy.reset(env, 0)
            policy.act(observations)
        finally:
            policy.close()
    said = str(failed.value)
    assert len(said) < 600
    assert all(character.isprintable() for character in said)
    return said


def answers(*content):
    """A handler that answers the first observation."""

    def handle(connection):
        connection.send(packed({}))
        connection.recv()
        for part in content:
            connection.send(part)
        connection.recv()

    return handle


# --- messages


def of_actions(value):
    return msgpack.packb({"actions": value})


def array(**changes):
    return of_actions(
        {b"__ndarray__": True, **FLOAT, **{k.encode(): v for k, v in changes.items()}}
    )


def scalar(data, dtype):
    return of_actions({b"__npgeneric__": True, b"data": data, b"dtype": dtype})


WRONG = {
    "deep lists": b"\x91" * 100_000 + b"\x01",
    "deep maps": b"\x81\xa1a" * 3000 + b"\x01",
    "deep actions": b"\x81\xa7actions" + b"\x91" * 3000 + b"\x01",
    "a list that claims to be long": b"\xdd\xff\xff\xff\xff",
    "bytes that claim to be long": b"\xc6\xff\xff\xff\xff",
    "nested lists that claim to be long": b"\xdd\x00\x7f\xff\xff" * 900,
    "an extension": b"\x81\xa1a\xc7\x05\x01hello",
    "a list": msgpack.packb([1, 2]),
    "a key that is a list": b"\x81\x90\x01",
    "many empty lists": msgpack.packb({"a": [[[]] * 200] * 200}),
    "an array without anything": of_actions({b"__ndarray__": True}),
    "an empty array that is long": array(data=b"", shape=[0, 10**18]),
    "a shape that is text": array(shape="1"),
    "a shape of nothing": array(shape=[None]),
    "a shape of infinity": array(shape=[math.inf]),
    "a negative shape": array(shape=[-1, -1]),
    "a shape of many axes": array(shape=[1] * 70),
    "a deep shape": array(shape=eval("[" * 90 + "]" * 90)),
    "data that is a number": array(data=5),
    "objects": array(dtype="O", data=bytes(8)),
    "no type": array(dtype=None),
    "a type of many": array(dtype="f4," * 100_000),
    "a type that is a map": array(dtype={"a": 1}),
    "a number too large for its type": scalar(100_000, "|i1"),
    "a list as a number": scalar([0.0] * SIZE, "<f4"),
    "text as a number": scalar("1", "<f4"),
}


@pytest.mark.parametrize("content", WRONG.values(), ids=WRONG)
def test_a_message_that_is_none_is_an_error_of_its_own(content):
    with pytest.raises(MessageError) as refused:
        unpacked(content)
    assert str(refused.value).isprintable()


def test_a_message_is_no_larger_than_allowed(monkeypatch):
    monkeypatch.setattr(messages, "LARGEST", 100)
    with pytest.raises(MessageError, match="more than 0 MiB"):
        unpacked(bytes(101))


@given(st.binary(max_size=60) | st.binary(max_size=60).map(lambda end: b"\x81\xa1a" + end))
def test_any_bytes_are_a_message_or_none(content):
    with suppress(MessageError):
        assert isinstance(unpacked(content), dict)


# --- actions

ACTIONS = {
    "a long text in a list": (["x" * 1_000_000, *["y"] * (SIZE - 1)], "that are no numbers"),
    "texts of numbers": (["0.5"] * SIZE, "that are no numbers"),
    "complex numbers": ([["1+2j"] * SIZE], "that are no numbers"),
    "a text": ("abc", "that are no numbers"),
    "ragged": ([[1.0] * SIZE, [1.0]], r"of shape (2, 1); reach takes"),
    "too many": ([[0.0] * (SIZE + 1)], f"of shape (1, {SIZE + 1}); reach takes"),
    "none": ([], "of shape (1, 0); reach takes"),
    "rows that are deep": ([[[0.0]] * SIZE], "that are no numbers"),
    "a row that is none": ([[0.0] * SIZE, {}], "that are no list of actions"),
    "infinite": ([math.inf] * SIZE, "that are not finite"),
    "finite in 64 bits alone": ([1e300] * SIZE, "that are not finite"),
    "nothing": (None, "of shape none"),
    "deep": (eval("[" * 80 + "]" * 80), "of shape (1, 1)"),
}


@pytest.mark.parametrize(("actions", "said"), ACTIONS.values(), ids=ACTIONS)
def test_actions_that_are_none_are_told(actions, said, env):
    with serving(answers(of_actions(actions))) as address:
        assert said in refused(address, env)


def test_an_array_of_another_shape_is_not_converted(env):
    with serving(answers(packed({"actions": np.zeros((100, 5, 5, 5), np.int8)}))) as address:
        assert "of shape (100, 5, 5, 5)" in refused(address, env)


# --- size and time


def endless(connection):
    connection.send(packed({}))
    connection.recv()

    def parts():
        while True:
            yield bytes(1 << 20)

    connection.send(parts())


def test_an_endless_message_takes_no_memory(env):
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with serving(endless) as address:
        said = refused(address, env)
    assert "was lost: " in said
    assert "too big" in said
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 150 * 1024


def test_a_message_in_many_parts_of_nothing_ends(env):
    def handle(connection):
        def parts():
            while True:
                yield b""

        connection.send(parts())

    with serving(handle) as address:
        refused(address, env, timeout_s=3.0)


def test_a_trickle_does_not_put_off_the_limit(env):
    def handle(connection):
        connection.send(packed({}))
        connection.recv()

        def parts():
            while True:
                yield b"\x00"
                time.sleep(0.1)

        connection.send(parts())

    with serving(handle) as address:
        begun = time.monotonic()
        assert "has not answered within 1 s" in refused(address, env, timeout_s=1.0)
        assert time.monotonic() - begun < 8.0


def test_a_server_that_does_not_read_does_not_hold_up_what_is_sent():
    def shake(connection):
        """Shake hands as a server of WebSockets, send metadata, and never read again."""
        from websockets.server import ServerProtocol

        protocol = ServerProtocol()
        while not (events := protocol.events_received()):
            protocol.receive_data(connection.recv(65536))
        protocol.send_response(protocol.accept(events[0]))
        protocol.send_binary(packed({}))
        for data in protocol.data_to_send():
            connection.sendall(data)
        done.wait(60)

    done = threading.Event()
    seen = {"cameras": ("front",), "camera_size": (1200, 1200), "renderer": "tiny"}
    with raw(shake) as address, closing(parallel_env("reach", horizon=1, **seen)) as env:
        said = refused(address, env, timeout_s=2.0)
        done.set()
    assert "has not answered within 2 s" in said


@pytest.mark.parametrize(
    "content", [b"", b"\x00" * 5000, b"HTTP/1.1 101 X\r\n" + b"A" * 100_000, b"SSH-2.0-x\r\n"]
)
def test_another_protocol_is_told(content, env):
    def handle(connection):
        connection.recv(4096)
        connection.sendall(content)

    with raw(handle) as address:
        assert "no policy server answers at " in refused(address, env)


def test_a_redirect_is_not_followed(env):
    visited = []

    def elsewhere(connection):
        visited.append(connection)

    with raw(elsewhere) as other:

        def handle(connection):
            connection.recv(4096)
            head = f"HTTP/1.1 302 Found\r\nLocation: {other}\r\nContent-Length: 0\r\n\r\n"
            connection.sendall(head.encode())

        with raw(handle) as address:
            assert "no policy server answers at " in refused(address, env)
    assert not visited


# --- text


@pytest.mark.parametrize(
    "text", ["Traceback\n\x1b[2J\x1b]0;title\x07evil \u202e", "x" * 1_000_000, "\n\n"]
)
def test_what_a_server_says_is_quoted_shortly_and_without_escapes(text, env):
    with serving(answers(text)) as address:
        assert "failed: " in refused(address, env)


def test_a_server_that_closes_with_escapes_is_quoted_without(env):
    def handle(connection):
        connection.close(1011, "\x1b[31mred\x1b[0m")

    with serving(handle) as address:
        assert "was lost: " in refused(address, env)


# --- addresses


@pytest.mark.parametrize("name", ["ws://[::1", "ws://:1/reach", "ws://h:0/reach", "ws://h:x/r"])
def test_a_malformed_address_is_one_sentence(name, capsys):
    assert main(["evaluate", name]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "is no address of a policy server" in said


def test_a_number_of_many_digits_is_refused(capsys):
    assert main(["evaluate", f"ws://localhost:8000/reach?steps={'9' * 5000}"]) == 2
    assert "is no whole number from 1 to 4096" in capsys.readouterr().err


def test_the_time_of_an_answer_can_be_named():
    assert read_server("ws://localhost:8000/reach?timeout=5").timeout_s == 5
    assert read_server("ws://localhost:8000/reach").timeout_s == 600
