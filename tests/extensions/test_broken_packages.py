"""Packages that are broken: messages name them, and they stop only what uses them."""

from __future__ import annotations

import logging
from contextlib import closing

import numpy as np
import pytest

from taskbuilder import extensions
from taskbuilder.cli import main
from taskbuilder.data.collecting import collect
from taskbuilder.data.dataset import load_dataset
from taskbuilder.data.formats import export_dataset
from taskbuilder.data.plan import CollectPlan
from taskbuilder.env.parallel import parallel_env
from taskbuilder.errors import (
    ExtensionError,
    FileError,
    SimulationError,
    UnknownNameError,
    UsageError,
)
from taskbuilder.extensions import ACTION_MODES, DOORS
from taskbuilder.learn.algorithms import find_algorithm
from taskbuilder.learn.runs import train
from taskbuilder.task import load_task
from taskbuilder.validate.formats import document_writer
from taskbuilder.validate.runner import validate_task

pytestmark = pytest.mark.in_process

MODE = """\
from dataclasses import dataclass
from taskbuilder.env.joint_modes import JointPositionMode

@dataclass(frozen=True)
class Mode(JointPositionMode):
"""

CHANNEL = """\
from dataclasses import dataclass
from taskbuilder.env.foreign_channels import ChannelReader

@dataclass(frozen=True)
class Reader(ChannelReader):
    meaning = "a number"
    names = ("one",)
    bounds = ((0.0, 1.0),)
    def read(self, episode):
        RETURN
"""

CHECKS = """\
from taskbuilder.diagnostics import Code
from taskbuilder.diagnostics.foreign import CheckFamily
from taskbuilder.errors import Finding
from taskbuilder.validate.report import Check
CODES = {"LAB101": Code("Wrong", "It is wrong.")}
def run(task):
    RETURN
FAMILY = CheckFamily(CODES, run)
"""

SHORT = {"steps": 4, "envs": 1, "evaluate_episodes": 1, "film_every": 0}
LEARNER = """\
from dataclasses import dataclass
import numpy as np
from taskbuilder.learn.learner import Algorithm
from taskbuilder.learn.on_policy import OnPolicy

@dataclass(frozen=True)
class Settings:
    rollout_steps: int = 2
    discount: float = 0.9

class Learner:
    def __init__(self, shapes, settings, *, shared_reward, seed, device):
        self.shapes, self.settings = shapes, settings
    def act(self, observations, rng, progress_fraction):
        sizes = self.shapes.actions.items()
        return {a: np.zeros((len(observations[a]), size), np.float32) + 0.0 for a, size in sizes}
    def update(self, rollout, lost, rng, progress_fraction):
        return {}
    def arrays(self):
        return {}

ALGORITHM = Algorithm("odd", Settings, Learner, collection=OnPolicy)
"""


def opened(task):
    """An environment after its first step."""
    env = parallel_env(load_task(task))
    with closing(env):
        env.reset(seed=0)
        env.step({"arm": np.zeros(env.action_space("arm").shape, np.float32)})


@pytest.mark.parametrize("door", DOORS, ids=lambda door: door.noun)
def test_a_package_that_fails_at_import_is_named(install, door, capfd):
    install("lab_parts", {door.group: {"odd": "Thing"}}, "import nowhere_to_be_found")
    (part,) = door.declared()["odd"]
    with pytest.raises(ExtensionError) as caught:
        part.load(lambda _: None)
    message = str(caught.value)
    assert message.startswith(f'the {door.noun} "odd" of lab_parts 1.0 (lab_parts:Thing)')
    assert "No module named 'nowhere_to_be_found'" in message
    assert message.endswith("update or remove lab_parts")
    assert main(["explain", "odd"]) == 0
    assert "nowhere_to_be_found" in capfd.readouterr().out


