"""Codes of files and YAML, and of keys and values: TB0xx and TB1xx."""

from __future__ import annotations

from taskbuilder.diagnostics.entry import Code, Example, within

ENTRIES = {
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
        within("scene.robots.left", "model: ur5", "model: ur5e"),
    ),
    "TB100": Code(
        "Keys, types and units are right",
        "The check that gathers TB101 to TB109: the form of the task or robot file.",
    ),
    "TB101": Code(
        "Something is missing",
        "A key that has no default is not given.",
        within(
            "scene.robots.left",
            "home: {tcp: {rpy_deg: [180, 0, 0]}}",
            "home: {tcp: {position: [-0.4, 0, 0.6], rpy_deg: [180, 0, 0]}}",
        ),
    ),
    "TB102": Code(
        "Unknown key",
        "The key is not one of those that may stand there. Nothing is ignored in silence.",
        within("scene.objects.table", "fixd: true", "fixed: true"),
    ),
    "TB103": Code(
        "Value of another type",
        "A number is needed and a text stands there, or the like. Booleans are true and "
        "false; off, on, yes and no are texts.",
        within("scene.objects.cube", "fixed: off", "fixed: false"),
    ),
    "TB104": Code(
        "Value out of range",
        "A number is too small or too large, or a list has too few or too many values.",
        within("scene.objects.cube", "mass: -0.08", "mass: 0.08"),
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
        within(
            "scene.objects.cube",
            "shape: {box: [0.05, 0.05, 0.05], sphere: 0.03}",
            "shape: {box: [0.05, 0.05, 0.05]}",
        ),
    ),
    "TB107": Code(
        "Not a name",
        "A name is a letter, then letters, digits and _, at most 40 in all, and none of the "
        "reserved words (self, world, all, together, until, repeat, nothing, time_left, "
        "description).",
        within(
            "scene.sites",
            "2nd_goal: {position: [0, 0, 0.6]}",
            "second_goal: {position: [0, 0, 0.6]}",
        ),
    ),
    "TB108": Code(
        "Not a colour",
        'A colour is a name of the palette, [r, g, b] with each from 0 to 1, or "#rrggbb".',
        within("scene.objects.cube", "color: crimson", 'color: "#b01030"'),
    ),
    "TB109": Code(
        "Name and file differ",
        "A task is named as its file is, without .yaml; a robot as the folder of its "
        "robot.yaml is.",
        Example("task", "task: exmaple", "task: example"),
    ),
}
"""Code -> what it stands for."""
