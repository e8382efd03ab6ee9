"""Policy servers: the protocol of openpi's servers, and the errors if one fails."""

from __future__ import annotations

import threading
from contextlib import closing, contextmanager

import numpy as np
import pytest
from websockets.sync.server import serve

from taskbuilder.cli import main
from taskbuilder.data.collecting import collect
from taskbuilder.data.dataset import load_dataset
from taskbuilder.data.plan import CollectPlan
from taskbuilder.env.parallel import parallel_env
from taskbuilder.errors import UsageError
from taskbuilder.policies.messages import MessageError, packed, unpacked
from taskbuilder.policies.served import PolicyServer, ServerError, read_server
from taskbuilder.rollout.play import play

CHUNK = 4


@contextmanager
def served(answer, metadata=None):
    """A policy server on a free port; it answers each observation by a function of it."""

    def handle(connection):
        connection.send(packed(metadata or {}))
        for content in connection:
            connection.send(answer(unpacked(content)))

    with serve(handle, "127.0.0.1", 0, compression=None, max_size=None) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield f"ws://127.0.0.1:{server.socket.getsockname()[1]}"
        finally:
            server.shutdown()
            thread.join()


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """An episode of the expert."""
    folder = tmp_path_factory.mktemp("data") / "reach"
    collect(CollectPlan(("reach",), 1), folder)
    return load_dataset(folder)[0]


class Replay:
    """Answers chunks of recorded actions, and keeps what it was asked."""

    def __init__(self, episode):
        self.actions = np.concatenate(list(episode.actions.values()), axis=1)
        self.asked = []
        self.played = 0

    def __call__(self, observation):
        self.asked.append(observation)
        chunk = self.actions[self.played : self.played + CHUNK]
        self.played += len(chunk)
        return packed({"actions": chunk, "server_timing": {"infer_ms": 0.1}})


