"""The options of environments on the command line, made from the fields of `Options`."""

from __future__ import annotations

import argparse
from collections.abc import Collection, Mapping, Sequence
from typing import Any, get_type_hints

from taskbuilder.cli.argument_types import (
    PartName,
    listed,
    listed_choices,
    number,
    robot_choice,
    side_or_size,
    variation,
    whole,
)
from taskbuilder.env import options as env_options
from taskbuilder.env.option_info import OptionInfo, OptionKind
from taskbuilder.env.options import Variation, flag_of, option_fields, option_infos, options_about
from taskbuilder.errors import UsageError
from taskbuilder.schema.choices import OtherRobots
from taskbuilder.schema.disturbances import Disturbances, disturbances

PLAYED: tuple[OptionKind, ...] = ("scene", "observed", "reward")
"""Kinds of options that every command takes that plays episodes."""


def add_env_options(
    parser: argparse.ArgumentParser,
    names: Collection[str] | None = None,
    *,
    without: Collection[str] = (),
    also: Mapping[str, str] | None = None,
    unless_given: Mapping[str, str] | None = None,
) -> None:
    """Add options of environments, each None unless it is given; see `asked_options`.

    Args:
        parser: The command's parser.
        names: Names of the options; by default all that matter where episodes are played.
        without: Of these, those that mean something else to the command, or nothing.
        also: A second name on the command line, by option.
        unless_given: What holds by default, in words, where it is not the default of environments.
    """
    hints = get_type_hints(env_options.Options)
    for name in names or options_about(*PLAYED):
        if name in without:
            continue
        each = option_fields()[name]
        info: OptionInfo = each.metadata["info"]
        default = (unless_given or {}).get(name) or info.unless_given or each.default
        other, reading = (also or {}).get(name), _reading(hints[name], info)
        repeated = "may be repeated; " if reading.get("action") == "append" else ""
        parser.add_argument(
            flag_of(name),
            *([other] if other else []),
            dest=name,
            default=None,
            help=f"{_help(info)} ({repeated}default {default})".replace("%", "%%"),
            **reading,
        )


def asked_options(
    arguments: argparse.Namespace, kinds: Sequence[OptionKind] = PLAYED
) -> dict[str, Any]:
    """The options of environments that the command line gives, by name, besides the variation.

    Args:
        arguments: The command line.
        kinds: Kinds of the options.

    Raises:
        UsageError: One robot is given two models; or there is no such disturbance or level.
    """
    infos = option_infos()
    asked: dict[str, Any] = {}
    for name in options_about(*kinds):
        value = getattr(arguments, name, None)
        if value is None or name == "variation":  # commands differ in what it may be
            continue
        asked[name] = True if value == infos[name].true_word else value
    if robots := asked.pop("robots", None):
        asked["robots"] = _pairs(robots)
    if given := asked.pop("disturbances", None):
        asked["disturbances"] = disturbances(given)
    return asked


def option_words(options: Mapping[str, Any]) -> list[str]:
    """The words of a command line that give these options; what `asked_options` reads."""
    infos, words = option_infos(), []
    for name, value in options.items():
        if value is True and infos[name].true_word:
            words.append(flag_of(name))
        elif isinstance(value, tuple):  # pairs, each given alone
            for key, one in value:
                words += [flag_of(name), f"{key}={one}"]
        else:
            words += [flag_of(name), str(value)]
    return words


def _help(info: OptionInfo) -> str:
    """What an option chooses, and what each of its values means."""
    words = {value: str(value) for value in info.choices}
    if info.true_word:
        words[True] = f"{info.true_word}, or no value"
    meanings = [f"{words[value]}: {meaning}" for value, meaning in info.choices.items()]
    return "; ".join([info.help, *meanings])


def _reading(hint: Any, info: OptionInfo) -> dict[str, Any]:
    """How values of a type are read, as arguments of `add_argument`."""
    if info.choices:
        words = [info.true_word if value is True else value for value in info.choices]
        once: dict[str, Any] = {"nargs": "?", "const": info.true_word} if info.true_word else {}
        if info.others:
            names = tuple(word for word in words if isinstance(word, str))
            return {"type": PartName(names, info.others), "metavar": listed_choices(names)}
        return {"choices": words, **once}
    if hint is bool:
        return {"action": argparse.BooleanOptionalAction}
    if hint == Disturbances:
        return {"action": "append", "metavar": "AXIS[=N]"}
    if hint == OtherRobots:
        return {"action": "append", "type": robot_choice, "metavar": "NAME=MODEL"}
    least, most = info.bounds or (0, 1_000_000_000)
    integer = whole(int(least), int(most))
    convert, metavar = {
        int: (integer, "N"),
        int | None: (integer, "N"),
        float: (number(least, most), "X"),
        float | None: (number(least, most), "X"),
        tuple[str, ...]: (listed, "C,C"),
        tuple[int, int] | None: (side_or_size, "WxH"),
        Variation: (variation, "K"),
    }.get(hint, (str, "TEXT"))
    return {"type": convert, "metavar": metavar}


def _pairs(robots: Sequence[tuple[str, str]]) -> OtherRobots:
    """The models of robots.

    Raises:
        UsageError: One robot is given two.
    """
    from taskbuilder.schema.other_robots import other_robots  # loads the models of files

    models = dict(robots)
    twice = next((name for name, model in robots if models[name] != model), None)
    if twice is not None:
        raise UsageError(f"--robot gives {twice} two models; give it one")
    return other_robots(models)
