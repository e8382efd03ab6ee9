"""Options and settings of the whole suite."""

from __future__ import annotations

import inspect
import os
import signal
import sys
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

SLOW = Path(__file__).with_name("slow.txt")
"""Tests that take seconds each, which `slowest.py` has chosen."""

# Tests are shared out over the cores already; with threads besides, they would wait for each other.
for library in ("OMP", "OPENBLAS"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

# No test fails for being slow: what else the machine does would decide.
settings.register_profile(
    "untimed", deadline=None, max_examples=50, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("untimed")

# A shell ignores Ctrl-C for what it starts in the background, and children inherit that; the tests
# that interrupt their children would fail there.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--update-golden",
        action="store_true",
        help="write what commands print now into the golden files; review the difference",
    )
    parser.addoption("--runslow", action="store_true", help="run the tests marked slow, too")


@pytest.hookimpl(tryfirst=True)  # before `-m slow` chooses
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out what is slow, unless it is asked for."""
    listed = set(SLOW.read_text(encoding="utf-8").splitlines())
    for item in items:
        if item.nodeid in listed:
            item.add_marker(pytest.mark.slow)
    if config.getoption("--runslow"):
        return
    slow = [item for item in items if item.get_closest_marker("slow")]
    config.hook.pytest_deselected(items=slow)
    items[:] = [item for item in items if not item.get_closest_marker("slow")]


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Validations play in child processes, as those of users, except in tests marked in_process.

    These have many validations, which need not all wait for a process to start, or have broken
    something on purpose in this process.
    """
    apart = item.get_closest_marker("in_process") is None
    if apart and "taskbuilder.validate.runner" not in sys.modules:
        return  # nothing to change, and tests of files need no physics engine
    from taskbuilder.validate.html.page import make_page
    from taskbuilder.validate.runner import validate_task

    for function in (inspect.unwrap(validate_task), make_page):
        function.__kwdefaults__["apart"] = apart


@pytest.fixture
def update_golden(request: pytest.FixtureRequest) -> bool:
    return bool(request.config.getoption("--update-golden"))
