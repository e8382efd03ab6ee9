"""A policy that a server evaluates, such as a vision-language-action model on another machine.

The protocol is that of openpi's servers: after the connection the server sends its metadata. The
client then sends an observation at a time and receives ``actions``: one, or a chunk of the next
ones.
"""

from __future__ import annotations

import socket
import time
from collections import deque
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from threading import Timer
from typing import Any
from urllib.parse import SplitResult, parse_qsl, urlsplit

import numpy as np
from numpy.typing import NDArray

from taskbuilder.env.action_encoder import Actions
from taskbuilder.env.joint_observation import PIXELS, JointObservation
from taskbuilder.env.joint_state import JointState
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.errors import TaskbuilderError, UsageError
from taskbuilder.policies.messages import HOW_TO_GET, LARGEST, MessageError, packed, unpacked
from taskbuilder.wording import excerpt, suggestion

SCHEMES = ("ws", "wss")

STATE, PROMPT, ACTIONS = "observation/state", "prompt", "actions"
"""Keys of messages: joint positions and grippers, the instruction, and the reply."""

IMAGES = "observation/images"
"""Prefix of the keys of images, such as ``observation/images/front``."""

ANSWERS_S = 600.0
"""How long an answer may take as a whole, in seconds; models are often compiled for the first."""

_CONNECTS_S, _CLOSES_S = 20.0, 2.0


class ServerError(TaskbuilderError):
    """A policy server is not there, or does not answer as it should."""


@dataclass(frozen=True)
class PolicyServer:
    """A policy server, and what it plays.

    Attributes:
        address: ``ws://host:port``.
        task: Name or path of the task; "" where it is named otherwise.
        cameras: Cameras whose images the policy sees.
        size: Width and height of the images; by default each camera's.
        steps: How many actions of a chunk are played before the next is asked for; by default all.
        renderer: Draws the images; by default, what the environment chooses.
        timeout_s: How long an answer may take, in seconds.
        name: Its name in messages and results.
    """

    address: str
    task: str = ""
    cameras: tuple[str, ...] = ()
    size: tuple[int, int] | None = None
    steps: int | None = None
    renderer: str | None = None
    timeout_s: float = ANSWERS_S
    name: str = "a policy server"

    @property
    def options(self) -> dict[str, Any]:
        """The options of the environment."""
        seen = {"cameras": self.cameras, "camera_size": self.size} if self.cameras else {}
        return seen | ({"renderer": self.renderer} if self.renderer else {})

    def __call__(self, env: TaskEnv) -> ServedPolicy:
        """The policy for an environment.

        Raises:
            UsageError: The extra is not installed.
            ServerError: No policy server answers.
        """
        return ServedPolicy(self.address, env, self.steps, self.timeout_s)


def is_served(name: str) -> bool:
    """Whether the name of a policy is the address of a server."""
    return name.startswith(tuple(f"{scheme}://" for scheme in SCHEMES))


def read_server(name: str) -> PolicyServer:
    """Read ``ws://host:port/TASK?cameras=front,left_wrist&size=224&steps=10``, TASK or not.

    Raises:
        UsageError: It is no such address.
    """
    example = "such as ws://localhost:8000/handover?cameras=front&size=224&steps=10"
    parts = _split(name)
    if parts is None or not parts.hostname or not parts.port or parts.scheme not in SCHEMES:
        raise UsageError(f'"{name}" is no address of a policy server; write one {example}')
    asked = dict(parse_qsl(parts.query, keep_blank_values=True))
    keys = ("cameras", "size", "steps", "renderer", "timeout")
    for key in asked:
        if key not in keys:
            help_ = suggestion(key, keys, what="one of")
            raise UsageError(f'a policy server has no option "{key}"; {help_}')
    width, _, height = asked.get("size", "").partition("x")
    size = (_whole(name, width), _whole(name, height or width)) if width else None
    return PolicyServer(
        address=f"{parts.scheme}://{parts.netloc}",
        task=parts.path[1:],
        cameras=tuple(filter(None, asked.get("cameras", "").split(","))),
        size=size,
        steps=_whole(name, asked["steps"]) if "steps" in asked else None,
        renderer=asked.get("renderer"),
        timeout_s=_whole(name, asked["timeout"]) if "timeout" in asked else ANSWERS_S,
        name=name,
    )


