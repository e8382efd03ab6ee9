"""Validation in processes of its own: nothing that a description does there reaches this one."""

from __future__ import annotations

import re
import subprocess
import sys
import time

import pytest

from taskbuilder import validate_task
from taskbuilder.validate import apart
from taskbuilder.validate.apart import Limits
from taskbuilder.validate.report import as_data

BEGIN = "from taskbuilder.description import Above, Below, Bonus, Description, condition\n"
ODD = """\
{imports}
from taskbuilder.description import Above, Below, Bonus, Description, condition, measure
{top}

@{sort}
def odd(world):
    {body}
    return {given}

"""
SUCCESS = '    success = Above("cube", height=0.2)\n'
USED = {
    "condition": '    success = Above("cube", height=0.2)\n    odd = odd()\n',
    "measure": '    success = Above("cube", height=0.2)\n    progress = odd()\n',
}


@pytest.fixture
def odd(write):
    """Write the small task with an odd condition or measure in it."""

    def written(body="pass", *, sort="condition", given="False", top=""):
        text = ODD.format(
            imports="import ctypes, os, signal, sys", body=body, sort=sort, given=given, top=top
        )
        return write((BEGIN, text), (SUCCESS, USED[sort]))

    return written


def line_of(file, text):
    lines = file.with_suffix(".py").read_text().splitlines()
    return next(n for n, line in enumerate(lines, start=1) if text in line)


def found(file, **how):
    report = validate_task(file, **{"seeds": 1, "level": "build", "apart": True} | how)
    assert not report.ok
    (finding,) = report.findings
    assert str(finding.location.file).endswith(".py")
    return finding


@pytest.mark.parametrize(
    ("body", "code", "said"),
    [
        ("os._exit(0)", "TB315", "ends the process that asks it, with status 0"),
        pytest.param(
            "os._exit(73)",
            "TB315",
            "ends the process that asks it, with status 73",
            marks=pytest.mark.slow,
        ),
        ("ctypes.string_at(0)", "TB315", r"crashes the process that asks it \(SIGSEGV\)"),
        pytest.param(
            "os.abort()",
            "TB315",
            r"crashes the process that asks it \(SIGABRT\)",
            marks=pytest.mark.slow,
        ),
        pytest.param(
            "raise BaseException('no')",
            "TB314",
            "fails when it is asked: BaseException: no",
            marks=pytest.mark.slow,
        ),
        ("raise KeyboardInterrupt", "TB314", "fails when it is asked: KeyboardInterrupt"),
        ("sys.exit(0)", "TB314", "fails when it is asked: SystemExit: 0"),
    ],
)
def test_what_a_condition_does_to_its_process_is_a_finding(body, code, said, odd):
    file = odd(body)
    finding = found(file)
    assert finding.code == code
    assert re.match(said, finding.message), finding.message
    assert finding.location.line == line_of(file, body)
    assert body in finding.excerpt


def test_a_condition_that_does_not_come_back_is_a_finding(odd, monkeypatch):
    monkeypatch.setattr(apart, "LIMITS", Limits(piece_s=5.0, step_s=0.0))
    file = odd("while True: pass")
    finding = found(file)
    assert finding.code == "TB315"
    assert finding.message.startswith("does not come back within 5 s when it is asked")
    assert finding.location.line == line_of(file, "while True")


@pytest.mark.parametrize(
    ("top", "said"),
    [
        ("os._exit(73)", "its import ended the interpreter"),
        ("while True: pass", "its import did not end within 3 s"),
    ],
)
def test_an_import_that_does_not_come_back_is_a_finding(top, said, odd, monkeypatch):
    monkeypatch.setattr(apart, "LIMITS", Limits(import_s=3.0))
    file = odd(top=top)
    for level in ("static", "build"):
        finding = found(file, level=level)
        assert (finding.code, finding.location.line) == ("TB213", line_of(file, top))
        assert finding.message == f"{said}; a description only declares"


