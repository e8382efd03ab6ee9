"""Who plays: one grammar for all commands and functions that let a policy play.

| text | who plays |
|---|---|
| ``expert`` | the expert of the task file |
| ``noisy:0.3`` | the expert with Gaussian noise on the actions of its arms |
| ``noisy:0.3@0.25`` | the same, in a quarter of the control steps |
| ``random`` | random actions |
| ``hold`` or ``nothing`` | all robots hold still |
| ``zoo:handover/demos`` | a pretrained policy of the package |
| ``runs/first``, ``policy.npz`` | the policy of a training run, or of a file |
| ``ws://localhost:8000/handover`` | the policy of a server |

From Python, a `Policy`, a class of policies, or a function of observations can play, too. The first
four can name a task: ``expert:handover``. Nothing here needs PyTorch.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from functools import partial
from inspect import signature
from pathlib import Path
from typing import Any, Literal, NamedTuple

from taskbuilder.env.parallel import TaskEnv
from taskbuilder.errors import UnknownNameError, UsageError, display_path
from taskbuilder.expert.script.player import Expert, has_expert
from taskbuilder.policies.fitting import check_fits, options_of
from taskbuilder.policies.noisy import NoisyExpert
from taskbuilder.policies.runs import RUN_FILE
from taskbuilder.policies.served import PolicyServer, is_served, read_server
from taskbuilder.policies.trained import TrainedPolicy
from taskbuilder.policies.zoo import POLICY_FILE, ZOO_PREFIX, load_policy, policy_file
from taskbuilder.rollout.play import Act, Policy, as_policy
from taskbuilder.rollout.players import HoldStill, RandomActions
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.task import Task
from taskbuilder.wording import excerpt, suggestion

PlayerKind = Literal["expert", "noisy", "random", "hold", "trained", "served", "own"]

MakePolicy = Callable[[TaskEnv], Policy]
"""Makes a policy for an environment."""

NOISY = "noisy"
LARGEST_NOISE = 2.0
"""Maximum standard deviation of the noise, where actions are from -1 to 1."""

_WORDS: Mapping[str, PlayerKind] = {
    "expert": "expert",
    "random": "random",
    "hold": "hold",
    "nothing": "hold",
}

FORMS = (
    "name expert, noisy:0.3, random, hold, zoo:TASK/NAME, the folder of a training run, a policy's "
    "file, or ws://HOST:PORT/TASK"
)
"""Everything that a text can be, for messages."""


class Word(NamedTuple):
    """A policy that a word stands for.

    Attributes:
        name: The word, with its noise.
        kind: Its kind.
        noise: Standard deviation of the noise.
        share: Share of the control steps that have noise.
        task: Name or path of the task that it names, or "".
    """

    name: str
    kind: PlayerKind
    noise: float = 0.0
    share: float = 1.0
    task: str = ""


def read_word(text: str) -> Word | None:
    """Read ``expert``, ``noisy:0.3``, ``random`` or ``hold``, perhaps with a task behind a colon.

    Returns:
        What it stands for; None of any other text.

    Raises:
        UsageError: The noise is no number from 0 to 2, its share of the steps none from 0 to 1, or
            there is no task behind the colon.
    """
    name, colon, task = text.partition(":")
    noise, share = 0.0, 1.0
    if name == NOISY and colon:
        given, colon, task = task.partition(":")
        number, at, part = given.partition("@")
        noise = _number(given, number, "the noise", LARGEST_NOISE)
        share = _number(given, part, "the share of the steps behind @", 1.0) if at else 1.0
        name = f"{NOISY}:{given}"
        kind: PlayerKind = "noisy"
    elif name in _WORDS:
        kind = _WORDS[name]
    else:
        return None
    if colon and not task:
        raise UsageError(f'"{text}": which task? name it after the colon, such as {name}:handover')
    return Word(name, kind, noise, share, task)


def _number(given: str, text: str, what: str, most: float) -> float:
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not 0.0 <= number <= most:
        raise UsageError(f'"{NOISY}:{excerpt(given)}": {what} is a number from 0 to {most:g}')
    return number


@dataclass(frozen=True)
class Player:
    """Who plays, before there is an environment; other processes can be told.

    Attributes:
        name: Its name: the text that it was read from, without the task.
        kind: ``expert``, ``noisy``, ``random``, ``hold``, ``trained``, ``served``, or ``own`` for
            somebody's own object.
        make: Makes the policy for an environment; see `prepare`.
        task: Name or path of the task that the text names, or "".
        options: Options of the environment that the policy was made for, by name.
        trained: The trained policy, or None.
        file: The file of the trained policy, or None.
    """

    name: str
    kind: PlayerKind
    make: MakePolicy
    task: str = ""
    options: Mapping[str, Any] = field(default_factory=dict)
    trained: TrainedPolicy | None = None
    file: Path | None = None

    def prepare(self, env: TaskEnv, stack: ExitStack, *, any_grasp: bool = False) -> Policy:
        """Make the policy for an environment.

        Args:
            env: The environment.
            stack: Frees what the policy holds.
            any_grasp: Whether grippers may hold objects by another rule than in training.

        Raises:
            UsageError: A trained policy does not fit the environment.
            ServerError: No policy server answers.
        """
        if self.trained is not None:
            check_fits(self.trained, env, self.name, any_grasp=any_grasp)
        made = self.make(env)
        if isinstance(made, Expert | NoisyExpert) or self.kind == "served":
            # `Policy` has no `close`; these kinds of policies do.
            stack.callback(made.close)  # type: ignore[attr-defined]
        return made

    @property
    def is_word(self) -> bool:
        """Whether a word of the grammar stands for it."""
        return self.kind in ("expert", "noisy", "random", "hold")

    def check_task(self, task: Task, catalogue: Catalogue) -> None:
        """Check that it can play a task.

        Raises:
            UsageError: The task has no expert, or the text of the policy names another task.
            UnknownNameError: The text of the policy names a task that is not there.
        """
        if self.task and catalogue.task(self.task).file.resolve() != task.file.entry.file.resolve():
            raise UsageError(
                f"{self.name} is to play {excerpt(self.task)} and {task.name}; name one task"
            )
        if self.kind in ("expert", "noisy") and not has_expert(task):
            raise UsageError(
                f"{task.name} has no expert; write its stages under expert: in "
                f"{display_path(task.file.entry.file)}, or let random or another policy play"
            )


PolicyLike = str | Path | Policy | Act | type[Any] | TrainedPolicy | PolicyServer | Player
"""What `parse_policy` reads."""


def parse_policy(policy: PolicyLike) -> Player:
    """Read who plays; the table of this module has all forms.

    Args:
        policy: A text or a path; or a `Policy`, a class that is called with the environment to make
            one, a function from all observations to all actions, or a trained policy.

    Raises:
        UnknownNameError: There is no policy of this name.
        UsageError: The text could be two things, there is no such folder or file, or the object is
            no policy.
        StoreError: The file of a policy is damaged.
    """
    match policy:
        case Player():
            return policy
        case TrainedPolicy():
            return _trained(policy, "the policy")
        case PolicyServer():
            return _served(policy)
        case Path():
            return _of_file(str(policy))
        case str():
            return _of_text(policy)
        case _:
            return _own(policy)


def player_of(word: Word) -> Player:
    """The player that a word stands for."""
    return Player(word.name, word.kind, partial(_of_word, word), word.task)


def is_word(text: str) -> bool:
    """Whether a text is a word of the grammar, and no trained or served policy."""
    return read_word(text) is not None


def _of_text(text: str) -> Player:
    word = read_word(text)
    if word is None:
        if is_served(text):
            return _served(read_server(text))
        if not (text.startswith(ZOO_PREFIX) or "/" in text or (text and Path(text).exists())):
            words = (*_WORDS, f"{NOISY}:0.3")
            raise UnknownNameError(
                f'no policy "{excerpt(text)}"; {suggestion(text, words, otherwise=FORMS)}'
            )
    if word is not None or text.startswith(ZOO_PREFIX):
        _check_single(text)
    if word is None:
        return _of_file(text)
    return player_of(word)


def _check_single(text: str) -> None:
    """Refuse a word of the grammar that is the name of a policy's file or folder as well."""
    path = Path(text)
    if any(file.is_file() for file in (path, path / POLICY_FILE, path / RUN_FILE)):
        what = "file" if path.is_file() else "folder"
        raise UsageError(
            f'"{text}" could be two things: the policy of this name, and the {what} {text} here; '
            f"write ./{text} for the {what}, or rename it"
        )