def _split(name: str) -> SplitResult | None:
    """The parts of an address; None if it is none."""
    try:
        parts = urlsplit(name)
        _ = parts.port  # it is read only now
    except ValueError:
        return None
    return parts


def _whole(name: str, text: str) -> int:
    if not text.isdecimal() or len(text) > 4 or not 1 <= int(text) <= 4096:
        raise UsageError(f'"{text}" in {name} is no whole number from 1 to 4096')
    return int(text)


class ServedPolicy:
    """The policy of a server.

    Args:
        address: ``ws://host:port``.
        env: The environment that it plays, with flat actions from -1 to 1.
        steps: How many actions of a chunk are played before the next is asked for; by default all.
        timeout_s: How long an answer may take, in seconds.

    Attributes:
        metadata: What the server says of itself.

    Raises:
        UsageError: The extra is not installed.
        ServerError: No policy server answers.
    """

    def __init__(
        self,
        address: str,
        env: TaskEnv,
        steps: int | None = None,
        timeout_s: float = ANSWERS_S,
    ) -> None:
        self.address, self._steps, self._timeout_s = address, steps, timeout_s
        self._stack = ExitStack()
        self._connection = self._stack.enter_context(_connected(address))
        with self._stack.pop_all() as stack:  # which closes it where the server is none
            self.metadata = self._answer(min(_CONNECTS_S, timeout_s))
            self._stack = stack.pop_all()
        self._env = env
        self._sizes = {agent: modes.size for agent, modes in env.episode.actions.items()}
        self._names = tuple(name for names in env.action_names.values() for name in names)
        spaces = {agent: env.observation_space(agent) for agent in env.possible_agents}
        self._observed = JointObservation(spaces, "nested")
        self._state = JointState(env)
        self._chunk: deque[NDArray[np.float32]] = deque()

    def close(self) -> None:
        """End the connection."""
        self._stack.close()

    def reset(self, env: TaskEnv, seed: int) -> None:
        """Begin an episode: what is left of the last chunk is dropped."""
        self._chunk.clear()

    def act(self, observations: Mapping[str, Any]) -> Actions:
        """The next action of the chunk, or the first of a new one.

        Raises:
            ServerError: The server does not answer as it should.
        """
        if not self._chunk:
            self._chunk.extend(self._asked(observations))
        action = self._chunk.popleft()
        cuts = np.cumsum([*self._sizes.values()])[:-1]
        return dict(zip(self._sizes, np.split(action, cuts), strict=True))

    def _asked(self, observations: Mapping[str, Any]) -> NDArray[np.float32]:
        """A new chunk: (steps, numbers)."""
        message: dict[str, Any] = {STATE: self._state(), PROMPT: self._env.task_description}
        seen = self._observed.join(observations)
        if isinstance(seen, Mapping):
            message |= {f"{IMAGES}/{name}": image for name, image in seen[PIXELS].items()}
        actions = self._answer(self._timeout_s, packed(message)).get(ACTIONS)
        count = len(self._names)
        try:
            chunk = _chunk(actions, count)
        except ValueError as error:
            takes = f"{self._env.task.name} takes (steps, {count}): {', '.join(self._names)}"
            raise ServerError(f"{self.address} answers actions {error}; {takes}") from None
        if not np.isfinite(chunk).all():
            raise ServerError(f"{self.address} answers actions that are not finite")
        return chunk[: self._steps]

    def _answer(self, limit_s: float, question: bytes | None = None) -> dict[str, Any]:
        """The next message of the server, after a question if there is one."""
        ends = time.monotonic() + limit_s
        try:
            with _cut_after(self._connection, limit_s):
                if question is not None:
                    self._connection.send(question)
                answer = self._connection.recv(timeout=limit_s)
        except Exception as error:  # whatever a library says of a connection
            if isinstance(error, TimeoutError) or time.monotonic() >= ends:
                raise ServerError(f"{self.address} has not answered within {limit_s:g} s") from None
            raise ServerError(f"{self.address} was lost: {excerpt(error)}") from None
        if isinstance(answer, str):
            last = excerpt((answer.strip().splitlines() or ["no message"])[-1])
            raise ServerError(f"the policy server at {self.address} failed: {last}")
        try:
            return unpacked(answer)
        except MessageError as error:
            raise ServerError(f"{self.address} is no policy server: it sends {error}") from None


