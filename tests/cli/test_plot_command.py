"""`taskbuilder plot`: which runs it draws together, and where."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import cv2
import pytest
from made_runs import write_run

from taskbuilder.visual.charts import COLORS

GREENS = (0x16, 0x80, 0x48)


@pytest.fixture
def runs(tmp_path):
    """Folders of runs under a folder, made with options of the plan."""

    def make(*names, **options):
        for seed, name in enumerate(names):
            write_run(tmp_path / name, seed=seed, **options)

    return make


def words_of(svg):
    """Texts of an SVG: matplotlib says in comments what it draws as shapes."""
    return re.findall(r"<!-- (.*?) -->", Path(svg).read_text())


def count(picture, color):
    return int((abs(cv2.imread(picture)[:, :, ::-1].astype(int) - color).max(axis=2) < 8).sum())


def rgb(text):
    return tuple(int(text[start : start + 2], 16) for start in (1, 3, 5))


def test_without_matplotlib_the_extra_is_named(run, runs, monkeypatch):
    runs("a")
    monkeypatch.delitem(sys.modules, "taskbuilder.visual.curves", raising=False)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    ran = run("plot", "a", "--out", "curves.png")
    assert ran.status == 2
    assert 'plot needs matplotlib; install the extra: pip install "taskbuilder[plot]"' in ran.err
    assert not Path("curves.png").exists()


def test_a_run_is_drawn_with_all_that_it_logged(run, runs):
    runs("a", learned_at=5_000)
    ran = run("plot", "a", "--out", "new/folder/curves.svg")
    assert (ran.status, ran.out, ran.err) == (0, "new/folder/curves.svg\n", "")
    said = words_of("new/folder/curves.svg")
    first = said.index("sideways")
    assert said[first : first + 3] == [
        "sideways",
        "maddpg · ratchet reward · 1 run",
        "training episodes averaged over 500 steps",
    ]
    for text in (
        "success in evaluations",
        "team return of training episodes",
        "reach/arm",
        "there",
        "furthest stage in evaluations",
        "begun",
        "none",
    ):
        assert said.count(text) == 1 + (text == "there")  # a term and a stage
    assert said.count("1k") == said.count("episodes") == 2  # a thousand in 20,000 steps
    assert said.count("20k") == said.count("environment steps") == 5


def test_every_term_is_drawn_by_its_own_numbers(run, runs):
    runs("a")
    path, pictures = Path("a/episodes.csv"), set()
    header, *rows = path.read_text().splitlines()
    for column in (None, header.split(",").index("term/reach/arm"), -1):
        lines = [line.split(",") for line in rows]
        for line in lines:
            if column is not None:
                line[column] = "0"
        path.write_text("\n".join([header, *map(",".join, lines), ""]))
        run("plot", "a", "--out", "a.svg")
        pictures.add(Path("a.svg").read_bytes())
    assert len(pictures) == 3


def test_runs_alike_share_a_colour_and_others_have_their_own(run, runs):
    runs("a", "b", "c")
    runs("x", "y", demos=100)
    runs("t", reward="team")
    ran = run("plot", "a", "x", "b", "t", "y", "c", "--out", "all.svg", "--title", "Past the goal")
    assert (ran.status, ran.err) == (0, "")
    said = words_of("all.svg")
    first = said.index("Past the goal")
    assert said[first : first + 6] == [
        "Past the goal",
        "sideways · 6 runs",
        "training episodes averaged over 500 steps · every run faint, in bold their interquartile "
        "mean with its 95% band",
        "ratchet reward · no demonstrations  (3 runs)",
        "ratchet reward · 100 demonstrations  (2 runs)",
        "team reward · no demonstrations  (1 run)",
    ]


def test_success_and_stages_rise_where_the_run_learned(run, runs):
    for name, step in (("early", 2_000), ("late", 18_000)):
        runs(name, learned_at=step)
        assert run("plot", name, "--out", f"{name}.png").out == f"{name}.png\n"
    assert count("early.png", GREENS) > 3 * count("late.png", GREENS) > 1000
    assert count("early.png", rgb(COLORS[0])) > 1000


def test_success_at_the_last_step_is_drawn_where_it_is_known(run, runs):
    title = "success in evaluations (dashed: at the last step)"
    runs("before")
    runs("lasting", lasting=0.5)
    for folder, times in (("before", 0), ("lasting", 1)):
        assert run("plot", folder, "--out", f"{folder}.svg").status == 0
        assert words_of(f"{folder}.svg").count(title) == times


def test_a_run_named_twice_is_one_and_has_no_band(run, runs):
    runs("a", "b")
    for name, words in (("once", ("a",)), ("twice", ("a", "./a")), ("both", ("a", "b"))):
        assert run("plot", *words, "--out", f"{name}.svg").status == 0
    once, twice, both = (Path(f"{name}.svg").read_text() for name in ("once", "twice", "both"))
    assert once == twice
    areas = [text.count('<g id="FillBetween') for text in (once, both)]
    assert areas == [3, 3 + 4]  # three stages; bands of success, return and two terms


def test_runs_that_have_come_this_far_are_drawn_together(run, runs):
    runs("a", steps=20_000, every=2_000)
    runs("b", steps=6_000, every=1_500)
    ran = run("plot", "a", "b", "--out", "both.png")
    assert (ran.status, ran.err) == (0, "")
    assert cv2.imread("both.png").shape[1] == 1210


def test_a_run_under_way_is_drawn_as_far_as_it_has_come(run, runs):
    runs("a")
    table = Path("a/evaluations.csv")
    lines = table.read_text().splitlines(keepends=True)
    table.write_text("".join(lines[:2]) + lines[2][:7])
    assert run("plot", "a", "--out", "first.png").status == 0


def test_nothing_is_left_behind_where_a_run_is_damaged(run, runs):
    runs("a")
    path = Path("a/episodes.csv")
    path.write_text(path.read_text().replace("\n400,", "\nx,", 1))
    ran = run("plot", "a", "--out", "new/curves.png")
    assert (ran.status, ran.out) == (1, "")
    assert ran.err == 'taskbuilder: a/episodes.csv:21: step is "x", which is no number\n'
    assert not Path("new").exists()


OTHERS = """\
algorithm,seed,step,success_rate,team_return
sb3,1,0,0,-20
sb3,2,0,0,
sb3,1,30000,1.0,-5
sb3,2,30000,0.8,-6
"""


def test_curves_of_other_software_are_drawn_beside_runs(run, runs):
    runs("a", "b")
    Path("sac.csv").write_text(OTHERS)
    Path("td3.csv").write_text("step,success_rate\n10000,0.25\n")
    ran = run("plot", "a", "b", "--beside", "sac.csv", "td3.csv", "--out", "all.svg")
    assert (ran.status, ran.err) == (0, "")
    said = words_of("all.svg")
    assert "sideways" in said
    assert [text for text in said if text.endswith(("run)", "runs)"))] == [
        "maddpg · ratchet reward  (2 runs)",
        "sac  (2 runs)",
        "td3  (1 run)",
    ]
    assert said.count("30k") == 5  # all panels are as long as the longest curve
    assert said.count("furthest stage in evaluations") == 1
    assert run("plot", "a", "b", "--beside", "sac.csv", "--out", "all.png").status == 0
    assert count("all.png", rgb(COLORS[1])) > 500


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "other.csv:1: needs the columns step and success_rate or team_return; the columns "
         "are none"),
        ("Step,Value\n1,2\n", "other.csv:1: needs the columns step and success_rate or "
         "team_return; the columns are Step, Value"),
        ("step,success_rate\n", "other.csv has no rows with a value"),
        ("step,success_rate\n0,0\n100,high\n", 'other.csv:3: success_rate is "high", which is '
         "no number"),
        ("step,success_rate\n,0.5\n", 'other.csv:2: step is "", which is no number'),
    ],
)  # fmt: skip
def test_damaged_curves_of_other_software_are_refused(run, runs, text, said):
    runs("a")
    Path("other.csv").write_text(text)
    ran = run("plot", "a", "--beside", "other.csv", "--out", "new/all.svg")
    assert (ran.status, ran.err) == (1, f"taskbuilder: {said}\n")
    assert not Path("new").exists()


def test_curves_that_are_not_there_are_refused(run, runs):
    runs("a")
    ran = run("plot", "a", "--beside", "none.csv", "--out", "all.svg")
    assert ran.status != 0
    assert "none.csv" in ran.err
    assert "Traceback" not in ran.err
