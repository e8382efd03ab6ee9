"""Workers that die or hang: replaced, what they lost reported, nothing else touched."""

from __future__ import annotations

import logging
import os
import signal

import numpy as np
import pytest
from vector_tasks import alive, digest, random_actions, roll, row, without_final

from taskbuilder.env.backends import WorkerError
from taskbuilder.env.parallel import parallel_env

TIMEOUT_S = 1.0


def strike(env, worker, kind, task_file):
    if kind in ("raise", "hang"):
        task_file.with_suffix(".order").write_text(kind)
    else:
        os.kill(env.worker_pids[worker], getattr(signal, kind))


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["SIGKILL", "SIGSEGV", "SIGSTOP", "raise"])
def test_three_faults_of_a_kind_are_survived(vec, task_file, caplog, kind):
    env = vec(2, 2, timeout_s=TIMEOUT_S)
    env.reset(seed=1)
    actions = random_actions(env, 9)
    for number in range(3):
        env.step(actions[3 * number])
        before = env.worker_pids
        strike(env, number % 2, kind, task_file)
        _, rewards, terminations, truncations, infos = env.step(actions[3 * number + 1])
        replaced = [old != new for old, new in zip(before, env.worker_pids, strict=True)]
        assert sum(replaced) == 1
        assert infos["lost"].tolist() == replaced
        assert (truncations >= infos["lost"]).all()
        assert not terminations[replaced].any()
        assert rewards["left"][replaced] == 0.0
        assert infos["step"][replaced] == 0.0
        _, _, _, _, infos = env.step(actions[3 * number + 2])
        assert infos["lost"].tolist() == [0.0, 0.0]
        assert infos["step"][replaced] == 1.0
        assert not any(alive(pid) for pid in set(before) - set(env.worker_pids))
    assert len(caplog.records) == 3
    said = {"SIGSTOP": "did not answer within 1 s", "raise": "failed: RuntimeError: told to"}
    assert said.get(kind, f"was killed by {kind}") in caplog.text
    assert "worker 0 (environment 0)" in caplog.text or kind == "raise"


def test_other_workers_notice_nothing(vec):
    calm, struck = vec(4), vec(4, 2)
    actions = random_actions(calm, 14)
    expected = without_final(roll(calm, actions, seed=9))
    seen = [struck.reset(seed=9), struck.state()]
    for number, action in enumerate(actions):
        if number in (3, 4):
            os.kill(struck.worker_pids[0], signal.SIGKILL)
        seen += [struck.step(action), struck.state()]
    seen = without_final(seen)
    for index in (2, 3):
        assert digest(row(seen, index)) == digest(row(expected, index))
    assert digest(row(seen, 0)) != digest(row(expected, 0))


def test_a_lost_episode_ends_as_it_was_last_seen(vec):
    env = vec(2, 1)
    env.reset(seed=1)
    first, second = random_actions(env, 2)
    seen, _, _, _, before = env.step(first)
    state = env.state()
    os.kill(env.worker_pids[0], signal.SIGKILL)
    _, _, _, truncations, infos = env.step(second)
    assert truncations.all()
    assert infos["_final_obs"].all()
    np.testing.assert_array_equal(infos["final_obs"][1]["right"], seen["right"][1])
    np.testing.assert_array_equal(infos["final_state"], state)
    assert infos["final_info"]["step"].tolist() == [1.0, 1.0]
    assert infos["final_info"]["lost"].tolist() == [1.0, 1.0]
    np.testing.assert_array_equal(infos["final_info"]["team_reward"], before["team_reward"])


