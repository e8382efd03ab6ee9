"""A few demonstrations of Handover become more, played by physics, and bad input is explained."""

from __future__ import annotations

import pytest

import taskbuilder
from taskbuilder.data.checking import check_dataset
from taskbuilder.errors import UsageError


@pytest.fixture(scope="module")
def few(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sets") / "few"
    return taskbuilder.collect("handover", folder, episodes=2, jobs=1)


def test_each_new_episode_succeeds_says_its_source_and_replays(few, tmp_path):
    many = taskbuilder.multiply(few, tmp_path / "many", episodes=3, jobs=1)
    names = {episode.name for episode in few}
    assert len(many) == 3
    for episode in many:
        assert episode.success
        assert episode.policy == "multiplied"
        assert episode.about["source"] in names
        assert episode.seed > max(source.seed for source in few)  # another placement
    # Stages keep their labels: they end where those of the source ended.
    labels = [[part["label"] for part in episode.subtasks] for episode in many]
    assert labels == [[part["label"] for part in few[0].subtasks]] * 3
    checked = check_dataset(tmp_path / "many", 0.3)
    assert checked.ok
    assert len(checked.replayed) == 1


def test_an_interrupted_one_goes_on_and_one_of_other_sources_is_refused(few, tmp_path):
    taskbuilder.multiply(few, tmp_path / "many", episodes=1, jobs=1)
    (tmp_path / "many" / "manifest.json").unlink()  # as if it had been interrupted
    again = taskbuilder.multiply(few.folder, tmp_path / "many", episodes=1, jobs=1)
    assert len(again) == 1
    other = taskbuilder.collect("handover", tmp_path / "other", episodes=1, first_seed=5, jobs=1)
    with pytest.raises(UsageError, match="policy_digests is"):
        taskbuilder.multiply(other, tmp_path / "many", episodes=1, jobs=1)


def test_without_success_there_is_nothing_to_multiply(tmp_path):
    taskbuilder.collect(
        "reach", tmp_path / "idle", episodes=1, policy="hold", keep_failures=True, jobs=1
    )
    with pytest.raises(UsageError, match=r"no episode of .* succeeds"):
        taskbuilder.multiply(tmp_path / "idle", tmp_path / "many", jobs=1)


def test_several_tasks_are_refused(tmp_path):
    both = taskbuilder.collect(
        ["reach", "press_button"],
        tmp_path / "both",
        episodes=1,
        policy="hold",
        keep_failures=True,
        jobs=1,
    )
    with pytest.raises(UsageError, match=r"several tasks \(reach, press_button\)"):
        taskbuilder.multiply(both, tmp_path / "many", jobs=1)


TORQUES = """\
task: hold_on
summary: The arm holds still.
scene:
  robots:
    arm: {model: panda, base: {position: [0, 0, 0]}, action: {arm: MODE}}
  objects:
    cube: {shape: {box: [0.04, 0.04, 0.04]}, mass: 0.1, position: [0.5, 0.2, 0.02]}
  cameras:
    front: {position: [1.2, 0, 0.8], look_at: [0.4, 0, 0.2], size: [64, 48]}
timing: {episode_steps: 3}
"""
DESCRIPTION = """\
from taskbuilder.description import Below, Bonus, Description


class HoldOn(Description):
    success = Below("cube", height=1.0)
    reward = (Bonus("low", success, 1.0),)
"""


@pytest.mark.parametrize(
    ("mode", "why"),
    [
        ("joint_torque", "the action mode of arm, joint_torque, commands torques"),
        ("tcp_delta", "no robot takes an object, or reaches a stage that names one"),
    ],
)
def test_what_cannot_be_multiplied_is_refused_with_the_reason(mode, why, tmp_path):
    file = tmp_path / "hold_on.yaml"
    file.write_text(TORQUES.replace("MODE", mode))
    file.with_suffix(".py").write_text(DESCRIPTION)
    data = taskbuilder.collect(file, tmp_path / "data", episodes=1, policy="hold", jobs=1)
    with pytest.raises(UsageError, match=why):
        taskbuilder.multiply(data, tmp_path / "many", jobs=1, trust=True)
