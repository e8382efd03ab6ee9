"""Work in several processes, some of which are lost."""

from __future__ import annotations

import logging
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import work_elsewhere as work

from taskbuilder import jobs
from taskbuilder.jobs import LostError, workers
from taskbuilder.processes import cores

LIMIT_S = 3.0


def alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def test_results_come_in_the_order_of_the_items():
    with workers(2) as spread:
        assert list(spread(work.double, range(7))) == [0, 2, 4, 6, 8, 10, 12]
        assert list(spread(work.double, [])) == []
        several = [spread(work.double, [n, n + 1]) for n in range(3)]
        assert [list(results) for results in reversed(several)] == [[4, 6], [2, 4], [0, 2]]


def test_all_processes_work_and_none_outlives_the_work():
    with workers(2) as spread:
        pids = set(spread(work.whose, range(4)))
    assert len(pids) == 2
    assert os.getpid() not in pids
    assert not any(map(alive, pids))


def test_one_process_is_this_one():
    with workers(1) as spread:
        assert set(spread(work.whose, range(2))) == {os.getpid()}


def test_errors_of_the_work_are_raised_here_and_the_rest_goes_on():
    with workers(2) as spread:
        results = spread(work.refuse, ["no"])
        assert list(spread(work.double, [1, 2])) == [2, 4]
        with pytest.raises(ValueError, match="no") as caught:
            next(results)
        assert "work_elsewhere.py" in caught.value.__notes__[0]


@pytest.mark.parametrize("how", ["SIGKILL", "SIGTERM", "SIGSTOP"])
def test_the_work_of_a_lost_process_is_done_again(how, tmp_path, caplog):
    doings = [("none", ""), (how, str(tmp_path / "done")), ("none", "")]
    with workers(2) as spread:
        assert list(spread(work.once, doings * 1)) == ["none", how, "none"]
    (record,) = caplog.records
    assert record.levelno == logging.WARNING
    assert "its work is done again" in record.getMessage()


def test_work_whose_processes_are_lost_again_and_again_is_given_up():
    with workers(2) as spread:
        results = spread(work.always, ["kill", "nothing"])
        with pytest.raises(LostError, match=r"killed by SIGKILL \(2 in a row\)") as caught:
            next(results)
    assert (caught.value.item, caught.value.fault.outside) == ("kill", True)


@pytest.mark.parametrize(
    ("how", "said"),
    [
        ("exit", "ended with status 0"),
        ("crash", "killed by SIGSEGV"),
        ("hang", "did not come back within 3 s"),
        ("interrupt", "was to end: KeyboardInterrupt"),
        ("leave", "was to end: SystemExit"),
    ],
)
def test_work_that_ends_its_own_process_is_given_up_and_says_where(how, said):
    with workers(2, limit_s=LIMIT_S) as spread:
        results = spread(work.always, ["before", how, "after"])
        assert next(results) == "before"
        with pytest.raises(LostError, match=said) as caught:
            next(results)
        assert list(spread(work.double, [1, 2, 3])) == [2, 4, 6]
    assert not caught.value.fault.outside
    assert work.HERE in caught.value.fault.words


@pytest.mark.skipif(not Path("/proc/self/schedstat").exists(), reason="not known here")
def test_waiting_for_a_core_takes_none_of_the_time():
    hogs = [
        subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(2 * cores())
    ]
    try:
        with workers(2, limit_s=1.0) as spread:
            begun = time.monotonic()
            assert list(spread(work.spin, [0.6, 0.6])) == [0.6, 0.6]
            assert time.monotonic() - begun > 1.5
    finally:
        for hog in hogs:
            hog.kill()
            hog.wait()


def test_a_process_that_waits_for_work_may_be_lost():
    with workers(2) as spread:
        pids = set(spread(work.whose, range(4)))
        for pid in pids:
            os.kill(pid, signal.SIGKILL)
        assert list(spread(work.double, [1, 2, 3])) == [2, 4, 6]


INTERRUPTED = """
import sys
import work_elsewhere as work
from taskbuilder.jobs import workers
with workers(2) as spread:
    try:
        list(spread(getattr(work, sys.argv[1]), [sys.argv[2]] * 2))
    except KeyboardInterrupt:
        sys.exit(130)
"""


@pytest.mark.parametrize("how", ["sleepy", "stopped"])
def test_ctrl_c_ends_promptly(how, tmp_path, monkeypatch):
    mark = tmp_path / "pid"
    command = [sys.executable, "-c", INTERRUPTED, how, str(mark)]
    environment = {**os.environ, "PYTHONPATH": str(Path(work.HERE).parent)}
    with subprocess.Popen(command, env=environment) as child:
        time.sleep(2.0)
        if how == "stopped":
            end = time.monotonic() + 20
            while not (mark.exists() and mark.read_text()):
                assert time.monotonic() < end
                time.sleep(0.01)
        begun = time.monotonic()
        child.send_signal(signal.SIGINT)
        assert child.wait(20) == 130
    assert time.monotonic() - begun < 3.0


def test_it_is_known_that_work_goes_on(monkeypatch):
    monkeypatch.setattr(jobs, "_LOOK_S", 0.05)
    beats = []
    with workers(2, beat=lambda: beats.append(1)) as spread:
        list(spread(work.whose, range(2)))
    assert len(beats) > 2
