"""Importing the Python file beside a task file, and everything that can go wrong with it."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest
from description_files import REWARD, SUCCESS, body, findings, load

from taskbuilder.description import load as loading
from taskbuilder.errors import FileError
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.task import load_task

SOUND = body(SUCCESS, REWARD)


@pytest.fixture
def found(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return lambda text, **options: findings(tmp_path, text, **options)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x = 1\nclass Plain(:\n", '2:13: error[TB208] fails to import: SyntaxError: invalid syn'),
        ("x = (\n", "1:5: error[TB208] fails to import: SyntaxError: '(' was never closed"),
        ("import os\nx = 1 + missing\n",
         "2:9: error[TB208] fails to import: NameError: name 'missing' is not defined\n"
         "    x = 1 + missing"),
        ("def f():\n    return 1 / 0\n\nf()\n",
         "2:12: error[TB208] fails to import: ZeroDivisionError: division by zero\n"
         "    return 1 / 0"),
        ("import nothing_of_this_name\n",
         "1:1: error[TB208] fails to import: ModuleNotFoundError: No module named 'nothing_of_th"),
        ("import sys\nsys.exit(3)\n", "2:1: error[TB208] fails to import: SystemExit: 3\n    sys."),
        ("raise RuntimeError('first\\nsecond')\n",
         "1:1: error[TB208] fails to import: RuntimeError: first\n    raise "),
        ("def f():\n    f()\nf()\n", "2:5: error[TB208] fails to import: RecursionError: "),
        ("from taskbuilder.description import *\nx = Held()\n",
         "2:5: error[TB208] fails to import: TypeError: Held.__init__() missing 1 required "),
        ("from taskbuilder.description import *\nx = Held('a') and Held('b')\n",
         "2:5: error[TB208] fails to import: TypeError: a condition has no truth of its own; "),
        ("x = 1\n", "1:1: error[TB209] its subclasses of Description: none; "
         "exactly one is the task's description"),
        ("", "1:1: error[TB209] its subclasses of Description: none; "),
        (SOUND + "\n\nclass Second(Plain):\n    pass\n",
         "1:1: error[TB209] its subclasses of Description: Plain and Second; exactly one is "),
    ],
)  # fmt: skip
def test_a_description_that_cannot_be_used_is_marked_at_the_line_to_blame(found, text, message):
    (line,) = found(text)
    assert line.startswith(message)


def test_a_text_that_is_no_python_at_all_is_refused(found, tmp_path):
    found(SOUND)
    (tmp_path / "plain.py").write_bytes(b"x = '\xff'\n")
    with pytest.raises(loading.FileError, match=r"TB208\] fails to import: "):
        load_task("plain.yaml")


def test_a_task_without_a_description_names_the_missing_file(found):
    (line,) = found(None)
    assert line.startswith("plain.yaml: error[TB206] there is no plain.py beside plain.yaml")


def test_an_imported_description_class_is_not_the_file_s_own(found, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "shared_plain_of_tasks.py").write_text(SOUND.replace("class Plain", "class Other"))
    assert not found("from shared_plain_of_tasks import Other\n" + SOUND)
    (line,) = found("from shared_plain_of_tasks import Other\n")
    assert "TB209" in line


def test_the_same_file_gives_the_same_class_until_it_changes(found, tmp_path):
    found(SOUND)
    first = load(tmp_path, SOUND).description
    assert load(tmp_path, SOUND).description is first
    assert load(tmp_path, SOUND + "# changed\n").description is not first


def test_equal_files_in_two_folders_give_two_classes(tmp_path):
    folders = [tmp_path / "one", tmp_path / "two"]
    for folder in folders:
        folder.mkdir()
    first, second = (load(folder, SOUND).description for folder in folders)
    assert first is not second


def test_a_failed_import_leaves_nothing_behind(found):
    before = set(sys.modules)
    found("import sys\nraise RuntimeError\n")
    assert not {name for name in set(sys.modules) - before if name.startswith("taskbuilder_task")}


def test_a_task_of_the_library_has_one_class_by_name_and_by_path():
    catalogue = Catalogue()
    by_name = load_task("handover", catalogue=catalogue)
    by_path = load_task(str(by_name.file.entry.file), catalogue=catalogue)
    assert by_path.description is by_name.description
    assert by_path.description.__module__ == "taskbuilder.tasks.handover"


def test_what_a_description_prints_does_not_mix_with_what_a_command_prints(found, capfd):
    assert not found("print('noise')\n" + SOUND)
    printed = capfd.readouterr()
    assert printed.out == ""
    assert "noise" in printed.err


def test_a_guarded_import_of_a_sound_description_changes_nothing(found):
    assert not found(SOUND, guarded=True)


def test_a_guarded_import_leaves_errors_to_be_explained_as_ever(found):
    (line,) = found("x = missing\n", guarded=True)
    assert line.startswith("1:5: error[TB208] fails to import: NameError")


@pytest.mark.parametrize(
    "text",
    [
        "import os\nos._exit(0)\n",
        "import os\nos.kill(os.getpid(), 9)\n",
        "import os\nos.abort()\n",
        "import os\nos._exit(73)\n",
        "print('the import came to its end', flush=True)\nimport os\nos._exit(0)\n",
    ],
)
def test_an_import_that_ends_the_interpreter_is_a_finding(found, text):
    assert found(text, guarded=True) == [
        "1:1: error[TB213] its import ended the interpreter; a description only declares"
    ]


@pytest.mark.parametrize(
    "text",
    [
        "while True:\n    pass\n",
        "import signal, time\nsignal.signal(signal.SIGTERM, signal.SIG_IGN)\ntime.sleep(60)\n",
        "import subprocess\nsubprocess.Popen(['sleep', '60']).wait()\n",
        "import threading, time\nthreading.Thread(target=time.sleep, args=(60,)).start()\n",
    ],
)
def test_an_import_that_hangs_is_a_finding_in_bounded_time(found, monkeypatch, text):
    monkeypatch.setattr(loading.try_import, "__defaults__", (0.5,))
    begin = time.monotonic()
    assert found(text, guarded=True)[0] == (
        "1:1: error[TB213] its import did not end within 0.5 s; a description only declares"
    )
    assert time.monotonic() - begin < 120.0


# True in the child process of a trial, and nowhere else.
IN_TRIAL = "import sys\nif sys.argv[0].endswith('load.py'):\n    "


def test_a_process_that_an_import_leaves_behind_ends_with_the_trial(found, tmp_path):
    late = tmp_path / "late"
    leave = f"__import__('subprocess').Popen(['sh', '-c', 'sleep 0.7; touch {late}'])\n"
    assert not found(IN_TRIAL + leave + SOUND, guarded=True)
    time.sleep(1.0)
    assert not late.exists()


def test_an_import_that_asks_gets_no_answer_and_does_not_wait(found):
    assert not found(IN_TRIAL + "input()\n" + SOUND, guarded=True)


def test_a_task_of_the_catalogue_needs_no_trial(monkeypatch):
    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("a child process was started")

    monkeypatch.setattr(subprocess, "Popen", refuse)
    assert load_task("handover", guarded=True).name == "handover"


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ('Hedl("cube")', "name 'Hedl' is not defined; did you mean \"Held\"?"),
        ('d.Hedl("cube")', "has no attribute 'Hedl'; did you mean \"Held\"?"),
        ('Near("cube", "goal", 0.05)', "Near takes within by name: write within=..."),
        ('Level("cube", 5)', "Level takes within_deg by name: write within_deg=..."),
        ("unheard_of()", "name 'unheard_of' is not defined"),
    ],
)
def test_what_was_meant_is_told(wrong, said, tmp_path):
    text = "from taskbuilder import description as d\n" + body(f"success = {wrong}", REWARD)
    with pytest.raises(FileError) as error:
        load(tmp_path, text)
    (finding,) = error.value.findings
    assert finding.message.endswith(said)
    assert (finding.fix is not None) == ("did you mean" in said)


def test_what_is_edited_within_a_second_is_read_anew(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    first = load(tmp_path, body('success = Held("cube")', REWARD))
    assert first.description.success.body == "cube"
    file = tmp_path / "plain.py"
    times = (file.stat().st_atime, file.stat().st_mtime)
    file.write_text(file.read_text().replace("Held(", "Lost("))
    os.utime(file, times)
    with pytest.raises(FileError, match="name 'Lost' is not defined"):
        load_task(tmp_path / "plain.yaml")
    assert not (tmp_path / "__pycache__").exists()


def test_a_description_knows_where_its_expressions_were_written(tmp_path):
    text = body('success = (\n    Held("cube") & ~Level("tray", within_deg=5)\n)', REWARD)
    success = load(tmp_path, text).description.success
    held, level = success.parts[0], success.parts[1].parts[0]
    place = Path(tmp_path / "plain.py")
    assert (held.origin.file, held.origin.line, held.origin.column) == (place, 6, 9)
    assert (level.origin.line, level.origin.column) == (6, 25)
