"""The families of checks that it takes to find out what a code stands for."""

from __future__ import annotations

FAMILIES = {
    "TB50": ("repeat",),
    "TB51": ("reach",),
    "TB52": ("contract",),
    "TB57": ("contract",),
    "TB58": ("contract",),
    "TB53": ("solvable",),
    "TB534": (),
    "TB54": ("needs its robots",),
    "TB545": ("reach",),
    "TB55": ("pays for success",),
    "TB553": ("needs its robots", "pays for success"),
    "TB554": ("needs its robots", "pays for success"),
}
"""A code, or its first letters -> the families that it takes to find it."""


def families_for(code: str) -> tuple[str, ...] | None:
    return FAMILIES.get(code, FAMILIES.get(code[:4]))
