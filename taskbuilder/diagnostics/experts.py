"""Codes of experts: TB51x and TB53x."""

from __future__ import annotations

from taskbuilder.diagnostics.entry import Code, Example, within

ENTRIES = {
    "TB511": Code(
        "The expert needs a pose out of reach",
        "A stage of the expert needs a pose for which inverse kinematics finds no solution within "
        "the joint limits, and the expert also fails when it is played. The finding names the "
        "stage, the robot, and the seed with which the pose is farthest from the robot's "
        "shoulder. It also states how far out of reach the pose is with this seed. If the expert "
        "succeeds without reaching the pose, the finding is only a warning. If another robot "
        "reaches the pose, the finding names it.",
        within(
            "",
            "expert:\n  - {right: {grasp: cube.top}, left: {reach: lamp}}\n"
            "  - {right: {bring: cube, to: goal}}",
            "expert:\n  - {left: {grasp: cube.top}, right: {reach: lamp}}\n"
            "  - {left: {bring: cube, to: goal}}",
        ),
    ),
    "TB512": Code(
        "Suction on nothing",
        "The expert grasps an object by suction, but the grasp point is too far from the surface "
        "of the object, either outside or inside it. The distance is greater than the reach of "
        "the suction cup. The finding says by how much, and which way along its approach, to move "
        "the grasp point onto the surface of the object. Or use a robot with a gripper, as in the "
        "example.",
        within(
            "scene.robots",
            "left:\n  model: ur5e_suction\n  base: {position: [-0.7, 0, 0.4]}\n"
            "  home: {tcp: {position: [-0.35, -0.1, 0.6]}}",
            "left:\n  model: ur5e\n  base: {position: [-0.7, 0, 0.4]}\n"
            "  home: {tcp: {position: [-0.35, -0.1, 0.6]}}",
        ),
    ),
    "TB531": Code(
        "The expert does not succeed reliably",
        "In at least one variation, the expert succeeds on fewer than 95 % of the seeds. The "
        "finding states how often each cause of failure occurred, and the seed and the stage of "
        "the first failure.",
        Example(
            "task",
            "expert:\n  - {left: {grasp: cube.top}, right: {reach: lamp}}",
            "expert:\n  - {left: {grasp: cube.top}, right: {reach: lamp}}\n"
            "  - {left: {bring: cube, to: goal}}",
        ),
    ),
    "TB532": Code(
        "The episode is too short",
        "The expert succeeds on at least 95 % of the seeds only if episodes are longer than "
        "`episode_steps`. The finding states how many control steps the expert needs.",
        within(
            "",
            "timing: {control_hz: 10, physics_hz: 120, episode_steps: 12}",
            "timing: {control_hz: 10, physics_hz: 120, episode_steps: 50}",
        ),
    ),
    "TB533": Code(
        "No expert",
        "The task has no expert, or a robot has an action mode for which the expert cannot plan. "
        "Without an expert that can be played, nothing shows that the task can be done, and "
        "`validate` skips the checks that play the expert. This is a warning.",
        Example(
            "task",
            "expert: []",
            "expert:\n  - {left: {grasp: cube.top}, right: {reach: lamp}}\n"
            "  - {left: {bring: cube, to: goal}}",
        ),
    ),
    "TB534": Code(
        "Variation without effect",
        "The variation does not change the scene of the task, or it gives the same scene as an "
        "earlier variation.",
        Example("task", "variations: [{cube.color: gray}]", "variations: [{cube.color: blue}]"),
    ),
    "TB535": Code(
        "Success does not last",
        "The expert reached success. `validate` then extended the episode by two seconds, in "
        "which all robots held still. At the end of the two seconds, the success condition no "
        "longer held. For example, the load may fly through its goal. A policy could learn to do "
        "the same. Define success as a state that lasts, and let the expert come to rest in this "
        "state. If nothing holds the object and it lies still in films, the physics engine makes "
        "it [twitch](physics.md#objects-that-twitch).",
        Example(
            "description",
            'success = Near("cube", "goal", within=0.05) & ~Stationary("cube", speed=0.02)',
            'success = Sustained(Near("cube", "goal", within=0.05), seconds=1.0)',
        ),
    ),
}
"""Code -> what it stands for."""