def _chunk(answer: object, count: int) -> NDArray[np.float32]:
    """Actions as a server answers them: (steps, count).

    Args:
        answer: An array, or lists of numbers; its shape is checked before an array is made of it.
        count: How many numbers an action has.

    Raises:
        ValueError: It is something else; the message goes on after "answers actions".
    """
    if isinstance(answer, list):
        rows = answer if any(isinstance(each, list | np.ndarray) for each in answer) else [answer]
        for row in rows:
            if not isinstance(row, list) and np.ndim(row) != 1:
                raise ValueError("that are no list of actions")
            if len(row) != count:
                raise ValueError(f"of shape {(len(rows), len(row))}")
            if not all(isinstance(number, int | float | np.number) for number in row):
                raise ValueError("that are no numbers")
        answer = np.array(rows, dtype=np.float64)
    if not isinstance(answer, np.ndarray):
        what = "of shape none" if answer is None else "that are no numbers"
        raise ValueError(what)  # noqa: TRY004  # the server is wrong, not the caller
    chunk = answer[None] if answer.ndim == 1 else answer
    if chunk.ndim != 2 or not len(chunk) or chunk.shape[1] != count:
        raise ValueError(f"of shape {answer.shape}")
    with np.errstate(over="ignore"):  # what is too large becomes infinite
        return chunk.astype(np.float32)


@contextmanager
def _cut_after(connection: Any, limit_s: float) -> Iterator[None]:
    """Cut a connection after a time: to send may wait for a server that does not read."""
    timer = Timer(limit_s, _cut, [connection.socket])
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def _cut(end: socket.socket) -> None:
    with suppress(OSError):  # it has been closed
        end.shutdown(socket.SHUT_RDWR)


@contextmanager
def _connected(address: str) -> Iterator[Any]:
    """A connection to a server, which is closed at the end.

    Raises:
        UsageError: The extra is not installed.
        ServerError: No policy server answers.
    """
    try:
        from websockets.exceptions import InvalidHandshake, InvalidStatus, WebSocketException
        from websockets.sync.client import ClientConnection, connect
    except ModuleNotFoundError:
        raise UsageError(f"policy servers need websockets; {HOW_TO_GET}") from None

    class Direct(ClientConnection):
        """A connection without redirects: no server decides what else is connected to."""

        def handshake(self, *arguments: Any, **options: Any) -> None:
            try:
                super().handshake(*arguments, **options)
            except InvalidStatus as error:  # `connect` follows what it says
                raise InvalidHandshake(str(error)) from None

    with ExitStack() as stack:
        try:
            made = connect(
                address,
                compression=None,  # small messages can then not become large ones
                max_size=LARGEST,
                max_queue=1,
                open_timeout=_CONNECTS_S,
                close_timeout=_CLOSES_S,
                create_connection=Direct,
                ping_interval=None,  # while it computes, a server may answer no ping
            )
            connection = stack.enter_context(made)
        except (OSError, ValueError, WebSocketException) as error:
            why = excerpt(getattr(error, "strerror", None) or error) or "no answer"
            raise ServerError(f"no policy server answers at {address} ({why})") from None
        yield connection
