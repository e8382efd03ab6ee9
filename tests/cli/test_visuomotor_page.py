"""The page on visuomotor policies: its commands run as written, with smaller numbers."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from written_pages import written

pytest.importorskip("torch")

SMALLER = {
    "--episodes": "1",
    "--size": "32",
    "--steps": "20",
    "--evaluate-every": "20",
}
LEFT_OUT = ("--device", "cuda")
TRAINING = ("--evaluate-episodes", "1", "--set", "hidden=[8]", "channels=[2,2,2]", "batch=8")


def commands() -> list[list[str]]:
    blocks = re.findall(r"^```sh\n(.*?)^```$", written("visuomotor.md"), re.MULTILINE | re.DOTALL)
    return [shlex.split(line)[1:] for block in blocks for line in block.splitlines()]


def smaller(words: list[str]) -> list[str]:
    """A command with smaller numbers, on the CPU."""
    for option, value in SMALLER.items():
        if option in words:
            words[words.index(option) + 1] = value
    words = [word for word in words if word not in LEFT_OUT]
    if words[0] == "train":
        words += [*TRAINING, *([] if "--steps" in words else ["--steps", "20"])]
    if "--video" in words:
        words += ["--size", "64x48"]
    return [*words, "--jobs", "1"] if words[0] in ("collect", "evaluate", "demo") else words


@pytest.mark.slow
def test_its_commands_run(run):
    told = commands()
    assert [words[0] for words in told] == [
        *("collect", "dataset", "train", "train", "evaluate", "evaluate", "demo"),
    ]
    for words in told:
        ran = run(*smaller(words))
        # A policy that has hardly been trained fails in its demo, which says so by its status.
        assert ran.status == (1 if words[0] == "demo" else 0), ran.err
        if words[0] == "evaluate":
            assert "  observed  pictures of front, top (32x32, renderer " in ran.out
    assert list(Path("films").glob("*.mp4"))
