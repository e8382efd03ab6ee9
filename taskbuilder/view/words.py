"""What the page says, in Markdown; names from files are shown as they are written."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from difflib import unified_diff
from itertools import islice, zip_longest

from taskbuilder.errors import Finding, display_path
from taskbuilder.fixes import Correction
from taskbuilder.geometry import Pose, to_rpy_deg
from taskbuilder.steering.operator import Jog
from taskbuilder.steering.session import Session, State
from taskbuilder.task import Task
from taskbuilder.view.contacts import Contacts
from taskbuilder.view.placing import Placing, ValueChange
from taskbuilder.view.recording import ConditionState, Recording
from taskbuilder.view.regions import RegionPlacing
from taskbuilder.view.stage_poses import StagePose

MOST_CONTACTS = 12
"""Of all contacts, at most so many are listed."""

OVERLAP_M = 0.002
"""Things that touch may overlap by so much."""

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


def outcome(recording: Recording, step: int, beside: Recording | None = None) -> str:
    """Who plays, where the episode stands, and how it ends.

    Args:
        recording: The episode.
        step: The control step that is shown.
        beside: An episode that is shown beside it, or None.
    """
    rollout = recording.rollout
    seconds = f"{rollout.seconds(step):.1f} s"
    text = (
        f"step {step} of {rollout.steps} · {seconds} · seed {rollout.seed}\n\n"
        f"{plain(recording.player)}: {plain(recording.verdict())}"
    )
    if beside is not None:
        text += f"\n\nbeside it, {plain(beside.player)}: {plain(beside.verdict())}"
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


def subjects(found: Iterable[Finding]) -> frozenset[str]:
    """The names in the paths of findings: ``left`` and ``grasp`` of ``expert[2].left.grasp``."""
    return frozenset(part for each in found for part in re.split(r"[.\[\]]+", each.path) if part)


def pose_yaml(name: str, pose: Pose) -> str:
    """A frame and where it is, to be copied into a task file."""
    x, y, z = (round(value, 4) + 0.0 for value in pose.position)
    roll, pitch, yaw = (round(value, 1) + 0.0 for value in to_rpy_deg(pose.quaternion))
    return f"```yaml\n# {name}\nposition: [{x}, {y}, {z}]\nrpy_deg: [{roll}, {pitch}, {yaw}]\n```"


def contact_forces(contacts: Contacts | None) -> str:
    """What touches what, with the largest forces first."""
    if contacts is None:
        return "Contacts are shown while an episode is shown."
    rows = (
        f"- **{plain(one)}** on **{plain(other)}**: {force:.1f} N"
        for (one, other), force in islice(contacts.forces.items(), MOST_CONTACTS)
    )
    return "\n".join(rows) or "Nothing touches anything."


def keys_table(keys: Mapping[str, Jog], buttons: Mapping[str, str]) -> str:
    """The keys by which people steer."""
    cells = [f"`{key}` | {jog.words}" for key, jog in keys.items()]
    cells += [f"`{key.capitalize()}` | {plain(label)}" for label, key in buttons.items()]
    pairs = zip_longest(cells[::2], cells[1::2], fillvalue=" | ")
    return "\n".join(
        (
            "Choose a robot, then drag its tool or press keys; hold a key down to move on, and "
            "Shift to move a little. Directions are as you look at the scene.",
            "",
            "| | | | |",
            "|---|---|---|---|",
            *(f"| {left} | {right} |" for left, right in pairs),
        )
    )


def steered(session: Session, folder: str) -> str:
    """Where a session of steered episodes stands, and where it is recorded.

    Args:
        session: The session.
        folder: The folder of its data set, as messages show it; "" if nothing is recorded.
    """
    if folder:
        recorded = f"Kept episodes go to {plain(folder)}: {session.kept} so far."
    else:
        recorded = "Nothing is recorded; the option --record DIR says where to."
    who = " · ".join(f"{plain(robot)}: {plain(name)}" for robot, name in session.people().items())
    return "\n\n".join(filter(None, (_episode(session), who, recorded)))


def _episode(session: Session) -> str:
    """The episode of a session, as it stands."""
    if session.env is None or session.state == State.IDLE:
        return "No episode runs; press *Begin*."
    episode = session.env.episode
    names = tuple(session.env.task.description.stages)
    hz = f" · {session.measured_hz:.1f} Hz" if session.measured_hz else ""
    lag = f" · lag {session.lag_ms:.0f} ms" if session.lag_ms is not None else ""
    line = f"step {episode.steps} of {episode.horizon} · seed {episode.seed}{hz}{lag}"
    text = f"{line}\n\n{stages(names, episode.outcome.stage)}"
    if session.data is None:
        return text
    why = session.data.about["why"]
    reason = f": {plain(why[0]['part'])}: {plain(why[0]['says'])}" if why else ""
    ended = "success" if session.data.about["success"] else f"no success{reason}"
    return f"{text}\n\n**{ended}**. Press *Keep*, or *Discard and try again*."


def placed(placing: Placing) -> str:
    """Where a thing is that is moved by hand, and what its file would say."""
    x, y, z = (f"{value:.3f}" for value in placing.pose.position)
    lines = [f"**{plain(str(placing.thing))}** at ({x}, {y}, {z}) m"]
    solution = placing.solution
    if solution is not None and not solution.ok:
        off = f"{100.0 * solution.position_error_m:.1f} cm"
        turned = f"{math.degrees(solution.angle_error):.0f}°"
        lines.append(f"{WRONG} out of reach: the nearest pose found is off by {off} and {turned}")
    if solution is not None:
        joints = ", ".join(f"{value:.1f}" for value in placing.joints_deg())
        lines.append(f"joints: {plain(f'[{joints}]')}")
    lines += [_distance(name, distance) for name, distance in placing.near()]
    return _with_changes("  \n".join(lines), placing.changes())


def region_placed(region: RegionPlacing) -> str:
    """Where a region is that is moved by hand, how large it is, and what its file would say."""
    center, size = (
        plain(f"[{', '.join(f'{each:.3f}' for each in values)}]")
        for values in (region.center, region.size)
    )
    lines = [f"**{plain(str(region.thing))}**: center {center}, size {size} m"]
    if region.reaches_beyond:
        lines.append(f"{WRONG} it reaches beyond {plain(region.reaches_beyond)}")
    lines.append("Drag it by the arrows in its middle, and resize it by those at its corner.")
    return _with_changes("  \n".join(lines), region.changes())


def difference(correction: Correction) -> str:
    """What a correction changes in the lines of its file; "" for nothing.

    Args:
        correction: The correction of a task file.
    """
    before, after = correction.before.splitlines(), correction.after.splitlines()
    lines = list(unified_diff(before, after, lineterm="", n=0))[2:]  # after the names of both files
    if not lines:  # it has moved by less than a file says
        return ""
    # Each line begins with a sign, so that none ends the block.
    changed = "\n".join(line for line in lines if not line.startswith("@@"))
    name = plain(display_path(correction.file))
    return f"When you press *Write*, {name} changes so:\n\n```diff\n{changed}\n```"


def _with_changes(text: str, changed: Sequence[ValueChange]) -> str:
    changes = "\n".join(_change(change) for change in changed)
    return f"{text}\n\n```yaml\n{changes}\n```" if changes else text


def _change(change: ValueChange) -> str:
    """A changed value, to be copied into a task file."""
    where = ".".join(map(str, change.path))
    before = f"was {change.before}" if change.before else "not written so far"
    return f"# {where}\n# {before}\n{change}"


def _distance(name: str, distance: float) -> str:
    """How far a body is, or how deep inside."""
    if distance < -OVERLAP_M:
        return f"{WRONG} {-1000.0 * distance:.0f} mm inside {plain(name)}"
    return f"{max(1000.0 * distance, 0.0):.0f} mm from {plain(name)}"


def margin_words(margin_mm: float) -> str:
    """A margin in millimetres, as pictures and lists have it."""
    return f"{margin_mm:+.0f} mm" if math.isfinite(margin_mm) else "nowhere near"


def expert_poses(poses: Sequence[StagePose]) -> str:
    """The poses that the expert's stages require, each with its margins."""
    if not poses:
        return "The expert's stages require no poses."
    return "  \n".join(_expert_pose(pose) for pose in poses)


def _expert_pose(pose: StagePose) -> str:
    mark = ON if pose.verdict == "in reach" else WRONG
    text = f"{mark} {pose.stage} **{plain(pose.robot)}** {plain(pose.order)}: {pose.verdict}, "
    text += f"reach {plain(margin_words(pose.reach_mm))}"
    if pose.clearance_mm is None or not pose.obstacle:
        return text
    return f"{text}, {plain(f'{pose.clearance_mm:.0f}')} mm from {plain(pose.obstacle)}"