def test_what_is_wrong_in_the_task_file_is_found_besides(odd):
    file = odd(top="os._exit(0)")
    file.write_text(file.read_text().replace("mass: 0.1", "mass: heavy"))
    report = validate_task(file, level="static", apart=True)
    assert {finding.code for finding in report.findings} == {"TB103", "TB213"}


@pytest.mark.parametrize(
    ("sort", "given"),
    [
        *(("condition", given) for given in ("None", "'no'", "float('nan')")),
        *(("measure", given) for given in ("None", "'1.0'", "float('nan')")),
    ],
)
def test_what_is_no_value_of_a_condition_or_measure_is_a_finding(sort, given, odd):
    file = odd(sort=sort, given=given)
    finding = found(file, apart=False)
    assert finding.code == "TB314"
    assert finding.message.startswith("fails when it is asked: odd gave ")
    assert finding.location.line == line_of(file, "def odd")


ONCE = "open('{mark}', 'x').close(); os.kill(os.getpid(), signal.{how})"


def once(how, mark, when="True"):
    """Do something to the process that asks, the first time only."""
    return f"if {when} and not os.path.exists('{mark}'): {ONCE.format(mark=mark, how=how)}"


@pytest.mark.slow
@pytest.mark.parametrize("how", ["SIGKILL", "SIGSTOP"])
def test_a_process_that_is_lost_is_replaced_and_goes_on(how, odd, tmp_path, caplog):
    sound = validate_task(odd(), seeds=2, level="build")
    seen = []

    def progress(seeds, label):
        seen.append(label)
        yield from seeds

    file = odd(once(how, tmp_path / "mark"))
    report = validate_task(file, seeds=2, level="build", apart=True, progress=progress)
    assert (tmp_path / "mark").exists()
    assert "its work is done again" in caplog.text
    one, two = (as_data([r])["tasks"][0] for r in (sound, report))
    assert one["checks"] == two["checks"]
    assert one["findings"] == two["findings"] == []
    assert seen == ["build", "reset", "reset"]  # what was done is not done again


def test_a_part_that_is_lost_twice_is_a_finding(odd):
    finding = found(odd("os.kill(os.getpid(), signal.SIGKILL)"))
    assert finding.code == "TB315"
    assert "was killed by SIGKILL, 2 times in a row" in finding.message


KILLS = """
@condition
def odd(world):
    {kills}
    return False


class Pair"""


@pytest.mark.slow
@pytest.mark.parametrize("family", ["repeat", "solvable"])
def test_processes_of_the_process_are_replaced_too(family, write_pair, tmp_path, caplog):
    """Repeated is in fresh processes, and the expert plays in several."""
    mark = tmp_path / "mark"
    elsewhere = "any(f.name == 'carry_out' for f in __import__('traceback').extract_stack())"
    kills = once("SIGKILL", mark, elsewhere)
    file = write_pair(
        ("import random\n", "import os, signal\n"),
        ("\n\nclass Pair", KILLS.format(kills=kills)),
        ("    stages =", "    failure = odd()\n    stages ="),
    )
    report = validate_task(file, seeds=1, jobs=2, only=(family,))
    assert mark.exists()
    assert report.ok, report.findings
    assert "its work is done again" in caplog.text


def test_the_exit_status_says_so_and_ctrl_c_ends_what_stands_still(odd, tmp_path):
    command = [sys.executable, "-m", "taskbuilder", "validate", "--level", "build", "--jobs", "1"]
    file = odd("os._exit(0)")
    done = subprocess.run([*command, str(file)], capture_output=True, text=True)
    assert done.returncode == 1
    assert "error[TB315]" in done.stdout
    mark = tmp_path / "mark"
    file = odd(once("SIGSTOP", mark))
    with subprocess.Popen([*command, str(file)], stderr=subprocess.PIPE, text=True) as child:
        end = time.monotonic() + 30
        while not mark.exists():
            assert time.monotonic() < end
            time.sleep(0.01)
        child.send_signal(2)
        _, said = child.communicate(timeout=10)
    assert (child.returncode, said) == (130, "interrupted\n")
