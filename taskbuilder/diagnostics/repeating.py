"""Codes of episodes that do not repeat: TB50x."""

from __future__ import annotations

from taskbuilder.diagnostics.entry import Code, Example

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
        "instead, such as `Once`, `Then` and `Sustained`.",
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
}
"""Code -> what it stands for."""