def test_a_served_policy_plays_chunks(recorded):
    replay = Replay(recorded)
    with served(replay, {"model": "replay"}) as address, closing(parallel_env("reach")) as env:
        policy = PolicyServer(address, "reach")(env)
        rollout = play(env, policy, recorded.seed)
        policy.close()
    assert policy.metadata == {"model": "replay"}
    assert rollout.success
    np.testing.assert_array_equal(rollout.actions["arm"], recorded.actions["arm"])
    assert len(replay.asked) == -(-recorded.steps // CHUNK)
    first = replay.asked[0]
    assert list(first) == ["observation/state", "prompt"]
    assert first["prompt"] == recorded.instruction
    joints = recorded.arrays["agents/arm/joint_position"]
    np.testing.assert_array_equal(first["observation/state"][:-1], joints[0].astype(np.float32))
    second = replay.asked[1]["observation/state"][:-1]
    np.testing.assert_array_equal(second, joints[CHUNK].astype(np.float32))


def test_pictures_are_sent_and_chunks_cut():
    asked = []

    def still(observation):
        asked.append(observation)
        return packed({"actions": np.zeros((CHUNK, 10))})

    with served(still) as address:
        server = read_server(f"{address}/handover?cameras=front,left_wrist&size=48x32&steps=2")
        assert server.task == "handover"
        with closing(parallel_env("handover", horizon=6, **server.options)) as env:
            play(env, server(env), 3)
    assert len(asked) == 3
    for camera in ("front", "left_wrist"):
        picture = asked[0][f"observation/images/{camera}"]
        assert picture.shape == (32, 48, 3)
        assert picture.dtype == np.uint8


def test_the_renderer_of_pictures_can_be_named():
    seen = {}
    for renderer in ("tiny", "raster"):
        asked = []

        def still(observation, asked=asked):
            asked.append(observation["observation/images/front"])
            return packed({"actions": [0.0] * 10})

        with served(still) as address:
            where = f"{address}/handover?cameras=front&size=48x32&renderer={renderer}"
            server = read_server(where)
            with closing(parallel_env("handover", horizon=1, **server.options)) as env:
                play(env, server(env), 3)
        seen[renderer] = asked[0]
    assert (seen["tiny"] != seen["raster"]).any()
    wrong = read_server("ws://localhost:8000/handover?cameras=front&renderer=rastre").options
    with pytest.raises(UsageError, match='did you mean "raster"'):
        parallel_env("handover", **wrong)


def test_one_action_is_a_chunk_of_one():
    with (
        served(lambda _: packed({"actions": [0.0] * 10})) as address,
        closing(parallel_env("handover", horizon=2)) as env,
    ):
        assert play(env, PolicyServer(address, "handover")(env), 3).steps == 2


@pytest.mark.parametrize(
    ("answer", "said"),
    [
        (
            packed({"actions": np.zeros((4, 7))}),
            r"\(4, 7\); handover takes \(steps, 10\): le",
        ),
        (packed({}), "actions of shape none"),
        (packed({"actions": np.full(10, np.nan)}), "not finite"),
        ("Traceback ...\nValueError: no such key", "failed: ValueError: no such key"),
        (b"\xc1", "is no policy server: it sends no message"),
        (packed({"actions": {"x": 1}}), "answers actions that are no numbers"),
    ],
)
def test_a_wrong_answer_is_explained(answer, said):
    with served(lambda _: answer) as address, closing(parallel_env("handover")) as env:
        policy = PolicyServer(address, "handover")(env)
        with pytest.raises(ServerError, match=said):
            play(env, policy, 3)


def test_a_server_that_goes_away_is_told():
    def ends(_):
        raise ValueError("out of memory")

    with served(ends) as address, closing(parallel_env("handover")) as env:
        policy = PolicyServer(address, "handover")(env)
        with pytest.raises(ServerError, match="was lost"):
            play(env, policy, 3)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("ws://localhost/handover", "is no address of a policy server"),
        ("ws://localhost:99999/handover", "is no address of a policy server"),
        ("ws://localhost:8000/handover?camera=front", 'no option "camera"; did you mean "cameras"'),
        ("ws://localhost:8000/handover?size=big", '"big" in .* is no whole number'),
        ("ws://localhost:8000/handover?steps=0", '"0" in .* is no whole number'),
    ],
)
def test_a_wrong_address_is_explained(name, said):
    with pytest.raises(UsageError, match=said):
        read_server(name)


def test_messages_keep_arrays_and_refuse_other_things():
    message = {"a": np.arange(6, dtype=np.int16).reshape(2, 3), "b": [np.float64(0.5)], "c": "x"}
    again = unpacked(packed(message))
    np.testing.assert_array_equal(again["a"], message["a"])
    assert again["a"].dtype == np.int16
    assert (again["b"], again["c"]) == ([0.5], "x")
    with pytest.raises(TypeError, match="cannot hold"):
        packed({"a": object()})
    lie = {b"__ndarray__": True, b"data": b"12", b"dtype": "<f4", b"shape": [9]}
    other = {b"__ndarray__": True, b"data": b"12345678", b"dtype": "|O", b"shape": [1]}
    for wrong in (lie, other, {b"__ndarray__": True}):
        with pytest.raises(MessageError):
            unpacked(packed({"a": wrong}))


def test_a_served_policy_is_evaluated(recorded, capfd, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = ["--episodes", "1", "--seed", str(recorded.seed), "--controls", "0", "--jobs", "1"]
    with served(Replay(recorded)) as address:
        assert main(["evaluate", f"{address}/reach", *words, "--out", "out"]) == 0
        assert "1 of 1" in capfd.readouterr().out
        assert (tmp_path / "out/reach-served.json").is_file()
        assert main(["evaluate", f"{address}/reach", *words, "--certificate", "c.json"]) == 2
        assert "has no certificate" in capfd.readouterr().err
        assert main(["evaluate", f"{address}/rech", *words]) != 0
        assert 'did you mean "reach"' in capfd.readouterr().err
    assert main(["evaluate", f"{address}/reach", *words]) == 1
    said = capfd.readouterr().err
    assert f"no policy server answers at {address}" in said
    assert "Traceback" not in said
