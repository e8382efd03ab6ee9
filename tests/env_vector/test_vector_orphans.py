"""However their owner ends, no worker stays."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from vector_tasks import alive

from taskbuilder.env.vector import make_vec

OWNER = """
import sys, time
from taskbuilder.env.vector import make_vec
env = make_vec(sys.argv[1], 2, 2)
env.reset(seed=0)
print(*env.worker_pids, flush=True)
ending = sys.stdin.readline().strip()
if ending == "raise":
    raise RuntimeError("the owner's own")
if ending == "wait":
    time.sleep(60)
if ending == "work":
    while True:
        env.step(env.action_space.sample())
"""

# How the owner is asked to end, the signals that the first worker and the owner get, and what the
# owner is to say.
ENDINGS = {
    "exit": ("", None, None, ""),
    "exception": ("raise", None, None, "the owner's own"),
    "interrupt": ("work", None, signal.SIGINT, "KeyboardInterrupt"),
    "kill": ("work", None, signal.SIGKILL, ""),
    "kill with a stopped worker": ("wait", signal.SIGSTOP, signal.SIGKILL, ""),
}


SLOW = ("exception", "kill")
"""They end as others do: by themselves, and by a signal."""


@pytest.mark.parametrize(
    "ending",
    [pytest.param(name, marks=pytest.mark.slow if name in SLOW else ()) for name in ENDINGS],
)
def test_workers_end_with_their_owner(task_file, ending):
    asked, to_worker, to_owner, says = ENDINGS[ending]
    owner = subprocess.Popen(
        [sys.executable, "-W", "error", "-c", OWNER, str(task_file)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    with owner:
        pids = [int(pid) for pid in owner.stdout.readline().split()]
        assert len(pids) == 2
        assert all(map(alive, pids))
        owner.stdin.write(f"{asked}\n")
        owner.stdin.flush()
        if to_worker:
            os.kill(pids[0], to_worker)
        if to_owner:
            time.sleep(0.3)
            owner.send_signal(to_owner)
        try:
            out, err = owner.communicate(timeout=20)
        finally:
            owner.kill()
    assert out == ""
    assert says in err if says else err == ""
    assert "resource_tracker" not in err
    deadline = time.monotonic() + 5.0
    while any(map(alive, pids)) and time.monotonic() < deadline:
        time.sleep(0.02)
    assert not any(map(alive, pids))


def test_workers_do_not_mind_an_interrupt(vec):
    env = vec(1, 1)
    env.reset(seed=0)
    pids = env.worker_pids
    os.kill(pids[0], signal.SIGINT)
    _, _, _, _, infos = env.step(env.action_space.sample())
    assert infos["lost"].tolist() == [0.0]
    assert env.worker_pids == pids


def test_a_fork_of_the_owner_leaves_the_workers_alone(vec):
    env = vec(1, 1)
    env.reset(seed=0)
    fork = os.fork()
    if not fork:
        env.close()
        os._exit(0)
    os.waitpid(fork, 0)
    _, _, _, _, infos = env.step(env.action_space.sample())
    assert infos["lost"].tolist() == [0.0]


def test_a_vector_that_is_forgotten_takes_its_workers_along(task_file):
    env = make_vec(task_file, 1, 1)
    pids = env.worker_pids
    del env
    assert not any(map(alive, pids))


def test_workers_have_one_thread_a_library_and_print_nothing(vec, capfd):
    env = vec(1, 1)
    env.reset(seed=0)
    process = Path(f"/proc/{env.worker_pids[0]}")
    assert "OMP_NUM_THREADS=1" in (process / "environ").read_text().split("\0")
    assert {str((process / "fd" / number).readlink()) for number in "12"} == {os.devnull}
    env.close()
    assert capfd.readouterr() == ("", "")
