"""Benchmarks that are really run: on two quick tasks, with next to no budget."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from threading import Thread

import numpy as np
import pytest
from made_benchmarks import ACTING, QUICK, write_suite
from websockets.sync.server import serve
from work_elsewhere import Ending

import taskbuilder
from taskbuilder.benchmark.records import CELL, CellRecord, cell_folder, read
from taskbuilder.errors import UnknownNameError, UsageError
from taskbuilder.policies.messages import packed, unpacked
from taskbuilder.rollout.players import HoldStill
from taskbuilder.schema.catalogue import Catalogue

pytest.importorskip("torch")

TINY = ("hidden=[8]", "batch=16")
KNOWN = {"track": QUICK, "algorithm": "bc", "settings": TINY}


def results_of(folder: Path) -> dict[str, tuple[str, str]]:
    """What must not depend on how cells were shared out: episodes, and the policies' bytes."""
    found = {}
    for file in sorted(folder.glob("cells/*/cell.json")):
        certificate = file.with_name("certificate-1.json")
        played = json.loads(certificate.read_text())["seals"] if certificate.exists() else {}
        policy = file.parent / "run" / "policy.npz"
        content = policy.read_bytes().hex() if policy.exists() else ""
        found[file.parent.name] = (played.get("episodes", ""), content)
    return found


@pytest.fixture(scope="module")
def ran(tmp_path_factory, catalogue) -> tuple[Path, list[CellRecord]]:
    """A benchmark that was run in this process; its folder, and the cells as they were told."""
    folder, told = tmp_path_factory.mktemp("ran"), []
    taskbuilder.benchmark(
        "few", folder, **KNOWN, seeds=(11, 12), catalogue=catalogue, report=told.append
    )
    return folder, told


def test_every_cell_is_trained_and_evaluated_with_a_certificate(ran, catalogue):
    folder, told = ran
    done = [cell for cell in told if cell.status == "done"]
    assert [(cell.task, cell.seed, cell.episodes) for cell in done] == [
        ("sideways", 11, 4),
        ("sideways", 12, 4),
    ]
    assert all(cell.train_cpu_s > 0 and cell.evaluate_cpu_s > 0 for cell in done)
    assert done[0].versions["taskbuilder"] == taskbuilder.__version__
    place = cell_folder(folder, "sideways", 11)
    certificate = json.loads((place / "certificate-1.json").read_text())
    assert certificate["seeds"] == [*range(3_100_000, 3_100_004)]
    assert certificate["options"]["variation"] == 1
    assert taskbuilder.verify(place / "certificate-1.json", jobs=1, catalogue=catalogue).verified


def test_seeds_differ_and_learn_from_the_same_demonstrations(ran):
    folder, _ = ran
    runs = [json.loads((folder / f"cells/sideways-{s}/run/run.json").read_text()) for s in (11, 12)]
    assert runs[0]["data_seal"] == runs[1]["data_seal"]
    found = results_of(folder)
    assert found["sideways-11"] != found["sideways-12"]
    dataset = taskbuilder.load_dataset(folder / "shared" / "sideways")
    assert [episode.variation for episode in dataset] == [0, 0, 0]
    assert dataset[0].seed >= 500_000
    told = json.loads((folder / "tasks" / "sideways.json").read_text())["demonstrator"]
    assert {episode.policy for episode in dataset} == {told} == {"noisy:0.1@0.25"}


def test_a_task_without_an_expert_is_a_row_with_its_reason(ran):
    _, told = ran
    lost = [cell for cell in told if cell.task == "lonely"]
    assert [cell.status for cell in lost] == ["impossible", "impossible"]
    assert lost[0].reason == (
        "lonely has no expert, and the track imitation needs its demonstrations"
    )


def test_what_is_there_is_not_done_again(ran, catalogue):
    folder, _ = ran
    file = cell_folder(folder, "sideways", 11) / CELL
    before = file.stat().st_mtime_ns
    results = taskbuilder.benchmark("few", folder, **KNOWN, seeds=(11, 12), catalogue=catalogue)
    assert file.stat().st_mtime_ns == before
    assert (results.missing, [task.impossible for task in results.tasks]) == (0, [False, True])


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"settings": ("hidden=[16]",)}, r"method: bc hidden=\[8\] batch=16 there, bc hidden="),
        (
            {"track": QUICK.model_copy(update={"episodes": 5})},
            "track: its episodes differ",
        ),
        ({"track": "vision"}, "track: imitation, version 2, changed: not comparable there, vision"),
    ],
)
def test_a_folder_of_another_benchmark_is_refused(ran, catalogue, changed, said):
    with pytest.raises(UsageError, match=said):
        taskbuilder.benchmark("few", ran[0], **{**KNOWN, **changed}, catalogue=catalogue)


