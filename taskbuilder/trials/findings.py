"""What is wrong with a robot that was tried: what was measured, and which key to change."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from taskbuilder.assets import codes
from taskbuilder.errors import Finding, Location, Severity
from taskbuilder.geometry import total
from taskbuilder.schema.robot import GripperSpec, SuctionSpec
from taskbuilder.schema.robots import RobotModel
from taskbuilder.schema.source import Path_, Source, dotted, read_source
from taskbuilder.sim.divergence import JOINT_SPEED_LIMIT
from taskbuilder.trials.arm import JointTrial
from taskbuilder.trials.gripping import BlockGrip
from taskbuilder.trials.robot_trial import GripperTrial, RobotTrial
from taskbuilder.trials.stand import BLOCK_KG, PHYSICS_HZ
from taskbuilder.trials.sucking import SuctionTrial
from taskbuilder.world.grip_force import (
    FINGERTIP_N,
    LIGHT_KG,
    most_damping,
    turned_inertia,
)

_STROKE_SHARE, _STROKE_M = 0.1, 3e-3  # by which a declared stroke may be off
_JAW_SHARE = 0.25  # a jaw that turns is open further at its tip than at the tcp
_LEAST_LOAD_N = 2.0
_NEARLY = 0.9  # share of its force with which a finger presses on wide blocks, if only narrow ones
# are the matter
_HEAVY_KG, _MORE, _LEAST_N = 0.02, 1.3, 0.1
_ARRIVES = 0.5  # least share of its force with which a finger presses
_LEFT, _STILL = 0.05, 0.5  # of the way of a free gripper: not arrived, and still moving
_MOST_GAP_M = 8e-3  # from the end of a cup to the tcp
_SAG_RAD, _SAG_M = math.radians(1.0), 3e-3
_FALLS_RAD, _FALLS_M = math.radians(6.0), 0.02
_LAG_RAD, _LAG_M = math.radians(12.0), 0.05


@dataclass(frozen=True)
class _Places:
    """Where findings point."""

    model: RobotModel
    source: Source | None

    def finding(
        self, code: str, message: str, path: Path_, severity: Severity = "error"
    ) -> Finding:
        """A finding at a key of the robot file."""
        where = Location(self.model.urdf.path)
        if self.source is not None:
            where = self.source.locate(path)
        return Finding(code, message, dotted(path), where, severity)

    def of_joint(self, code: str, message: str, joint: str, severity: Severity) -> Finding:
        """A finding at a joint of the URDF."""
        urdf = self.model.urdf
        element = next(each for each in urdf.tree.all("joint") if each.get("name") == joint)
        where = Location(urdf.path, element.line, element.column)
        return Finding(code, message, f"joint {joint}", where, severity)


def judge(trial: RobotTrial, model: RobotModel) -> tuple[Finding, ...]:
    """What of a robot's trial is not as it should be.

    Args:
        trial: What was measured.
        model: The robot; a proposal has no robot file, and its findings point at the URDF.
    """
    places = _places(model)
    findings: list[Finding] = []
    if trial.gripper is not None and model.spec.gripper is not None:
        findings += _of_gripper(trial.gripper, model.spec.gripper, places)
    if trial.suction is not None and model.spec.suction is not None:
        findings += _of_suction(trial.suction, model.spec.suction, places)
    for joint in trial.arm:
        findings += _of_joint(joint, places)
    return tuple(findings)


def _places(model: RobotModel) -> _Places:
    file = model.entry.file
    return _Places(model, read_source(file) if file != model.urdf.path else None)


def _of_gripper(trial: GripperTrial, spec: GripperSpec, places: _Places) -> Iterator[Finding]:
    untouching = list(_untouching(spec, places))
    yield from untouching
    flying = _flying(trial, spec, places)
    if flying is not None:
        yield flying
    if untouching:
        return
    outside = _outside(trial, places)
    if outside is not None:
        yield outside
        return
    yield from _stroke(trial, spec, places)
    if flying is None:
        yield from _holding(trial, spec, places)


def _of_suction(trial: SuctionTrial, spec: SuctionSpec, places: _Places) -> Iterator[Finding]:
    if not any(grip.fits for grip in trial.grips):
        message = (
            f"{spec.cup} reaches {-trial.gap * 1000:.0f} mm beyond it, so no surface gets near "
            "enough; move the tcp to 2 mm before the end of the cup, with z out of it"
        )
        yield places.finding(codes.TOOL_POINT, message, ("tcp",))
        return
    if trial.gap > _MOST_GAP_M:
        message = (
            f"{spec.cup} ends {trial.gap * 1000:.0f} mm before it, so what it holds hangs in the "
            "air; move the tcp to 2 mm before the end of the cup"
        )
        yield places.finding(codes.TOOL_POINT, message, ("tcp",), "warning")
    lost = [grip for grip in trial.grips if grip.fits and not grip.held]
    if not lost:
        return
    message = (
        f"a plate of {_mm(lost)} and {_weight(BLOCK_KG)} is not taken, or falls when the arm "
        f"moves; raise force from {spec.force:g}, or correct the tcp: z points out of the cup, "
        "2 mm before its end"
    )
    yield places.finding(codes.NOT_HELD, message, ("suction", "force"))


def untouching_fingers(model: RobotModel) -> tuple[Finding, ...]:
    """Fingers that pass through everything, which is known without a trial.

    Args:
        model: The robot; a proposal has no robot file, and its findings point at the URDF.
    """
    if model.spec.gripper is None:
        return ()
    return tuple(_untouching(model.spec.gripper, _places(model)))


def _untouching(spec: GripperSpec, places: _Places) -> Iterator[Finding]:
    urdf = places.model.urdf
    for number, links in enumerate(spec.fingers):
        if any(urdf.link(link).collisions for link in links):
            continue
        named, several = " and ".join(links), len(links) > 1
        message = (
            f"{named} {'have' if several else 'has'} no <collision>, so this finger passes "
            "through everything; "
        )
        if any(urdf.link(link).visuals for link in links):
            message += (
                "name the links of the finger that have one, or add it to the URDF (robots import "
                "makes it from the visual meshes)"
            )
        else:
            message += (
                f"nothing can be seen of {'them' if several else 'it'} either, so the URDF has the "
                "mounts of fingers and no fingers: take a description of the gripper with "
                "fingers, or add <visual> and <collision> of them"
            )
        yield places.finding(codes.UNTOUCHING, message, ("gripper", "fingers", number))


def _flying(trial: GripperTrial, spec: GripperSpec, places: _Places) -> Finding | None:
    motion = trial.motion
    if motion.fastest < JOINT_SPEED_LIMIT and motion.left <= _LEFT and motion.still <= _STILL:
        return None
    path: Path_ = ("gripper", "joints", motion.joint)
    flies = motion.fastest >= JOINT_SPEED_LIMIT or motion.left > 1.0 or motion.still > _STILL
    damped = _too_damped(motion.joint, places)
    if flies:
        slides = places.model.urdf.joint(motion.joint).type == "prismatic"
        shown = f"{motion.fastest:.3g} {'m/s' if slides else 'rad/s'}"
        begin = f"{motion.joint} reaches {shown} when the empty gripper closes and opens"
        advice = damped or (
            "give the links of the fingers more mass, or lower the force of the gripper"
        )
        return places.finding(codes.FLYING, f"{begin}; {advice}", path)
    message = (
        f"the empty gripper stops {motion.left * 100:.0f} % of its way from where it is told to be"
    )
    advice = damped or f"raise force from {spec.force:g}, or correct open and closed"
    return places.finding(codes.FLYING, f"{message}; {advice}", ("gripper", "force"))


def _too_damped(joint: str, places: _Places) -> str:
    """What to write, where damping is what makes a joint fly; the engine applies it explicitly."""
    urdf = places.model.urdf
    element = next(each for each in urdf.tree.all("joint") if each.get("name") == joint)
    dynamics = element.first("dynamics")
    damping = float((dynamics.get("damping") if dynamics else None) or 0.0)
    moved = urdf.joint(joint)
    if moved.type == "prismatic":
        inertia = _moved_mass(moved.child, places)
        of_what = _weight(inertia)
    else:
        inertia = turned_inertia(urdf, moved)
        of_what = f"a moment of inertia of {inertia:.2g} kg·m²"
    most = most_damping(inertia)
    if damping <= 2.0 * most:
        return ""
    return (
        f"its damping of {damping:g} is too much for {of_what} at {PHYSICS_HZ} physics steps per "
        f'second; write <dynamics damping="{most:.2g}"/> or less'
    )


def _moved_mass(link: str, places: _Places) -> float:
    """Mass of a link and of all that is fixed to it, in kg."""
    urdf = places.model.urdf
    return total(urdf.link(name).mass or 0.0 for name, _ in urdf.fixed_to(link))


def _outside(trial: GripperTrial, places: _Places) -> Finding | None:
    """A tcp that has no finger on both sides."""
    sides = {"-y": trial.opened.below, "+y": trial.opened.above}
    missing = [side for side, free in sides.items() if math.isinf(free)]
    inside = [side for side, free in sides.items() if free <= 0.0]
    if inside:
        message = "lies inside a finger of the open gripper"
    elif missing:
        message = f"no finger is met from it along {' and '.join(missing)}"
    else:
        return None
    advice = "move it between the fingers, with y from one to the other"
    return places.finding(codes.TOOL_POINT, f"{message}; {advice}", ("tcp",))


def _stroke(trial: GripperTrial, spec: GripperSpec, places: _Places) -> Iterator[Finding]:
    measured, declared = trial.opened.width, spec.stroke
    off = declared - measured
    share = _JAW_SHARE if _has_fixed_jaw(spec, places) else _STROKE_SHARE
    if abs(off) <= max(share * measured, _STROKE_M):
        return
    message = (
        f"{declared * 1000:.0f} mm are declared, and {measured * 1000:.0f} mm are open between the "
        f"fingers at the tcp; write {measured:.3g}, or correct open or the tcp"
    )
    severity: Severity = "error" if off > 0.0 else "warning"
    yield places.finding(codes.STROKE, message, ("gripper", "stroke"), severity)


def _has_fixed_jaw(spec: GripperSpec, places: _Places) -> bool:
    """Whether a finger is a jaw that no joint of the gripper moves."""
    urdf = places.model.urdf
    return any(
        not any(joint.name in spec.joints for joint in urdf.moving_joints_above(links[0]))
        for links in spec.fingers
    )


def _holding(trial: GripperTrial, spec: GripperSpec, places: _Places) -> Iterator[Finding]:
    """Blocks that are not held, each cause once."""
    fitting = [grip for grip in trial.grips if grip.fits]
    if not fitting:
        message = (
            f"no block fits between the open fingers there, not even one of "
            f"{_mm([trial.grips[0]])}; move it towards the fingertips"
        )
        yield places.finding(codes.TOOL_POINT, message, ("tcp",))
        return
    lost = [grip for grip in fitting if not grip.held]
    narrow = [grip for grip in lost if grip.width <= trial.closed.width and not grip.force]
    if len(narrow) == len(fitting):  # some grippers are made for wide objects; figures tell of it
        message = (
            f"the fingers stay {trial.closed.width * 1000:.0f} mm apart when they are closed, so "
            f"a block of {_mm(narrow)} is not held; write values of closed at which they meet"
        )
        yield places.finding(codes.NOT_HELD, message, ("gripper", "joints"))
    lost = [grip for grip in lost if grip not in narrow]
    pressing = [grip for grip in fitting if grip not in narrow]
    least = min((grip.force for grip in pressing), default=math.inf)
    if least < _ARRIVES * trial.expected:
        yield _lost_force(trial, spec, places, least, lost)
    elif lost:
        yield _too_weak(trial, spec, places, lost, least)
    else:
        weak = [grip for grip in fitting if grip.held and grip.load < _LEAST_LOAD_N]
        if weak:
            message = (
                f"a block of {_mm(weak)} slips at a load of {min(g.load for g in weak):.1f} N; "
                f"{_raise_force(trial, spec)}"
            )
            yield places.finding(codes.NOT_HELD, message, ("gripper", "force"), "warning")


def _lost_force(
    trial: GripperTrial, spec: GripperSpec, places: _Places, least: float, lost: list[BlockGrip]
) -> Finding:
    """Fingers that press with much less than their motors exert."""
    urdf = places.model.urdf
    masses = {finger[0]: _moved_mass(finger[0], places) for finger in spec.fingers}
    sliding = {joint.child for joint in urdf.joints if joint.type == "prismatic"}
    slides = [link for link in masses if sliding & {name for name, _ in urdf.fixed_to(link)}]
    # The solver exerts less the lighter a finger is and the less it has left to close.
    pressing = [grip for grip in trial.grips if grip.fits and grip.force]
    wide = max(pressing, key=lambda grip: grip.width, default=None)
    by_width = wide is not None and wide.force >= _NEARLY * trial.expected
    light = [link for link in slides if masses[link] < LIGHT_KG or by_width]
    falls = f", and a block of {_mm(lost)} falls" if lost else ""
    message = (
        f"each finger should press with {trial.expected:.3g} N and presses with {least:.2g} N"
        f"{falls}"
    )
    severity: Severity = "error" if lost else "warning"
    if light:
        lightest = min(masses[link] for link in light)
        enough = max(_HEAVY_KG, _MORE * lightest * trial.expected / max(least, _LEAST_N))
        message += (
            f"; {' and '.join(light)} weigh {_weight(lightest)}, too little for the engine to "
            f"press with {trial.expected:.3g} N on narrow objects: write a <mass> of {enough:.1g} "
            "kg in the URDF, or a lower force"
        )
        return places.finding(codes.FORCE_LOST, message, ("gripper", "fingers"), severity)
    message += "; correct tcp and fingers, so that their pads meet the block on both sides"
    return places.finding(codes.FORCE_LOST, message, ("gripper", "fingers"), severity)


def _too_weak(
    trial: GripperTrial, spec: GripperSpec, places: _Places, lost: list[BlockGrip], least: float
) -> Finding:
    held = [grip for grip in trial.grips if grip.held]
    message = (
        f"each finger presses with {least:.2g} N, and a block of {_mm(lost)} and "
        f"{_weight(BLOCK_KG)} falls when the arm moves"
    )
    severity: Severity = "warning" if held else "error"
    if least < FINGERTIP_N / 2.0:
        message += f"; {_raise_force(trial, spec)}"
        return places.finding(codes.NOT_HELD, message, ("gripper", "force"), severity)
    if held and min(grip.width for grip in lost) > max(grip.width for grip in held):
        widest = max(grip.width for grip in held)
        message += (
            f"; fingers that are so far open are not parallel enough: bring open nearer to closed, "
            f"for a stroke of about {widest:.2g}, if wider objects are not to be tried"
        )
        return places.finding(codes.NOT_HELD, message, ("gripper", "joints"), severity)
    message += "; move tcp, so that the pads of the fingers meet the block on both sides"
    return places.finding(codes.NOT_HELD, message, ("tcp",), severity)


def _raise_force(trial: GripperTrial, spec: GripperSpec) -> str:
    if not trial.expected:
        return "raise force"
    enough = spec.force * FINGERTIP_N / trial.expected
    return f"raise force from {spec.force:g} to {enough:.2g}, for {FINGERTIP_N:g} N at each finger"


def _of_joint(joint: JointTrial, places: _Places) -> Iterator[Finding]:
    sags, falls, lags = (
        (_SAG_M, _FALLS_M, _LAG_M) if joint.slides else (_SAG_RAD, _FALLS_RAD, _LAG_RAD)
    )
    unit = "N" if joint.slides else "Nm"
    if joint.sag > sags:
        short = joint.needed > joint.effort
        message = f"sags by {_way(joint.sag, joint.slides)} under gravity"
        if short:
            message += f", which asks up to {joint.needed:.3g} {unit} of {joint.effort:.3g} {unit}"
        enough = 1.5 * max(joint.needed, joint.effort)
        advice = (
            f"raise effort in its <limit> to {enough:.2g}, or correct the masses beyond it"
            if short
            else "correct the masses beyond it, or its damping and friction"
        )
        severity: Severity = "error" if joint.sag > falls else "warning"
        yield places.of_joint(codes.SAGGING, f"{message}; {advice}", joint.joint, severity)
    elif joint.lag > lags:
        message = (
            f"is {_way(joint.lag, joint.slides)} behind at half of its speed limit; raise effort "
            f"({joint.effort:.3g} {unit}) or lower velocity in its <limit>"
        )
        yield places.of_joint(codes.SAGGING, message, joint.joint, "warning")


def _way(value: float, slides: bool) -> str:
    if not math.isfinite(value):
        return "more than can be measured"
    return (
        f"{value * 1000:.3g} mm"
        if slides
        else f"{math.degrees(value):.{0 if value > 0.2 else 1}f}°"
    )


def _mm(grips: list[BlockGrip]) -> str:
    return ", ".join(f"{grip.width * 1000:.0f} mm" for grip in grips)


def _weight(kilograms: float) -> str:
    return f"{kilograms * 1000:.3g} g" if kilograms < 1.0 else f"{kilograms:.3g} kg"