@pytest.mark.parametrize("door", DOORS, ids=lambda door: door.noun)
def test_explain_says_what_a_part_lacks(install, door, capfd):
    install("lab_parts", {door.group: {"odd": "THING"}}, "THING = 42")
    assert main(["explain", "odd"]) == 0
    text = " ".join(capfd.readouterr().out.split())
    assert f'the {door.noun} "odd" of lab_parts 1.0 (lab_parts:THING)' in text
    assert text.endswith("update or remove lab_parts.")


def test_a_package_that_ends_the_interpreter_at_import_is_named(install):
    install("lab_parts", {"taskbuilder.algorithms": {"odd": "Thing"}}, "raise SystemExit(3)")
    with pytest.raises(ExtensionError, match="cannot be imported: SystemExit: 3"):
        find_algorithm("odd")


def test_an_attribute_that_is_not_there_is_named(install):
    install("lab_parts", {"taskbuilder.algorithms": {"odd": "Thing"}})
    with pytest.raises(ExtensionError, match="no attribute 'Thing'"):
        find_algorithm("odd")


def test_a_broken_package_does_not_stop_what_does_not_use_it(install, own_task, capfd):
    groups = {door.group: {"odd": "Thing"} for door in DOORS if door.noun != "check"}
    install("lab_parts", groups, "import nowhere_to_be_found")
    opened(own_task())
    assert main(["explain", "TB101"]) == 0
    assert validate_task(own_task(), level="static").ok


@pytest.mark.parametrize(
    ("door", "name"),
    [
        ("taskbuilder.action_modes", "odd"),
        ("taskbuilder.channels", "object.odd"),
    ],
)
def test_two_packages_with_one_name_are_both_named_where_a_file_uses_it(
    install, own_task, door, name
):
    install("lab_one", {door: {name: "Thing"}})
    install("lab_two", {door: {name: "Thing"}})
    modes = door.endswith("modes")
    file = own_task(arm="odd") if modes else own_task(channel="cube.odd")
    with pytest.raises(FileError) as caught:
        load_task(file)
    (finding,) = caught.value.findings
    assert f'"{name}" is declared twice, by lab_one 1.0 (lab_one:Thing) and lab_two 1.0' in str(
        finding.message
    )
    assert finding.code == ("TB105" if modes else "TB204")
    assert finding.location.line == (10 if modes else 18)
    assert load_task(own_task()).name == "mine"


@pytest.mark.parametrize("group", ["algorithms", "report_formats", "data_formats", "renderers"])
def test_two_packages_with_one_name_are_both_named_by_calls(install, group, tmp_path, own_task):
    install("lab_one", {f"taskbuilder.{group}": {"odd": "Thing"}})
    install("lab_two", {f"taskbuilder.{group}": {"odd": "Thing"}})
    uses = {
        "algorithms": lambda: find_algorithm("odd"),
        "report_formats": lambda: document_writer("odd"),
        "data_formats": lambda: export(recorded(own_task, tmp_path), "odd"),
        "renderers": lambda: drawn(own_task(), "odd"),
    }
    with pytest.raises(ExtensionError, match=r"declared twice, by lab_one 1.0 .* and lab_two 1.0"):
        uses[group]()


def export(folder, form):
    """Export a data set to a folder beside it."""
    return export_dataset(load_dataset(folder), form, folder.with_name("out"))


def drawn(task, renderer):
    """A picture of a task."""
    env = parallel_env(load_task(task), cameras=("front",), renderer=renderer)
    with closing(env):
        return env.reset(seed=0)


def recorded(own_task, tmp_path):
    """A data set of one episode."""
    collect(CollectPlan((str(own_task()),), 1), tmp_path / "data")
    return tmp_path / "data"


def test_a_built_in_name_stays_the_library_s_and_the_package_is_named(install, own_task, caplog):
    install("lab_parts", {"taskbuilder.action_modes": {"tcp_delta": "Mode"}}, MODE + "    pass")
    with caplog.at_level(logging.WARNING, "taskbuilder.hints"):
        opened(own_task())
    (record,) = caplog.records
    assert 'the action mode "tcp_delta" of lab_parts 1.0' in record.getMessage()
    assert "lab_parts must rename it" in record.getMessage()


