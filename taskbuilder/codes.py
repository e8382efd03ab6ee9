"""The codes of findings TB0xx to TB3xx, with the explanation that the documentation shows.

Those of assets, TB401 on, are in `taskbuilder.assets.codes`. A code never changes its meaning, and
one that is given up is not used again.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

Where = Literal["file", "task", "description", "module", "robot", "folder"]
"""What an example is a piece of.

``file``: a YAML file, whole. ``task``, ``robot``: keys of a task file or robot.yaml.
``description``: attributes of the description class. ``module``: the Python file, less its
imports from taskbuilder. ``folder``: names of files.
"""


@dataclass(frozen=True, slots=True)
class Example:
    """Something that gives a finding, and the same mended.

    Attributes:
        where: What both are a piece of.
        bad: What gives the finding.
        good: What does not.
        under: Dotted path of the mapping that the keys belong to; "" for the top level.
    """

    where: Where
    bad: str
    good: str
    under: str = ""


@dataclass(frozen=True, slots=True)
class Code:
    """What a code stands for.

    Attributes:
        title: A few words.
        meaning: What is wrong, and why it is refused.
        example: None for a check that gathers several codes.
    """

    title: str
    meaning: str
    example: Example | None = None


def _in(under: str, bad: str, good: str) -> Example:
    return Example("task", bad, good, under)


def _block(bad: str, good: str) -> Example:
    """A block that is put somewhere, badly and well."""
    block = "block: {shape: {box: [0.06, 0.06, 0.06]}, mass: 0.1, "
    return _in("scene.objects", f"{block}{bad}}}", f"{block}{good}}}")


_CODES = {
    "TB000": Code(
        "The files can be read",
        "The check that gathers TB001 to TB009: files, YAML and the catalogue.",
    ),
    "TB001": Code(
        "File cannot be read",
        "The file does not exist, is not a plain file, or may not be read by this user.",
        Example("folder", "example.yaml/", "example.yaml"),
    ),
    "TB002": Code(
        "Not UTF-8",
        "Task and robot files are UTF-8. The finding names the line of the first byte that is not.",
        Example("file", "summary: Öffne die Tür.  # Latin-1", "summary: Öffne die Tür.  # UTF-8"),
    ),
    "TB003": Code(
        "Not valid YAML",
        "The file is not YAML, or holds a second document, or a key that is not a plain word.",
        Example("file", "timing: {control_hz: 10", "timing: {control_hz: 10}"),
    ),
    "TB004": Code(
        "Key given twice",
        "A key stands twice in one mapping. Most YAML readers keep the last in silence.",
        Example("file", "state: all\nstate: [cube.pose]", "state: [cube.pose]"),
    ),
    "TB005": Code(
        "YAML feature that is not read",
        "Tags (!!str) and merge keys (<<) are not read: files hold plain values only.",
        Example("file", "summary: !!str Lift the cube.", "summary: Lift the cube."),
    ),
    "TB006": Code(
        "Beyond what is read",
        "A file has at most 256 KiB, 24 levels and 20,000 values once its aliases are written "
        "out, and an alias comes after the anchor that it names.",
        Example("file", "state: *everything", "state: all"),
    ),
    "TB007": Code(
        "Top level is not a mapping",
        "The file is empty, or is a list or a single value in place of keys.",
        Example("file", "- task: example", "task: example"),
    ),
    "TB008": Code(
        "Two files of one name",
        "Two tasks, or two robots, have one name in the catalogue. Neither wins: rename one, "
        "or take its folder off the task path.",
        Example("folder", "mine/handover.yaml", "mine/wide_handover.yaml"),
    ),
    "TB009": Code(
        "No such robot",
        "The model is neither a robot of the catalogue nor the path of a robot.yaml.",
        _in("scene.robots.left", "model: ur5", "model: ur5e"),
    ),
    "TB100": Code(
        "Keys, types and units are right",
        "The check that gathers TB101 to TB109: the form of the task or robot file.",
    ),
    "TB101": Code(
        "Something is missing",
        "A key that has no default is not given.",
        _in(
            "scene.robots.left",
            "home: {tcp: {rpy_deg: [180, 0, 0]}}",
            "home: {tcp: {position: [-0.4, 0, 0.6], rpy_deg: [180, 0, 0]}}",
        ),
    ),
    "TB102": Code(
        "Unknown key",
        "The key is not one of those that may stand there. Nothing is ignored in silence.",
        _in("scene.objects.table", "fixd: true", "fixed: true"),
    ),
    "TB103": Code(
        "Value of another type",
        "A number is needed and a text stands there, or the like. Booleans are true and "
        "false; off, on, yes and no are texts.",
        _in("scene.objects.cube", "fixed: off", "fixed: false"),
    ),
    "TB104": Code(
        "Value out of range",
        "A number is too small or too large, or a list has too few or too many values.",
        _in("scene.objects.cube", "mass: -0.08", "mass: 0.08"),
    ),
    "TB105": Code(
        "Not one of the choices",
        "The key takes one of a few words, and this is none of them.",
        Example("task", "cooperation: needed", "cooperation: required"),
    ),
    "TB106": Code(
        "Values that do not go together",
        "Each value is right alone, but not beside the others: two shapes for one object, "
        "[greatest, least] in place of [least, greatest], a physics_hz that is no multiple of "
        "control_hz.",
        _in(
            "scene.objects.cube",
            "shape: {box: [0.05, 0.05, 0.05], sphere: 0.03}",
            "shape: {box: [0.05, 0.05, 0.05]}",
        ),
    ),
    "TB107": Code(
        "Not a name",
        "A name is a letter, then letters, digits and _, at most 40 in all, and none of the "
        "reserved words (self, world, all, together, time_left, description).",
        _in(
            "scene.sites",
            "2nd_goal: {position: [0, 0, 0.6]}",
            "second_goal: {position: [0, 0, 0.6]}",
        ),
    ),
    "TB108": Code(
        "Not a colour",
        'A colour is a name of the palette, [r, g, b] with each from 0 to 1, or "#rrggbb".',
        _in("scene.objects.cube", "color: crimson", 'color: "#b01030"'),
    ),
    "TB109": Code(
        "Name and file differ",
        "A task is named as its file is, without .yaml; a robot as the folder of its "
        "robot.yaml is.",
        Example("task", "task: exmaple", "task: example"),
    ),
    "TB200": Code(
        "Names resolve and the description is sound",
        "The check that gathers TB201 to TB213: names in the task file, and the description.",
    ),
    "TB201": Code(
        "Name that stands for nothing",
        "The task file refers to something that the scene does not have, or that is of "
        "another kind: a site where a robot is needed.",
        _in(
            "scene.objects.cube",
            "place: {surface: tabel, center: [-0.4, 0], size: [0.1, 0.1]}",
            "place: {surface: table, center: [-0.4, 0], size: [0.1, 0.1]}",
        ),
    ),
    "TB202": Code(
        "Name used twice",
        "Robots, objects, sites and cameras share one space of names.",
        _in("scene.sites", "cube: {position: [0, 0, 0.6]}", "cube_goal: {position: [0, 0, 0.6]}"),
    ),
    "TB203": Code(
        "Positions run in a circle",
        "One thing stands in the frame of another that, in the end, stands in the frame of "
        "the first.",
        _in(
            "scene.sites",
            "a: {position: [0, 0, 0.1], in: b}\nb: {position: [0, 0, 0.1], in: a}",
            "a: {position: [0, 0, 0.6]}\nb: {position: [0, 0, 0.1], in: a}",
        ),
    ),
    "TB204": Code(
        "Not an observation channel",
        "A channel is subject.quantity, such as self.tcp or cube.pose, with a quantity that "
        "the subject has.",
        _in("observe", "left: [self.tcp, cube.color]", "left: [self.tcp, cube.pose]"),
    ),
    "TB205": Code(
        "Change of the scene that cannot be made",
        "A variation, a randomised quantity or a {thing.key} of an instruction names no value "
        "of the scene, or one that cannot change.",
        Example("task", "variations: [{cub.color: blue}]", "variations: [{cube.color: blue}]"),
    ),
    "TB206": Code(
        "No description beside the task file",
        "NAME.yaml needs NAME.py in the same folder; it holds the description.",
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
        "condition. Logs could not tell them apart.",
        Example(
            "description",
            'reward = (Bonus("grasp", Held("cube"), 1.0), Bonus("grasp", Held("tray"), 1.0))',
            'reward = (Bonus("cube", Held("cube"), 1.0), Bonus("tray", Held("tray"), 1.0))',
        ),
    ),
    "TB212": Code(
        "Value that makes no sense in the description",
        "A threshold is negative or not a number, bounds exclude each other, or the like.",
        Example(
            "description",
            'success = Near("cube", "goal", within=-0.05)',
            'success = Near("cube", "goal", within=0.05)',
        ),
    ),
    "TB213": Code(
        "The description does not come back",
        "Importing the Python file took over ten seconds or ended the interpreter. A "
        "description only declares: it neither trains nor talks to anything.",
        Example("module", "import os\n\nos._exit(0)", "class Example(Description):\n    ..."),
    ),
    "TB300": Code(
        "Robots and joint values fit their URDFs",
        "The check that gathers TB301 and TB302, which need no physics.",
    ),
    "TB301": Code(
        "Does not fit the URDF",
        "A robot.yaml, or the joints of an object, name a link or a moving joint that the URDF "
        "does not have, or give a gripper a position beyond its joint's limits.",
        Example("robot", "link: wrist_3", "link: wrist_3_link", "tcp"),
    ),
    "TB302": Code(
        "Joint value beyond its limits",
        "A position lies outside the limits of its joint, or there are not as many positions "
        "as joints.",
        _in(
            "scene.robots.left",
            "home: {joints_deg: [0, -90, 190, -90, -90, 0]}",
            "home: {joints_deg: [0, -90, 90, -90, -90, 0]}",
        ),
    ),
    "TB303": Code(
        "Home that the robot cannot reach",
        "No joint positions within the limits bring the tcp to this pose.",
        _in(
            "scene.robots.left",
            "home: {tcp: {position: [0.9, 0, 0.6]}}",
            "home: {tcp: {position: [-0.4, 0, 0.6]}}",
        ),
    ),
    "TB304": Code(
        "Starts inside another body",
        "Two bodies overlap by more than 1 mm when the episode begins.",
        _block("position: [0, 0, 0.41]", "position: [0, 0, 0.43]"),
    ),
    "TB305": Code(
        "No free place",
        "A hundred placements were tried, and each came closer than 5 mm to something else.",
        _block(
            "place: {surface: table, center: [0.4, 0], size: [0.05, 0.05]}",
            "place: {surface: table, center: [0, 0.3], size: [0.05, 0.05]}",
        ),
    ),
    "TB306": Code(
        "Does not come to rest",
        "Left alone for a second, the object is more than 5 mm from its start or still moves.",
        _block("position: [0, 0, 0.6]", "position: [0, 0, 0.43]"),
    ),
    "TB307": Code(
        "The simulation explodes",
        "With nothing driven, bodies gain energy, leave the scene or have positions that are "
        "not finite. Bodies inside each other, or of very unlike masses, are the usual cause.",
        _block("position: [0, 0, -47]", "position: [0, 0, 0.43]"),
    ),
    "TB308": Code(
        "Implausible mass",
        "The density of the bounding box is below that of foam or above that of lead. A warning.",
        _in("scene.objects.cube", "mass: 8", "mass: 0.08"),
    ),
    "TB309": Code(
        "Camera sees nothing",
        "The picture shows only floor and background.",
        _in(
            "scene.cameras",
            "side: {position: [0, -2, 1], look_at: [0, -4, 1]}",
            "side: {position: [0, -2, 1], look_at: [0, 0, 0.5]}",
        ),
    ),
    "TB310": Code(
        "Leaves its region",
        "After the control step in which an episode settles, the thing is more than 3 mm "
        "outside the region that it was placed in: it fell, slid or was pushed.",
        _block(
            "place: {center: [0, 0.3, 0.436], size: [0.1, 0.1, 0]}",
            "place: {surface: table, center: [0, 0.3], size: [0.1, 0.1]}",
        ),
    ),
    "TB311": Code(
        "Solved at the start",
        "The success condition holds before anyone has acted.",
        Example(
            "description",
            'success = Above("cube", height=0.3)',
            'success = Above("cube", height=0.6)',
        ),
    ),
    "TB312": Code(
        "Failed at the start",
        "The failure condition holds before anyone has acted.",
        Example(
            "description",
            'failure = Below("cube", height=0.6)',
            'failure = Below("cube", height=0.3)',
        ),
    ),
    "TB313": Code(
        "Placement does not vary",
        "The region has a size, yet the thing is at one place for every seed.",
        _in(
            "scene.sites",
            "spot: {place: {center: [0, 0, 0.6], size: [1e-9, 0, 0]}}",
            "spot: {place: {center: [0, 0, 0.6], size: [0.1, 0.1, 0]}}",
        ),
    ),
    "TB314": Code(
        "The description fails when it is asked",
        "A condition, measure or reward term raised an error; the finding shows its line.",
        Example(
            "module",
            "@condition\ndef up(world):\n    return world.position('cube') > 0.6\n\n\n"
            "class Example(Description):\n    ...\n    failure = up()",
            "class Example(Description):\n    ...\n    failure = Above('cube', height=0.6)",
        ),
    ),
    "TB400": Code(
        "Assets are there and sound",
        "The check that gathers the codes of meshes and URDFs, TB401 to TB420.",
    ),
}

CODES: Mapping[str, Code] = MappingProxyType(_CODES)
"""Every code, in order."""
