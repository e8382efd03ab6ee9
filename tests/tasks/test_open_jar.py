"""The lid of Open Jar comes off by turning, and turns only while the jar is held."""

from __future__ import annotations

import shutil
from contextlib import closing
from pathlib import Path

import pytest

import taskbuilder as tb
from taskbuilder.expert import Expert

TASKS = Path(tb.__file__).resolve().parents[1] / "tasks"
TURN = "  - right: {bring: lid, to: loose, align: true, touching: [jar], speed: 0.6}\n"
HOLD = "  - left: {grasp: jar.side}\n    right: {reach: lid.grip, above: 0.1}\n"
UPRIGHT_M = 0.11
"""Height of the lid above the bottom of the closed jar."""


def after(tmp_path, order, instead):
    """Where lid and jar are in the end, and the joint, if an order of the expert is replaced."""
    text = (TASKS / "open_jar.yaml").read_text()
    assert order in text
    (tmp_path / "open_jar.yaml").write_text(text.replace(order, instead))
    shutil.copy(TASKS / "open_jar.py", tmp_path)
    shutil.copytree(TASKS / "objects", tmp_path / "objects")
    with (
        closing(tb.parallel_env(tmp_path / "open_jar.yaml")) as env,
        closing(Expert(env)) as expert,
    ):
        assert not expert.play(0).success
        world = env.episode.world
        return world.pose("jar").inverse() @ world.pose("lid"), world.joint("jar.screw")


def test_an_unturned_lid_stays_on(tmp_path):
    lid, turned = after(tmp_path, TURN, "")
    assert lid.position[2] == pytest.approx(UPRIGHT_M, abs=0.005)
    assert turned < 0.2


def test_a_jar_that_nobody_holds_turns_along(tmp_path):
    lid, turned = after(tmp_path, HOLD, "  - right: {reach: lid.grip, above: 0.1}\n")
    assert lid.position[2] == pytest.approx(UPRIGHT_M, abs=0.005)
    assert turned < 0.2