def test_an_unknown_mode_is_told_with_the_names_of_packages(install, own_task):
    install("lab_parts", {"taskbuilder.action_modes": {"swing": "Mode"}}, MODE + "    pass")
    with pytest.raises(FileError, match=r'mine.yaml:10:\d+: .*did you mean "swing"\?'):
        load_task(own_task(arm="swnig"))


def test_an_unknown_channel_is_told_with_the_names_of_packages(install, own_task):
    parts = {"object.wetness": "Reader", "things.colour": "Reader"}
    install("lab_parts", {"taskbuilder.channels": parts})
    with pytest.raises(FileError, match=r'did you mean "wetness"\?'):
        load_task(own_task(channel="cube.wetnes"))
    with pytest.raises(FileError, match=r"lab_parts 1.0 .* must be declared as .* object.colour"):
        load_task(own_task(channel="cube.colour"))


@pytest.mark.parametrize(
    ("body", "wrong"),
    [
        ("names = ('one',)", "has 1 names for 7 pairs of bounds"),
        ("bounds = ((1.0, 1.0),) * 7", "two numbers, low < high"),
        ("def after(self, joints, values): return joints[:3]", "returns 3 numbers"),
        ("def after(self, joints, values): 1 / 0", "failed: ZeroDivisionError"),
    ],
)
def test_an_action_mode_of_the_wrong_shape_is_named(install, own_task, body, wrong):
    install("lab_parts", {"taskbuilder.action_modes": {"odd": "Mode"}}, f"{MODE}    {body}\n")
    with pytest.raises(ExtensionError, match=wrong) as caught:
        opened(own_task(arm="odd"))
    assert 'the action mode "odd" of lab_parts 1.0' in str(caught.value)


@pytest.mark.parametrize(
    ("code", "wrong"),
    [
        ("Mode = 3", "is no subclass of taskbuilder.env.arm_modes.ArmMode"),
        ("from taskbuilder.env.arm_modes import ArmMode as Mode", "lacks after, bounds"),
    ],
)
def test_something_that_is_no_action_mode_is_named(install, own_task, code, wrong):
    install("lab_parts", {"taskbuilder.action_modes": {"odd": "Mode"}}, code)
    with pytest.raises(ExtensionError, match=f"lab_parts 1.0.*{wrong}"):
        opened(own_task(arm="odd"))


@pytest.mark.parametrize(
    ("returned", "wrong"),
    [
        ("return (1.0, 2.0)", r"reads \[1.0, 2.0\], where 1 finite numbers"),
        ("return (float('nan'),)", "where 1 finite numbers are needed"),
        ("raise KeyError('lost')", "failed: KeyError: 'lost'"),
    ],
)
def test_a_channel_of_the_wrong_shape_is_named(install, own_task, returned, wrong):
    code = CHANNEL.replace("RETURN", returned)
    install("lab_parts", {"taskbuilder.channels": {"object.odd": "Reader"}}, code)
    with pytest.raises(ExtensionError, match=wrong) as caught:
        opened(own_task(channel="cube.odd"))
    assert 'the observation channel "object.odd" of lab_parts 1.0' in str(caught.value)


def test_something_that_is_no_algorithm_is_named(install):
    install("lab_parts", {"taskbuilder.algorithms": {"odd": "Thing"}}, "Thing = 3")
    with pytest.raises(ExtensionError, match=r"lab_parts 1.0 .* is no object of .*Algorithm"):
        find_algorithm("odd")
    with pytest.raises(UsageError, match=r'no algorithm "od"; did you mean "odd"\?'):
        find_algorithm("od")


