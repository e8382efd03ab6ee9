"""How the tasks of the library can be done, for proof that they can: see `scripted.Script`."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from scripted import Script

from taskbuilder.geometry import NO_TURN, Pose, subtract

ABOVE = (0.0, 0.0, 0.1)
CLOSING, OPENING, KEEPING = 3, 2, 11  # control steps


def handover(script: Script) -> None:
    """Left takes the stick and holds it up; right takes it, left lets go, right brings it."""
    world = script.world
    take(script, left="stick.left_end")
    script.go({"left": script.commanded["left"].moved(ABOVE)})
    meeting = Pose(world.position("meeting"), NO_TURN)
    waiting = meeting.apply(world.scene.objects["stick"].grasps["right_end"].at)
    script.go(
        {
            "left": script.carrying("left", "stick", meeting),
            "right": Pose(waiting, script.commanded["right"].quaternion).moved(ABOVE),
        }
    )
    script.go({"right": script.grasp_pose("right", "stick.right_end")})
    script.grip("right", opening=0.0, steps=CLOSING)
    script.grip("left", opening=1.0, steps=OPENING)
    goal = Pose(world.position("goal"), world.pose("stick").quaternion)
    behind = Pose(meeting.position, script.commanded["left"].quaternion)
    script.go({"left": behind, "right": script.carrying("right", "stick", goal)})
    script.wait(KEEPING)


def pick_push_place(script: Script) -> None:
    """Left takes the cube; right draws the tray to the middle; left puts the cube into it."""
    world = script.world
    take(script, left="cube.middle", right="tray.grip")
    way = subtract(world.position("middle"), world.position("tray"))
    held = script.commanded["right"]
    script.go(
        {
            "right": held.moved((way[0], way[1], 0.0)),
            "left": script.commanded["left"].moved(ABOVE),
        }
    )
    inside = Pose(world.position("tray.floor"), world.pose("cube").quaternion)
    above = script.carrying("left", "cube", inside.moved((-0.02, 0.0, 0.12)))
    script.go({"left": above})
    script.go({"left": above.moved((0.0, 0.0, -0.07))})
    script.grip("left", opening=1.0, steps=OPENING)
    script.wait(KEEPING)


def collaborative_lift(script: Script) -> None:
    """Both take the tray by its handles and move alike, until the cube is at the goal."""
    world = script.world
    take(script, left="tray.left_handle_top", right="tray.right_handle_top")
    way = subtract(world.position("goal"), world.position("cube"))
    script.go({name: script.commanded[name].moved(way) for name in world.robot_names})
    script.wait(KEEPING)


def take(script: Script, **grasps: str) -> None:
    """Robots come from above and close their grippers, all at once."""
    poses = {robot: script.grasp_pose(robot, grasp) for robot, grasp in grasps.items()}
    script.go({robot: pose.moved(ABOVE) for robot, pose in poses.items()})
    script.go(poses)
    script.grip(*grasps, opening=0.0, steps=CLOSING)


PLAYS: Mapping[str, Callable[[Script], None]] = {
    "handover": handover,
    "pick_push_place": pick_push_place,
    "collaborative_lift": collaborative_lift,
}
