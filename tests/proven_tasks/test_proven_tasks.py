"""Tasks whose experts push things and turn joints: they work, so they prove whole.

Where things are after a push or on a joint is foreseen without physics, and physics decides.
"""

from __future__ import annotations

import math
from contextlib import contextmanager
from pathlib import Path

import pytest

from taskbuilder.env.parallel import parallel_env
from taskbuilder.expert.script.dry_run import dry_run
from taskbuilder.expert.script.foresight import Foresight
from taskbuilder.expert.script.player import Expert
from taskbuilder.schema.expert import Order
from taskbuilder.task import load_task
from taskbuilder.validate.run import validate_task

HERE = Path(__file__).parent
TASKS = sorted(file.stem for file in HERE.glob("*.yaml"))
FAMILIES = 10


@contextmanager
def playing(name):
    env = parallel_env(load_task(HERE / f"{name}.yaml"))
    expert = Expert(env)
    yield env, expert
    expert.close()
    env.close()


@pytest.mark.parametrize("name", TASKS)
def test_the_expert_succeeds_from_every_seed_and_nothing_is_said_against_it(name):
    report = validate_task(HERE / f"{name}.yaml", seeds=5, only=("reach", "solvable"))
    assert report.findings == ()
    values = {check.code: check.value for family in report.families for check in family.checks}
    assert values["TB531"] == 1.0
    assert values["TB511"] > 0.0


@pytest.mark.parametrize("name", TASKS)
def test_it_proves_whole(name):
    report = validate_task(HERE / f"{name}.yaml", seeds=1)
    assert report.ok, "\n".join(map(str, report.findings))
    assert report.skipped == ()
    assert len(report.families) == FAMILIES


class TestWhatIsForeseen:
    def test_a_block_is_taken_where_a_push_leaves_it(self):
        with playing("pushed_then_picked") as (env, expert):
            env.reset(seed=3)
            asked = [a for a in dry_run(env.episode.world) if a.order == "grasp block.middle"]
            places = []
            expert.play(3, after_stage=lambda _: places.append(env.episode.world.pose("block")))
            begin, end = places[1].position, places[2].position
        assert end[0] - begin[0] > 0.2
        assert {a.guess for a in asked} == {"block"}
        assert math.dist(asked[-1].choices[0].position[:2], end[:2]) < 0.02

    def test_a_knob_is_where_its_lid_was_turned_to(self):
        there = ({"right": Order(reach="chest.knob")},)
        with playing("lid_by_its_knob") as (env, expert):
            stages = env.task.file.spec.expert
            env.reset(seed=0)
            (*_, knob) = dry_run(env.episode.world, (*stages[:4], *there))
            (*_, begin) = dry_run(env.episode.world, there)
            (*_, case) = dry_run(env.episode.world, (*stages[:4], {"right": Order(reach="chest")}))
            places = []
            expert.play(
                0, after_stage=lambda _: places.append(env.episode.world.pose("chest.knob"))
            )
            base = env.episode.world.pose("chest")
        end = places[3].position
        assert math.dist(begin.choices[0].position, end) > 0.15
        assert math.dist(knob.choices[0].position, end) < 0.02
        assert case.choices[0].position == pytest.approx(base.position)
        assert knob.guess == ""

    def test_a_lid_turns_no_farther_than_its_hinge_lets_it(self):
        with playing("lid_by_its_knob") as (env, _):
            env.reset(seed=0)
            take = {"left": Order(grasp="chest.grip")}
            below = {"left": Order(reach="chest.grip", offset=(0.0, 0.0, -0.08))}
            where = {"right": Order(reach="chest.knob")}
            (*_, begin) = dry_run(env.episode.world, (where,))
            (*_, knob) = dry_run(env.episode.world, (take, below, where))
        assert knob.choices[0].position == pytest.approx(begin.choices[0].position, abs=1e-6)


class TestPhysicsDecides:
    def test_what_is_foreseen_wrongly_is_no_error_where_the_expert_succeeds(self, monkeypatch):
        monkeypatch.setattr(Foresight, "_pushed", lambda *_: None)
        report = validate_task(
            HERE / "pushed_then_picked.yaml", seeds=2, only=("reach", "solvable")
        )
        assert report.ok
        assert report.findings == ()
        assert "where block will be is a guess" in report.families[1].summary

    def test_a_pose_that_only_comes_after_success_is_a_warning(self, tmp_path):
        for file in HERE.glob("pushed_then_picked.*"):
            text = file.read_text(encoding="utf-8")
            (tmp_path / file.name).write_text(text, encoding="utf-8")
        task = tmp_path / "pushed_then_picked.yaml"
        text = task.read_text(encoding="utf-8")
        text += "  - left: {reach: aside, offset: [0, 0, 2]}\n"
        text = text.replace("seconds: 1.0", "seconds: 0.1")
        task.write_text(text, encoding="utf-8")
        says = task.with_suffix(".py")
        says.write_text(says.read_text().replace("seconds=1.0", "seconds=0.1"))
        report = validate_task(task, seeds=1, only=("reach", "solvable"))
        (finding,) = report.findings
        assert (finding.code, finding.severity) == ("TB511", "warning")
        assert finding.message.endswith(
            "from 1 of 1 placements: at worst, from seed 0, even 0.5 m nearer would be out of "
            "reach, so turn the tool otherwise; the expert succeeds without it"
        )
