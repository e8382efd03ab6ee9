"""Files are checked where the physics engine cannot be imported."""

from __future__ import annotations

import subprocess
import sys

from taskbuilder.schema.catalogue import Catalogue

LOAD_ALL = """
import sys


class Refuse:
    def find_spec(self, name, path=None, target=None):
        if name == "pybullet":  # pybullet_data has only files
            raise ImportError(f"{name} is refused")
        return None


sys.meta_path.insert(0, Refuse())

from taskbuilder import Catalogue, validate_task
from taskbuilder.task import load_task

catalogue = Catalogue.discover()
for name in catalogue.tasks:
    task = load_task(name, catalogue=catalogue)
    print(task.name, len(task.file.scenes))
report = validate_task("handover", level="static", apart=False)
print(report.ok, "pybullet" in sys.modules)
"""


def test_every_task_is_loaded_and_checked_without_the_physics_engine():
    run = subprocess.run(
        [sys.executable, "-c", LOAD_ALL], capture_output=True, text=True, timeout=300, check=False
    )
    assert run.returncode == 0, run.stderr
    *tasks, verdict = run.stdout.splitlines()
    assert [line.split()[0] for line in tasks] == list(Catalogue.discover().tasks)
    assert verdict == "True False"
