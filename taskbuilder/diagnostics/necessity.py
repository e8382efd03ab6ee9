"""Codes of tasks that are solved without a robot, or without doing anything: TB54x."""

from __future__ import annotations

from taskbuilder.diagnostics.entry import Code, Example, within

ENTRIES = {
    "TB541": Code(
        "A robot is not needed",
        "In at least one episode, the team succeeds although one robot holds still throughout. If "
        "this is intended, write `cooperation: optional`.",
        Example(
            "description",
            'success = Near("cube", "goal", within=0.05)',
            'success = Near("cube", "goal", within=0.05) & Moved("tray", by=0.1)',
        ),
    ),
    "TB542": Code(
        "One robot can do the task alone",
        "One robot reached success while all other robots held still. It lifted an object that "
        "the success condition names, brought such an object to a place that the condition names, "
        "or moved a joint that the condition names. If this is intended, write `cooperation: "
        "optional`.",
        Example(
            "description",
            'success = (Near("cube", "goal", within=0.05) & Moved("tray", by=0.1)'
            ' | Near("cube", "lamp", within=0.05))',
            'success = Near("cube", "goal", within=0.05) & Moved("tray", by=0.1)',
        ),
    ),
    "TB543": Code(
        "Random actions succeed",
        "Success becomes true in an episode of random actions, so the success condition is too "
        "weak.",
        Example(
            "description",
            'success = Moved("left.tcp", by=0.1)',
            'success = Near("cube", "goal", within=0.05) & Moved("tray", by=0.1)',
        ),
    ),
    "TB544": Code(
        "Doing nothing succeeds",
        "Success is false at the start, but becomes true while all robots hold still.",
        Example(
            "description",
            'success = Sustained(Near("cube", "table", within=1.0), 1.0)',
            'success = Near("cube", "goal", within=0.05) & Moved("tray", by=0.1)',
        ),
    ),
    "TB545": Code(
        "An object starts within reach of several robots",
        "The task requires cooperation, but an object that the expert grasps with one robot "
        "starts within reach of a second robot. In the simulation, the second robot was able to "
        "grasp it. A policy might learn to do the task with the second robot alone, even if the "
        "single-robot attempts of TB542 fail. Objects that several robots hold or carry together, "
        "or push to each other, may start within reach of all of them. This is a warning.",
        within(
            "scene.objects",
            "cube:\n  shape: {box: [0.045, 0.045, 0.045]}\n  mass: 0.08\n"
            "  grasps: {top: {at: [0, 0, 0.01], across: y}}\n"
            "  place: {surface: table, center: [0, -0.2], size: [0.1, 0.1]}",
            "cube:\n  shape: {box: [0.045, 0.045, 0.045]}\n  mass: 0.08\n"
            "  grasps: {top: {at: [0, 0, 0.01], across: y}}\n"
            "  place: {surface: table, center: [-0.4, -0.2], size: [0.1, 0.1]}",
        ),
    ),
    "TB546": Code(
        "A robot is needed for a clause only",
        "No probe succeeds, but without the clauses of success that are about the missing robots "
        "only, one does: the robots that are there reach everything else, and keep it for half a "
        'second. The others are needed only because success names them, as in `Near("right.tcp", '
        '...)` or `Held(..., by="right")`. If that is the task, such as a robot that has to point '
        "somewhere meanwhile, leave it so. Otherwise, put an object where only this robot gets to "
        "it, or let it hold or carry what the others cannot hold or carry alone. Conditions that "
        "are functions of the description are not taken apart. This is a warning.",
        Example(
            "description",
            'success = Near("cube", "goal", within=0.05) & Near("right.tcp", "lamp", within=0.05)',
            'success = Near("cube", "goal", within=0.05) & Moved("tray", by=0.1)',
        ),
    ),
}
"""Code -> what it stands for."""
