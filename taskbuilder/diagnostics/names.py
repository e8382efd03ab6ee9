"""Codes of names and descriptions: TB2xx."""

from __future__ import annotations

from taskbuilder.diagnostics.entry import Code, Example, within

ENTRIES = {
    "TB200": Code(
        "Names resolve and the description is sound",
        "The check that gathers TB201 to TB214: names in the task file, and the description.",
    ),
    "TB201": Code(
        "Name that stands for nothing",
        "The task file refers to something that the scene does not have, or that is of another "
        "kind, such as a site instead of a robot.",
        within(
            "scene.objects.cube",
            "place: {surface: tabel, center: [-0.4, 0], size: [0.1, 0.1]}",
            "place: {surface: table, center: [-0.4, 0], size: [0.1, 0.1]}",
        ),
    ),
    "TB202": Code(
        "Name used twice",
        "Robots, objects, sites and cameras share one namespace, and so do the links and grasp "
        "points of a URDF object.",
        within(
            "scene.sites", "cube: {position: [0, 0, 0.6]}", "cube_goal: {position: [0, 0, 0.6]}"
        ),
    ),
    "TB203": Code(
        "Positions run in a circle",
        "An object or site is placed in the frame of another one that is, directly or "
        "indirectly, placed in the frame of the first.",
        within(
            "scene.sites",
            "a: {position: [0, 0, 0.1], in: b}\nb: {position: [0, 0, 0.1], in: a}",
            "a: {position: [0, 0, 0.6]}\nb: {position: [0, 0, 0.1], in: a}",
        ),
    ),
    "TB204": Code(
        "Not an observation channel",
        "A channel is subject.quantity, such as self.tcp or cube.pose, with a quantity that "
        "the subject has.",
        within("observe", "left: [self.tcp, cube.color]", "left: [self.tcp, cube.pose]"),
    ),
    "TB205": Code(
        "Change of the scene that cannot be made",
        "A variation, a randomised quantity or a {thing.key} of an instruction refers to a "
        "value that the scene does not have, or that cannot change.",
        Example("task", "variations: [{cub.color: blue}]", "variations: [{cube.color: blue}]"),
    ),
    "TB206": Code(
        "No description beside the task file",
        "NAME.yaml needs NAME.py in the same folder, which holds the description.",
        Example("folder", "example.yaml", "example.yaml\nexample.py"),
    ),
    "TB207": Code(
        "The description names something that is not there",
        "A condition, measure or reward term names something that the scene does not have, or "
        "that is of another kind.",
        Example("description", 'success = Held("cub")', 'success = Held("cube")'),
    ),
    "TB208": Code(
        "The description fails to import",
        "Running the Python file raised an error; the finding shows its line.",
        Example("description", "success = Held(cube)", 'success = Held("cube")'),
    ),
    "TB209": Code(
        "Not exactly one description",
        "The Python file defines no subclass of Description, or several.",
        Example("module", "class Example:\n    ...", "class Example(Description):\n    ..."),
    ),
    "TB210": Code(
        "The description is incomplete",
        "success and reward are required; success, failure and stages are conditions, reward "
        "is a tuple of terms, progress is a measure.",
        Example(
            "description",
            'reward = Bonus("held", Held("cube"), 1.0)',
            'reward = (Bonus("held", Held("cube"), 1.0),)',
        ),
    ),
    "TB211": Code(
        "Two things of one name in the description",
        "Two reward terms have the same name and agent, or a stage has the name of another "
        "condition. Logs could not distinguish them.",
        Example(
            "description",
            'reward = (Bonus("grasp", Held("cube"), 1.0), Bonus("grasp", Held("tray"), 1.0))',
            'reward = (Bonus("cube", Held("cube"), 1.0), Bonus("tray", Held("tray"), 1.0))',
        ),
    ),
    "TB212": Code(
        "Value that makes no sense in the description",
        "A value is invalid: a threshold is negative or not a number, bounds exclude each "
        "other, or the like.",
        Example(
            "description",
            'success = Near("cube", "goal", within=-0.05)',
            'success = Near("cube", "goal", within=0.05)',
        ),
    ),
    "TB213": Code(
        "The description does not come back",
        "Importing the Python file took over ten seconds or ended the interpreter. A "
        "description only declares expressions: it must not train anything or communicate.",
        Example("module", "import os\n\nos._exit(0)", "class Example(Description):\n    ..."),
    ),
    "TB214": Code(
        "No such condition",
        "An expert waits for a condition, or a lock of a joint names one, that the description "
        "does not have. It can be a stage, success or failure, or any condition that is an "
        "attribute of the class.",
        within("", "expert: [{until: sucess}]", "expert: [{until: success}]"),
    ),
}
"""Code -> what it stands for."""
