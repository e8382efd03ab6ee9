"""The options of environments: as a class, as keywords, and as messages name them."""

from __future__ import annotations

from dataclasses import fields
from typing import get_type_hints

from taskbuilder.env.options import EnvOptions, Options


def test_the_keywords_are_the_fields():
    keywords, kept = get_type_hints(EnvOptions), get_type_hints(Options)
    keywords.pop("robots"), kept.pop("robots")  # a mapping or pairs, kept as pairs
    assert keywords == kept
    assert [*EnvOptions.__annotations__] == [field.name for field in fields(Options)]
    assert not EnvOptions.__required_keys__
