"""The codes of findings TB0xx to TB3xx and TB5xx, with the explanation that the docs show.

Those of assets, TB401 on, are in `taskbuilder.assets.codes`. A code never changes its meaning, and
one that is given up is not used again.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from taskbuilder.diagnostics import (
    environments,
    experts,
    names,
    necessity,
    repeating,
    rewards,
    scene,
    yaml,
)
from taskbuilder.diagnostics.entry import Code, Example, Where

__all__ = ["CODES", "Code", "Example", "Where"]

CODES: Mapping[str, Code] = MappingProxyType(
    dict(
        sorted(
            item
            for part in (yaml, names, scene, repeating, experts, environments, necessity, rewards)
            for item in part.ENTRIES.items()
        )
    )
)
"""Every code, in order."""
