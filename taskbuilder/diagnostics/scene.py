"""Codes of robots, physics and resets, TB3xx, and the one that gathers those of assets."""

from __future__ import annotations

from taskbuilder.diagnostics.entry import Code, Example, block, cabinet, within

ENTRIES = {
    "TB300": Code(
        "Robots and joint values fit their URDFs",
        "The check that gathers TB301 and TB302, which need no physics.",
    ),
    "TB301": Code(
        "Does not fit the URDF",
        "A robot.yaml, or the joints and grasp points of an object, refer to a link or a moving "
        "joint that the URDF does not have, or give a gripper a position beyond its joint's "
        "limits.",
        Example("robot", "link: wrist_3", "link: wrist_3_link", "tcp"),
    ),
    "TB302": Code(
        "Joint value beyond its limits",
        "A position, or a limit in the task file, is outside the limits of its joint, or the "
        "number of positions is not the number of joints.",
        within(
            "scene.robots.left",
            "home: {joints_deg: [0, -90, 190, -90, -90, 0]}",
            "home: {joints_deg: [0, -90, 90, -90, -90, 0]}",
        ),
    ),
    "TB303": Code(
        "Home that the robot cannot reach",
        "No joint positions within the limits bring the tcp to this pose.",
        within(
            "scene.robots.left",
            "home: {tcp: {position: [0.9, 0, 0.6]}}",
            "home: {tcp: {position: [-0.4, 0, 0.6]}}",
        ),
    ),
    "TB304": Code(
        "Starts inside another body",
        "Two bodies overlap by more than 1 mm when the episode begins.",
        block("position: [0, 0, 0.41]", "position: [0, 0, 0.43]"),
    ),
    "TB305": Code(
        "No free place",
        "A hundred placements were tried, and each was closer than 5 mm to something else.",
        block(
            "place: {surface: table, center: [0.4, 0], size: [0.05, 0.05]}",
            "place: {surface: table, center: [0, 0.3], size: [0.05, 0.05]}",
        ),
    ),
    "TB306": Code(
        "Does not come to rest",
        "During a second without any action, the object moved more than 5 mm from its start, or"
        " it is still moving.",
        block("position: [0, 0, 0.6]", "position: [0, 0, 0.43]"),
    ),
    "TB307": Code(
        "The simulation explodes",
        "Without any action, bodies gain energy, leave the scene or have positions that are not"
        " finite. Bodies inside each other, or with very different masses, are the usual cause.",
        block("position: [0, 0, -47]", "position: [0, 0, 0.43]"),
    ),
    "TB308": Code(
        "Implausible mass",
        "The density of the bounding box is below that of foam or above that of lead. A warning.",
        within("scene.objects.cube", "mass: 8", "mass: 0.08"),
    ),
    "TB309": Code(
        "Camera sees nothing",
        "The picture shows only floor and background.",
        within(
            "scene.cameras",
            "side: {position: [0, -2, 1], look_at: [0, -4, 1]}",
            "side: {position: [0, -2, 1], look_at: [0, 0, 0.5]}",
        ),
    ),
    "TB310": Code(
        "Leaves its region",
        "After the scene has settled for one control step, the object is more than 3 mm outside"
        " the region that it was placed in: it fell, slid or was pushed.",
        block(
            "place: {center: [0, 0.3, 0.436], size: [0.1, 0.1, 0]}",
            "place: {surface: table, center: [0, 0.3], size: [0.1, 0.1]}",
        ),
    ),
    "TB311": Code(
        "Solved at the start",
        "The success condition holds before any action.",
        Example(
            "description",
            'success = Above("cube", height=0.3)',
            'success = Above("cube", height=0.6)',
        ),
    ),
    "TB312": Code(
        "Failed at the start",
        "The failure condition holds before any action.",
        Example(
            "description",
            'failure = Below("cube", height=0.6)',
            'failure = Below("cube", height=0.3)',
        ),
    ),
    "TB313": Code(
        "Placement does not vary",
        "The region has a size, but the position is the same for every seed.",
        within(
            "scene.sites",
            "spot: {place: {center: [0, 0, 0.6], size: [1e-9, 0, 0]}}",
            "spot: {place: {center: [0, 0, 0.6], size: [0.1, 0.1, 0]}}",
        ),
    ),
    "TB314": Code(
        "The description fails when it is asked",
        "A condition, measure or reward term raised an error or returned an invalid value: a "
        "condition returns True or False, a measure and a term return a number. The finding "
        "shows the line.",
        Example(
            "module",
            "@condition\ndef up(world):\n    return world.position('cube') > 0.6\n\n\n"
            "class Example(Description):\n    ...\n    failure = up()",
            "class Example(Description):\n    ...\n    failure = Above('cube', height=0.6)",
        ),
    ),
    "TB315": Code(
        "The process that plays is lost",
        "The description ended or crashed the interpreter while it was evaluated, or did not "
        "return in time: 20 s and 0.8 s for each control step of an episode. The finding shows "
        "the line, if it is known. A process that is killed or stopped from outside is replaced"
        " and its work is repeated; if this happens twice in a row, memory may be short.",
        Example(
            "module",
            "import os\n\n\n@condition\ndef up(world):\n    os._exit(0)\n\n\n"
            "class Example(Description):\n    ...\n    failure = up()",
            "class Example(Description):\n    ...\n    failure = Above('cube', height=0.6)",
        ),
    ),
    "TB316": Code(
        "Grasp point that stays behind",
        "A grasp point of an articulated object is fixed to its base, but the nearest link moves. "
        "When that link moves, grasps miss, and rewards pay for the wrong place. A warning.",
        cabinet(
            "grasps: {knob: {at: [0, -0.07, 0.03]}}",
            "grasps: {knob: {at: [0, -0.07, 0], link: drawer}}",
        ),
    ),
    "TB400": Code(
        "Assets are there and sound",
        "The check that gathers the codes of meshes and URDFs, TB401 to TB421.",
    ),
}
"""Code -> what it stands for."""
