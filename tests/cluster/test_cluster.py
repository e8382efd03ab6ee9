"""Work spread over a Ray cluster: the same results, whatever happens to its nodes."""

from __future__ import annotations

import json
import os
import shutil
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import ray
from ray.cluster_utils import Cluster

from taskbuilder import cluster as clusters
from taskbuilder.cli import main
from taskbuilder.cluster import cluster
from taskbuilder.data import layout
from taskbuilder.data.checking import check_dataset
from taskbuilder.data.collecting import CollectProgress, collect
from taskbuilder.data.plan import CollectPlan
from taskbuilder.errors import UsageError
from taskbuilder.jobs import LostError
from taskbuilder.policies.mixture import PolicyShare
from taskbuilder.policies.zoo import load_policy, policy_file

pytestmark = [
    pytest.mark.filterwarnings("ignore::DeprecationWarning:ray.*"),
    pytest.mark.filterwarnings("ignore::FutureWarning:ray.*"),
    pytest.mark.filterwarnings("ignore::ResourceWarning"),  # Ray's own sockets and files
]


@pytest.fixture(scope="module")
def nodes() -> Iterator[Cluster]:
    """A cluster of two nodes with one core each, which find the functions below."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", str(Path(__file__).parent))
        patch.setenv("RAY_worker_niceness", "0")  # as patient as the tests are
        yield from _nodes()


def _nodes() -> Iterator[Cluster]:
    made = Cluster(initialize_head=True, head_node_args={"num_cpus": 1})
    made.add_node(num_cpus=1)
    yield made
    made.shutdown()


def double(number: int) -> int:
    return 2 * number


def where(_: int) -> str:
    time.sleep(0.2)
    return ray.get_runtime_context().get_node_id()


def directory(_: int) -> str:
    return str(Path.cwd())


def wrong(number: int) -> int:
    raise UsageError(f"{number} is wrong")


def wrong_or_long(number: int) -> int:
    if number == 7:
        return wrong(number)
    time.sleep(number)
    return number


def ends(_: int) -> None:
    os._exit(3)


def test_results_come_in_order(nodes: Cluster) -> None:
    with cluster(nodes.address) as spread:
        assert list(spread(double, range(50))) == [2 * number for number in range(50)]


@pytest.mark.slow
def test_all_nodes_work_in_the_callers_directory(
    nodes: Cluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with cluster(nodes.address) as spread:
        # So many that the second node has a process before the first has done them all.
        assert len(set(spread(where, range(30)))) == 2
        assert set(spread(directory, range(4))) == {str(tmp_path)}


def test_errors_come_back_as_they_were_raised(nodes: Cluster) -> None:
    with cluster(nodes.address) as spread, pytest.raises(UsageError, match="7 is wrong"):
        list(spread(wrong, [7]))


def test_many_errors_leave_a_cluster_as_it_was(nodes: Cluster) -> None:
    with cluster(nodes.address) as spread:
        for _ in range(100):
            with pytest.raises(UsageError, match="7 is wrong"):
                list(spread(wrong, [7, 8]))
        assert list(spread(double, range(4))) == [0, 2, 4, 6]


@pytest.mark.slow
def test_work_that_nobody_waits_for_ends_with_the_cluster(nodes: Cluster) -> None:
    begun = time.monotonic()
    with cluster(nodes.address) as spread, pytest.raises(UsageError, match="7 is wrong"):
        list(spread(wrong_or_long, [7, 600]))
    assert time.monotonic() - begun < 60
    with cluster(nodes.address) as spread:
        assert list(spread(double, range(4))) == [0, 2, 4, 6]


@pytest.mark.slow
def test_work_that_ends_its_process_is_given_up(nodes: Cluster) -> None:
    with cluster(nodes.address) as spread, pytest.raises(LostError, match="was lost"):
        list(spread(ends, [0]))


@pytest.mark.slow
def test_a_node_with_another_library_is_refused(
    nodes: Cluster, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(clusters, "library_digest", lambda: "another")
    with cluster(nodes.address) as spread, pytest.raises(UsageError, match="another taskbuilder"):
        list(spread(double, [1]))


@pytest.mark.slow
def test_a_node_of_another_kind_is_told(
    nodes: Cluster, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(clusters, "machine_kind", lambda: "another")
    with cluster(nodes.address) as spread:
        assert list(spread(double, [1, 2])) == [2, 4]
    assert caplog.text.count("is another kind of machine; its results may differ in bits") == 1


@pytest.mark.slow
def test_a_node_that_dies_costs_nothing_but_time(nodes: Cluster) -> None:
    third = nodes.add_node(num_cpus=1)
    with cluster(nodes.address) as spread:
        results = spread(where, range(12))
        first = next(results)
        nodes.remove_node(third)
        rest = list(results)
    assert len([first, *rest]) == 12
    assert third.node_id not in rest[-3:]


@pytest.mark.parametrize(
    ("address", "said"),
    [
        ("handover", "no address of a Ray cluster; write host:port"),
        ("127.0.0.1:99999", "no address"),
        ("127.0.0.1:9", "no Ray cluster answers at 127.0.0.1:9"),
    ],
)
def test_no_cluster_there(address: str, said: str) -> None:
    with pytest.raises(UsageError, match=said), cluster(address):
        pass


def evaluated(capfd: pytest.CaptureFixture[str], *words: str) -> Any:
    status = main(["evaluate", "zoo:handover/demos", "--episodes", "3", "--json", *words])
    assert status == 0
    return json.loads(capfd.readouterr().out)


@pytest.mark.slow
def test_an_evaluation_is_the_same_as_on_one_machine(
    nodes: Cluster, capfd: pytest.CaptureFixture[str]
) -> None:
    here = evaluated(capfd, "--jobs", "1")
    assert evaluated(capfd, "--ray", nodes.address) == here


COLLECT = ("collect", "handover", "--episodes", "4", "--cameras", "front", "--size", "32")


def collected(out: Path, *words: str) -> dict[str, bytes]:
    assert main([*COLLECT, "--out", str(out), *words]) == 0
    return {
        file.relative_to(out).as_posix(): file.read_bytes()
        for file in sorted(out.rglob("*"))
        if file.is_file()
    }


@pytest.mark.slow
def test_a_data_set_has_the_same_bytes_as_on_one_machine(nodes: Cluster, tmp_path: Path) -> None:
    here = collected(tmp_path / "here", "--jobs", "1")
    there = collected(tmp_path / "there", "--ray", nodes.address)
    assert there == here
    assert any(name.endswith("front.mp4") for name in there)
    assert collected(tmp_path / "there", "--ray", nodes.address) == here


@pytest.mark.slow
def test_a_node_that_dies_while_it_collects_costs_its_time_alone(
    nodes: Cluster, tmp_path: Path
) -> None:
    plan = CollectPlan(("reach",), 12, policies=(PolicyShare("random"),), keep_failures=True)
    collect(plan, tmp_path / "here")
    third = nodes.add_node(num_cpus=1)
    killed = []

    def kill(progress: CollectProgress) -> None:
        if progress.kept == 2 and not killed:
            killed.append(nodes.remove_node(third, allow_graceful=False))

    with cluster(nodes.address) as spread:
        collect(plan, tmp_path / "there", nodes=spread, report=kill)
    assert killed
    check = check_dataset(tmp_path / "there", 1.0)
    assert check.ok
    assert not check.elsewhere
    manifests = (tmp_path / name / layout.MANIFEST for name in ("here", "there"))
    assert len({manifest.read_bytes() for manifest in manifests}) == 1


@pytest.mark.slow
def test_collecting_on_nodes_goes_on_where_it_was(nodes: Cluster, tmp_path: Path) -> None:
    plan = CollectPlan(("reach",), 3)
    collect(plan, tmp_path / "out")
    before = layout.read_manifest(tmp_path / "out")
    (tmp_path / "out" / layout.MANIFEST).unlink()
    episode = next((tmp_path / "out" / layout.EPISODES).iterdir())
    (episode / layout.ARRAYS).write_bytes(b"half")
    with cluster(nodes.address) as spread:
        collect(plan, tmp_path / "out", nodes=spread)
    assert layout.read_manifest(tmp_path / "out") == before


@pytest.mark.slow
def test_trained_policies_travel_to_the_nodes(
    nodes: Cluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copyfile(policy_file("zoo:handover/demos"), tmp_path / "mine.npz")
    words = ("--policy", "./mine.npz", "--keep-failures", "--episodes", "2")
    there = collected(tmp_path / "there", *words, "--ray", nodes.address)
    assert there == collected(tmp_path / "here", *words, "--jobs", "1")


@pytest.mark.slow
def test_a_hopeless_task_stops_on_nodes_too(
    nodes: Cluster, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    words = ["collect", "reach", "--policy", "nothing", "--out", str(tmp_path / "out")]
    assert main([*words, "--episodes", "40", "--ray", nodes.address]) == 1
    said = capfd.readouterr().err
    assert "0 of 20 attempts at reach succeeded" in said
    assert "Exception ignored" not in said


@pytest.mark.slow
def test_tasks_are_validated_on_nodes(nodes: Cluster, capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["validate", "reach", "handover", "--level", "static", "--ray", nodes.address]) == 0
    told = capfd.readouterr().out
    assert told.index("reach · 1 robot") < told.index("handover · 2 robots") < told.index("ok in")


@pytest.mark.slow
def test_a_run_is_trained_on_a_node(
    nodes: Cluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    words = ["train", "reach", "--algorithm", "ppo", "--steps", "64", "--evaluate-episodes", "1"]
    words += ["--set", "rollout_steps=16", "epochs=1"]
    assert main([*words, "--out", "there", "--ray", nodes.address]) == 0
    assert main([*words, "--out", "here"]) == 0
    there, here = (load_policy(name).arrays() for name in ("there", "here"))
    for name, weights in here.items():
        np.testing.assert_array_equal(there[name], weights)


def test_processes_are_not_asked_for_beside_a_cluster(capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["validate", "reach", "--jobs", "2", "--ray"]) == 2
    assert "--jobs does not go with --ray" in capfd.readouterr().err
