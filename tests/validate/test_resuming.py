"""An interrupted validation goes on from the last family that was finished."""

from __future__ import annotations

import pickle

import pytest

from taskbuilder import validate_task
from taskbuilder.arrays import packed_arrays
from taskbuilder.cli import main
from taskbuilder.validate.checks import build, incentives, reset
from taskbuilder.validate.report import FamilyResult

pytestmark = pytest.mark.in_process

OPTIONS = {"level": "build", "seeds": 2}
WORDS = ("--level", "build", "--seeds", "2")


@pytest.fixture(autouse=True)
def cached(tmp_path, monkeypatch):
    """A cache folder for the test; descriptions are not tried in a child process first."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr("taskbuilder.task.try_import", lambda _: None)
    return tmp_path / "cache" / "taskbuilder" / "validations"


@pytest.fixture
def interrupted(write, monkeypatch):
    """A task whose validation was interrupted after the family build, which is not run again."""

    def interrupt(_):
        raise KeyboardInterrupt

    def twice(_):
        raise AssertionError("the family build was run again")

    file = write()
    with monkeypatch.context() as patch:
        patch.setattr(reset, "reset_family", interrupt)
        with pytest.raises(KeyboardInterrupt):
            validate_task(file, **OPTIONS, keep=True, apart=False)
    monkeypatch.setattr(build, "build_family", twice)
    return file


def test_it_goes_on_after_the_last_family_that_was_finished(interrupted, cached):
    (kept,) = cached.iterdir()
    assert kept.stat().st_mode & 0o777 == 0o600
    report = validate_task(interrupted, **OPTIONS, resume=True, apart=False)
    assert [(family.name, family.ok) for family in report.families] == [
        ("static", True),
        ("build", True),
        ("reset", True),
    ]
    assert report.making.seconds > sum(family.seconds for family in report.families[:2])


def test_it_goes_on_only_if_it_is_asked_to(interrupted):
    report = validate_task(interrupted, **OPTIONS, apart=False)
    assert "was run again" in report.findings[0].message


@pytest.mark.parametrize("other", [{"seeds": 3}, {"only": ("build", "reset")}])
def test_other_arguments_are_another_validation(interrupted, other):
    report = validate_task(interrupted, **(OPTIONS | other), resume=True, apart=False)
    assert "was run again" in report.findings[0].message


def test_a_task_whose_files_have_changed_starts_anew(interrupted, monkeypatch, capfd):
    with interrupted.with_suffix(".py").open("a") as file:
        file.write("\n# changed\n")
    monkeypatch.setattr(build, "build_family", lambda _: FamilyResult("build", (), (), "anew"))
    monkeypatch.setattr("taskbuilder.validate.runner.CHILDREN", False)
    assert main(["validate", str(interrupted), *WORDS, "--resume"]) == 0
    printed = capfd.readouterr()
    assert "its files have changed since it was interrupted; starting anew" in printed.err
    assert "anew" in printed.out


def test_the_command_says_where_it_goes_on_and_removes_what_is_done(
    interrupted, cached, monkeypatch, capfd
):
    monkeypatch.setattr("taskbuilder.validate.runner.CHILDREN", False)
    assert main(["validate", str(interrupted), *WORDS, "--resume", "--format", "json"]) == 0
    printed = capfd.readouterr()
    assert printed.err == f"{interrupted}: going on after build\n"
    assert printed.out.startswith("{")
    assert list(cached.iterdir()) == []
    assert main(["validate", str(interrupted), *WORDS, "--resume"]) == 1  # build is run again
    assert "nothing was interrupted; starting from the beginning" in capfd.readouterr().err


class Boom:
    """Raises an error when it is unpickled."""

    def __reduce__(self):
        return (eval, ("1 / 0",))


def another(kept):
    """What a file of results would contain with other content."""
    return packed_arrays({}, {"kind": "partial validation", "checksum": "", "kept": kept})


FOREIGN = {"mapping": [["system", {"Popen": ["true"]}]]}


@pytest.mark.parametrize(
    "content",
    [b"", b"junk", pickle.dumps(Boom()), another(None), another([1, 2]), another(FOREIGN)],
)
def test_a_damaged_file_starts_anew(content, interrupted, cached, monkeypatch, capfd):
    (kept,) = cached.iterdir()
    kept.write_bytes(content)
    monkeypatch.setattr("taskbuilder.validate.runner.CHILDREN", False)
    assert main(["validate", str(interrupted), *WORDS, "--resume"]) == 1
    assert "is damaged; starting anew" in capfd.readouterr().err


def test_what_others_could_have_written_is_not_read(interrupted, cached, monkeypatch, capfd):
    (kept,) = cached.iterdir()
    kept.chmod(0o666)
    monkeypatch.setattr("taskbuilder.validate.runner.CHILDREN", False)
    assert main(["validate", str(interrupted), *WORDS, "--resume"]) == 1
    assert "could be written by others; starting anew" in capfd.readouterr().err


def test_episodes_are_read_back_as_they_were_kept(write_pair, cached, monkeypatch):
    """The families after the interruption find the same demonstrations and probes, to the bit."""
    states = []

    def interrupt(context):
        states.append(context.state)
        raise KeyboardInterrupt

    file, only = write_pair(), ("needs its robots", "pays for success")
    monkeypatch.setattr(incentives, "pays_family", interrupt)
    with pytest.raises(KeyboardInterrupt):
        validate_task(file, seeds=1, only=only, keep=True, apart=False)
    with pytest.raises(KeyboardInterrupt):
        validate_task(file, seeds=1, only=only, resume=True, apart=False)
    (measures, demonstrations, plays), again = states
    assert (measures, list(demonstrations), list(plays)) == (again[0], [*again[1]], [*again[2]])
    assert {baseline.kind for baseline in plays} >= {"without", "alone", "random"}
    episodes = [*demonstrations.items(), *((s, r) for p in plays.values() for s, r in p.items())]
    kept = [*again[1].items(), *((s, r) for p in again[2].values() for s, r in p.items())]
    for (start, rollout), (kept_start, read) in zip(episodes, kept, strict=True):
        assert (start, type(start)) == (kept_start, type(kept_start))
        assert rollout.equals(read)