@pytest.mark.parametrize(
    ("broken", "wrong"),
    [
        (("collection=OnPolicy", "presets={}"), "has no `collection`"),
        (("rollout_steps", "steps"), "has settings without rollout_steps"),
        (("shared_reward, ", ""), "failed: TypeError: .*shared_reward"),
        (("def act", "def play"), "makes a learner without `act`"),
        (("+ 0.0", '+ {}["oops"]'), "failed: KeyError: 'oops'"),
        (("size)", "size + 1)"), r"actions of arm from `act` of shape \(1, 6\), not \(1, 5\)"),
        (("+ 0.0", "+ np.nan"), "actions of arm from `act` that are not finite"),
        (("return {}", "return {}[0]"), "failed: KeyError: 0"),
    ],
)
def test_a_broken_learner_is_named(broken, wrong, install, tmp_path):
    pytest.importorskip("torch")
    assert broken[0] in LEARNER
    code = LEARNER.replace(*broken)
    install("lab_parts", {"taskbuilder.algorithms": {"odd": "ALGORITHM"}}, code)
    with pytest.raises(ExtensionError, match=wrong) as caught:
        train("reach", algorithm="odd", out=tmp_path / "run", **SHORT)
    assert 'the algorithm "odd" of lab_parts 1.0' in str(caught.value)


def test_a_learner_of_its_own_episodes_takes_no_demonstrations(install, tmp_path):
    pytest.importorskip("torch")
    install("lab_parts", {"taskbuilder.algorithms": {"odd": "ALGORITHM"}}, LEARNER)
    with pytest.raises(UsageError, match="odd learns from no demonstrations"):
        train("reach", algorithm="odd", demos=2, steps=4, out=tmp_path / "run")


def test_a_report_format_that_returns_no_text_is_named(install, own_task, capfd):
    code = "def write(reports): return len(reports)"
    install("lab_parts", {"taskbuilder.report_formats": {"odd": "write"}}, code)
    assert main(["validate", str(own_task()), "--level", "static", "--format", "odd"]) == 1
    assert "lab_parts 1.0 (lab_parts:write) returns int, where a text is needed" in (
        capfd.readouterr().err
    )


def test_a_report_format_that_cannot_be_imported_is_refused_before_the_work(
    install, own_task, capfd
):
    install("lab_parts", {"taskbuilder.report_formats": {"odd": "write"}})
    assert main(["validate", str(own_task()), "--format", "odd"]) == 1
    assert capfd.readouterr().err.startswith('taskbuilder: the report format "odd" of lab_parts')


@pytest.mark.parametrize(
    ("code", "wrong"),
    [
        ("def write(dataset, folder, options): pass", "has written nothing"),
        ("def write(dataset): pass", "failed: TypeError"),
        ("write = 3", "cannot be called"),
    ],
)
def test_a_data_format_that_fails_is_named_and_leaves_nothing(
    install, own_task, tmp_path, code, wrong
):
    install("lab_parts", {"taskbuilder.data_formats": {"odd": "write"}}, code)
    folder = recorded(own_task, tmp_path)
    with pytest.raises(ExtensionError, match=f"lab_parts 1.0.*{wrong}"):
        export(folder, "odd")
    assert not (tmp_path / "out").exists()
    with pytest.raises(UsageError, match=r'no data set format "od"; did you mean "odd"\?'):
        export(folder, "od")


@pytest.mark.parametrize(
    ("code", "wrong"),
    [
        (
            "import numpy as np\nclass Thing:\n    ray_in_pixel = (0.5, 0.5)\n"
            "    def draw(self, shot): return (np.zeros((2, 2, 3), np.uint8),) * 4\n"
            "thing = Thing()",
            r"draws rgb of \(2, 2, 3\) uint8, where",
        ),
        ("class thing: pass", "is no object with a method `draw`"),
    ],
)
def test_a_renderer_of_the_wrong_shape_is_named(install, own_task, code, wrong):
    install("lab_parts", {"taskbuilder.renderers": {"odd": "thing"}}, code)
    with pytest.raises(ExtensionError, match=f"lab_parts 1.0.*{wrong}"):
        drawn(own_task(), "odd")


