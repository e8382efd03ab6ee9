"""A certificate that was made to be believed: sealed anew after an edit, it does not verify."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from taskbuilder.evaluation.certificate import seals

ONE = ("--episodes", "2", "--seed", "4", "--jobs", "1", "--controls", "1")


@pytest.fixture(scope="module")
def content(tmp_path_factory) -> bytes:
    """A certificate of holding still."""
    from taskbuilder.cli import main

    file = tmp_path_factory.mktemp("certificate") / "c.json"
    assert main(["evaluate", "nothing:reach", *ONE, "--certificate", str(file)]) == 0
    return file.read_bytes()


@pytest.fixture
def verified(run, content):
    """Edits the certificate, seals it anew and verifies it."""

    def verify(edit):
        data = json.loads(content)
        edit(data)
        data["seals"] = seals(data)
        Path("c.json").write_text(json.dumps(data))
        return run("evaluate", "--verify", "c.json", "--jobs", "1", "--json")

    return verify


def differs(ran) -> dict[str, list[str]]:
    return {about: told for about, told in ran.data["differs"].items() if told}


def test_it_verifies_unedited(verified):
    ran = verified(lambda _: None)
    assert (ran.status, differs(ran)) == (0, {})


def twice(data):
    data["seeds"] = [4, 4]
    data["episodes"]["policy"][1] = data["episodes"]["policy"][0]


def two_names(data):
    """A result that is named twice, once by a path with a dot, which comes last."""
    control = data["results"]["controls"]["random"]
    data["results"]["controls.random.return"] = control["return"]
    control["return"] = -1e9


def put(*place):
    """Puts the last word where the others lead to."""

    def edit(data):
        *path, name, value = place
        for step in path:
            data = data[step]
        data[name] = value

    return edit


EDITS = {
    "an option that no environment has": (
        put("options", "wind", 5),
        {"options": ["option wind is None here, not 5"]},
    ),
    "the policy of another task": (
        put("policy", "nothing:handover"),
        {"options": ["policy is nothing:reach here, not nothing:handover"]},
    ),
    "the digest of a policy that is none": (
        put("digests", "policy", {"nothing:reach": "0" * 64}),
        {"policy": ["nothing:reach is gone"]},
    ),
    "a truth that is a number": (
        lambda data: data["episodes"]["policy"][0].update(success=0),
        {"episodes": ["policy, seed 4: success"]},
    ),
    "a result of two names": (two_names, {"results": ["are named otherwise"]}),
}


@pytest.mark.parametrize(("edit", "told"), EDITS.values(), ids=EDITS)
def test_an_edit_is_told_though_it_is_sealed(edit, told, verified):
    ran = verified(edit)
    assert ran.status == 1
    assert ran.data["verified"] is False
    assert differs(ran) == told


def test_an_option_of_the_policy_that_is_left_out_is_told(run):
    one = ("--episodes", "1", "--controls", "0", "--jobs", "1")
    assert run("evaluate", "zoo:handover/demos", *one, "--certificate", "z.json").status == 0
    data = json.loads(Path("z.json").read_text())
    frame = data["options"].pop("frame")
    data["seals"] = seals(data)
    Path("z.json").write_text(json.dumps(data))
    ran = run("evaluate", "--verify", "z.json", "--jobs", "1", "--json")
    assert ran.status == 1
    assert differs(ran)["options"] == [f"option frame is {frame} here, not None"]


def test_an_episode_does_not_count_twice(verified):
    ran = verified(twice)
    assert ran.status == 1
    assert differs(ran)["seeds"] == ["do not follow each other, as those of an evaluation do"]


DAMAGED = {
    "more controls than seeds": (put("controls_seeds", 3), "controls_seeds is 3, and it has 2"),
    "fewer controls than none": (put("controls_seeds", -1), "controls_seeds is -1"),
    "a truth as a number": (put("controls_seeds", True), "controls_seeds is True"),
    "a truth as a seed": (put("seeds", [True, 5]), "its seeds are no whole numbers"),
    "seeds without episodes": (put("seeds", list(range(4, 90))), "an episode for each seed"),
    "another section": (put("award", "best"), "it has award, which no certificate has"),
    "escapes": (put("made", "\x1b[2Jtoday"), "control characters"),
    "no seeds": (put("seeds", []), "its seeds are no whole numbers"),
}


@pytest.mark.parametrize(("edit", "said"), DAMAGED.values(), ids=DAMAGED)
def test_what_contradicts_itself_is_damaged(edit, said, verified):
    ran = verified(edit)
    assert (ran.status, ran.out) == (2, "")
    assert said in ran.err
    assert ran.err.count("\n") == 1


def test_a_name_that_is_there_twice_is_damaged(run, content):
    Path("c.json").write_bytes(content.replace(b'"task": ', b'"task": "handover", "task": ', 1))
    ran = run("evaluate", "--verify", "c.json")
    assert ran.status == 2
    assert "a key twice" in ran.err


def test_devices_and_fifos_end_with_one_sentence(run):
    os.mkfifo("fifo")
    for name in ("/dev/zero", "/dev/stdin", "fifo", "."):
        ran = run("evaluate", "--verify", name)
        assert (ran.status, ran.out) == (2, "")
        assert ran.err == f"taskbuilder: {name}: is no plain file\n"


def test_a_file_without_end_is_not_read(run):
    Path("c.json").touch()
    os.truncate("c.json", 1 << 40)  # takes no room on the disk
    ran = run("evaluate", "--verify", "c.json")
    assert ran.status == 2
    assert "has more than 33,554,432 bytes" in ran.err


@pytest.mark.parametrize("make", [os.mkfifo, lambda name: Path(name).symlink_to("/etc/passwd")])
def test_the_policy_of_a_certificate_is_a_plain_file_of_its_folder(make, run, content):
    data = json.loads(content)
    data["policy"] = "policy.npz"
    Path("c.json").write_text(json.dumps(data))
    make("policy.npz")
    ran = run("evaluate", "--verify", "c.json", "--jobs", "1")
    assert ran.status == 2
    assert ran.err.count("\n") == 1


def test_a_policy_without_end_is_not_read(run, content):
    data = json.loads(content)
    data["policy"] = "policy.npz"
    Path("c.json").write_text(json.dumps(data))
    Path("policy.npz").touch()
    os.truncate("policy.npz", 1 << 40)
    ran = run("evaluate", "--verify", "c.json", "--jobs", "1")
    assert ran.status == 2
    assert "policy.npz: has more than 67,108,864 bytes" in ran.err
