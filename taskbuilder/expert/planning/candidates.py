"""Simple detours that are tried before a search: over obstacles, or one robot after the other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import islice, pairwise, permutations, product

from taskbuilder.expert.planning.spaces import Space
from taskbuilder.expert.planning.subspaces import Carried, Coordinates, Polyline, Subspace
from taskbuilder.geometry import total

HEIGHTS_M = (0.0, 0.05, 0.1, 0.18, 0.28)
"""Heights above the higher end of a motion at which a detour passes over obstacles, in metres."""

MOST_ORDERS = 6
"""Maximum number of orders in which robots move one after the other: those of three robots."""


def candidate_paths(space: Space) -> Iterator[Polyline]:
    """Waypoints of detours from the start of a space to its end, without the straight line.

    First detours on which all parts move at once, some of them raised. Then detours on which they
    move one after the other.
    """
    raisable = [_raisable(part) for part in space.parts]
    for height in HEIGHTS_M:
        for raised in product((True, False), repeat=len(space.parts)):
            fits = all(can for can, wanted in zip(raisable, raised, strict=True) if wanted)
            if any(raised) and fits:
                yield _together(space.parts, raised, height)
    if len(space.parts) > 1:
        for order in islice(permutations(range(len(space.parts))), MOST_ORDERS):
            yield _in_order(space.parts, order, None)
            if any(raisable):
                yield _in_order(space.parts, order, HEIGHTS_M[2])


def _raisable(part: Subspace) -> bool:
    return isinstance(part, Carried) and not part.straight


def _together(parts: Sequence[Subspace], raised: Sequence[bool], height: float) -> Polyline:
    """All parts at once; parts that are not raised move at a constant rate."""
    lines = [_over(part, height) for part, up in zip(parts, raised, strict=True) if up]
    lengths = [total(sizes) for sizes in zip(*(_lengths(line) for line in lines), strict=True)]
    length = total(lengths) or 1.0
    over = iter(lines)
    own: list[Polyline] = []
    for part, up in zip(parts, raised, strict=True):
        if up:
            own.append(next(over)[1:])
        else:
            shares = [total(lengths[: corner + 1]) / length for corner in range(len(lengths))]
            own.append([_between(part.begin, part.end, share) for share in shares[:-1]])
            own[-1].append(part.end)
    return [tuple(value for at in corner for value in at) for corner in zip(*own, strict=True)]


def _in_order(parts: Sequence[Subspace], order: Sequence[int], height: float | None) -> Polyline:
    """One part after the other, each straight or raised."""
    now = [part.begin for part in parts]
    corners: Polyline = []
    for number in order:
        part = parts[number]
        raised = height is not None and _raisable(part)
        line = _over(part, height)[1:] if height is not None and raised else [part.end]
        for at in line:
            now[number] = at
            corners.append(tuple(value for own in now for value in own))
    return corners


def _over(part: Subspace, height: float) -> Polyline:
    """Waypoints up, over and down, with the start."""
    (x, y, z, share), (to_x, to_y, to_z, to_share) = part.begin, part.end
    top = max(z, to_z) + height
    return [part.begin, (x, y, top, share), (to_x, to_y, top, to_share), part.end]


def _lengths(line: Polyline) -> list[float]:
    return [
        total((b - a) ** 2 for a, b in zip(one[:3], other[:3], strict=True)) ** 0.5
        for one, other in pairwise(line)
    ]


def _between(begin: Coordinates, end: Coordinates, share: float) -> Coordinates:
    return tuple(a + share * (b - a) for a, b in zip(begin, end, strict=True))