def test_an_unknown_renderer_is_told_with_the_names_of_packages(install, own_task):
    install("lab_parts", {"taskbuilder.renderers": {"sketch": "thing"}})
    with pytest.raises((UsageError, SimulationError), match=r'did you mean "sketch"\?'):
        drawn(own_task(), "skecth")


@pytest.mark.parametrize(
    ("code", "wrong"),
    [
        ("import nowhere_to_be_found", "cannot be imported"),
        (CHECKS.replace("RETURN", "1 / 0"), "failed: ZeroDivisionError"),
        (CHECKS.replace("RETURN", "return [(3, [])]"), "returns int, where Check is needed"),
        (
            CHECKS.replace("RETURN", 'return [(Check("LAB999", "x", True, 0), [])]'),
            "reports LAB999, which is none of its codes",
        ),
        (CHECKS.replace("LAB101", "TB101"), "write two to five capital letters, not TB"),
        ("FAMILY = 3", "is no object of taskbuilder.diagnostics.foreign.CheckFamily"),
    ],
)
def test_a_broken_check_is_a_failed_family_of_its_own(install, own_task, code, wrong):
    install("lab_parts", {"taskbuilder.checks": {"odd": "FAMILY"}}, code)
    report = validate_task(own_task(), level="build", seeds=1)
    assert [(f.name, f.ok) for f in report.families] == [
        ("static", True),
        ("odd", False),
        ("build", True),
        ("reset", True),
    ]
    (finding,) = report.findings
    assert finding.code == "TB317"
    assert 'the check "odd" of lab_parts 1.0' in finding.message
    assert wrong in finding.message


def test_checks_with_one_name_or_one_code_are_failed_families(install, own_task):
    code = CHECKS.replace("RETURN", 'return [(Check("LAB101", "fine", True, 0), [])]')
    install("lab_one", {"taskbuilder.checks": {"odd": "FAMILY", "static": "FAMILY"}}, code)
    install("lab_two", {"taskbuilder.checks": {"odd": "FAMILY", "third": "FAMILY"}}, code)
    install("lab_zzz", {"taskbuilder.checks": {"zzz": "FAMILY"}}, code)
    report = validate_task(own_task(), level="static")
    passed = {family.name: family.ok for family in report.families}
    assert passed == {
        "static": True,
        "odd (lab_one 1.0)": False,
        "odd (lab_two 1.0)": False,
        "static (lab_one 1.0)": False,
        "third": True,
        "zzz": False,
    }
    messages = [finding.message for finding in report.findings]
    assert any("has the code LAB101, as the check" in message for message in messages)
    assert any("has the name of one of taskbuilder's own families" in m for m in messages)


def test_a_check_with_physics_is_run_after_those_that_it_needs(install, own_task):
    returned = (
        'finding = Finding("LAB101", f"{task.world(0).robots.keys()}")\n'
        '    return [(Check("LAB101", "fine", False, 1, 0, "robots"), [finding])]'
    )
    code = CHECKS.replace("RETURN", returned).replace("run)", 'run, "build")')
    install("lab_parts", {"taskbuilder.checks": {"odd": "FAMILY"}}, code)
    assert "odd" not in {f.name for f in validate_task(own_task(), level="static").families}
    report = validate_task(own_task(), level="build", seeds=1, only=("build", "odd"))
    assert [family.name for family in report.families] == ["static", "build", "odd"]
    assert not report.ok
    assert [finding.code for finding in report.findings] == ["LAB101"]


def test_what_is_declared_can_be_looked_for_anew(tmp_path, install):
    site = install("lab_parts", {"taskbuilder.action_modes": {"swing": "Mode"}})
    assert "swing" in ACTION_MODES.names()
    (site / "lab_parts-1.0.dist-info" / "entry_points.txt").unlink()
    extensions.forget()
    assert "swing" not in ACTION_MODES.names()
    with pytest.raises(UnknownNameError, match='no action mode "swing"'):
        ACTION_MODES.part("swing")
