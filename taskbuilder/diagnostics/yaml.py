"""Codes of files and YAML, and of keys and values: TB0xx and TB1xx."""

from __future__ import annotations

from taskbuilder.diagnostics.entry import Code, Example, cabinet, within

ENTRIES = {
    "TB000": Code(
        "Readable files",
        "Summary of TB001 to TB009, which check the files, their YAML and the catalogue.",
    ),
    "TB001": Code(
        "File cannot be read",
        "The file does not exist, is not a regular file (for example, it is a folder), or you do "
        "not have permission to read it.",
        Example("folder", "example.yaml/", "example.yaml"),
    ),
    "TB002": Code(
        "Not UTF-8",
        "Task and robot files must be encoded in UTF-8. The finding names the line of the first "
        "byte that is not valid UTF-8.",
        Example("file", "summary: Öffne die Tür.  # Latin-1", "summary: Öffne die Tür.  # UTF-8"),
    ),
    "TB003": Code(
        "Not valid YAML",
        "The file is not valid YAML, contains a second document, or has a key that is not a "
        "scalar.",
        Example("file", "timing: {control_hz: 10", "timing: {control_hz: 10}"),
    ),
    "TB004": Code(
        "Key given twice",
        "A key occurs twice in one mapping. Most YAML readers would silently keep the last value.",
        Example("file", "state: all\nstate: [cube.pose]", "state: [cube.pose]"),
    ),
    "TB005": Code(
        "Unsupported YAML feature",
        "Tags (`!!str`) and merge keys (`<<`) are not supported. Remove the tag, or write out the "
        "merged keys.",
        Example("file", "summary: !!str Lift the cube.", "summary: Lift the cube."),
    ),
    "TB006": Code(
        "YAML limits exceeded",
        "A file must not be larger than 256 KiB, be nested deeper than 24 levels, or contain more "
        "than 20,000 keys and values in total. Each alias counts as all the keys and values that "
        "it stands for. An alias must come after its anchor.",
        Example("file", "state: *everything", "state: all"),
    ),
    "TB007": Code(
        "Top level is not a mapping",
        "The file is empty, or holds a list or a single value instead of keys.",
        Example("file", "- task: example", "task: example"),
    ),
    "TB008": Code(
        "Two files with the same name",
        "Two tasks, two robots or two suites in the catalogue have the same name. Until this is "
        "resolved, neither of the two tasks or robots can be used by that name. Tasks that use "
        "the robot by that name cannot be used either. All other tasks and robots can. Of suites, "
        "none can be used. Rename one of the two, or leave its folder out of `--task-path` and "
        "`TASKBUILDER_PATH`.",
        Example("folder", "mine/handover.yaml", "mine/wide_handover.yaml"),
    ),
    "TB009": Code(
        "No such robot or task",
        "`model` is neither the name of a robot in the catalogue nor the path of a robot.yaml. "
        "This code is also reported if a suite lists a task that is not in the folder of its "
        "suites.yaml.",
        within("scene.robots.left", "model: ur5", "model: ur5e"),
    ),
    "TB100": Code(
        "Keys, types and units",
        "Summary of TB101 to TB111, which check the keys, types and units of a task or robot file.",
    ),
    "TB101": Code(
        "Missing key",
        "A required key is missing.",
        within(
            "scene.robots.left",
            "home: {tcp: {rpy_deg: [180, 0, 0]}}",
            "home: {tcp: {position: [-0.4, 0, 0.6], rpy_deg: [180, 0, 0]}}",
        ),
    ),
    "TB102": Code(
        "Unknown key",
        "This key is not allowed here. Unknown keys are never ignored silently.",
        within("scene.objects.table", "fixd: true", "fixed: true"),
    ),
    "TB103": Code(
        "Wrong type",
        "The value has the wrong type, for example a string instead of a number. Booleans are "
        "`true` and `false`; `off`, `on`, `yes` and `no` are strings.",
        within("scene.objects.cube", "fixed: off", "fixed: false"),
    ),
    "TB104": Code(
        "Value out of range",
        "A number is too small or too large, or a list has too few or too many values.",
        within("scene.objects.cube", "mass: -0.08", "mass: 0.08"),
    ),
    "TB105": Code(
        "Not one of the choices",
        "The value is not one of the allowed words.",
        Example("task", "cooperation: needed", "cooperation: required"),
    ),
    "TB106": Code(
        "Incompatible values",
        "Each value is valid on its own, but not in combination with the others. Examples: two "
        "shapes for one object, `[maximum, minimum]` instead of `[minimum, maximum]`, or a "
        "`physics_hz` that is not a multiple of `control_hz`.",
        within(
            "scene.objects.cube",
            "shape: {box: [0.05, 0.05, 0.05], sphere: 0.03}",
            "shape: {box: [0.05, 0.05, 0.05]}",
        ),
    ),
    "TB107": Code(
        "Invalid name",
        "A name must start with a letter, contain only letters, digits and `_`, and have at most "
        "40 characters. These words are reserved: `self`, `world`, `all`, `together`, `until`, "
        "`repeat`, `nothing`, `time_left`, `description`, `background`.",
        within(
            "scene.sites",
            "2nd_goal: {position: [0, 0, 0.6]}",
            "second_goal: {position: [0, 0, 0.6]}",
        ),
    ),
    "TB108": Code(
        "Invalid colour",
        "A colour must be a name from taskbuilder's palette, a list `[r, g, b]` of values from 0 "
        'to 1, or a string `"#rrggbb"`. If the name is unknown, the message lists the palette.',
        within("scene.objects.cube", "color: crimson", 'color: "#b01030"'),
    ),
    "TB109": Code(
        "Name does not match the file",
        "The value of `task` must be the name of the task file without `.yaml`. The value of "
        "`robot` must be the name of the folder that contains the robot.yaml.",
        Example("task", "task: exmaple", "task: example"),
    ),
    "TB110": Code(
        "Wrong unit for the joint",
        "`start`, `limits` and `rest` are for prismatic joints and are given in metres. "
        "`start_deg`, `limits_deg` and `rest_deg` are for revolute joints and are given in "
        "degrees. Likewise, in the orders of the expert, `slide` is for prismatic joints and "
        "`turn` is for revolute joints.",
        cabinet("joints: {slide: {start_deg: 5}}", "joints: {slide: {start: 0.05}}"),
    ),
    "TB111": Code(
        "Group does not fit",
        "The objects of a group overlap in their arrangement, or the box of a `pile` is too small "
        "for the objects of the group. The message states a spacing or a size that is large "
        "enough.",
        within(
            "scene.objects",
            "blocks: {shape: {box: [0.03, 0.03, 0.05]}, mass: 0.02, count: 4, "
            "arrange: {line: 0.02}, position: [0, 0.3, 0.425]}",
            "blocks: {shape: {box: [0.03, 0.03, 0.05]}, mass: 0.02, count: 4, "
            "arrange: {line: 0.05}, position: [0, 0.3, 0.425]}",
        ),
    ),
}
"""Code -> what it stands for."""