def _of_file(name: str) -> Player:
    return replace(_trained(load_policy(name), name), file=policy_file(name))


def _trained(policy: TrainedPolicy, name: str) -> Player:
    make = partial(_player_of, policy)
    return Player(name, "trained", make, options=options_of(policy), trained=policy)


def _served(server: PolicyServer) -> Player:
    return Player(server.name, "served", server, server.task, server.options)


def _player_of(policy: TrainedPolicy, _: TaskEnv) -> Policy:
    return policy.player()


def _of_word(word: Word, env: TaskEnv) -> Policy:
    match word.kind:
        case "expert":
            return Expert(env)
        case "noisy":
            return NoisyExpert(env, word.noise, word.share)
        case "random":
            return RandomActions()
        case _:
            return HoldStill()


def _own(policy: Any) -> Player:
    """Somebody's own policy.

    Raises:
        UsageError: It is none.
    """
    kind = policy if isinstance(policy, type) else type(policy)
    plays = all(callable(getattr(kind, name, None)) for name in ("reset", "act"))
    if not plays and (isinstance(policy, type) or not callable(policy)):
        raise UsageError(
            f"{kind.__qualname__} is no policy: a policy has the methods reset(env, seed) and "
            "act(observations), or is a function from observations to actions"
        )
    named = policy if hasattr(policy, "__qualname__") else kind
    name = f"{named.__module__}.{named.__qualname__}".removeprefix("__main__.")
    if isinstance(policy, type):
        takes_env = bool(signature(policy).parameters)
        return Player(name, "own", policy if takes_env else partial(_made, policy))
    return Player(name, "own", partial(_given, policy if plays else as_policy(policy)))


def _made(policy: type[Policy], _: TaskEnv) -> Policy:
    return policy()


def _given(policy: Policy, _: TaskEnv) -> Policy:
    return policy
