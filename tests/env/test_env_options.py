"""The options of environments: as a class, as keywords, and as messages name them."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass, field, fields
from typing import get_args, get_type_hints

import pytest

from taskbuilder.cli.arguments import parse
from taskbuilder.cli.env_options import asked_options
from taskbuilder.data.plan import CollectPlan, describe
from taskbuilder.env.option_info import about
from taskbuilder.env.options import EnvOptions, Options, option_infos
from taskbuilder.errors import UsageError
from taskbuilder.learn.plan import load_plan, make_plan, save_plan
from taskbuilder.task import load_task


def test_the_keywords_are_the_fields():
    keywords, kept = get_type_hints(EnvOptions), get_type_hints(Options)
    for name in ("robots", "disturbances"):  # a mapping or pairs, kept as pairs
        keywords.pop(name), kept.pop(name)
    assert keywords == kept
    assert {*EnvOptions.__annotations__} == {field.name for field in fields(Options)}
    assert not EnvOptions.__required_keys__


def test_every_option_says_what_it_means():
    for name, info in option_infos().items():
        assert info.help, name
        named = set(_literals(get_type_hints(Options)[name])) - {"random"}
        assert named == {choice for choice in info.choices if isinstance(choice, str)}, name


def _literals(hint):
    """The words in a type, in any of its parts."""
    for part in get_args(hint):
        yield from [part] if isinstance(part, str) else _literals(part)


@dataclass(frozen=True)
class WindyOptions(Options):
    """Options with one more."""

    wind: float = field(
        default=0.0,
        metadata=about("speed of the wind", "scene", bounds=(0.0, 9.0), decides_policy=True),
    )


def test_an_added_option_is_everywhere(monkeypatch, tmp_path):
    monkeypatch.setattr("taskbuilder.env.options.Options", WindyOptions)
    for command in ("train handover", "collect handover", "evaluate zoo:x/y", "demo handover"):
        arguments = parse([*command.split(), "--wind", "2.5"])
        assert asked_options(arguments)["wind"] == 2.5
    plan = make_plan("handover", algorithm="ppo", wind=2.5)
    assert (plan.values["wind"], plan.env["wind"], plan.experiment["wind"]) == (2.5, 2.5, 2.5)
    save_plan(tmp_path, plan, {})
    assert load_plan(tmp_path)[0].options == plan.options
    assert make_plan("handover", algorithm="ppo").experiment != plan.experiment
    with pytest.raises(UsageError, match=r"wind is 10\.0; 0 to 9"):
        make_plan("handover", wind=10.0)
    collected = CollectPlan(("reach",), 1, options={"wind": 2.5})
    assert describe(collected, [load_task("reach")])["options"] == {"wind": 2.5}
    with closing(collected.make_env(load_task("reach"), 0)) as env:
        assert env.options.wind == 2.5
