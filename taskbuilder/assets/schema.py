"""The elements and numbers of a URDF, as a table, and a reading that keeps only those."""

from __future__ import annotations

import math
import re

from taskbuilder.assets import codes
from taskbuilder.assets.markup import Element
from taskbuilder.assets.report import Report
from taskbuilder.wording import suggestion

_CONTACT = (
    "lateral_friction",
    "rolling_friction",
    "spinning_friction",
    "restitution",
    "contact_cfm",
    "contact_erp",
    "inertia_scaling",
    "stiffness",
    "damping",
)

# What each element may hold. What is not here never reaches the physics engine.
_CHILDREN: dict[str, tuple[str, ...]] = {
    "robot": ("link", "joint", "material"),
    "link": ("inertial", "visual", "collision", "contact"),
    "joint": ("origin", "parent", "child", "axis", "limit", "dynamics", "mimic"),
    "inertial": ("origin", "mass", "inertia"),
    "visual": ("origin", "geometry", "material"),
    "collision": ("origin", "geometry"),
    "geometry": ("box", "sphere", "cylinder", "capsule", "mesh"),
    "material": ("color", "texture", "specular"),
    "contact": (*_CONTACT, "friction_anchor"),
}
_REPEATABLE = frozenset({"link", "joint", "visual", "collision"})
# Meant for other programs, in URDFs everywhere, and nothing that PyBullet would read.
_FOREIGN = frozenset(
    {
        "gazebo",
        "transmission",
        "calibration",
        "safety_controller",
        "sensor",
        "verbose",
        "self_collision_checking",
    }
)

_FAR_M = 1e3
_HUGE = 1e9
# The numbers of each element: how many, and the largest magnitude.
_NUMBERS: dict[str, dict[str, tuple[int, float]]] = {
    "origin": {"xyz": (3, _FAR_M), "rpy": (3, _FAR_M)},
    "mass": {"value": (1, _HUGE)},
    "inertia": dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), (1, _HUGE)),
    "box": {"size": (3, _FAR_M)},
    "sphere": {"radius": (1, _FAR_M)},
    "cylinder": {"radius": (1, _FAR_M), "length": (1, _FAR_M)},
    "capsule": {"radius": (1, _FAR_M), "length": (1, _FAR_M)},
    "mesh": {"scale": (3, _HUGE)},
    "color": {"rgba": (4, 255)},
    "specular": {"rgb": (3, _HUGE)},
    "axis": {"xyz": (3, _HUGE)},
    "limit": dict.fromkeys(("lower", "upper", "effort", "velocity"), (1, _HUGE)),
    "dynamics": {"damping": (1, _HUGE), "friction": (1, _HUGE)},
    "mimic": {"multiplier": (1, _HUGE), "offset": (1, _HUGE)},
    **{tag: {"value": (1, _HUGE)} for tag in _CONTACT},
}
# Narrower than float(), which also reads 1_0, infinity and digits of other scripts.
_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")


def cleaned(element: Element, report: Report, subject: str = "") -> Element:
    """The element with only what a URDF has, numbers separated by single spaces.

    Reports unknown and repeated elements and every attribute that should be numbers and is not.
    """
    subject = _subject(element) or subject
    kept = [child for child in element.children if _is_known(child, element, report, subject)]
    _check_repetitions(kept, report, subject)
    _check_numbers(element, report, subject)
    spaced = {name: _respaced(element, name, text) for name, text in element.attributes.items()}
    children = tuple(cleaned(child, report, subject) for child in kept)
    return Element(element.tag, spaced, element.line, element.column, children)


def numbers(element: Element | None, attribute: str) -> tuple[float, ...] | None:
    """The numbers of an attribute; None if it is absent or was reported as wrong."""
    text = element.get(attribute) if element else None
    if element is None or text is None or _complaint(element.tag, attribute, text):
        return None
    return tuple(map(float, text.split()))


def number(element: Element | None, attribute: str) -> float | None:
    """The one number of an attribute; None if it is absent or was reported as wrong."""
    values = numbers(element, attribute)
    return values[0] if values else None


def _subject(element: Element) -> str:
    """How findings name the part of the robot that an element begins, or ""."""
    if element.tag not in ("link", "joint"):
        return ""
    return f"{element.tag} {element.get('name') or '(without a name)'}"


def _is_known(child: Element, parent: Element, report: Report, subject: str) -> bool:
    """Whether to keep a child; reports one that nobody knows."""
    known = _CHILDREN.get(parent.tag, ())
    if child.tag in known:
        return True
    if child.tag.startswith("xacro:"):
        message = f"<{child.tag}> is a macro; run the file through xacro first"
        report.error(codes.XML, child, subject, message)
    elif child.tag not in _FOREIGN and (parent.tag, child.tag) != ("collision", "material"):
        allowed = f"it may hold {', '.join(known)}" if known else "delete it"
        right = suggestion(child.tag, known, otherwise=allowed)
        code, note = codes.IGNORED, report.warning
        if parent.tag == "geometry":
            code, note = codes.GEOMETRY, report.error
        note(code, child, subject, f"<{child.tag}> is not read in <{parent.tag}>; {right}")
        return parent.tag == "geometry"  # kept, so as not to be reported as missing too
    return False


def _check_repetitions(children: list[Element], report: Report, subject: str) -> None:
    seen: dict[str, Element] = {}
    for child in children:
        first = seen.setdefault(child.tag, child)
        named = child.get("name") is not None  # as materials of a robot are
        if first is not child and child.tag not in _REPEATABLE and not named:
            message = f"a second <{child.tag}>, after line {first.line}; keep one"
            report.error(codes.STRUCTURE, child, subject, message)


def _check_numbers(element: Element, report: Report, subject: str) -> None:
    for attribute in _NUMBERS.get(element.tag, {}):
        text = element.get(attribute)
        complaint = "" if text is None else _complaint(element.tag, attribute, text)
        if complaint:
            report.error(codes.NUMBER, element, subject, complaint)


def _complaint(tag: str, attribute: str, text: str) -> str:
    """What is wrong with the numbers of an attribute, or ""."""
    count, largest = _NUMBERS[tag][attribute]
    wanted = "a number" if count == 1 else f"{count} numbers separated by spaces"
    shown = text if len(text) <= 40 else text[:37] + "…"
    said = f'<{tag} {attribute}="{shown}">'
    words = text.split()
    if any(not _NUMBER.fullmatch(word) for word in words):
        decimal = "; decimals take a point, not a comma" if "," in text else ""
        macro = "; run the file through xacro first" if "${" in text else ""
        return f"{said} should be {wanted}{decimal or macro}"
    if len(words) != count:
        return f"{said} has {len(words)}; it should be {wanted}"
    if not all(math.isfinite(float(word)) and abs(float(word)) <= largest for word in words):
        return f"{said} is too large; at most {largest:g} makes sense here"
    return ""


def _respaced(element: Element, attribute: str, text: str) -> str:
    """Numbers separated as Bullet splits them: it takes two spaces or a tab for a bad vector."""
    return " ".join(text.split()) if attribute in _NUMBERS.get(element.tag, {}) else text
