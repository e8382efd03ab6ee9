"""The robots of the library."""

from __future__ import annotations

from pathlib import Path

from taskbuilder.geometry import bounding_box
from taskbuilder.reference.markdown import side_by_side, table
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.robot import GripperSpec
from taskbuilder.schema.robots import RobotModel, load_robot
from taskbuilder.world.hands import link_corners, link_pose

IMAGES = Path(__file__).parents[1] / "images"


def library(_: str) -> str:
    """A table of the robots, and their pictures."""
    robots = [load_robot(entry) for entry in Catalogue().robots.values() if entry.module]
    rows = [
        [
            f"`{robot.name}`",
            str(len(robot.arm)),
            robot.grip or "–",
            robot.spec.summary,
        ]
        for robot in robots
    ]
    figures = [
        f"![{robot.spec.summary}](images/robot-{robot.name}.png)\n\n`{robot.name}`"
        for robot in robots
        if (IMAGES / f"robot-{robot.name}.png").is_file()
    ]
    return f"{table(['robot', 'joints', 'gripper', 'what it is'], rows)}\n\n{side_by_side(figures)}"


def fingers(_: str) -> str:
    """How much room the grippers with fingers take, in the frame of the tcp."""
    robots = [load_robot(entry) for entry in Catalogue().robots.values() if entry.module]
    head = ["robot", "stroke", "width when open", "width of a finger", "reach beyond the tcp"]
    rows = [_room(robot, gripper) for robot in robots if (gripper := robot.spec.gripper)]
    return table(head, rows)


def _room(robot: RobotModel, gripper: GripperSpec) -> list[str]:
    urdf = robot.urdf
    opened = {name: ends.open for name, ends in gripper.joints.items()}
    root = urdf.root
    tcp = link_pose(urdf, root, robot.spec.tcp.link, opened) @ robot.spec.tcp.pose
    fingers = [link for finger in gripper.fingers for link in finger]
    corners = [each for link in fingers for each in link_corners(urdf, root, link, opened)]
    box = bounding_box([tcp.inverse().apply(corner) for corner in corners])
    figures = [robot.stroke, 2.0 * box.half[1], 2.0 * box.half[0], box.high[2]]
    return [f"`{robot.name}`", *(f"{1000 * figure:.0f} mm" for figure in figures)]
