"""The whole work from Python: what `taskbuilder` exports, its keywords, and what it shows."""

from __future__ import annotations

import inspect
import subprocess
import sys
import typing

import pytest

import taskbuilder
from taskbuilder.env.options import TrainingOptions
from taskbuilder.errors import UsageError

WORK = (
    *(
        "benchmark",
        "collect",
        "evaluate",
        "export",
        "film",
        "load_dataset",
        "render",
        "train",
        "validate",
    ),
    "verify",
)


def test_the_whole_work_is_exported():
    assert set(WORK) <= set(taskbuilder.__all__) <= {*dir(taskbuilder), *vars(taskbuilder)}
    assert all(callable(getattr(taskbuilder, name)) for name in taskbuilder.__all__ if name in WORK)


@pytest.mark.parametrize("name", [*WORK, "parallel_env", "make_vec", "make_from", "play"])
def test_every_keyword_has_a_type_that_an_editor_completes(name):
    function = getattr(taskbuilder, name)
    function = getattr(function, name, function)  # of a package that can be called
    for each in inspect.signature(function).parameters.values():
        assert each.annotation is not inspect.Parameter.empty, each
        if each.kind is inspect.Parameter.VAR_KEYWORD:
            assert str(each.annotation).startswith("Unpack["), each


def test_training_takes_every_field_of_a_plan():
    from taskbuilder.learn.plan import Plan
    from taskbuilder.learn.runs import train

    named = {*inspect.signature(train).parameters} - {"out", "watch", "options"}
    options = {*typing.get_type_hints(TrainingOptions)}
    decided = {"teachers", "progress_range"}  # by the data set; by the task or its expert
    assert named | options == {*Plan("").values, "settings"} - decided


def test_importing_needs_no_torch_and_no_physics():
    code = (
        "import sys, time; sys.modules['torch'] = None; import taskbuilder;"
        "print({'numpy', 'pybullet', 'pydantic', 'taskbuilder.sim'} & {*sys.modules})"
    )
    ran = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert ran.stdout == "set()\n"


def test_representations_are_short_and_say_what_a_thing_is(tmp_path):
    task = taskbuilder.load_task("reach")
    assert repr(task) == "<Task reach: arm; 2 stages>"
    env = taskbuilder.parallel_env(task, horizon=3)
    assert repr(env) == "<TaskEnv reach: arm; 3 steps>"
    env.close()
    data = taskbuilder.collect(
        task, tmp_path / "data", episodes=2, policy="hold", keep_failures=True, jobs=1, horizon=3
    )
    assert repr(data).startswith("<Dataset ")
    assert repr(data).endswith("data: 2 episodes of reach>")
    assert repr(data[0]) == "<RecordedEpisode reach, seed 0: 3 steps, no success>"
    policy = taskbuilder.load_policy("zoo:handover/demos")
    assert repr(policy) == "<TrainedPolicy for handover: left, right>"
    result = taskbuilder.evaluate("hold", 1, task=task, jobs=1, horizon=3)
    assert repr(result.rollouts[0]).startswith("<Rollout reach, seed 2000000: 3 steps, no success")
    assert len(repr(result)) < 600


def test_a_task_is_collected_rendered_filmed_and_validated(tmp_path):
    def still(observations):
        return {agent: [0.0] * size for agent in observations}

    task = taskbuilder.load_task("reach")
    env = taskbuilder.parallel_env(task)
    size = env.action_space("arm").shape[0]
    env.close()
    data = taskbuilder.collect(
        [task],
        tmp_path / "data",
        episodes=2,
        policy=["random*1", still],
        keep_failures=True,
        horizon=3,
    )
    names = {episode.policy for episode in data}
    assert "random" in names
    assert any(name.endswith("still") for name in names)
    assert data.about["options"] == {"horizon": 3}
    again = taskbuilder.load_dataset(tmp_path / "data")
    assert len(again) == 2
    pictures = taskbuilder.render("reach", tmp_path / "seen", camera="front", size=(64, 48))
    assert [file.name for file in pictures] == ["reach-front.png", "reach-sheet.png"]
    films = taskbuilder.film(
        task, tmp_path / "film.mp4", policy="hold", gif=False, size=(64, 48), horizon=3
    )
    assert [file.name for file in films] == ["film.mp4"]
    report = taskbuilder.validate(task, level="static")
    assert report.task == "reach"


def test_what_cannot_be_collected_or_rendered_is_refused(tmp_path):
    for options, said in (
        ({"variation": "random"}, 'variations="all"'),
        ({"policy": "expert:handover"}, "name one task"),
    ):
        with pytest.raises(UsageError, match=said):
            taskbuilder.collect("reach", tmp_path / "data", **options)
    with pytest.raises(UsageError, match="reach has no variation 7"):
        taskbuilder.render("reach", tmp_path, variation=7)
    with pytest.raises(UsageError, match="the task is loaded already"):
        taskbuilder.render(taskbuilder.load_task("reach"), tmp_path, grasp="friction")
