"""Codes of what only playing episodes shows: TB5xx."""

from __future__ import annotations

from taskbuilder.diagnostics.entry import Code, Example, within

_OURS = " No task file is known to fail this; please report one that does."

ENTRIES = {
    "TB501": Code(
        "The same seed gives another episode",
        "Two episodes with the same seed and the same actions differ, in one process and also "
        "in a fresh process. Some code draws from a generator that the seed does not determine,"
        " or reads the clock.",
        Example(
            "module",
            "import random\n\n\n@measure\ndef luck(world):\n    return random.random()\n\n\n"
            "class Example(Description):\n    ...\n    progress = luck()",
            "class Example(Description):\n    ...\n    progress = Closeness('cube', 'goal')",
        ),
    ),
    "TB502": Code(
        "An episode depends on those before it",
        "The same seed and actions give the same episode in two fresh processes, but another "
        "one after other episodes. A description keeps state in a variable of its module. Use "
        "conditions with memory instead, such as Once, Then and Sustained.",
        Example(
            "module",
            "asked = []\n\n\n@measure\ndef longest(world):\n    asked.append(world.time)\n"
            "    return len(asked)\n\n\n"
            "class Example(Description):\n    ...\n    progress = longest()",
            "class Example(Description):\n    ...\n    progress = Closeness('cube', 'goal')",
        ),
    ),
    "TB503": Code(
        "An episode depends on the process",
        "The same seed and actions give the same episode repeatedly in one process, but another"
        " one in a second process. Hashes of strings, the order of sets, id() and the process "
        "id differ between processes.",
        Example(
            "module",
            "@measure\ndef order(world):\n    return hash('cube') % 1000\n\n\n"
            "class Example(Description):\n    ...\n    progress = order()",
            "class Example(Description):\n    ...\n    progress = Closeness('cube', 'goal')",
        ),
    ),
    "TB504": Code(
        "A restored episode goes on differently",
        "An episode was saved and continued, then restored and continued with the same actions,"
        " and the two continuations differ. A description has state that is not saved. Use "
        "conditions with memory instead, such as Once, Then and Sustained.",
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
        "After the description was evaluated, positions, velocities or motor commands had "
        "changed. A description must only read the world.",
        Example(
            "module",
            "@condition\ndef freed(world):\n"
            "    world.objects['cube'].body.place(world.pose('goal'))\n    return False\n\n\n"
            "class Example(Description):\n    ...\n    failure = freed()",
            "class Example(Description):\n    ...\n    failure = Below('cube', height=0.3)",
        ),
    ),
    "TB511": Code(
        "The expert asks for what a robot cannot reach",
        "For some placement, no joint positions within the limits bring the robot's tcp to a "
        "pose that a stage of the expert needs, and the expert fails there too. The finding "
        "names the seed, the stage and the robot, and how far the pose is out of reach. If the "
        "expert succeeds before that stage, it is a warning.",
        within(
            "",
            "expert:\n  - {right: {grasp: cube.top}, left: {reach: lamp}}\n"
            "  - {right: {bring: cube, to: goal}}",
            "expert:\n  - {left: {grasp: cube.top}, right: {reach: lamp}}\n"
            "  - {left: {bring: cube, to: goal}}",
        ),
    ),
    "TB521": Code(
        "PettingZoo's test of the parallel API",
        "`parallel_api_test` refuses the environment of the task." + _OURS,
    ),
    "TB522": Code(
        "PettingZoo's tests of the turn-based view",
        "`api_test` or `seed_test` refuses the turn-based view of the environment." + _OURS,
    ),
    "TB523": Code(
        "Gymnasium's test of the joint view",
        "`check_env` refuses the joint view of the environment. An episode of a single step is "
        "one reason.",
        within(
            "",
            "timing: {control_hz: 10, physics_hz: 120, episode_steps: 1}",
            "timing: {control_hz: 10, physics_hz: 120, episode_steps: 50}",
        ),
    ),
    "TB524": Code(
        "Observation outside its space",
        "An observation has another shape or type than its space, exceeds its bounds, or is not"
        " a number. Observations are clipped to their bounds. No task file is known to fail "
        "this, except for a description that manipulates the values of the world.",
    ),
    "TB525": Code(
        "Observation that does not vary",
        "An agent's observation is the same at every step of whole episodes, or the same in "
        "every episode although objects are placed at random. In both cases the agent cannot "
        "learn from it.",
        Example(
            "task",
            "observe: {left: [goal.position], right: [self.tcp, cube.position]}",
            "observe: {left: [self.tcp, cube.position], right: [self.tcp, cube.position]}",
        ),
    ),
    "TB526": Code(
        "Observations that are not each agent's own",
        "Two agents have exactly the same observations and neither observes itself, so that "
        "neither can tell which one it is. Or writing into an observation changes another one, "
        "or the episode.",
        Example(
            "task",
            "observe: {left: [cube.pose, time_left], right: [cube.pose, time_left]}",
            "observe: {left: [self.tcp, cube.pose], right: [self.tcp, cube.pose]}",
        ),
    ),
    "TB527": Code(
        "Space that is made anew at every call",
        "observation_space or action_space of an agent returns another object at every call, so"
        " that seeding it has no effect." + _OURS,
    ),
    "TB531": Code(
        "The expert does not succeed",
        "The task's own expert succeeds from fewer than 95 % of the seeds. The finding counts "
        "what keeps it from succeeding, and names the first seed and stage.",
        Example(
            "task",
            "expert:\n  - {left: {grasp: cube.top}, right: {reach: lamp}}",
            "expert:\n  - {left: {grasp: cube.top}, right: {reach: lamp}}\n"
            "  - {left: {bring: cube, to: goal}}",
        ),
    ),
    "TB532": Code(
        "The episode is too short",
        "The expert succeeds from enough seeds if episodes are longer, but not within "
        "timing.episode_steps. The finding says how many steps it takes.",
        within(
            "",
            "timing: {control_hz: 10, physics_hz: 120, episode_steps: 12}",
            "timing: {control_hz: 10, physics_hz: 120, episode_steps: 50}",
        ),
    ),
    "TB533": Code(
        "No expert",
        "The task has no expert, so nothing shows that it can be done, and checks that play the"
        " expert are skipped. A warning.",
        Example(
            "task",
            "expert: []",
            "expert:\n  - {left: {grasp: cube.top}, right: {reach: lamp}}\n"
            "  - {left: {bring: cube, to: goal}}",
        ),
    ),
    "TB534": Code(
        "Variation that changes nothing",
        "The scene of a variation is the same as that of the task as written, or of another "
        "variation.",
        Example("task", "variations: [{cube.color: gray}]", "variations: [{cube.color: blue}]"),
    ),
    "TB535": Code(
        "Success passes",
        "The success of the expert does not last for two seconds in which all robots hold "
        "still, for example because the load flies through its goal. A learner would learn to "
        "pass through the goal, too. Require a state that lasts, and let the expert come to "
        "rest in it.",
        Example(
            "description",
            'success = Near("cube", "goal", within=0.05) & ~Stationary("cube", speed=0.02)',
            'success = Sustained(Near("cube", "goal", within=0.05), seconds=1.0)',
        ),
    ),
    "TB541": Code(
        "A robot is not needed",
        "The others succeed while one robot stays at home and its orders are left out. If that "
        "is intended, write cooperation: optional.",
        Example(
            "description",
            'success = Near("cube", "goal", within=0.05)',
            'success = Near("cube", "goal", within=0.05) & Near("right.tcp", "lamp", within=0.05)',
        ),
    ),
    "TB542": Code(
        "One robot can do it alone",
        "One robot succeeds alone by taking an object in the success condition to a place in "
        "the condition, in another way than the expert. If that is intended, write cooperation:"
        " optional.",
        Example(
            "description",
            'success = (Near("cube", "goal", within=0.05) & Near("right.tcp", "lamp", within=0.05)'
            ' | Near("cube", "lamp", within=0.05))',
            'success = Near("cube", "goal", within=0.05) & Near("right.tcp", "lamp", within=0.05)',
        ),
    ),
    "TB543": Code(
        "Random play succeeds",
        "Success becomes true in an episode of random actions. The condition is too weak.",
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
        "An object starts in the reach of both arms",
        "Cooperation is required, and an object that one robot has to fetch starts where "
        "another could fetch it. No single robot succeeded, but a better policy may. Objects "
        "that several robots take or carry together, or push to each other, may start in the "
        "reach of all of them. A warning.",
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
        "Reward term that is not finite, or huge",
        "A reward term is not a finite number, or is more than a million at one control step, "
        "where single precision loses the other terms.",
        Example(
            "description",
            'reward = (Distance("carry", "cube", "goal", 1e8), Distance("point", "right.tcp", '
            '"lamp"))',
            'reward = (Distance("carry", "cube", "goal", 1.0), Distance("point", "right.tcp", '
            '"lamp"))',
        ),
    ),
    "TB552": Code(
        "Stalling pays better than going on",
        "Holding still forever after one of the expert's stages earns as much as the expert, or"
        " the played episodes do not show otherwise: the interval of the difference, pair by "
        "pair on the same seeds, includes zero. A learner would stop there. Give more reward "
        "for later stages, or less for earlier ones.",
        Example(
            "description",
            'reward = (Bonus("hold", Held("cube") & ~success, 1.0), Bonus("done", success, 0.1))',
            'reward = (Bonus("hold", Held("cube") & ~success, 1.0), Bonus("done", success, 4.0))',
        ),
    ),
    "TB553": Code(
        "Doing nothing or anything pays as well",
        "Holding still from the start, or random actions, earn as much as the expert, or the "
        "played episodes do not show otherwise.",
        Example(
            "description",
            'reward = (Distance("carry", "cube", "goal", -1.0), Bonus("done", success, 0.1))',
            'reward = (Distance("carry", "cube", "goal", 1.0), Bonus("done", success, 1.0))',
        ),
    ),
    "TB554": Code(
        "Leaving out a robot pays as well",
        "The others earn as much as the expert while one robot stays at home, although "
        "cooperation is required: a learner would leave that robot idle.",
        Example(
            "description",
            'reward = (Distance("carry", "cube", "goal", 4.0), Distance("rest", "right.tcp", '
            '"right.base"))',
            'reward = (Distance("carry", "cube", "goal", 4.0), Distance("point", "right.tcp", '
            '"lamp"))',
        ),
    ),
    "TB555": Code(
        "Failing on purpose pays as well",
        "Dropping a held object, or throwing it away, after one of the expert's stages earns as"
        " much as the expert. If failure ends the episode, it may also end negative rewards.",
        Example(
            "description",
            'reward = (Distance("carry", "cube", "goal"), Distance("point", "right.tcp", "lamp"), '
            'Bonus("let go", Once(Held("cube")) & Released("cube"), 5.0))',
            'reward = (Distance("carry", "cube", "goal"), Distance("point", "right.tcp", "lamp"), '
            'Bonus("let go", success & Released("cube"), 5.0))',
        ),
    ),
    "TB561": Code(
        "What it costs",
        "Figures without a verdict: control steps a second, what a control step costs beyond its "
        "physics steps, and how long a reset and building the world take.",
    ),
    "TB571": Code(
        "Render gives no picture",
        "`render` returns nothing, something other than (height, width, 3) of uint8, or a "
        "picture of a single colour." + _OURS,
    ),
    "TB572": Code(
        "Resets keep memory",
        "Each reset keeps saved states, or more than 100 KB, that no later one frees: training "
        "would run out of memory." + _OURS,
    ),
    "TB573": Code(
        "An episode that does not end",
        "The episode continues after its last control step." + _OURS,
    ),
    "TB574": Code(
        "An agent sees nothing",
        "An agent has no observation, or an empty one, and cannot learn from it.",
        Example(
            "task",
            "observe: {left: [], right: [self.tcp, cube.position]}",
            "observe: {left: [self.tcp], right: [self.tcp, cube.position]}",
        ),
    ),
    "TB575": Code(
        "The seed does not decide",
        "The same seed and actions gave another episode in the same environment, or another "
        "episode after it; or all seeds gave the same episode although objects are placed at "
        "random." + _OURS,
    ),
    "TB576": Code(
        "Reward that is no finite number",
        "The reward of an agent is not a finite number." + _OURS,
    ),
}
"""Code -> what it stands for."""