def test_other_files_are_left_alone(folder, catalogue):
    folder.mkdir()
    (folder / "thesis.tex").write_text("")
    with pytest.raises(UsageError, match=r"holds other files \(thesis.tex\)"):
        taskbuilder.benchmark("few", folder, **KNOWN, catalogue=catalogue)


def test_shared_demonstrations_of_another_track_are_refused(ran, folder, catalogue):
    with pytest.raises(UsageError, match="is shared by methods on the track imitation, version 2"):
        taskbuilder.benchmark(
            "few",
            folder,
            track=ACTING,
            policy="hold",
            only=["sideways"],
            shared=ran[0] / "shared",
            catalogue=catalogue,
        )


def test_policies_that_exist_are_only_evaluated(folder, catalogue, ran):
    text = f"{ran[0]}/cells/{{task}}-{{seed}}/run"
    known = {"track": QUICK, "only": ["sideways"], "catalogue": catalogue}
    known |= {"shared": ran[0] / "shared"}
    results = taskbuilder.benchmark("few", folder, policy=text, seeds=(12,), **known)
    (cell,) = results.tasks[0].there
    was = read(cell_folder(ran[0], "sideways", 12) / CELL, CellRecord)
    assert (cell.successes_at_end, cell.mean_return) == (was.successes_at_end, was.mean_return)
    assert cell.train_cpu_s == 0.0
    assert results.missing == 1


def test_a_policy_server_is_asked_for_every_task_and_has_no_certificate(folder, catalogue):
    def handle(connection):
        connection.send(packed({}))
        for content in connection:
            asked.append(unpacked(content)["prompt"])
            connection.send(packed({"actions": np.zeros((12, 5), np.float32)}))

    asked: list[str] = []
    with serve(handle, "127.0.0.1", 0, compression=None, max_size=None) as server:
        Thread(target=server.serve_forever).start()
        results = taskbuilder.benchmark(
            "few",
            folder,
            track=ACTING,
            policy=f"ws://127.0.0.1:{server.socket.getsockname()[1]}/{{task}}",
            catalogue=catalogue,
        )
        server.shutdown()
    cells = [task.there[0] for task in results.tasks]
    assert [(cell.status, cell.reason, cell.certificates) for cell in cells] == [
        ("done", "", ())
    ] * 2
    assert len(asked) == 2 * ACTING.episodes


def test_a_policy_of_ones_own_has_no_certificate(ran, folder, catalogue):
    known = {"track": QUICK, "only": ["sideways"], "catalogue": catalogue}
    known |= {"shared": ran[0] / "shared"}
    results = taskbuilder.benchmark("few", folder, policy=HoldStill(), **known)
    (cell,) = results.tasks[0].there
    assert (cell.seed, cell.status, cell.episodes, cell.certificates) == (11, "done", 4, ())
    assert results.name == "taskbuilder.rollout.players.HoldStill"


class Broken:
    """A policy whose weights are not there."""

    def reset(self, env, seed):
        raise FileNotFoundError("weights.bin")

    def act(self, observations):
        return observations


def test_a_method_that_breaks_is_a_row_and_is_tried_again(ran, folder, catalogue):
    known = {"track": QUICK, "only": ["sideways"], "catalogue": catalogue}
    known |= {"shared": ran[0] / "shared"}
    (cell,) = taskbuilder.benchmark("few", folder, policy=Broken(), **known).tasks[0].there
    assert (cell.status, cell.reason) == ("failed", "FileNotFoundError: weights.bin")
    trace = cell_folder(folder, "sideways", 11) / "error.txt"
    assert 'raise FileNotFoundError("weights.bin")' in trace.read_text()
    before = (trace.parent / CELL).stat().st_mtime_ns
    taskbuilder.benchmark("few", folder, policy=Broken(), **known)
    assert (trace.parent / CELL).stat().st_mtime_ns > before


