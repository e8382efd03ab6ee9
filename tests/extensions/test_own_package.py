"""The package that the page on the architecture shows, word for word, works as the page says."""

from __future__ import annotations

import re
import tomllib
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from taskbuilder.cli import main
from taskbuilder.data.collecting import collect
from taskbuilder.data.plan import CollectPlan
from taskbuilder.env.parallel import parallel_env
from taskbuilder.task import load_task
from taskbuilder.validate.runner import validate_task

PAGE = Path(__file__).resolve().parents[2] / "docs" / "architecture.md"


@pytest.fixture
def lab_parts(tmp_path, install):
    """The package of the page, written and declared as the page says."""
    text = PAGE.read_text(encoding="utf-8").partition("### From a package of one's own")[2]
    blocks = re.findall(r"^```\w+\n# (\S+)\n(.*?)^```$", text, re.M | re.S)
    files = dict(blocks)
    assert len(files) == len(blocks) == 4
    project = tomllib.loads(files.pop("pyproject.toml"))["project"]
    site = install("lab_parts_declared", {})
    info = site / "lab_parts-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: lab-parts\nVersion: 1.0\n")
    groups = project["entry-points"].items()
    lines = [
        line
        for group, parts in groups
        for line in (f"[{group}]", *(f"{name} = {value}" for name, value in parts.items()))
    ]
    (info / "entry_points.txt").write_text("\n".join(lines))
    (site / "lab_parts").mkdir()
    (site / "lab_parts" / "__init__.py").write_text("")
    for name, code in files.items():
        (site / name).write_text(code)


def test_an_expert_is_proved_with_the_action_mode_of_the_page(lab_parts, own_task):
    file = own_task(arm="half_position")
    report = validate_task(file, seeds=2, only=("build", "reset", "contract", "solvable"))
    assert report.ok, [family.trace for family in report.families]
    with closing(parallel_env(load_task(file), normalize=False)) as env:
        env.reset(seed=0)
        robot = env.episode.world.robots["arm"]
        start = robot.commanded()
        env.step({"arm": np.array([start[0] + 3.0, *start[1:], 1.0], np.float32)})
        most = env.episode.world.robots["arm"].model.arm[0].velocity / 10
        assert robot.commanded()[0] - start[0] == pytest.approx(most / 2)


def test_the_algorithm_and_the_format_of_the_page(lab_parts, tmp_path):
    pytest.importorskip("torch")
    data, out = tmp_path / "data", tmp_path / "npz"
    collect(CollectPlan(("reach",), 2), data)
    assert main(["dataset", "export", str(data), "--format", "npz", "--out", str(out)]) == 0
    with np.load(out / "000000.npz") as arrays:
        assert set(arrays) == {"observation/arm", "action/arm"}
    words = ["train", "--data", str(data), "--algorithm", "mean_action", "--steps", "10"]
    assert main([*words, "--evaluate-episodes", "1", "--out", str(tmp_path / "run")]) == 0


@pytest.mark.parametrize("name", ["half_position", "mean_action", "npz"])
def test_explain_finds_the_parts_of_the_page(lab_parts, capfd, name):
    assert main(["explain", name]) == 0
    assert "of lab-parts 1.0" in capfd.readouterr().out
