"""What the page says, in Markdown; names from files are shown as they are written."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from taskbuilder.errors import Finding, display_path
from taskbuilder.geometry import Pose, to_rpy_deg
from taskbuilder.task import Task
from taskbuilder.view.recording import ConditionState, Recording

ON, OFF, WRONG = "●", "○", "✗"


def plain(text: str) -> str:
    """Text that Markdown and HTML show as it is."""
    return re.sub(r"([\\`*_{}\[\]<>()#+!|~$&-])", r"\\\1", text.replace("\n", " "))


def heading(task: Task) -> str:
    """The name and the summary of a task."""
    return f"**{plain(task.name)}**\n\n{plain(task.file.spec.summary)}"


def stages(names: Sequence[str], reached: int) -> str:
    """The stages of a description, with the furthest reached so far marked."""
    if not names:
        return "This task has no stages."
    listed = (f"{ON if n <= reached else OFF} {plain(name)}" for n, name in enumerate(names, 1))
    return " → ".join(listed)


def conditions(lamps: Iterable[ConditionState]) -> str:
    """The named conditions, each with its figure."""
    rows = (
        f"- {ON if lamp.on else OFF} **{plain(lamp.name)}**  \n  {plain(lamp.figure)}"
        for lamp in lamps
    )
    return "\n".join(rows)


def outcome(recording: Recording, step: int) -> str:
    """Who plays, where the episode stands, and how it ends."""
    rollout = recording.rollout
    seconds = f"{rollout.seconds(step):.1f} s"
    text = (
        f"step {step} of {rollout.steps} · {seconds} · seed {rollout.seed}\n\n"
        f"{plain(recording.player)}: {plain(recording.verdict())}"
    )
    return f"“{plain(recording.instruction)}”\n\n{text}" if recording.instruction else text


def findings(found: Sequence[Finding]) -> str:
    """Findings, each with its place and remedy."""
    if not found:
        return "No findings: the files are read without errors."
    return "\n\n".join(_finding(finding) for finding in found)


def _finding(finding: Finding) -> str:
    at = finding.location
    place = f"{display_path(at.file)}:{at.line}:{at.column}" if at is not None else ""
    head = " · ".join(filter(None, (finding.code, plain(place))))
    return f"{WRONG} **{head}**\n\n{plain(finding.path)} {plain(finding.message)}"


def pose_yaml(name: str, pose: Pose) -> str:
    """A frame and where it is, to be copied into a task file."""
    x, y, z = (round(value, 4) + 0.0 for value in pose.position)
    roll, pitch, yaw = (round(value, 1) + 0.0 for value in to_rpy_deg(pose.quaternion))
    return f"```yaml\n# {name}\nposition: [{x}, {y}, {z}]\nrpy_deg: [{roll}, {pitch}, {yaw}]\n```"
