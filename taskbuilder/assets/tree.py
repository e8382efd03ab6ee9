"""Names and connections: what Bullet needs to be a tree, and ends the process if it is not."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from taskbuilder.assets import codes
from taskbuilder.assets.markup import Element
from taskbuilder.assets.report import Report
from taskbuilder.wording import quoted, suggestion

_LONGEST_NAME = 128


def check_names(elements: Iterable[Element], report: Report) -> dict[str, Element]:
    """The elements of one kind by name; reports names that are missing, repeated or too long."""
    named: dict[str, Element] = {}
    for element in elements:
        name = element.get("name") or ""
        subject = f"{element.tag} {name or '(without a name)'}"
        complaint = _name_complaint(name)
        if complaint:
            report.error(codes.NAME, element, subject, complaint)
        elif name in named:
            message = (
                f"the name is taken by line {named[name].line}; give each {element.tag} its own"
            )
            report.error(codes.NAME, element, subject, message)
        if name:
            named.setdefault(name, element)
    return named


def check_tree(
    robot: Element, links: Mapping[str, Element], joints: Sequence[Element], report: Report
) -> str:
    """The name of the root link; reports everything that keeps the links from being a tree.

    Where links lack names of their own, which has been reported, nothing can be said of the tree.
    """
    if len(links) < len(list(robot.all("link"))):
        return ""
    above = _links_above(links, joints, report)
    roots = [name for name in links if name not in above]
    if not links:
        report.error(codes.STRUCTURE, robot, "", "a robot needs at least one <link>")
    elif not roots:
        report.error(codes.TREE, robot, "", "every link has a parent; one link must have none")
    for extra in roots[1:]:
        message = f"has no parent, as {quoted(roots[0])} has none; connect the two by a joint"
        report.error(codes.TREE, links[extra], f"link {extra}", message)
    _check_loops(links, above, report)
    return roots[0] if roots else ""


def _links_above(
    links: Mapping[str, Element], joints: Sequence[Element], report: Report
) -> dict[str, str]:
    """The parent of each link that has one."""
    above: dict[str, str] = {}
    for joint in joints:
        parent, child = (_end(joint, tag, links, report) for tag in ("parent", "child"))
        if child in above:
            message = (
                f"{quoted(child)} hangs on {quoted(above[child])} already; a link has one parent"
            )
            report.error(codes.TREE, joint, f"joint {joint.get('name')}", message)
        elif child:
            above[child] = parent
    return above


def _end(joint: Element, tag: str, links: Mapping[str, Element], report: Report) -> str:
    """The link at one end of a joint; "" if it does not exist, which is reported."""
    end = joint.first(tag)
    name = (end.get("link") if end else None) or ""
    if end is None or not name or name in links:
        return name
    right = suggestion(name, links, otherwise="name one of the file's links")
    message = f"the {tag} {quoted(name)} does not exist; {right}"
    report.error(codes.JOINT, end, f"joint {joint.get('name')}", message)
    return name if tag == "child" else ""


def _check_loops(links: Mapping[str, Element], above: Mapping[str, str], report: Report) -> None:
    """Reports each ring of links once, at the link that comes first in the file."""
    seen: set[str] = set()
    for start in links:
        path: list[str] = []
        name = start
        while name and name not in seen:
            seen.add(name)
            path.append(name)
            name = above.get(name, "")
        if name in path:
            ring = " → ".join([*path[path.index(name) :], name])
            message = f"is its own ancestor ({ring}); remove one of these joints"
            report.error(codes.TREE, links[start], f"link {start}", message)


def _name_complaint(name: str) -> str:
    if not name.strip():
        return "has no name; write name=…"
    if len(name.encode()) > _LONGEST_NAME:
        return f"the name is longer than {_LONGEST_NAME} bytes; shorten it"
    return "" if name.isprintable() else "the name has unprintable characters; remove them"
