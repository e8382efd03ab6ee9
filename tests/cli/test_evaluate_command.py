"""`taskbuilder evaluate`, and trained policies in `taskbuilder demo`."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import pytest
from made_runs import ENV, sideways, write_run, write_task

from taskbuilder.cli.evaluation_text import bar
from taskbuilder.policies.zoo import save_policy

HERE = ("--task-path", ".", "--jobs", "1")
SMALL = ("--size", "32x24", "--renderer", "tiny")


@pytest.fixture
def policy(tmp_path) -> Path:
    """The task's files, and a policy's for it, pushing.npz."""
    write_task(tmp_path)
    save_policy(tmp_path / "pushing.npz", sideways())
    return tmp_path / "pushing.npz"


def test_a_policy_is_measured_and_told_about(run, policy):
    ran = run("evaluate", "pushing.npz", "--episodes", "8", "--seed", "0", *HERE)
    assert (ran.status, ran.err) == (0, "")
    assert ran.out.splitlines() == [
        "sideways · pushing.npz",
        "  observed  what the task file lists for each robot",
        "  options   observe: task, frame: task",
        "  track     scratch: no demonstrations, no special starts",
        "  trained   maddpg with the reward ratchet · 20,000 control steps · seed 3",
        "  command   taskbuilder train sideways.yaml --steps 20000 --seed 3",
        "  plays     8 episodes from the task's own starts, seeds 0 to 7",
        "",
        "4 of 8 succeeded (50.0%), 95% interval 21.5% to 78.5% · median 1 steps",
        "0 of 8 at the last step (0.0%), 95% interval 0.0% to 32.4%",
        "success held 0.2 s in the mean, 0.2 s in the median",
        "return -0.84, interquartile mean -1.26",
        "",
        "beside         return  policy's  succeeded  at the end  seeds",
        "random play    -0.89   -0.84     37.5%      0.0%        8",
        "holding still  3.82    -0.84     37.5%      37.5%       8",
        "",
        "furthest stage  episodes",
        "none            0",
        "begun           3  █████████",
        "there           5  ███████████████",
        "",
        "why no success at the end  episodes",
        "Near(arm.tcp, goal)        8",
        "",
        "best    seed 5  success  return     2.04  7 of 12 steps",
        "        lost at the end: Near(arm.tcp, goal): 9.7 cm, within 3 cm is needed "
        "(since step 10)",
        "median  seed 4  success  return    -0.97  1 of 12 steps",
        "        lost at the end: Near(arm.tcp, goal): 30.2 cm, within 3 cm is needed "
        "(since step 2)",
        "failed  seed 1  failed   return    -2.29  furthest stage: begun",
        "        Near(arm.tcp, goal): 32.9 cm, within 3 cm is needed (from the start)",
        "failed seeds: 1, 2, 6, 7",
    ]
    assert {file.suffix for file in Path().iterdir()} == {".npz", ".py", ".yaml"}  # as before


def test_json_has_the_shape_that_others_rely_on(run, policy):
    ran = run("evaluate", "pushing.npz", "--episodes", "3", "--seed", "4", *HERE, "--json")
    assert (ran.status, ran.err) == (0, "")
    data = ran.data
    assert (data["task"], data["policy"], data["success_rate"]) == (
        "sideways",
        "pushing.npz",
        2 / 3,
    )
    assert data["interval"] == pytest.approx([0.2077, 0.9385], abs=1e-4)
    assert data["return"] == pytest.approx(sum(e["return"] for e in data["episodes"]) / 3)
    assert data["stages"] == {"": 0, "begun": 0, "there": 3}
    assert data["terms"]["reach/arm"] + data["terms"]["there"] == pytest.approx(data["return"])
    assert data["seeds"] == {"best": 5, "median": 4, "failed": 6}
    assert data["steps_to_success"] == 4.0
    assert data["about"]["env"] == ENV
    assert data["files"] == []
    assert (data["success_at_end_rate"], data["best_stall"]) == (0.0, None)
    assert data["interval_at_end"] == pytest.approx([0.0, 0.5615], abs=1e-4)
    assert data["success_held_s"] == {"mean": pytest.approx(0.2), "median": pytest.approx(0.2)}
    assert data["peak_robot_force"] == {"median": 0.0, "max": 0.0}
    assert data["normalized_return"] is None  # it has no expert
    assert set(data["controls"]) == {"random", "nothing"}
    assert data["controls"]["nothing"]["policy_return"] == data["return"]
    first = data["episodes"][0]
    assert first.pop("return") == pytest.approx(-0.973, abs=1e-3)
    assert len(first.pop("digest")) == 64
    (why,) = first.pop("why")
    assert (why["of"], why["part"], why["since"]) == ("success", "Near(arm.tcp, goal)", 2)
    assert first == {
        "seed": 4,
        "variation": 0,
        "success": True,
        "success_at_end": False,
        "first_success": 1,
        "success_held_s": pytest.approx(0.1),
        "failed_at": None,
        "steps": 1,
        "stage": "there",
        "peak_robot_force": 0.0,
    }
    assert [episode["steps"] for episode in data["episodes"]] == [1, 7, 12]


def test_episodes_are_others_than_those_of_training_unless_seeds_are_given(run, policy):
    ran = run("evaluate", "pushing.npz", "--episodes", "1", *HERE, "--json")
    assert [episode["seed"] for episode in ran.data["episodes"]] == [2_000_000]


def test_any_number_of_processes_measures_the_same(run, policy):
    words = ("evaluate", "pushing.npz", "--episodes", "3", "--task-path", ".")
    assert run(*words, "--jobs", "1").out == run(*words, "--jobs", "2").out


def test_a_result_and_films_are_written(run, policy):
    words = ("evaluate", "pushing.npz", "--episodes", "3", "--seed", "4", *HERE, *SMALL)
    ran = run(*words, "--out", "new/folder", "--video")
    names = ["best.mp4", "best.gif", "median.mp4", "median.gif", "failed.mp4", "failed.gif"]
    files = [f"new/folder/sideways-pushing{name}" for name in (".json", *(f"-{n}" for n in names))]
    assert (ran.status, ran.err) == (0, "")
    assert ran.out.splitlines()[-8:] == ["", *files]
    assert sorted(str(file) for file in Path("new/folder").iterdir()) == sorted(files)
    assert json.loads(Path(files[0]).read_text())["seeds"]["failed"] == 6
    lengths = [_seconds(files[number]) for number in (1, 3, 5)]
    assert lengths == pytest.approx([2.2, 2.2, 2.2], abs=0.1)  # to the end, and a second more
    assert len({Path(files[number]).read_bytes() for number in (2, 4, 6)}) == 3


def _seconds(name):
    film = cv2.VideoCapture(name)
    return film.get(cv2.CAP_PROP_FRAME_COUNT) / film.get(cv2.CAP_PROP_FPS)


def test_films_go_to_a_folder_of_their_own_and_each_episode_is_shown_once(run, policy):
    words = ("evaluate", "pushing.npz", "--episodes", "1", "--seed", "5", *HERE, *SMALL)
    ran = run(*words, "--video", "--json")
    assert ran.data["files"] == [f"evaluations/sideways-pushing-best.{e}" for e in ("mp4", "gif")]


def test_a_run_is_measured_by_the_policy_in_its_folder(run, policy):
    task = str(policy.with_name("sideways.yaml"))
    folder = write_run(Path("runs/sideways-scratch-3"), task=task, steps=400, every=100)
    policy.rename(folder / "policy.npz")
    # The task is found where training found it, with no folder named.
    words = ("--episodes", "1", "--jobs", "1", "--out", "o", "--trust")
    ran = run("evaluate", "runs/sideways-scratch-3", *words)
    assert (ran.status, ran.err) == (0, "")
    assert ran.out.splitlines()[-1] == "o/sideways-scratch-3.json"


def test_policies_of_the_whole_scene_are_called_so_and_play_in_it(run, policy):
    scene = {"observe": "scene", "frame": "base", "rotation": "matrix", "variation": 1}
    save_policy(policy, sideways(seen=24, env=scene, track="demos", starts=0.5, step=None))
    ran = run("evaluate", "pushing.npz", "--episodes", "1", *HERE)
    assert ran.status == 0, ran.err
    _, saw, options, track, trained, *_ = ran.out.splitlines()
    assert saw == "  observed  the whole scene, more than the task file lists for each robot"
    assert options == "  options   observe: scene, frame: base"
    assert track == (
        "  track     demos: demonstrations of the expert, episodes that may begin in its states"
    )
    assert trained.startswith("  trained   maddpg with the reward ratchet · unknown control steps")


def test_the_variation_is_that_of_training_unless_another_is_asked_for(run, policy):
    save_policy(policy, sideways(env={**ENV, "variation": 4}))
    ran = run("evaluate", "pushing.npz", *HERE)
    assert (ran.status, ran.out) == (2, "")
    assert ran.err == (
        "taskbuilder: sideways has no variation 4; it has 1 to 1, and 0 is the plain task\n"
    )
    words = ("evaluate", "pushing.npz", "--episodes", "1", *HERE)
    assert run(*words, "--variation", "1").status == 0
    save_policy(policy, sideways(env={**ENV, "variation": "random"}))
    assert run(*words).status == 0
    ran = run(*words, "--video")
    assert ran.err == (
        "taskbuilder: films are of one variation, and the policy's is random; name --variation\n"
    )


def test_a_failing_policy_is_a_result_and_no_failure_of_the_command(run, policy):
    save_policy(policy, sideways(push=0.9, axis=2))
    ran = run("evaluate", "pushing.npz", "--episodes", "11", "--seed", "0", *HERE)
    assert ran.status == 0
    lines = ran.out.splitlines()
    assert "0 of 11 succeeded (0.0%), 95% interval 0.0% to 25.9%" in lines
    assert lines[-1] == "failed seeds: 0, 1, 2, 3, 4, 5, 6, 7, 8, 9 and 1 more"
    told = [line[:6] for line in lines if line[:6] in ("best  ", "median", "failed")]
    assert told == ["best  ", "median", "failed"]


@pytest.mark.parametrize(
    ("made", "said"),
    [
        (
            {"task": "side_ways"},
            'p.npz is for a task that is not here (no task "side_ways"; did you mean "sideways"?); '
            "name the folder of its files by --task-path",
        ),
        ({"seen": 12}, "p.npz: arm sees 12 numbers, in sideways as it is now 11; train it anew"),
        ({"said": 7}, "p.npz: arm acts by 7 numbers, in sideways as it is now 5; train it anew"),
        (
            {"agents": ("left", "right")},
            "p.npz plays left, right, and sideways as it is now has arm; train anew",
        ),
        ({"env": None}, "the policy does not say what its environment was; train it anew"),
        ({"env": {"observe": "all"}}, 'observe "all": one of: task, scene'),
        ({"env": {"variation": "x"}}, "variation is 'x'; sideways has 0 to 1, or \"random\""),
    ],
)
def test_a_policy_that_does_not_fit_is_refused_before_anything_is_played(made, said, run, policy):
    save_policy(Path("p.npz"), sideways(**made))
    ran = run("evaluate", "p.npz", *HERE, "--out", "new")
    assert (ran.status, ran.out, ran.err) == (2, "", f"taskbuilder: {said}\n")
    assert not Path("new").exists()


@pytest.mark.parametrize(
    ("share", "shown"),
    [(0.0, ""), (1e-6, "▏"), (1 / 48, "▌"), (1 / 24, "█"), (0.1, "██▍"), (1.0, "█" * 24)],
)
def test_bars_are_an_eighth_of_a_character_fine(share, shown):
    assert bar(share) == shown


# In `taskbuilder demo`


def test_trained_policies_play_in_demo(run, policy):
    words = ("--policy", "pushing.npz", "--episodes", "2", "--seed", "5", "--jobs", "1")
    ran = run("demo", "sideways.yaml", *words, *SMALL)
    assert (ran.status, ran.err) == (1, "")
    assert ran.out.splitlines() == [
        "seed 5  success  return     2.04  7 of 12 steps",
        "        lost at the end: Near(arm.tcp, goal): 9.7 cm, within 3 cm is needed "
        "(since step 10)",
        "seed 6  failed   return    -2.17  furthest stage: there",
        "        Near(arm.tcp, goal): 31.8 cm, within 3 cm is needed (since step 1)",
        "1 of 2 succeeded (50%) · median 7 steps",
        "demos/sideways-strip.png",
        "demos/sideways-rewards.png",
    ]


def test_demo_plays_and_shows_a_policy_in_the_environment_that_it_was_trained_in(run, policy):
    # Turned by half a turn, the base's y is the other way: played or shown in the task's own
    # frames the arm would miss the goals on its way.
    text = Path("sideways.yaml").read_text()
    turned = text.replace(
        "base: {position: [0, 0, 0]}", "base: {position: [0.9, 0, 0], rpy_deg: [0, 0, 180]}"
    )
    Path("sideways.yaml").write_text(turned)
    pictures = []
    for push, frame in ((0.5, "task"), (-0.5, "base")):
        save_policy(policy, sideways(push, env={**ENV, "frame": frame}))
        ran = run("demo", "sideways.yaml", "--policy", "pushing.npz", "--seed", "5", *SMALL)
        assert ran.out.splitlines()[0] == "seed 5  success  return     2.04  7 of 12 steps"
        pictures.append(Path("demos/sideways-strip.png").read_bytes())
    assert pictures[0] == pictures[1]


def test_demo_refuses_a_policy_of_another_task(run, policy, good):
    ran = run("demo", "good.yaml", "--policy", "pushing.npz")
    assert (ran.status, ran.out) == (2, "")
    assert ran.err == "taskbuilder: pushing.npz was trained on sideways, not on good\n"
    assert not Path("demos").exists()


def test_all_variations_are_evaluated_and_the_worst_is_named(run, policy):
    words = ("evaluate", "pushing.npz", "--episodes", "6", "--seed", "0", *HERE)
    ran = run(*words, "--variation", "all", "--controls", "0", "--out", "o")
    assert (ran.status, ran.err) == (0, "")
    *_, head, first, second, _, worst, _, file = ran.out.splitlines()
    assert head.split() == [
        "variation",
        "succeeded",
        "95%",
        "interval",
        "at",
        "the",
        "last",
        "step",
    ]
    kept = json.loads(Path(file).read_text())
    assert [result["variation"] for result in kept["variations"]] == [0, 1]
    for line, result in zip((first, second), kept["variations"], strict=True):
        number = str(result["variation"])
        alone = run(*words, "--variation", number, "--controls", "0", "--json").data
        assert {k: result[k] for k in ("success_rate", "return")} == {
            k: alone[k] for k in ("success_rate", "return")
        }
        assert line.split()[:4] == [
            number,
            str(round(6 * alone["success_rate"])),
            "of",
            "6",
        ]
    rates = [result["success_rate"] for result in kept["variations"]]
    assert rates[kept["worst"]] == min(rates)
    assert worst == f"worst: variation {kept['worst']}, {min(rates):.1%}"
    told = run(*words, "--variation", "all", "--controls", "0", "--json")
    assert told.data["variations"] == kept["variations"]


@pytest.mark.parametrize("option", ["--video", "--certificate"])
def test_what_is_of_one_variation_is_refused_for_all(run, policy, option):
    value = ("c.json",) if option == "--certificate" else ()
    ran = run("evaluate", "pushing.npz", *HERE, "--variation", "all", option, *value)
    assert (ran.status, ran.out) == (2, "")
    assert ran.err == (f"taskbuilder: {option} is of one variation; name it by its number\n")


def test_observations_are_disturbed_where_asked(run):
    words = ("evaluate", "zoo:handover/demos", "--episodes", "1", "--jobs", "1", "--json")
    plain, disturbed = (
        run(*words, "--noise", noise, "--controls", "1").data for noise in ("0", "0.02")
    )
    assert disturbed["return"] != plain["return"]
    for name, control in plain["controls"].items():  # the baselines are not disturbed
        assert disturbed["controls"][name]["return"] == control["return"]


def test_what_disturbs_is_told(run, policy):
    words = ("evaluate", "pushing.npz", "--episodes", "1", "--controls", "0", *HERE)
    ran = run(*words, "--noise", "0.2", "--randomize", "quantities")
    assert "  disturbed  randomize: True, position_noise: 0.2\n" in ran.out
    assert "disturbed" not in run(*words).out
