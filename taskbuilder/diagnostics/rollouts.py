"""Codes of what only playing episodes shows: TB5xx."""

from __future__ import annotations

from taskbuilder.diagnostics.entry import Code, Example, within

_OURS = " No known task fails this check. If yours does, please report it."

ENTRIES = {
    "TB501": Code(
        "Episodes differ for the same seed",
        "Two episodes with the same seed and the same actions differ, whether they are played in "
        "the same process or in different processes. Something in the description uses a "
        "random-number generator that is not seeded from the episode's seed, or reads the clock.",
        Example(
            "module",
            "import random\n\n\n@measure\ndef luck(world):\n    return random.random()\n\n\n"
            "class Example(Description):\n    ...\n    progress = luck()",
            "class Example(Description):\n    ...\n    progress = Closeness('cube', 'goal')",
        ),
    ),
    "TB502": Code(
        "Episodes depend on earlier ones",
        "With the same seed and actions, two new processes give the same episode, but a process "
        "that has already played other episodes gives a different one. The usual cause is a "
        "description that keeps state in a module-level variable. Use conditions with memory "
        "instead, such as `Once`, `Then` and `Sustained`. Another cause is that several loose "
        "objects lie against each other on a moving link of an articulated object. Between such "
        "objects, the physics engine keeps contacts from earlier episodes. Place the objects "
        "apart from each other at the start, or use fewer of them.",
        Example(
            "module",
            "asked = []\n\n\n@measure\ndef longest(world):\n    asked.append(world.time)\n"
            "    return len(asked)\n\n\n"
            "class Example(Description):\n    ...\n    progress = longest()",
            "class Example(Description):\n    ...\n    progress = Closeness('cube', 'goal')",
        ),
    ),
    "TB503": Code(
        "Episodes depend on the process",
        "With the same seed and actions, episodes are the same within one process, but differ "
        "between processes. The usual cause is a description that depends on values that differ "
        "between processes: string hashes, the order of sets, `id()`, or the process id.",
        Example(
            "module",
            "@measure\ndef order(world):\n    return hash('cube') % 1000\n\n\n"
            "class Example(Description):\n    ...\n    progress = order()",
            "class Example(Description):\n    ...\n    progress = Closeness('cube', 'goal')",
        ),
    ),
    "TB504": Code(
        "Restored episodes continue differently",
        "An episode was saved and continued, then restored and continued with the same actions. "
        "The two continuations differ. The usual cause is a description that keeps state in a "
        "module-level variable, which is not saved. Use conditions with memory instead, such as "
        "`Once`, `Then` and `Sustained`. If the message says that it is not the cause, report it.",
        Example(
            "module",
            "highest = []\n\n\n@measure\ndef record(world):\n    if world.time == 0:\n"
            "        highest.clear()\n    highest.append(world.position('left.tcp')[2])\n"
            "    return max(highest)\n\n\n"
            "class Example(Description):\n    ...\n    progress = record()",
            "class Example(Description):\n    ...\n    progress = Closeness('cube', 'goal')",
        ),
    ),
    "TB505": Code(
        "The description changes the world",
        "Evaluating the description changed positions, velocities or motor commands. A description "
        "must only read the world.",
        Example(
            "module",
            "@condition\ndef freed(world):\n"
            "    world.objects['cube'].body.place(world.pose('goal'))\n    return False\n\n\n"
            "class Example(Description):\n    ...\n    failure = freed()",
            "class Example(Description):\n    ...\n    failure = Below('cube', height=0.3)",
        ),
    ),
    "TB511": Code(
        "The expert needs a pose out of reach",
        "A stage of the expert needs a pose for which inverse kinematics finds no solution within "
        "the joint limits, and the expert also fails when it is played. The finding names the "
        "stage, the robot, and the seed with which the pose is farthest from the robot's "
        "shoulder. It also states how far out of reach the pose is with this seed. If the expert "
        "succeeds without reaching the pose, the finding is only a warning.",
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
        "the suction cup. Put the grasp point on the surface of the object, on the side from "
        "which the tool approaches. Or use a robot with a gripper, as in the example.",
        within(
            "scene.robots",
            "left:\n  model: ur5e_suction\n  base: {position: [-0.7, 0, 0.4]}\n"
            "  home: {tcp: {position: [-0.35, -0.1, 0.6]}}",
            "left:\n  model: ur5e\n  base: {position: [-0.7, 0, 0.4]}\n"
            "  home: {tcp: {position: [-0.35, -0.1, 0.6]}}",
        ),
    ),
    "TB521": Code(
        "PettingZoo's parallel API test",
        "`parallel_api_test` fails on the environment of the task." + _OURS,
    ),
    "TB522": Code(
        "PettingZoo's AEC tests",
        "`api_test` or `seed_test` fails on the turn-based (AEC) environment of the task." + _OURS,
    ),
    "TB523": Code(
        "Gymnasium's environment checker",
        "`check_env` fails on the joint environment (`JointEnv`), in which one agent controls all "
        "robots. For example, it fails if an episode has only one control step.",
        within(
            "",
            "timing: {control_hz: 10, physics_hz: 120, episode_steps: 1}",
            "timing: {control_hz: 10, physics_hz: 120, episode_steps: 50}",
        ),
    ),
    "TB524": Code(
        "Observation outside its space",
        "An observation does not have the shape or dtype of its space, lies outside the bounds of "
        "the space, or contains NaN. taskbuilder clips observations to these bounds. No known "
        "task fails this check unless its description changes values of the world.",
    ),
    "TB525": Code(
        "Constant observation",
        "The observation of an agent never changes during an episode. Or, when the same actions "
        "are played, the agent's observations are the same in every episode, although the initial "
        "positions differ. The agent cannot learn from such observations.",
        Example(
            "task",
            "observe: {left: [goal.position], right: [self.tcp, cube.position]}",
            "observe: {left: [self.tcp, cube.position], right: [self.tcp, cube.position]}",
        ),
    ),
    "TB526": Code(
        "Observations shared between agents",
        "Two agents have exactly the same observations and neither observes itself, so neither "
        "agent can tell which of the two it is. Or observations share memory. Then writing into "
        "one observation changes another observation or the episode, or the next step changes an "
        "observation that was returned earlier.",
        Example(
            "task",
            "observe: {left: [cube.pose, time_left], right: [cube.pose, time_left]}",
            "observe: {left: [self.tcp, cube.pose], right: [self.tcp, cube.pose]}",
        ),
    ),
    "TB527": Code(
        "Space recreated on every call",
        "`observation_space` or `action_space` returns a new object on every call, so seeding the "
        "space has no effect." + _OURS,
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
        "state.",
        Example(
            "description",
            'success = Near("cube", "goal", within=0.05) & ~Stationary("cube", speed=0.02)',
            'success = Sustained(Near("cube", "goal", within=0.05), seconds=1.0)',
        ),
    ),
    "TB541": Code(
        "A robot is not needed",
        "In at least one episode, the team succeeds although one robot holds still throughout. If "
        "this is intended, write `cooperation: optional`.",
        Example(
            "description",
            'success = Near("cube", "goal", within=0.05)',
            'success = Near("cube", "goal", within=0.05) & Near("right.tcp", "lamp", within=0.05)',
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
            'success = (Near("cube", "goal", within=0.05) & Near("right.tcp", "lamp", within=0.05)'
            ' | Near("cube", "lamp", within=0.05))',
            'success = Near("cube", "goal", within=0.05) & Near("right.tcp", "lamp", within=0.05)',
        ),
    ),
    "TB543": Code(
        "Random actions succeed",
        "Success becomes true in an episode of random actions, so the success condition is too "
        "weak.",
        Example(
            "description",
            'success = Moved("left.tcp", by=0.1)',
            'success = Near("cube", "goal", within=0.05) & Near("right.tcp", "lamp", within=0.05)',
        ),
    ),
    "TB544": Code(
        "Doing nothing succeeds",
        "Success is false at the start, but becomes true while all robots hold still.",
        Example(
            "description",
            'success = Sustained(Near("cube", "table", within=1.0), 1.0)',
            'success = Near("cube", "goal", within=0.05) & Near("right.tcp", "lamp", within=0.05)',
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
    "TB551": Code(
        "Reward term not finite or too large",
        "A reward term is not a finite number, or its absolute value exceeds one million at a "
        "control step. Next to such a large term, the other terms would be lost to rounding in "
        "single precision.",
        Example(
            "description",
            'reward = (Distance("carry", "cube", "goal", 1e8), Distance("point", "right.tcp", '
            '"lamp"))',
            'reward = (Distance("carry", "cube", "goal", 1.0), Distance("point", "right.tcp", '
            '"lamp"))',
        ),
    ),
    "TB552": Code(
        "Stalling earns as much as continuing",
        "If all robots hold still after one of the expert's stages, they do not earn "
        "significantly less than the expert. A learner would stop after this stage. To test "
        "significance, `validate` compares the returns of episodes with the same seed in pairs. "
        "The 95 % confidence interval of the expert's mean lead must lie above zero. Give more "
        "reward for later stages, or less for earlier ones.",
        Example(
            "description",
            'reward = (Bonus("hold", Held("cube") & ~success, 1.0), Bonus("done", success, 0.1))',
            'reward = (Bonus("hold", Held("cube") & ~success, 1.0), Bonus("done", success, 4.0))',
        ),
    ),
    "TB553": Code(
        "Doing nothing or acting at random earns as much",
        "Holding still from the start, or acting at random, does not earn significantly less than "
        "the expert (see TB552).",
        Example(
            "description",
            'reward = (Distance("carry", "cube", "goal", -1.0), Bonus("done", success, 0.1))',
            'reward = (Distance("carry", "cube", "goal", 1.0), Bonus("done", success, 1.0))',
        ),
    ),
    "TB554": Code(
        "Leaving out a robot earns as much",
        "The task requires cooperation, but with one robot holding still, the team does not earn "
        "significantly less than the expert (see TB552). A learner would leave that robot idle.",
        Example(
            "description",
            'reward = (Distance("carry", "cube", "goal", 4.0), Distance("rest", "right.tcp", '
            '"right.base"))',
            'reward = (Distance("carry", "cube", "goal", 4.0), Distance("point", "right.tcp", '
            '"lamp"))',
        ),
    ),
    "TB555": Code(
        "Failing on purpose earns as much",
        "Dropping or throwing the held objects after one of the expert's stages does not earn "
        "significantly less than the expert (see TB552). To drop the objects, all robots open "
        "their grippers. To throw them, all arms swing sideways at full speed, and the grippers "
        "open during the swing. Each of the two is played on half of the seeds. Episodes that "
        "succeed nevertheless are not compared. A possible cause is a bonus that is also paid "
        "after a failure. In this case, write `Bonus(..., done & ~Once(failure))`. Another "
        "possible cause is a failure that ends the episode and so avoids negative rewards.",
        Example(
            "description",
            'reward = (Distance("carry", "cube", "goal"), Distance("point", "right.tcp", "lamp"), '
            'Bonus("let go", Once(Held("cube")) & Released("cube"), 5.0))',
            'reward = (Distance("carry", "cube", "goal"), Distance("point", "right.tcp", "lamp"), '
            'Bonus("let go", success & Released("cube"), 5.0))',
        ),
    ),
    "TB556": Code(
        "Progress is higher before success",
        "In an episode in which the expert succeeds, the description's `progress` is lower at "
        "success than at an earlier control step. A training reward based on progress would then "
        "pay nothing for the last step to success, or even penalise it. A common cause is a rung "
        "of a `Ladder` that is worth less than the rung below it, or whose condition does not "
        "hold at success.",
        Example(
            "description",
            'progress = Ladder(Closeness("left.tcp", "cube"), (Held("cube"), 3.0), (success, 2.0))',
            'progress = Ladder(Closeness("left.tcp", "cube"), (Held("cube"), 2.0), (success, 3.0))',
        ),
    ),
    "TB557": Code(
        "Setback although the expert succeeds",
        "The description's `setback` holds in an episode in which the expert succeeds. A setback "
        "can end a training episode with a penalty, so training would punish the robots for what "
        "the expert does. In the wrong example, `Sustained` measures the time from the start of "
        "the episode and not from the grasp, so `Then` may hold as soon as the cube is grasped.",
        Example(
            "description",
            'setback = Then(Held("cube"), Sustained(~success, seconds=2.0))',
            'setback = Sustained(Once(Held("cube")) & ~success, seconds=2.0)',
        ),
    ),
    "TB561": Code(
        "Speed and cost",
        "Three measurements, which neither pass nor fail. The first is the number of control "
        "steps per second. The second is the overhead of a control step: the time that it takes "
        "in addition to its physics steps, as a multiple of the duration of one physics step. The "
        "third is the median duration of a reset.",
    ),
}
