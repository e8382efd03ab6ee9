"""The example package adds a part of each kind, and all are used through the public face."""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
import tomllib
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

import taskbuilder
from taskbuilder.cli import main
from taskbuilder.data.collecting import collect
from taskbuilder.data.dataset import load_dataset
from taskbuilder.data.formats import export_dataset
from taskbuilder.data.plan import CollectPlan
from taskbuilder.env.parallel import parallel_env
from taskbuilder.extensions import DOORS
from taskbuilder.task import load_task
from taskbuilder.validate.runner import validate_task

pytestmark = pytest.mark.in_process

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "taskbuilder-extras"
IMPORT = "from taskbuilder_extras.conditions import Higher"
ALL = {
    "arm": "joint_range",
    "channel": "cube.speed",
    "condition": 'Higher("target", "table", by=0.1)',
    "imports": IMPORT,
}


def test_the_example_declares_one_part_of_each_kind():
    project = tomllib.loads((EXAMPLE / "pyproject.toml").read_text())["project"]
    groups = project["entry-points"]
    assert set(groups) == {door.group for door in DOORS}
    assert all(len(parts) == 1 for parts in groups.values())


def test_an_environment_steps_with_the_action_mode_and_the_channel(extras, own_task):
    with closing(parallel_env(load_task(own_task(**ALL)), normalize=False)) as env:
        seen, _ = env.reset(seed=0)
        names = env.observation_names["arm"]
        assert "cube.speed" in names
        assert env.action_names["arm"][:2] == ("arm.joint_1_fraction", "arm.joint_2_fraction")
        space = env.action_space("arm")
        assert space.low[:7].tolist() == [0.0] * 7
        assert space.high[:7].tolist() == [1.0] * 7
        robot = env.episode.world.robots["arm"]
        low, high = ([getattr(j, end) for j in robot.model.arm] for end in ("lower", "upper"))
        ranges = zip(robot.commanded(), low, high, strict=True)
        goal = [(at - least) / (most - least) for at, least, most in ranges]
        goal[0] = 0.6
        for _ in range(12):
            seen, *_ = env.step({"arm": np.array([*goal, 1.0], np.float32)})
        turned = robot.arm_state()[0][0]
        assert turned == pytest.approx(low[0] + 0.6 * (high[0] - low[0]), abs=0.01)
        assert 0.0 <= seen["arm"][names.index("cube.speed")] < 0.01


def test_a_task_with_foreign_parts_is_proved(extras, own_task):
    families = ("build", "reset", "contract", "solvable")
    report = validate_task(own_task(**ALL), seeds=3, only=families)
    assert report.ok, [family.trace for family in report.families]
    assert [f.name for f in report.families] == ["static", "colours", *families]
    (finding,) = report.findings
    assert finding.code == "EXT101"
    assert finding.severity == "warning"
    assert "block" in finding.path
    assert finding.location.line == 14


def test_a_foreign_condition_is_checked_statically(extras, own_task):
    wrong = 'Higher("target", "tabel", by=0.1)'
    report = validate_task(own_task(imports=IMPORT, condition=wrong), level="static")
    (finding,) = report.findings
    assert finding.code == "TB207"
    assert 'did you mean "table"?' in finding.message
    worthless = 'Higher("target", "table", by=float("nan"))'
    report = validate_task(own_task(imports=IMPORT, condition=worthless), level="static")
    assert [finding.code for finding in report.findings] == ["TB212"]


def test_a_report_is_printed_in_the_foreign_format(extras, own_task, capfd):
    words = ["validate", str(own_task(**ALL)), "--level", "static", "--format", "markdown"]
    assert main(words) == 0
    out = capfd.readouterr().out
    assert out.startswith("| task | family | result | summary |\n")
    assert "| mine | colours | passed | 1 check of taskbuilder-extras 1.0 |" in out


def test_a_picture_is_drawn_by_the_foreign_renderer(extras, own_task):
    task = load_task(own_task())
    images = {}
    for renderer in ("tiny", "silhouettes"):
        options = {"cameras": ("front",), "camera_size": (64, 48), "renderer": renderer}
        with closing(parallel_env(task, **options)) as env:
            images[renderer] = env.reset(seed=0)[0]["arm"]["front.rgb"]
            assert env.cameras()["front"].intrinsics.shape == (3, 3)
    colours = {tuple(pixel) for pixel in images["silhouettes"].reshape(-1, 3).tolist()}
    assert (31, 119, 180) in colours  # the floor, which is body number 0
    assert len(colours) <= 7
    assert images["tiny"].shape == images["silhouettes"].shape


