"""Codes of robots, physics and resets, TB3xx, and the one that gathers those of assets."""

from __future__ import annotations

from taskbuilder.diagnostics.entry import Code, Example, block, cabinet, within

ENTRIES = {
    "TB300": Code(
        "Robots and joint values",
        "Summary of TB301 and TB302, which compare robots and joint values with the URDFs. These "
        "checks do not use the physics engine.",
    ),
    "TB301": Code(
        "Does not match the URDF",
        "A robot.yaml, or an entry of an object's `joints` or `grasps`, names a link or a movable "
        "joint that the URDF does not have. Or another key of a robot.yaml contradicts the URDF. "
        "For example, a gripper position is beyond the limits of its joint, or no gripper joint "
        "moves one of the fingers.",
        Example("robot", "link: wrist_3", "link: wrist_3_link", "tcp"),
    ),
    "TB302": Code(
        "Joint value out of limits",
        "A joint position or a joint limit in a task or robot file is outside the limits of the "
        "joint in the URDF. Or the expert moves a joint beyond its limits, or a list of joint "
        "positions in a task file has too many or too few values. Or a `JointAngle` or "
        "`JointPosition` of the description can never hold, because a limit of the joint forbids "
        "it. This is an error if success needs the condition, and otherwise a warning.",
        within(
            "scene.robots.left",
            "home: {joints_deg: [0, -90, 190, -90, -90, 0]}",
            "home: {joints_deg: [0, -90, 90, -90, -90, 0]}",
        ),
    ),
    "TB303": Code(
        "Home pose out of reach",
        "Inverse kinematics found no solution within the joint limits for this pose of the tcp. "
        "The finding names the first position on the way back to the arm that the tool reaches "
        "with the same orientation. If there is none, the orientation is to blame.",
        within(
            "scene.robots.left",
            "home: {tcp: {position: [0.9, 0, 0.6]}}",
            "home: {tcp: {position: [-0.4, 0, 0.6]}}",
        ),
    ),
    "TB304": Code(
        "Overlap at the start",
        "When the episode begins, two bodies overlap by more than 2 mm.",
        block("position: [0, 0, 0.41]", "position: [0, 0, 0.43]"),
    ),
    "TB305": Code(
        "No room for an object",
        "The reset tried a hundred placements. In each of them, the distance between the object "
        "and another body was smaller than the `clearance` given in `place`, which is 5 mm by "
        "default. Only the distance to the objects that `surface` and `in` name may be smaller.",
        block(
            "place: {surface: table, center: [0.4, 0], size: [0.05, 0.05]}",
            "place: {surface: table, center: [0, 0.3], size: [0.05, 0.05]}",
        ),
    ),
    "TB306": Code(
        "Does not come to rest",
        "During one second in which no robot was commanded, the object moved by more than 5 mm, or "
        "it was still moving at the end.",
        block("position: [0, 0, 0.6]", "position: [0, 0, 0.43]"),
    ),
    "TB307": Code(
        "The simulation diverges",
        "A body is more than 50 m from the origin, has a pose that is not finite, or has a joint "
        "at the speed limit of the physics engine. Or an object moves faster than 10 m/s although "
        "no robot is commanded. The usual cause is that bodies overlap or have very different "
        "masses.",
        block("position: [0, 0, -47]", "position: [0, 0, 0.43]"),
    ),
    "TB308": Code(
        "Implausible mass",
        "The density of the object, computed from its mass and its bounding box, is below 10 "
        "kg/m³ (lighter than foam) or above 25,000 kg/m³ (denser than any metal). This is a "
        "warning.",
        within("scene.objects.cube", "mass: 8", "mass: 0.08"),
    ),
    "TB309": Code(
        "Empty camera image",
        "More than 99.5 % of the camera image shows only the floor and the background.",
        within(
            "scene.cameras",
            "side: {position: [0, -2, 1], look_at: [0, -4, 1]}",
            "side: {position: [0, -2, 1], look_at: [0, 0, 0.5]}",
        ),
    ),
    "TB310": Code(
        "Leaves its region",
        "After the reset, in which the scene settles for one control step, the object is more than "
        "3 mm outside the region in which it was placed. It fell, slid or was pushed. Or an object "
        "that was placed on a surface is more than 5 mm below its top, or has tilted by more than "
        "2°: the bottom of its shape is not level in its own frame, or a URDF states a centre of "
        "mass that is elsewhere. The message names the `rpy_deg` in which it comes to lie, or "
        "`inertia: shape`, which takes the centre of mass from the shape.",
        block(
            "place: {center: [0, 0.3, 0.436], size: [0.1, 0.1, 0]}",
            "place: {surface: table, center: [0, 0.3], size: [0.1, 0.1]}",
        ),
    ),
    "TB311": Code(
        "Solved at the start",
        "The success condition holds before the first action.",
        Example(
            "description",
            'success = Above("cube", height=0.3)',
            'success = Above("cube", height=0.6)',
        ),
    ),
    "TB312": Code(
        "Failed at the start",
        "The failure condition holds before the first action.",
        Example(
            "description",
            'failure = Below("cube", height=0.6)',
            'failure = Below("cube", height=0.3)',
        ),
    ),
    "TB313": Code(
        "Placement does not vary",
        "The `place` of an object or a site has a non-zero `size`, but every seed gives the same "
        "position.",
        within(
            "scene.sites",
            "spot: {place: {center: [0, 0, 0.6], size: [1e-9, 0, 0]}}",
            "spot: {place: {center: [0, 0, 0.6], size: [0.1, 0.1, 0]}}",
        ),
    ),
    "TB314": Code(
        "The description fails during an episode",
        "A condition, measure or reward term raised an error or returned an invalid value. A "
        "condition must return `True` or `False`, and a measure or term must return a number. The "
        "finding shows the line.",
        Example(
            "module",
            "@condition\ndef up(world):\n    return world.position('cube') > 0.6\n\n\n"
            "class Example(Description):\n    ...\n    failure = up()",
            "class Example(Description):\n    ...\n    failure = Above('cube', height=0.6)",
        ),
    ),
    "TB315": Code(
        "Lost process",
        "While a process evaluated the description, the description terminated or crashed the "
        "Python interpreter, or the evaluation took too long. The time limit is 20 s plus 0.8 s "
        "for each control step of an episode. On Linux, time that the process spends waiting for "
        "a free CPU core does not count. The finding shows the line of the description if the "
        "line is known. If something other than the description kills or stops the process, "
        "`validate` repeats the work in a new process. It reports this code only if the same work "
        "is lost twice in a row. The machine may then be short of memory.",
        Example(
            "module",
            "import os\n\n\n@condition\ndef up(world):\n    os._exit(0)\n\n\n"
            "class Example(Description):\n    ...\n    failure = up()",
            "class Example(Description):\n    ...\n    failure = Above('cube', height=0.6)",
        ),
    ),
    "TB316": Code(
        "Grasp point on the wrong link",
        "A grasp point of an articulated object is fixed to the object's base, but the link "
        "nearest to the grasp point is a moving link. When that link moves, the grasp point stays "
        "behind, so that grasps miss and rewards refer to the wrong place. This is a warning.",
        cabinet(
            "grasps: {knob: {at: [0, -0.07, 0.03]}}",
            "grasps: {knob: {at: [0, -0.07, 0], link: drawer}}",
        ),
    ),
    "TB317": Code(
        "The check itself failed",
        "A family of checks could not be finished: taskbuilder has a defect, a file has changed "
        "since it was read, or the machine ran out of memory or disk space. The other families "
        "are run and reported all the same, except those that build on this one. For a defect, "
        "please report the message and the traceback. `validate --debug` prints the traceback; "
        "the formats `json` and `junit` and the pages of `--report` always have it.",
    ),
    "TB318": Code(
        "Region over an edge",
        "The region of an object or a site on a surface reaches over an edge of that surface, and "
        "nothing beside the surface is as high. An object that is placed there falls. The finding "
        "says how far the region reaches over the edge, and which part of it is on the surface.",
        block(
            "place: {surface: table, center: [0, 0.4], size: [0.1, 0.22]}",
            "place: {surface: table, center: [0, 0.4], size: [0.1, 0.18]}",
        ),
    ),
    "TB319": Code(
        "Attached object too heavy for the fingers",
        "With `grasp: attach` and no `force`, a gripper holds any load. This object is heavier "
        "than the fingers of the robots that take it could hold by friction: the force of each "
        "finger, times the coefficients of friction of finger and object, over all fingers. If the "
        "gripper is stronger in reality, say so in the robot file. If `force` is written, the "
        "object comes off at this pull, and nothing is reported. For fingers that turn, 20 N are "
        "assumed. This is a warning.",
        Example("robot", "force: 0.3\ngrasp: attach", "force: 20.0\ngrasp: attach", "gripper"),
    ),
    "TB400": Code(
        "Assets",
        "Summary of TB401 to TB421, which check meshes and URDFs.",
    ),
}
"""Code -> what it stands for."""
