"""A proposal for a robot file, as its user pastes it."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Mapping

from taskbuilder.assets.model import Urdf
from taskbuilder.geometry import Pose
from taskbuilder.world.robot_proposal import Proposal

_WIDTH = 78


def robot_file(urdf: Urdf, proposal: Proposal, *, summary: str = "") -> str:
    """The text of a robot.yaml that lies beside the URDF.

    Args:
        urdf: The robot.
        proposal: What was found out about it.
        summary: What it is, in a line; by default its name and its number of joints.
    """
    name = _name(urdf)
    joints = ", ".join(joint.name for joint in proposal.arm)
    home = ", ".join(_home(proposal))
    lines = [
        *(f"# {line}" for remark in proposal.remarks for line in _wrapped(remark)),
        f"robot: {name}",
        f"summary: {summary or _summary(name, proposal)}",
        f"urdf: {urdf.path.name}",
        f"arm: [{joints}]",
        f"tcp: {_tcp(proposal.tcp_link, proposal.tcp)}",
        f"home_deg: [{home}]",
    ]
    if proposal.gripper:
        fingers = ", ".join(f"[{', '.join(finger)}]" for finger in proposal.fingers)
        lines += [
            "gripper:",
            "  joints:",
            *(f"    {line}" for line in _ends(proposal.gripper)),
            f"  fingers: [{fingers}]",
            f"  stroke: {proposal.stroke:.4g}",
            f"  force: {proposal.force:g}",
        ]
    if proposal.cup is not None:
        lines.append(f"suction: {{cup: {proposal.cup.link}, force: {proposal.cup.force:g}}}")
    return "\n".join(lines) + "\n"


def _wrapped(remark: str) -> list[str]:
    """The lines of a comment; with the sign before them they are as wide as a terminal."""
    return textwrap.wrap(remark, _WIDTH, subsequent_indent="  ", break_long_words=False) or [""]


def _summary(name: str, proposal: Proposal) -> str:
    return f"{name}, {len(proposal.arm)} joint{'s' * (len(proposal.arm) > 1)}"


def _name(urdf: Urdf) -> str:
    """The name of the folder, as it has to be, or of the robot where that is none."""
    folder = urdf.path.parent.name
    return folder if re.fullmatch(r"[A-Za-z]\w{0,39}", folder, re.ASCII) else "my_robot"


def _home(proposal: Proposal) -> list[str]:
    """Home positions in degrees, or metres where a joint slides, rounded within the limits."""
    words = []
    for joint, value in zip(proposal.arm, proposal.home, strict=True):
        slides = joint.type == "prismatic"
        digits = 3 if slides else 1
        shown = round(value if slides else math.degrees(value), digits)
        limit = [v if v is None or slides else math.degrees(v) for v in (joint.lower, joint.upper)]
        low = -math.inf if limit[0] is None else math.ceil(limit[0] * 10**digits) / 10**digits
        high = math.inf if limit[1] is None else math.floor(limit[1] * 10**digits) / 10**digits
        words.append(f"{min(max(shown, low), high) + 0.0:g}")
    return words


def _tcp(link: str, pose: Pose) -> str:
    parts = [f"link: {link}"]
    if any(abs(value) > 5e-4 for value in pose.position):
        parts.append(f"position: [{', '.join(f'{v + 0.0:.4g}' for v in _clean(pose.position))}]")
    rpy = _rpy_deg(pose)
    if any(abs(value) > 0.05 for value in rpy):
        parts.append(f"rpy_deg: [{', '.join(f'{round(v, 1) + 0.0:g}' for v in rpy)}]")
    return "{" + ", ".join(parts) + "}"


def _clean(values: tuple[float, ...]) -> list[float]:
    return [round(value, 4) for value in values]


def _rpy_deg(pose: Pose) -> tuple[float, float, float]:
    """Roll, pitch and yaw about the fixed axes, in degrees."""
    (a, b, c), (d, e, f), (_, _, i) = (pose.axis(0), pose.axis(1), pose.axis(2))
    pitch = math.asin(min(1.0, max(-1.0, -c)))
    if abs(c) > 1.0 - 1e-9:  # roll and yaw turn about the same axis
        return 0.0, math.degrees(pitch), math.degrees(math.atan2(-d, e))
    return (
        math.degrees(math.atan2(f, i)),
        math.degrees(pitch),
        math.degrees(math.atan2(b, a)),
    )


def _ends(gripper: Mapping[str, tuple[float, float]]) -> list[str]:
    return [
        f"{name}: {{open: {opened + 0.0:.4g}, closed: {closed + 0.0:.4g}}}"
        for name, (opened, closed) in gripper.items()
    ]
