"""`taskbuilder view`."""

from __future__ import annotations

import argparse
import sys
import webbrowser
from contextlib import ExitStack, closing
from pathlib import Path
from typing import TYPE_CHECKING

from taskbuilder.cli.tasks import catalogue_of
from taskbuilder.errors import FileError, UsageError, display_path

if TYPE_CHECKING:
    from taskbuilder.view.stage import Choice, Stage


def run(arguments: argparse.Namespace) -> int:
    """Show a task on a page in the browser, until Ctrl-C; or write an episode as a page."""
    from taskbuilder.view.page import LivePage
    from taskbuilder.view.server import PageServer
    from taskbuilder.view.stage import Choice, Stage

    stage = Stage(
        arguments.task,
        catalogue_of(arguments),
        record=arguments.record,
        horizon=arguments.horizon,
    )
    choice = Choice(arguments.policy or stage.players[0], arguments.seed, arguments.variation)
    if arguments.export:
        return _export(stage, choice, arguments.export)
    with ExitStack() as opened:
        server = opened.enter_context(
            closing(PageServer(arguments.port, arguments.host, notify=_TerminalNotifier()))
        )
        # The address comes first: a browser loads the page while the scene is built.
        print(f"{server.address} shows {arguments.task}; Ctrl-C ends it", flush=True)
        if server.gate.token:
            print(
                "whoever has this address can watch, steer and write the task file, and what is "
                "sent is not encrypted: use it in a network that you trust",
                flush=True,
            )
        if arguments.open:
            webbrowser.open(server.address)
        try:
            page = opened.enter_context(closing(LivePage(stage, server, choice)))
            page.run()
        except KeyboardInterrupt:
            print("\nclosed the page")
    return 0


class _TerminalNotifier:
    """Prints messages on standard error; the same one again is printed once."""

    def __init__(self) -> None:
        self._last = ""

    def __call__(self, words: str) -> None:
        if words != self._last:
            print(words, file=sys.stderr, flush=True)
        self._last = words


def _export(stage: Stage, choice: Choice, file: Path) -> int:
    """Write an episode as a page that needs no server."""
    from taskbuilder.view.export import export

    if stage.task is None:
        raise FileError(stage.findings)
    if not file.parent.is_dir():
        raise UsageError(f"there is no folder {display_path(file.parent)}")
    recording = stage.play(choice, lambda _: None)
    with closing(stage.env(choice)) as env:
        export(env.episode.world, recording, file)
    print(f"{display_path(file)}: {recording.player}, seed {choice.seed}: {recording.verdict()}")
    return 0
