"""Codes of names and descriptions: TB2xx."""

from __future__ import annotations

from taskbuilder.diagnostics.entry import Code, Example, within

ENTRIES = {
    "TB200": Code(
        "Names and description",
        "Summary of TB201 to TB216, which check the description and the names in the task file.",
    ),
    "TB201": Code(
        "Unknown name",
        "The task file uses a name that the scene does not have, or a name of the wrong kind, "
        "such as a site where a robot is needed.",
        within(
            "scene.objects.cube",
            "place: {surface: tabel, center: [-0.4, 0], size: [0.1, 0.1]}",
            "place: {surface: table, center: [-0.4, 0], size: [0.1, 0.1]}",
        ),
    ),
    "TB202": Code(
        "Name used twice",
        "Robots, objects, sites and cameras share one namespace, so two of them cannot have the "
        "same name. In an object with a URDF, a grasp point cannot have the same name as a link.",
        within(
            "scene.sites", "cube: {position: [0, 0, 0.6]}", "cube_goal: {position: [0, 0, 0.6]}"
        ),
    ),
    "TB203": Code(
        "Circular positions",
        "Objects or sites are placed in each other's frames, directly or indirectly, so none of "
        "their positions is defined.",
        within(
            "scene.sites",
            "a: {position: [0, 0, 0.1], in: b}\nb: {position: [0, 0, 0.1], in: a}",
            "a: {position: [0, 0, 0.6]}\nb: {position: [0, 0, 0.1], in: a}",
        ),
    ),
    "TB204": Code(
        "Unknown observation channel",
        "Except for `time_left`, a channel has the form `SUBJECT.QUANTITY`, such as `self.tcp` or "
        "`cube.pose`. Either the subject does not exist, or it does not have this quantity.",
        within("observe", "left: [self.tcp, cube.color]", "left: [self.tcp, cube.pose]"),
    ),
    "TB205": Code(
        "Impossible change of the scene",
        "A variation or an entry of `randomize` changes a value that the scene does not have or "
        "that cannot be changed. Or a placeholder in an instruction, such as `{cube.color}`, "
        "refers to a value that the scene does not have.",
        Example("task", "variations: [{cub.color: blue}]", "variations: [{cube.color: blue}]"),
    ),
    "TB206": Code(
        "No description beside the task file",
        "The description of `NAME.yaml` must be in `NAME.py`, in the same folder.",
        Example("folder", "example.yaml", "example.yaml\nexample.py"),
    ),
    "TB207": Code(
        "Unknown name in the description",
        "A condition, measure or reward term uses a name that the scene does not have, or a name "
        "of the wrong kind.",
        Example("description", 'success = Held("cub")', 'success = Held("cube")'),
    ),
    "TB208": Code(
        "The description fails to import",
        "The Python file raised an error when it was imported. The finding shows the line.",
        Example("description", "success = Held(cube)", 'success = Held("cube")'),
    ),
    "TB209": Code(
        "Not exactly one description",
        "The Python file must define exactly one subclass of `Description`. This file defines "
        "none, or more than one.",
        Example("module", "class Example:\n    ...", "class Example(Description):\n    ..."),
    ),
    "TB210": Code(
        "The description is incomplete",
        "`success` and `reward` are required. `success`, `failure` and `setback` must be "
        "conditions, `stages` must map names to conditions, `reward` must be a tuple of reward "
        "terms, and `progress` must be a measure.",
        Example(
            "description",
            'reward = Bonus("held", Held("cube"), 1.0)',
            'reward = (Bonus("held", Held("cube"), 1.0),)',
        ),
    ),
    "TB211": Code(
        "Duplicate name in the description",
        "Two reward terms have the same name and the same agent. Or a stage has the same name as "
        "an attribute of the class, but is a different condition. In logs, the two could not be "
        "told apart.",
        Example(
            "description",
            'reward = (Bonus("grasp", Held("cube"), 1.0), Bonus("grasp", Held("tray"), 1.0))',
            'reward = (Bonus("cube", Held("cube"), 1.0), Bonus("tray", Held("tray"), 1.0))',
        ),
    ),
    "TB212": Code(
        "Invalid value in the description",
        "An expression has an invalid value. For example, a threshold is negative or not a number, "
        "or a lower bound is greater than the upper bound.",
        Example(
            "description",
            'success = Near("cube", "goal", within=-0.05)',
            'success = Near("cube", "goal", within=0.05)',
        ),
    ),
    "TB213": Code(
        "The import of the description does not finish",
        "Importing the Python file took longer than 30 s, or terminated the interpreter. (With "
        "`validate_task(..., apart=False)`, the limit is 10 s.) A description should only declare "
        "expressions, without long computations or network access.",
        Example("module", "import os\n\nos._exit(0)", "class Example(Description):\n    ..."),
    ),
    "TB214": Code(
        "Unknown condition",
        "The expert waits for a condition that the description does not have, or the lock of a "
        "joint depends on such a condition. The condition can be `success`, `failure`, a stage, or "
        "any other attribute of the description class that is a condition.",
        within("", "expert: [{until: sucess}]", "expert: [{until: success}]"),
    ),
    "TB215": Code(
        "Members of a group not combined",
        "An expression of the description names a group of objects, but does not state how the "
        "values for the members of the group are combined. Put a condition into `All`, `Any`, "
        "`AtLeast` or `Count`, and a measure into `Mean` or `Minimum`.",
        Example(
            "description",
            'failure = Near("pegs", "cube", within=0.01)',
            'failure = Any(Near("pegs", "cube", within=0.01))',
        ),
    ),
    "TB216": Code(
        "Not with this end effector",
        "The expert gives a robot without a gripper or suction cup an order that requires one, "
        "such as `grasp` or `release`, or the `action` of such a robot has the key `gripper`. "
        "Such a robot can only move its arm, push and press. This code is also reported if a "
        "robot with a suction cup has `gripper: continuous`, because suction is either on or off, "
        "or if a robot without fingers has the key `grasp`.",
        within(
            "scene.robots.left",
            "model: ur5e_pusher\naction: {gripper: binary}",
            "model: ur5e\naction: {gripper: binary}",
        ),
    ),
}
"""Code -> what it stands for."""
