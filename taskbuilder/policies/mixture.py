"""Several policies that take turns at the episodes of a data set."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from taskbuilder.digests import digest
from taskbuilder.env.options import option_infos
from taskbuilder.errors import UsageError
from taskbuilder.policies.grammar import Player, parse_policy, read_word


@dataclass(frozen=True)
class PolicyShare:
    """A policy of a mixture.

    Attributes:
        name: The policy, as `parse_policy` reads it.
        weight: Its attempts in every round of the mixture.
    """

    name: str
    weight: int = 1

    def __str__(self) -> str:
        return self.name if self.weight == 1 else f"{self.name}*{self.weight}"


def read_share(text: str) -> PolicyShare:
    """Read a policy and its weight: ``expert*3``.

    Raises:
        UsageError: The weight is no whole number of at least 1, or the noise no number.
    """
    name, star, weight = text.rpartition("*")
    if not star:
        name, weight = text, "1"
    if not weight.isdecimal() or not 1 <= int(weight) <= 1000:
        raise UsageError(f'"{text}": the weight after * is a whole number from 1 to 1000')
    read_word(name)
    return PolicyShare(name, int(weight))


def policy_of(shares: Sequence[PolicyShare], attempt: int) -> str:
    """The policy of an attempt: the shares take turns, each as often as its weight."""
    turn = attempt % round_of(shares)
    for share in shares:
        if turn < share.weight:
            return share.name
        turn -= share.weight
    raise ValueError("there are no policies")


def round_of(shares: Sequence[PolicyShare]) -> int:
    """Attempts in a round of the mixture."""
    return sum(share.weight for share in shares)


def players_of(shares: Sequence[PolicyShare]) -> dict[str, Player]:
    """The players of a mixture, by name.

    Raises:
        UnknownNameError: There is no policy of this name.
        UsageError: It could be two things, or there is no such file.
    """
    return {share.name: parse_policy(share.name) for share in shares}


def shared_options(players: Mapping[str, Player], asked: Mapping[str, Any]) -> dict[str, Any]:
    """The options of an environment in which all of several policies can play.

    Args:
        players: The policies, by name.
        asked: Options that were asked for.

    Raises:
        UsageError: Policies were made for environments of different options.
    """
    options, infos = dict(asked), option_infos()
    for name, player in players.items():
        needed = {key: value for key, value in player.options.items() if key != "variation"}
        for option, value in needed.items():
            if options.setdefault(option, value) != value and not infos[option].disturbs:
                raise UsageError(
                    f"{name} was trained with {option}: {value}, and another policy or option "
                    f"needs {options[option]}; collect a data set for each"
                )
    return options


def digests_of_players(players: Mapping[str, Player]) -> dict[str, str]:
    """The digest of the file of each trained policy, by name."""
    return {
        name: digest(player.file.read_bytes())
        for name, player in players.items()
        if player.file is not None
    }
