"""Parts of pages that are made from the library itself.

A page has them between two comments::

    <!-- generated: keys ObjectSpec -->
    …
    <!-- end -->

``make docs`` writes them anew, in place, so that the pages are whole wherever they are read; a
test keeps them true.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path

from generators import (
    api,
    commands,
    disturbances,
    imports,
    leaderboard,
    objects,
    options,
    results,
    robots,
    suites,
    swaps,
    tasks,
    training,
)
from taskbuilder.reference import codes, keys, vocabulary

DOCS = Path(__file__).resolve().parents[1]

GENERATORS: Mapping[str, Callable[[str], str]] = {
    "algorithms": training.algorithms,
    "api": api.names,
    "channels": vocabulary.channels,
    "cloning": training.cloning,
    "collecting": results.collecting,
    "codes": codes.entries,
    "colours": keys.colours,
    "commands": commands.helps,
    "deadlock": training.deadlock,
    "disturbances": disturbances.axes,
    "disturbed": disturbances.measured,
    "distillation": training.distillation,
    "experts": results.experts,
    "file": tasks.shown_file,
    "fingers": robots.fingers,
    "gallery": tasks.gallery,
    "holding": results.holding,
    "install_sizes": results.install_sizes,
    "imports": imports.files,
    "keys": keys.table,
    "household": objects.household,
    "kinds": vocabulary.kinds,
    "lasting": training.lasting,
    "leaderboard": leaderboard.rows,
    "learning": training.learning,
    "manners": keys.manners,
    "options": options.options,
    "decisive": options.decisive,
    "own": swaps.own,
    "nodes": vocabulary.nodes,
    "objects": objects.library,
    "phases": training.phases,
    "probes": results.probes,
    "proof_times": results.proof_times,
    "recovery": training.recovery,
    "robots": robots.library,
    "scaffold": commands.scaffold,
    "robust": training.robust,
    "solver": results.solver,
    "stopping": results.stopping,
    "stopping_verdicts": results.stopping_verdicts,
    "proofs_elsewhere": results.proofs_elsewhere,
    "suite_tasks": suites.tasks,
    "suites": suites.over,
    "swaps": swaps.swaps,
    "task": tasks.page,
    "verbs": keys.verbs,
    "view": vocabulary.view,
    "whole_scene": training.whole_scene,
    "zoo": training.zoo,
}

_BLOCK = re.compile(
    r"^<!-- generated: (\w+)(?: ([^\n]+?))? -->\n.*?^<!-- end -->$", re.MULTILINE | re.DOTALL
)


def pages() -> list[Path]:
    """The README and every page of the documentation."""
    docs = sorted(page for page in DOCS.rglob("*.md") if "_build" not in page.parts)
    return [DOCS.parent / "README.md", *docs]


def fill(text: str) -> str:
    """The text of a page with every generated part made anew.

    Raises:
        LookupError: There is no such generator, or it was asked for what does not exist.
        ValueError: A generator found the page out of step with the library.
    """

    def made(block: re.Match[str]) -> str:
        opening = block[0].partition("\n")[0]
        return f"{opening}\n\n{GENERATORS[block[1]](block[2] or '')}\n\n<!-- end -->"

    return _BLOCK.sub(made, text)
