"""Which tasks and robots there are, by name and by path, and where they come from."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from task_texts import PLAIN

from taskbuilder.errors import FileError, UnknownNameError
from taskbuilder.schema.catalogue import Catalogue, looks_like_path
from taskbuilder.schema.load import read_task

REPOSITORY = Path(__file__).resolve().parents[2]


def write_task(folder: Path, name: str) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.yaml"
    path.write_text(PLAIN.replace("task: plain", f"task: {name}"))
    return path


@pytest.fixture
def plugin(folder: Path, monkeypatch: pytest.MonkeyPatch):
    """Puts a package on the path as if it were installed, with an entry point for its tasks."""

    def install(namespace: str = "lab", value: str = "lab_tasks.tasks") -> Path:
        site = folder / "site"
        tasks = site / "lab_tasks" / "tasks"
        write_task(tasks, "stack")
        for package in (tasks.parent, tasks):
            (package / "__init__.py").write_text("")
        info = site / "lab_tasks-1.0.dist-info"
        info.mkdir()
        (info / "METADATA").write_text("Metadata-Version: 2.1\nName: lab-tasks\nVersion: 1.0\n")
        (info / "entry_points.txt").write_text(f"[taskbuilder.tasks]\n{namespace} = {value}\n")
        monkeypatch.syspath_prepend(site)
        return tasks

    yield install
    for name in [name for name in sys.modules if name.partition(".")[0] == "lab_tasks"]:
        del sys.modules[name]


def test_the_library_has_its_tasks_and_robots():
    catalogue = Catalogue()
    assert {"collaborative_lift", "handover", "pick_push_place"} <= {*catalogue.tasks}
    assert {"panda", "ur5e", "xarm6"} <= {*catalogue.robots}
    for entry in (*catalogue.tasks.values(), *catalogue.robots.values()):
        assert entry.trusted
        assert entry.file.is_file()


def test_a_task_of_the_library_knows_its_module_and_description():
    entry = Catalogue().task("handover")
    assert entry.module == "taskbuilder.tasks.handover"
    assert entry.description_file == REPOSITORY / "tasks" / "handover.py"
    assert entry.root == REPOSITORY / "tasks"


@pytest.mark.parametrize("way", ["absolute", "relative", "dotted", "link"])
def test_a_task_opened_by_its_path_is_the_one_of_its_name(folder, monkeypatch, way):
    path = REPOSITORY / "tasks" / "handover.yaml"
    (folder / "link.yaml").symlink_to(path)
    monkeypatch.chdir(REPOSITORY / "tasks" if way in ("relative", "dotted") else folder)
    reference = {
        "absolute": str(path),
        "relative": "handover.yaml",
        "dotted": "./../tasks/handover.yaml",
        "link": "link.yaml",
    }[way]
    catalogue = Catalogue()
    assert catalogue.task(reference) == catalogue.task("handover")


@pytest.mark.parametrize("reference", ["robot.yaml", "../ur5e/robot.yaml", "../ur5e"])
def test_a_robot_is_found_by_a_path_relative_to_the_file_that_names_it(reference):
    catalogue = Catalogue()
    assert catalogue.robot(reference, REPOSITORY / "robots" / "ur5e") == catalogue.robot(
        "ur5e", Path()
    )


def test_a_task_outside_the_catalogue_is_found_by_its_path_alone(folder):
    path = write_task(folder / "mine", "juggle")
    entry = Catalogue().task("mine/juggle.yaml")
    assert (entry.name, entry.file, entry.module, entry.trusted) == ("juggle", path, "", False)


def test_a_folder_of_the_task_path_adds_its_tasks_and_robots(folder):
    path = write_task(folder / "mine", "juggle")
    write_task(folder / "mine", "_draft")
    robot = folder / "mine" / "arm" / "robot.yaml"
    robot.parent.mkdir()
    robot.write_text("robot: arm\n")
    catalogue = Catalogue.discover(["mine"])
    assert catalogue.task("juggle").file == path
    assert catalogue.robot("arm", Path()).file == robot
    assert "_draft" not in catalogue.tasks
    assert "handover" in catalogue.tasks
    assert not catalogue.task("juggle").trusted


def test_folders_of_the_environment_variable_are_searched_too(folder, monkeypatch):
    write_task(folder / "one", "juggle")
    write_task(folder / "two", "stack")
    monkeypatch.setenv("TASKBUILDER_PATH", f"one:{folder / 'two'}::one")
    catalogue = Catalogue.discover(["two"])
    assert {"juggle", "stack"} <= {*catalogue.tasks}
    assert catalogue.folders == (folder / "two", folder / "one")


def test_a_task_path_that_is_no_folder_is_refused(folder):
    write_task(folder, "juggle")
    for wrong in ("nowhere", "juggle.yaml"):
        with pytest.raises(UnknownNameError, match=rf"the task path {wrong} is not a folder"):
            Catalogue.discover([wrong])


def test_two_tasks_of_one_name_are_an_error_that_names_both(folder):
    write_task(folder / "one", "juggle")
    write_task(folder / "two", "juggle")
    with pytest.raises(FileError) as caught:
        Catalogue.discover(["one", "two"]).task("juggle")
    assert str(caught.value) == (
        'two/juggle.yaml: error[TB008] the task "juggle" is also one/juggle.yaml; '
        "rename one of them, or take its folder off the task path"
    )


def test_a_task_of_the_name_of_one_of_the_library_stops_that_name_alone(folder):
    write_task(folder / "one", "handover")
    catalogue = Catalogue.discover(["one"])
    for look_up in (catalogue.task, catalogue.named_task):
        with pytest.raises(FileError, match=r'one/handover\.yaml: error\[TB008\] the task "hand'):
            look_up("handover")
        assert look_up("pick_push_place").trusted
    assert [*catalogue.clashes("task")] == ["handover"]
    assert catalogue.task("one/handover.yaml").file == folder / "one" / "handover.yaml"


def test_a_robot_of_the_name_of_one_of_the_library_stops_that_name_alone(folder):
    (folder / "one" / "ur5e").mkdir(parents=True)
    (folder / "one" / "ur5e" / "robot.yaml").write_text("robot: ur5e")
    catalogue = Catalogue.discover(["one"])
    with pytest.raises(FileError, match=r'one/ur5e/robot\.yaml: error\[TB008\] the robot "ur5e"'):
        catalogue.robot("ur5e", folder)
    assert catalogue.robot("panda", folder).trusted
    assert {"ur5e", "panda"} <= {*catalogue.robots}
    assert [*catalogue.clashes("robot")] == ["ur5e"]


def test_one_file_found_twice_is_one_task(folder):
    write_task(folder / "one", "juggle")
    (folder / "two").symlink_to(folder / "one")
    (folder / "three").mkdir()
    (folder / "three" / "juggle.yaml").symlink_to(folder / "one" / "juggle.yaml")
    catalogue = Catalogue.discover(["one", "two", "three", REPOSITORY / "tasks"])
    assert catalogue.task("juggle").file == folder / "one" / "juggle.yaml"


@pytest.mark.parametrize(
    ("reference", "message"),
    [
        ("handovr", 'no task "handovr"; did you mean "handover"?'),
        ("HANDOVER", 'no task "HANDOVER"; did you mean "handover"?'),
        ("zzz", r'no task "zzz"; `taskbuilder list` shows all there are'),
        ("nowhere/zzz.yaml", r"there is no file nowhere/zzz\.yaml"),
        ("./zzz", r"there is no file zzz"),
        (".", r"is a folder; name the YAML file in it"),
        ("x" * 300 + ".yaml", "there is no file xxx"),
        ("a\0b.yaml", "there is no file"),
    ],
)
def test_an_unknown_task_is_refused_with_what_there_is(reference, message):
    with pytest.raises(UnknownNameError, match=message):
        Catalogue().task(reference)


def test_an_unknown_robot_is_refused_with_what_there_is():
    with pytest.raises(UnknownNameError, match='no robot "ur5"; did you mean "ur5e"'):
        Catalogue().robot("ur5", Path())


@pytest.mark.parametrize(
    ("reference", "path"),
    [
        ("handover", False),
        ("lab/stack", False),
        ("handover.yaml", True),
        ("handover.yml", True),
        ("./handover", True),
        ("/tmp", True),
        ("~/x", True),
        ("a/" + "b" * 300, False),
    ],
)
def test_a_path_is_told_from_a_name(reference, path):
    assert looks_like_path(reference) is path


def test_an_installed_package_adds_tasks_in_a_namespace(plugin):
    tasks = plugin()
    catalogue = Catalogue()
    entry = catalogue.task("lab/stack")
    assert entry.file == tasks / "stack.yaml"
    assert entry.module == "lab_tasks.tasks.stack"
    assert entry.trusted
    assert "stack" not in catalogue.tasks
    assert catalogue.task(str(tasks / "stack.yaml")) == entry


def test_a_task_in_a_namespace_is_called_by_its_own_name_in_its_file(plugin):
    plugin()
    catalogue = Catalogue()
    assert read_task(catalogue.task("lab/stack"), catalogue).spec.task == "stack"


@pytest.mark.parametrize("value", ["nowhere", "nowhere.tasks", "lab_tasks.nowhere"])
def test_a_package_whose_tasks_are_gone_does_not_take_the_others_along(plugin, value):
    plugin(value=value)
    assert "handover" in Catalogue().tasks


def test_two_packages_may_not_add_one_name(plugin, folder, monkeypatch):
    plugin()
    other = folder / "other" / "other_tasks"
    write_task(other, "stack")
    (other / "__init__.py").write_text("")
    info = folder / "other" / "other_tasks-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: other-tasks\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[taskbuilder.tasks]\nlab = other_tasks\n")
    monkeypatch.syspath_prepend(folder / "other")
    with pytest.raises(FileError, match=r'the task "lab/stack" is also'):
        Catalogue().task("lab/stack")
