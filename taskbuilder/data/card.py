"""The card of a data set: a README for people, with a header that the Hugging Face Hub reads."""

from __future__ import annotations

import html
import json
import re
from collections.abc import Iterator, Mapping
from statistics import median
from typing import Any

from taskbuilder.data.index import success_rates, variation_counts
from taskbuilder.machine import PACKAGES


def card_text(about: Mapping[str, Any], index: Mapping[str, Any]) -> str:
    """The card of a data set, in Markdown.

    Args:
        about: What the data set says of itself.
        index: Its index.
    """
    return "\n".join(
        (*_header(about), *_summary(about, index), *_tasks(about, index), *_made(about))
    )


def export_card_text(about: Mapping[str, Any], index: Mapping[str, Any], form: str) -> str:
    """The card of an export: licence, task and figures, without how to read it.

    Args:
        about: What the data set says of itself.
        index: Its index.
        form: The format of the export.
    """
    tags = ", ".join(dict.fromkeys(("taskbuilder", "multi-agent", _TAGS.get(form, form))))
    header = list(_header(about))
    header[3] = f"tags: [{tags}]"
    lines = (*header, *_summary(about, index), *_tasks(about, index))
    return "\n".join((*lines, "Exported by taskbuilder.", ""))


_TAGS = {"lerobot": "LeRobot"}
"""Tags by which the Hub recognises a format, where it is not the name."""


def _header(about: Mapping[str, Any]) -> Iterator[str]:
    yield from ("---", f"license: {_scalar(about['license'].lower())}")
    yield "task_categories: [robotics]"
    yield from ("tags: [taskbuilder, multi-agent, simulation]", "---", "")


def _summary(about: Mapping[str, Any], index: Mapping[str, Any]) -> Iterator[str]:
    names = ", ".join(about["tasks"])
    episodes = index["episodes"]
    steps = [each["steps"] for each in episodes]
    won = sum(each["success"] for each in episodes)
    yield from (f"# {names}", "")
    yield f"A data set of {len(episodes)} episodes ({sum(steps)} control steps) of {names}."
    yield f"{won} of them succeed. An episode has a median of {median(steps):g} steps."
    if about["collected"]["cameras"]:
        cameras = ", ".join(about["collected"]["cameras"])
        yield f"Cameras: {cameras} (renderer {about['renderer']})."
    yield from (f"Licence: {_plain(about['license'])}.", "")


def _tasks(about: Mapping[str, Any], index: Mapping[str, Any]) -> Iterator[str]:
    rates, counts = success_rates(index), variation_counts(about, index)
    for name, task in about["tasks"].items():
        yield from (f"## {name}", "", _plain(task["summary"]), "")
        robots = ", ".join(f"{agent} ({_model(robot)})" for agent, robot in task["robots"].items())
        yield f"Robots: {robots}. {task['control_hz']} control steps per second, at most "
        yield f"{task['max_episode_steps']} steps."
        yield from ("", "| policy | attempts | succeeded |", "|---|---|---|")
        for policy, (won, played) in rates.get(name, {}).items():
            yield f"| {_plain(policy)} | {played} | {won} |"
        yield from ("", "| variation | attempts | episodes |", "|---|---|---|")
        for variation, count in counts[name].items():
            yield f"| {variation} | {count.attempts} | {count.episodes} |"
        yield ""


def _model(robot: Mapping[str, Any]) -> str:
    """A robot's model, with its rule of grasping where that is not friction."""
    attaches = robot.get("grasp") == "attach"
    return f"{robot['model']}, grasp attach" if attaches else str(robot["model"])


def _scalar(text: str) -> str:
    """A text as a value in YAML; one that could mean anything else is quoted."""
    word = re.fullmatch("[a-z][a-z0-9.+-]*", text) and text not in _YAML_WORDS
    return text if word else json.dumps(text)  # the quoted texts of JSON are those of YAML too


_YAML_WORDS = ("y", "n", "yes", "no", "on", "off", "true", "false", "null")
"""Words that are no text in YAML."""


def _plain(text: str) -> str:
    """A text without meaning in Markdown: on one line, without markup or cells of tables."""
    return html.escape(" ".join(text.split()), quote=False).replace("|", "\\|")


def _made(about: Mapping[str, Any]) -> Iterator[str]:
    versions = about["versions"]
    used = ", ".join(f"{name} {versions[name]}" for name in PACKAGES if name in versions)
    yield from ("## Reading it", "", "```python", "import taskbuilder", "")
    yield from ('dataset = taskbuilder.load_dataset("this/folder")', "episode = dataset[0]")
    yield from ('env = taskbuilder.make_from("this/folder")', "```", "")
    yield "The files are JSON, NumPy arrays (`numpy.load`) and MP4 videos. `manifest.json` has the"
    yield "SHA-256 of every file, and `taskbuilder dataset check` verifies them."
    yield from ("", f"Made with {used}.", "")