@pytest.mark.slow
def test_a_cell_that_ends_its_process_is_a_row_and_the_others_go_on(folder, catalogue):
    results = taskbuilder.benchmark(
        "few", folder, track=ACTING, policy=Ending(), jobs=2, catalogue=catalogue
    )
    ended, other = (task.there[0] for task in results.tasks)
    assert (ended.status, other.status) == ("failed", "done")
    assert ended.reason.startswith("a process ")
    assert results.scores() == [(0.0,), (other.successes_at_end / 2,)]


def test_learning_by_acting_has_no_demonstrations(folder, catalogue):
    results = taskbuilder.benchmark(
        "few",
        folder,
        track=ACTING,
        algorithm="ppo",
        settings=("hidden=[8]", "rollout_steps=6"),
        seeds=(11,),
        only=["lonely"],
        catalogue=catalogue,
    )
    (cell,) = results.tasks[1].there
    assert (cell.status, cell.reason, cell.episodes) == ("done", "", 2)
    assert not (folder / "shared" / "lonely").exists()
    plan = json.loads((cell_folder(folder, "lonely", 11) / "run" / "run.json").read_text())
    assert (plan["steps"], plan["observe"], plan["variation"]) == (48, "scene", 0)


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({}, "name either an algorithm"),
        ({"algorithm": "bc", "policy": "hold"}, "name either an algorithm"),
        ({"algorithm": "maddpq"}, 'no algorithm "maddpq"; did you mean "maddpg'),
        ({"algorithm": "maddpg"}, "maddpg learns by acting, and the track imitation"),
        ({"algorithm": "bc", "track": "reinforcement"}, "bc learns from a data set, and the track"),
        ({"algorithm": "bc", "settings": ("nois=0.1",)}, 'did you mean "noise"'),
        ({"algorithm": "bc", "preset": "clonin"}, 'did you mean "cloning"'),
        ({"algorithm": "bc", "only": ["sidewise"]}, 'no task "sidewise"; did you mean "sideways"'),
        ({"algorithm": "bc", "seeds": ()}, "at least one seed"),
        (
            {"algorithm": "bc", "track": QUICK, "smoke": True},
            "smoke shortens a track of the library",
        ),
        ({"policy": "hold", "seeds": (1,)}, "hold is not trained here, so it has no seeds"),
        ({"policy": "hold", "settings": ("noise=0",)}, "a policy has no preset and no settings"),
    ],
)
def test_what_cannot_be_run_is_told_before_anything_is_written(folder, catalogue, asked, said):
    with pytest.raises(UsageError, match=said):
        taskbuilder.benchmark("few", folder, catalogue=catalogue, **asked)
    assert not folder.exists()


def test_an_unknown_suite_is_told(folder, catalogue):
    with pytest.raises(UnknownNameError, match='no suite "fewe"; did you mean "few"'):
        taskbuilder.benchmark("fewe", folder, algorithm="bc", catalogue=catalogue)


KILLED = """\
import sys, taskbuilder
from made_benchmarks import QUICK
from taskbuilder.schema.catalogue import Catalogue

tasks, folder, shared = sys.argv[1:]
taskbuilder.benchmark(
    "few", folder, track=QUICK, algorithm="bc", settings=("hidden=[8]", "batch=16"),
    seeds=(11, 12), shared=shared, catalogue=Catalogue.discover([tasks]),
)
"""


@pytest.mark.slow
def test_a_killed_benchmark_goes_on_in_several_processes_to_the_same_results(ran, folder, tmp_path):
    """Killed as the training of its first cell began."""
    (tmp_path / "tasks").mkdir()
    tasks = write_suite(tmp_path / "tasks")
    words = [sys.executable, "-c", KILLED, str(tasks), str(folder), str(ran[0] / "shared")]
    path = os.pathsep.join([str(Path(__file__).parents[1]), os.environ.get("PYTHONPATH", "")])
    child = subprocess.Popen(words, env={**os.environ, "PYTHONPATH": path})
    begun = cell_folder(folder, "sideways", 11) / "run" / "run.json"
    while not begun.exists():
        assert child.poll() is None
        time.sleep(0.01)
    child.send_signal(signal.SIGKILL)
    child.wait()
    assert len(list(folder.glob("cells/*/cell.json"))) < 4
    catalogue = Catalogue.discover([str(tasks)])
    known = {**KNOWN, "seeds": (11, 12), "catalogue": catalogue, "shared": ran[0] / "shared"}
    assert taskbuilder.benchmark("few", folder, **known, jobs=2).missing == 0
    assert results_of(folder) == results_of(ran[0])
    assert not (folder / "shared").exists()