def test_a_data_set_is_exported_in_the_foreign_format(extras, own_task, tmp_path):
    plan = CollectPlan((str(own_task()),), 1)
    folder = tmp_path / "data"
    collect(plan, folder)
    dataset = load_dataset(folder)
    out = export_dataset(dataset, "csv", tmp_path / "out")
    with (out / "episode_000000.csv").open(newline="") as file:
        head, *rows = csv.reader(file)
    (episode,) = dataset
    assert head[0] == "step"
    assert head[-1] == "reward"
    assert len(rows) == episode.steps
    assert np.array(rows, float)[:, 1:-1] == pytest.approx(episode.actions["arm"])
    assert (out / "README.md").is_file()
    words = ["dataset", "export", str(folder), "--format", "csv", "--out", str(tmp_path / "again")]
    assert main(words) == 0


def test_the_foreign_algorithm_is_trained_and_its_policy_plays(extras, tmp_path, capfd):
    pytest.importorskip("torch")
    collect(CollectPlan(("reach",), 6), tmp_path / "data")
    words = ["train", "--data", str(tmp_path / "data"), "--algorithm", "ridge"]
    words += ["--evaluate-episodes", "2", "--out", str(tmp_path / "run")]
    assert main([*words, "--set", "penalty=0.1"]) == 0, capfd.readouterr()
    policy = taskbuilder.load_policy(str(tmp_path / "run"))
    assert policy.about["algorithm"] == "ridge"
    assert len(policy.networks["arm"].layers) == 1
    actions = policy.act({"arm": np.zeros(policy.sizes("arm")[0], np.float32)})
    assert np.isfinite(actions["arm"]).all()
    file = tmp_path / "run" / "run.json"
    assert json.loads(file.read_text())["algorithm_package"] == "taskbuilder-extras 1.0"
    file.write_text(file.read_text().replace('"ridge"', '"crest"'))  # as if it were not installed
    assert main(["train", "--resume", str(tmp_path / "run")]) == 2
    assert "is of the package taskbuilder-extras 1.0, which is not here" in capfd.readouterr().err


@pytest.mark.parametrize(
    ("name", "kind", "text"),
    [
        ("joint_range", "action mode", "fraction of its range"),
        ("ridge", "algorithm", "ridge regression"),
        ("object.speed", "observation channel", "Linear speed, m/s"),
        ("colours", "check", "EXT101: Same colour"),
        ("ext101", "finding", "Two movable objects"),
        ("Higher", "condition", "from taskbuilder_extras.conditions import Higher"),
        ("csv", "data set format", "actions and rewards"),
        ("silhouettes", "renderer", "paints it"),
        ("markdown", "report format", "One text"),
    ],
)
def test_explain_knows_each_part(extras, capfd, name, kind, text):
    assert main(["explain", name, "--json"]) == 0
    (entry,) = json.loads(capfd.readouterr().out)["entries"]
    assert entry["kind"] == f"{kind} of taskbuilder-extras 1.0"
    assert text in entry["text"]


@pytest.mark.parametrize(
    ("words", "line"),
    [
        ("train", "  --algorithm ridge  taskbuilder-extras 1.0"),
        ("benchmark", "  --algorithm ridge  taskbuilder-extras 1.0"),
        ("dataset", "  --format csv  taskbuilder-extras 1.0"),
        ("validate", "  --format markdown  taskbuilder-extras 1.0"),
        ("collect", "  --renderer silhouettes  taskbuilder-extras 1.0"),
    ],
)
def test_help_lists_what_packages_add(extras, capfd, words, line):
    assert main([words, "--help"]) == 0
    assert line in capfd.readouterr().out.partition("\nadded by installed packages:")[2]


def test_nothing_is_looked_for_until_it_is_needed(example_site):
    code = (
        "import sys, taskbuilder, taskbuilder.cli\n"
        "taskbuilder.cli.main(['--help'])\n"
        "wanted = ('importlib.metadata', 'taskbuilder_extras')\n"
        "print(*[name for name in wanted if name in sys.modules], file=sys.stderr)"
    )
    environment = os.environ | {"PYTHONPATH": str(example_site)}
    words = [sys.executable, "-c", code]
    done = subprocess.run(words, capture_output=True, text=True, env=environment, check=True)
    assert done.stderr.strip() == ""
    assert Path(taskbuilder.__file__).is_file()
