"""Whether attached objects are no heavier than the fingers of their robots could hold by friction.

Fingers that attach an object hold any load. A task that is proved by them may be one that no
gripper could do. Friction is what the robot file says of the real gripper: each finger presses with
its force, and carries that times the coefficients of finger and object.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

from taskbuilder.errors import Finding
from taskbuilder.schema.grasping import grasping
from taskbuilder.task import Task
from taskbuilder.validate.locate import finding_at
from taskbuilder.validate.report import Check, Result
from taskbuilder.validate.solo import first_grasps, sharers
from taskbuilder.world.grip_force import FINGERTIP_N
from taskbuilder.world.world import World

GRAVITY = 9.81


def check_loads(task: Task, world: World) -> Result:
    """Warn of attached objects that are too heavy for the fingers that are to hold them."""
    strong = {name: friction for name in task.agents if (friction := _press(task, name))}
    takers = _takers(task)
    findings, worst = [], 0.0
    for name, thing in world.objects.items():
        attached = sorted(takers.get(name, strong if not takers else ()))
        if thing.spec.fixed or not attached or not set(attached) <= set(strong):
            continue
        most = sum(strong[robot] for robot in attached) * thing.spec.friction / GRAVITY
        worst = max(worst, thing.body.mass / most)
        if thing.body.mass > most:
            findings.append(_finding(task, name, thing.body.mass, most, attached))
    check = Check("TB319", "attached objects are not too heavy", True, worst, None, "share")
    return check, findings


def _press(task: Task, robot: str) -> float:
    """What a robot's fingers carry by friction on a surface of friction 1, in newtons.

    Without fingers that attach whatever the load, 0.
    """
    model = task.file.robots[robot]
    how = grasping(task.file.spec.scene.robots[robot], model)
    gripper = model.spec.gripper
    if gripper is None or how is None or how.rule != "attach" or how.force is not None:
        return 0.0
    slides = all(model.urdf.joint(name).type == "prismatic" for name in gripper.joints)
    force = gripper.force if slides else FINGERTIP_N
    return len(gripper.fingers) * force * gripper.friction


def _takers(task: Task) -> Mapping[str, Collection[str]]:
    """The robots that take each object, by the expert."""
    stages = task.file.spec.expert
    found = {thing: set(robots) for thing, robots in sharers(stages).items()}
    for grasp, robot in first_grasps(stages).items():
        found.setdefault(grasp.partition(".")[0], set()).add(robot)
    return found


def _finding(task: Task, name: str, mass: float, most: float, robots: Collection[str]) -> Finding:
    who = " and ".join(robots)
    verb = "attaches" if len(robots) == 1 else "attach"
    message = (
        f"{name} weighs {mass:.3g} kg, and {who} {verb} it, whatever the load; by the friction of "
        f"the fingers, up to {most:.2g} kg could be held; make it lighter, or write a limit, "
        f"such as grasp: {{rule: attach, force: {round(most * GRAVITY)}}}"
    )
    written = task.file.spec.scene.objects[name].mass is not None
    place = ("mass",) if written else ()
    return finding_at(task, "TB319", message, name, *place, severity="warning")
