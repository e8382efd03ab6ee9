"""Tools for coding agents: what they may do with the tasks in one folder.

    python -m taskbuilder mcp --dir tasks

Each tool runs a command of the command line in the folder and returns what the command prints as
JSON. The commands run in child processes, so that a task that crashes or hangs ends nothing else.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

from taskbuilder._version import __version__
from taskbuilder.errors import TaskbuilderError, UsageError, display_path
from taskbuilder.extras import extra_needed

if TYPE_CHECKING:
    from mcp.server import MCPServer

LONGEST_S = 1800.0
"""Seconds after which a command is stopped."""

MOST_CHARACTERS = 200_000
"""Characters of a command's output that are returned at most."""

INSTRUCTIONS = """\
Write robot manipulation tasks: a task is NAME.yaml (the scene and the script of an expert) and
NAME.py (success and reward). Begin with new_task, edit the two files, and repeat: check_task until
it has no findings (fix_task corrects what is misspelt), render_task and look at the picture,
demo_task until the expert succeeds, validate_task with quick=true, and at the end validate_task
with quick=false, which proves the task. explain says what a code, a condition or a key means.\
"""

_NAME = re.compile(r"[a-z][a-z0-9_]*(/[a-z][a-z0-9_]*)?")


@dataclass(frozen=True)
class TaskTools:
    """The tools.

    Attributes:
        folder: The folder with the tasks. Nothing is written elsewhere.
    """

    folder: Path

    def list_tasks(self) -> str:
        """List the tasks in the folder and those of the library, each with a summary."""
        return self._run("list", "--json")

    def show_task(self, task: str) -> str:
        """Show the files of a task, such as one of the library to learn from.

        Args:
            task: Name of a task, or path of its YAML file in the folder.
        """
        from taskbuilder.schema.catalogue import Catalogue

        entry = Catalogue.discover([self.folder]).task(self._named(task))
        files = [file for file in (entry.file, entry.description_file) if file.is_file()]
        return "\n\n".join(f"# {file.name}\n{file.read_text(encoding='utf-8')}" for file in files)

    def new_task(self, name: str, robots: int = 2) -> str:
        """Write the files of a new task, a sound example to start from.

        Args:
            name: Name of the task, such as stack_cubes.
            robots: Number of robots, 1 to 6.
        """
        if not _NAME.fullmatch(name) or "/" in name:
            raise UsageError(f'"{name}" is no name of a task; write it as in stack_cubes')
        return self._run("new", name, "--robots", str(robots))

    def check_task(self, task: str) -> str:
        """Check both files of a task without physics, in a second; findings have line and column.

        Args:
            task: Name of a task, or path of its YAML file in the folder.
        """
        return self._run("validate", self._named(task), "--level", "static", "--json")

    def fix_task(self, task: str) -> str:
        """Correct misspelt keys, choices and names in the files of a task; returns the difference.

        Args:
            task: Name of a task, or path of its YAML file in the folder.
        """
        return self._run("fix", self._named(task), "--yes")

    def render_task(self, task: str, show: str = "", seed: int = 0) -> list[Any]:
        """Render the first state of an episode from all cameras of the scene.

        Args:
            task: Name of a task, or path of its YAML file in the folder.
            show: What to draw over the picture, with commas between: frames, grasps, sites,
                regions, cameras, reach.
            seed: Seed of the episode.
        """
        from mcp.server.mcpserver import Image

        options = ["--seed", str(seed), *(["--show", *show.split(",")] if show else [])]
        printed = self._run("render", self._named(task), *options, "--json")
        files = [self.folder / file for file in json.loads(printed)["files"]]
        return [printed, Image(path=max(files, key=lambda file: "sheet" in file.name))]

    def demo_task(self, task: str, seed: int = 0) -> str:
        """Play a task once with its expert; says how far it came and why it stopped.

        Args:
            task: Name of a task, or path of its YAML file in the folder.
            seed: Seed of the episode.
        """
        return self._run("demo", self._named(task), "--seed", str(seed), "--json")

    def validate_task(self, task: str, quick: bool = True) -> str:
        """Play a task in many ways and report faults; without `quick`, this is a proof.

        Args:
            task: Name of a task, or path of its YAML file in the folder.
            quick: Use five seeds per variation in place of forty.
        """
        return self._run("validate", self._named(task), *(["--quick"] if quick else []), "--json")

    def explain(self, name: str) -> str:
        """Explain a code such as TB305, a condition, a verb, a channel or a key of task files.

        Args:
            name: The code or word.
        """
        return self._run("explain", "--json", "--", name)

    def _named(self, task: str) -> str:
        """The task as commands take it.

        Raises:
            UsageError: It is a path that leads out of the folder.
        """
        if _NAME.fullmatch(task):
            return task
        path = (self.folder / task).resolve()
        if not path.is_relative_to(self.folder.resolve()):
            raise UsageError(f'"{task}" lies outside the folder {display_path(self.folder)}')
        return str(path)

    def _run(self, *words: str) -> str:
        """What a command prints; findings are a result, and not an error.

        Raises:
            UsageError: The command was refused, or took too long.
        """
        command, *rest = words
        words = (command, "--task-path", ".", *rest)
        try:
            ran = subprocess.run(
                [sys.executable, "-P", "-m", "taskbuilder", *words],
                cwd=self.folder,
                stdin=subprocess.DEVNULL,
                capture_output=True,
                text=True,
                errors="replace",
                timeout=LONGEST_S,
                check=False,
            )
        except subprocess.TimeoutExpired:
            raise UsageError(f"{command} did not end within {LONGEST_S / 60:.0f} minutes") from None
        if ran.returncode > 1 or not ran.stdout:
            raise UsageError(ran.stderr.strip()[-MOST_CHARACTERS:] or f"{command} failed")
        return ran.stdout[:MOST_CHARACTERS]


def make_server(folder: Path) -> MCPServer[Any]:
    """A server of the Model Context Protocol with the tools of a folder.

    Raises:
        UsageError: The extra `mcp` is not installed, or there is no such folder.
    """
    with extra_needed("mcp", "serving coding agents"):
        from mcp.server import MCPServer
    if not folder.is_dir():
        raise UsageError(f"there is no folder {display_path(folder)}; make it first")
    server: MCPServer[Any] = MCPServer(
        "taskbuilder", instructions=INSTRUCTIONS, version=__version__, log_level="WARNING"
    )
    tools = TaskTools(folder.resolve())
    for name, tool in vars(TaskTools).items():
        if callable(tool) and not name.startswith("_"):
            server.add_tool(_said(getattr(tools, name)), structured_output=False)
    return server


def _said(tool: Callable[..., Any]) -> Callable[..., Any]:
    """The tool; its errors reach the agent as they are, and are not logged as defects."""
    from mcp.server.mcpserver.exceptions import ToolError

    @wraps(tool)
    def call(*arguments: Any, **named: Any) -> Any:
        try:
            return tool(*arguments, **named)
        except TaskbuilderError as error:
            raise ToolError(str(error)) from None

    return call
