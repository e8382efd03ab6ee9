"""A Sphinx extension: parts of pages that are made from the library itself, at build time.

A line ``% generated: NAME ARGUMENT`` in a page is replaced by what the generator of that name
returns, as MyST Markdown. So tables of keys, help texts and task pages cannot go stale.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any

from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.errors import ExtensionError

from generators import api, codes, commands, keys, results, robots, tasks, vocabulary

GENERATORS: Mapping[str, Callable[[str], str]] = {
    "api": api.names,
    "channels": vocabulary.channels,
    "codes": codes.entries,
    "colours": keys.colours,
    "commands": commands.helps,
    "experts": results.experts,
    "gallery": tasks.gallery,
    "keys": keys.table,
    "kinds": vocabulary.kinds,
    "learning": results.learning,
    "manners": keys.manners,
    "nodes": vocabulary.nodes,
    "probes": results.probes,
    "robots": robots.library,
    "scaffold": commands.scaffold,
    "task": tasks.page,
    "verbs": keys.verbs,
    "view": vocabulary.view,
    "zoo": results.zoo,
}

_MARK = re.compile(r"^% generated: (\w+)(?: (.*))?$", re.MULTILINE)


def fill(page: str, text: str) -> str:
    """The text of a page with every mark replaced by what it asks for.

    Raises:
        ExtensionError: There is no such generator, or it found the page out of step.
    """

    def made(mark: re.Match[str]) -> str:
        try:
            return GENERATORS[mark[1]](mark[2] or "")
        except (LookupError, ValueError) as error:
            raise ExtensionError(f'{page}: "{mark[0]}": {error!r}') from error

    return _MARK.sub(made, text)


def _on_source(_: Sphinx, page: str, source: list[str]) -> None:
    source[0] = fill(page, source[0])


def _all_pages(
    _: Sphinx, env: BuildEnvironment, *__: Any
) -> list[str]:  # what they are made from is not among the files that Sphinx watches
    return sorted(env.found_docs)


def _escape_bars(_: Sphinx, *args: Any) -> None:
    """Let ``|a - b|`` in the prose of a docstring be a length, not a substitution."""
    lines: list[str] = args[-1]
    for index, line in enumerate(lines):
        if not line.startswith("    "):
            parts = re.split(r"(``.*?``)", line)
            parts[::2] = [part.replace("|", "\\|") for part in parts[::2]]
            lines[index] = "".join(parts)


def setup(app: Sphinx) -> dict[str, Any]:
    """Called by Sphinx."""
    app.connect("source-read", _on_source)
    app.connect("env-get-outdated", _all_pages)
    app.connect("autodoc-process-docstring", _escape_bars)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