@pytest.mark.parametrize("mode", ["SameStep", "NextStep"])
def test_lost_environments_go_on_with_their_next_seed(vec, task_file, mode):
    env = vec(2, 1, autoreset=mode)
    first, second, third = random_actions(env, 3)
    single = parallel_env(task_file)
    single.reset(seed=6)
    expected, _ = single.reset()
    single.close()
    env.reset(seed=5)
    kept, earned, *_ = env.step(first)
    assert earned["right"].all()
    os.kill(env.worker_pids[0], signal.SIGKILL)
    observations, rewards, _, truncations, _ = env.step(second)
    assert truncations.all()
    assert not rewards["right"].any()
    if mode == "NextStep":
        np.testing.assert_array_equal(observations["left"], kept["left"])
        observations, rewards, _, truncations, infos = env.step(third)
        assert not truncations.any()
        assert rewards["left"].tolist() == infos["lost"].tolist() == [0.0, 0.0]
    np.testing.assert_array_equal(observations["left"][1], expected["left"])


def test_episodes_that_are_lost_before_they_begin_keep_their_seed(vec, task_file):
    env = vec(2, 1, autoreset="NextStep")
    first, second, third, fourth = random_actions(env, 4)
    single = parallel_env(task_file)
    single.reset(seed=6)
    expected, _ = single.reset()
    single.close()
    env.reset(seed=5)
    env.step(first)
    for actions in (second, third):  # the episode is lost, and then the beginning of the next one
        os.kill(env.worker_pids[0], signal.SIGKILL)
        assert env.step(actions)[3].all()
    observations, *_ = env.step(fourth)
    np.testing.assert_array_equal(observations["left"][1], expected["left"])


def test_a_reset_after_a_fault_is_an_ordinary_one(vec):
    env = vec(2, 2)
    before = digest(env.reset(seed=4))
    os.kill(env.worker_pids[1], signal.SIGKILL)
    assert digest(env.reset(seed=4)) == before


def test_where_a_worker_hangs_is_told(vec, task_file, caplog):
    env = vec(1, 1, timeout_s=TIMEOUT_S)
    env.reset(seed=1)
    strike(env, 0, "hang", task_file)
    env.step(random_actions(env, 1)[0])
    assert "did not answer within 1 s" in caplog.text
    assert "in trouble" in caplog.text  # the function that hangs


def test_a_worker_that_is_always_lost_is_an_error(vec, task_file, caplog):
    env = vec(2, 2, retries=1)
    env.reset(seed=1)
    action = random_actions(env, 1)[0]
    strike(env, 0, "raise", task_file)
    env.step(action)  # one of them is replaced
    env.step(action)  # which is forgotten once a step is complete
    # An edited description is no longer what the environments were made of.
    description = task_file.with_suffix(".py")
    text = description.read_text()
    description.write_text(text + "\n")
    os.kill(env.worker_pids[1], signal.SIGKILL)
    with pytest.raises(WorkerError, match="2 in a row") as caught:
        env.step(action)
    assert caught.value.worker == 1
    assert list(caught.value.environments) == [1]
    assert "ModuleNotFoundError" in caught.value.cause
    assert "Traceback" in caught.value.words
    description.write_text(text)
    env.reset(seed=1)
    env.step(action)


def test_faults_are_logged_as_warnings(vec, caplog):
    env = vec(3, 1)
    env.reset(seed=1)
    os.kill(env.worker_pids[0], signal.SIGSEGV)
    env.step(random_actions(env, 1)[0])
    (record,) = caplog.records
    assert record.levelno == logging.WARNING
    assert record.getMessage().startswith("worker 0 (environments 0 to 2) was killed by SIGSEGV")
    assert "Current thread" in record.getMessage()  # where it was at that moment


def test_an_interrupted_step_asks_for_a_reset_and_no_more(vec, monkeypatch):
    env = vec(2, 2)
    before = digest(env.reset(seed=1))
    pids = env.worker_pids
    worker = env._backend._workers[1]

    def interrupted(limit_s):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(worker, "wait", interrupted)
        with pytest.raises(KeyboardInterrupt):
            env.step(random_actions(env, 1)[0])
    assert digest(env.reset(seed=1)) == before
    assert env.worker_pids == pids
