"""A policy that a server evaluates, such as a vision-language-action model on another machine.

The protocol is that of openpi's servers: after the connection the server sends its metadata. The
client then sends an observation at a time and receives ``actions``: one, or a chunk of the next
ones.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Any
from urllib.parse import parse_qsl, urlsplit

import numpy as np
from numpy.typing import NDArray

from taskbuilder.env.action_encoder import Actions
from taskbuilder.env.joint_observation import PIXELS, JointObservation
from taskbuilder.env.joint_state import JointState
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.errors import TaskbuilderError, UsageError
from taskbuilder.rollout.messages import HOW_TO_GET, MessageError, packed, unpacked
from taskbuilder.wording import suggestion

SCHEMES = ("ws", "wss")

STATE, PROMPT, ACTIONS = "observation/state", "prompt", "actions"
"""Keys of messages: joint positions and grippers, the instruction, and the reply."""

IMAGES = "observation/images"
"""Prefix of the keys of images, such as ``observation/images/front``."""

ANSWERS_S = 600.0
"""How long an answer may take; models are often compiled for the first."""

_CONNECTS_S = 20.0


class ServerError(TaskbuilderError):
    """A policy server is not there, or does not answer as it should."""


@dataclass(frozen=True)
class PolicyServer:
    """A policy server, and what it plays.

    Attributes:
        address: ``ws://host:port``.
        task: Name or path of the task.
        cameras: Cameras whose images the policy sees.
        size: Width and height of the images; by default each camera's.
        steps: How many actions of a chunk are played before the next is asked for; by default all.
        renderer: Draws the images; by default, what the environment chooses.
    """

    address: str
    task: str
    cameras: tuple[str, ...] = ()
    size: tuple[int, int] | None = None
    steps: int | None = None
    renderer: str | None = None

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
        return ServedPolicy(self.address, env, self.steps)


def is_served(name: str) -> bool:
    """Whether the name of a policy is the address of a server."""
    return name.startswith(tuple(f"{scheme}://" for scheme in SCHEMES))


def read_server(name: str) -> PolicyServer:
    """Read ``ws://host:port/TASK?cameras=front,left_wrist&size=224&steps=10``.

    Raises:
        UsageError: It is no such address.
    """
    example = "such as ws://localhost:8000/handover?cameras=front&size=224&steps=10"
    parts = urlsplit(name)
    try:
        port = parts.port
    except ValueError:
        port = None
    if not parts.hostname or port is None or parts.scheme not in SCHEMES:
        raise UsageError(f'"{name}" is no address of a policy server; write one {example}')
    if len(parts.path) < 2:
        raise UsageError(f"which task? name it after the address, {example}")
    asked = dict(parse_qsl(parts.query, keep_blank_values=True))
    known = ("cameras", "size", "steps", "renderer")
    for key in asked:
        if key not in known:
            help_ = suggestion(key, known, what="one of")
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
    )


def _whole(name: str, text: str) -> int:
    if not text.isdecimal() or not 1 <= int(text) <= 4096:
        raise UsageError(f'"{text}" in {name} is no whole number from 1 to 4096')
    return int(text)


class ServedPolicy:
    """The policy of a server.

    Args:
        address: ``ws://host:port``.
        env: The environment that it plays, with flat actions from -1 to 1.
        steps: How many actions of a chunk are played before the next is asked for; by default all.

    Attributes:
        metadata: What the server says of itself.

    Raises:
        UsageError: The extra is not installed.
        ServerError: No policy server answers.
    """

    def __init__(self, address: str, env: TaskEnv, steps: int | None = None) -> None:
        self.address, self._steps = address, steps
        self._stack = ExitStack()
        self._connection = self._stack.enter_context(_connected(address))
        self.metadata = self._received(_CONNECTS_S)
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
        try:
            self._connection.send(packed(message))
        except Exception as error:
            raise ServerError(f"{self.address} was lost: {error}") from None
        found = self._received(ANSWERS_S).get(ACTIONS)
        try:
            chunk = np.asarray(() if found is None else found).astype(np.float32)
        except (TypeError, ValueError):
            raise ServerError(f"{self.address} answers actions that are no numbers") from None
        if chunk.ndim == 1:
            chunk = chunk[None]
        count = len(self._names)
        if chunk.ndim != 2 or not len(chunk) or chunk.shape[1] != count:
            shape = np.shape(found) if found is not None else "none"
            raise ServerError(
                f"{self.address} answers actions of shape {shape}; {self._env.task.name} takes "
                f"(steps, {count}): {', '.join(self._names)}"
            )
        if not np.isfinite(chunk).all():
            raise ServerError(f"{self.address} answers actions that are not finite")
        return chunk[: self._steps]

    def _received(self, limit_s: float) -> dict[str, Any]:
        try:
            answer = self._connection.recv(timeout=limit_s)
        except TimeoutError:
            raise ServerError(f"{self.address} has not answered within {limit_s:g} s") from None
        except Exception as error:
            raise ServerError(f"{self.address} was lost: {error}") from None
        if isinstance(answer, str):
            last = (answer.strip().splitlines() or ["no message"])[-1]
            raise ServerError(f"the policy server at {self.address} failed: {last}")
        try:
            return unpacked(answer)
        except MessageError as error:
            raise ServerError(f"{self.address} is no policy server: it sends {error}") from None


@contextmanager
def _connected(address: str) -> Iterator[Any]:
    """A connection to a server, which is closed at the end.

    Raises:
        UsageError: The extra is not installed.
        ServerError: No policy server answers.
    """
    try:
        from websockets.exceptions import WebSocketException
        from websockets.sync.client import connect
    except ModuleNotFoundError:
        raise UsageError(f"policy servers need websockets; {HOW_TO_GET}") from None
    with ExitStack() as stack:
        try:
            made = connect(address, compression=None, max_size=None, open_timeout=_CONNECTS_S)
            connection = stack.enter_context(made)
        except (OSError, WebSocketException) as error:
            why = getattr(error, "strerror", None) or str(error) or "no answer"
            raise ServerError(f"no policy server answers at {address} ({why})") from None
        yield connection
