"""Policies, and the files that they and other numbers are kept in."""

from __future__ import annotations

import errno
import io
import os
import subprocess
import sys
import zipfile

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from taskbuilder.arrays import StoreError, read_arrays, write_arrays
from taskbuilder.errors import UnknownNameError, UsageError
from taskbuilder.policies import zoo
from taskbuilder.policies.trained import Network, TrainedPolicy, folded
from taskbuilder.policies.zoo import load_policy, save_policy, zoo_names

ABOUT = {"kind": "test", "words": "ä"}
ARRAYS = {"left/0": np.arange(3, dtype=np.float32), "count": np.array([7], dtype=np.int64)}


def network(ins=2, outs=1, *, squash=True, norms=False, seed=0):
    draws, sizes = np.random.default_rng(seed), (ins, 4, outs)
    layers = tuple(
        (draws.standard_normal((a, b), dtype=np.float32), draws.random(b, dtype=np.float32))
        for a, b in ((sizes[0], sizes[1]), (sizes[1], sizes[2]))
    )
    return Network(layers, squash, norms)


def policy(*, squash=True, norms=False):
    kind = {"squash": squash, "norms": norms}
    return TrainedPolicy(
        {"left": network(2, 1, **kind), "right": network(3, 2, **kind, seed=1)},
        {"task": "handover", "step": 12},
    )


def same(one, other):
    return set(one) == set(other) and all(
        np.array_equal(one[n], other[n]) and one[n].dtype == other[n].dtype for n in one
    )


@pytest.fixture
def content(tmp_path):
    """The bytes of a small file."""
    write_arrays(tmp_path / "whole.npz", ARRAYS, ABOUT)
    return (tmp_path / "whole.npz").read_bytes()


# --- networks and policies


def test_a_network_is_its_layers_with_relu_between_and_ends_in_tanh_or_bounds():
    layers = (
        (np.array([[1.0, -1.0]], dtype=np.float32), np.array([0.5, 0.0], dtype=np.float32)),
        (np.array([[2.0], [0.2]], dtype=np.float32), np.array([-1.0], dtype=np.float32)),
    )
    inputs = np.array([[0.25], [-0.25], [3.0], [-2.0]])
    before = np.array([[0.5], [-0.45], [6.0], [-0.6]])
    assert Network(layers, squash=True)(inputs) == pytest.approx(np.tanh(before))
    assert Network(layers, squash=False)(inputs) == pytest.approx(np.clip(before, -1.0, 1.0))


def test_every_agent_acts_by_what_it_alone_sees():
    made = policy()
    seen = {"left": np.ones(2), "right": np.ones(3)}
    acts = made.act(seen)
    assert {a: v.shape for a, v in acts.items()} == {"left": (1,), "right": (2,)}
    other = made.act({**seen, "right": -np.ones(3)})
    assert np.array_equal(acts["left"], other["left"])
    assert not np.array_equal(acts["right"], other["right"])


@given(st.integers(0, 3), st.integers(0, 2**32 - 1))
def test_folding_takes_the_standardising_and_the_role_into_the_first_layer(roles, seed):
    draws = np.random.default_rng(seed)
    plain = network(3 + roles, 2, seed=seed)
    mean, scale = draws.normal(0, 5, 3).astype("f4"), draws.uniform(0.1, 9, 3).astype("f4")
    role = np.eye(roles, dtype=np.float32)[0] if roles else np.zeros(0, dtype=np.float32)
    seen = mean + scale * draws.standard_normal((10, 3))
    told = np.concatenate([(seen - mean) / scale, np.tile(role, (10, 1))], 1)
    out = Network(folded(plain.layers, mean, scale, role), squash=True)(seen)
    assert out == pytest.approx(plain(told), abs=1e-4)


def test_policies_need_no_torch():
    code = "import sys; sys.modules['torch'] = None; import taskbuilder.policies.zoo"
    subprocess.run([sys.executable, "-c", code], check=True)


# --- policies in files


@pytest.mark.parametrize("norms", [True, False])
@pytest.mark.parametrize("squash", [True, False])
def test_a_policy_read_again_is_the_same(tmp_path, squash, norms):
    made = policy(squash=squash, norms=norms)
    save_policy(tmp_path / "made.npz", made)
    again = load_policy(str(tmp_path / "made.npz"))
    assert list(again.networks) == ["left", "right"]
    assert again.about.items() >= made.about.items()
    seen = {"left": np.full((2, 2), [[0.1], [9.0]]), "right": np.full((2, 3), [[0.1], [9.0]])}
    assert same(again.act(seen), made.act(seen))
    assert 0.0 < np.abs(again.act(seen)["left"][0]) < 0.9  # neither tanh nor bounds hide the rest


def test_a_policy_is_found_by_the_folder_of_its_run(tmp_path):
    save_policy(tmp_path / "policy.npz", policy())
    assert load_policy(str(tmp_path)).about["step"] == 12


def test_a_folder_without_a_policy_says_so(tmp_path):
    with pytest.raises(UsageError, match=r"is no training run; it has no run\.json and no policy"):
        load_policy(str(tmp_path))
    (tmp_path / "run.json").write_text("{}")
    with pytest.raises(UsageError, match=r"has no policy\.npz; it comes with an evaluation"):
        load_policy(str(tmp_path))


def test_what_is_neither_a_file_nor_a_folder_is_refused_with_what_would_be_right(tmp_path):
    with pytest.raises(UsageError, match="name the folder of a training run"):
        load_policy(str(tmp_path / "nowhere"))


def test_the_zoo_is_known_by_name(tmp_path, monkeypatch):
    monkeypatch.setattr(zoo, "ZOO", tmp_path)
    (tmp_path / "handover").mkdir()
    save_policy(tmp_path / "handover" / "scratch.npz", policy())
    assert zoo_names() == ("zoo:handover/scratch",)
    assert load_policy("zoo:handover/scratch").about["task"] == "handover"
    with pytest.raises(UnknownNameError, match='did you mean "zoo:handover/scratch"'):
        load_policy("zoo:handover/scratsh")
    with pytest.raises(UnknownNameError, match="the zoo has: zoo:handover/scratch"):
        load_policy("zoo:../../elsewhere")


@pytest.mark.parametrize(
    ("arrays", "about"),
    [
        ({"left/0/weight": np.zeros((2, 1), dtype=np.float32)}, {"squash": True}),
        ({"left/1/weight": np.zeros(1), "left/1/bias": np.zeros(1)}, {"squash": True}),
        ({"weights": np.zeros(1)}, {"squash": True}),
        ({"left/x/weight": np.zeros(1), "left/x/bias": np.zeros(1)}, {"squash": True}),
        ({}, {}),
    ],
)
def test_a_file_that_lacks_parts_of_a_policy_is_refused(tmp_path, arrays, about):
    write_arrays(tmp_path / "odd.npz", arrays, {"kind": "policy", **about})
    with pytest.raises(StoreError, match=r"odd\.npz: lacks parts of a policy"):
        load_policy(str(tmp_path / "odd.npz"))


# --- files of numbers


def test_arrays_read_again_are_the_same_to_the_bit(tmp_path):
    draws = np.random.default_rng(0)
    arrays = {
        "weights/0": draws.standard_normal((3, 4), dtype=np.float32),
        "file": np.array([np.nan, -0.0, np.inf]),
        "flags": np.array([True, False]),
        "nothing": np.zeros((0, 5), dtype=np.float32),
    }
    write_arrays(tmp_path / "a.npz", arrays, {**ABOUT, "deep": {"list": [1, None]}})
    read, about = read_arrays(tmp_path / "a.npz", "test")
    assert {n: (a.dtype, a.shape, a.tobytes()) for n, a in read.items()} == {
        n: (a.dtype, a.shape, a.tobytes()) for n, a in arrays.items()
    }
    assert about == {**ABOUT, "deep": {"list": [1, None]}}


def test_a_file_of_another_kind_is_refused(tmp_path, content):
    with pytest.raises(StoreError, match=r"whole\.npz: is a test; a policy is needed"):
        load_policy(str(tmp_path / "whole.npz"))


def test_a_file_cut_off_anywhere_is_refused(tmp_path, content):
    path = tmp_path / "cut.npz"
    for length in range(len(content)):
        path.write_bytes(content[:length])
        with pytest.raises(StoreError, match=r"cut\.npz: is damaged"):
            read_arrays(path, "test")


def test_a_changed_bit_is_found_out_or_does_no_harm(tmp_path, content):
    path, harmless = tmp_path / "changed.npz", 0
    for place in range(len(content)):
        changed = bytearray(content)
        changed[place] ^= 1 << place % 8
        path.write_bytes(changed)
        try:
            arrays, about = read_arrays(path, "test")
        except StoreError:
            continue
        harmless += 1
        assert same(arrays, ARRAYS), place
        assert about == ABOUT
    assert harmless < 0.4 * len(content)  # dates and the like, which nobody reads


def damaged_shape(content):
    """The file with an array that claims to be huge, its checksums as they should be."""
    out = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(content)) as old, zipfile.ZipFile(out, "w") as new:
        for name in old.namelist():
            new.writestr(name, old.read(name).replace(b"(3,), }", b"(3,3)}"))
    return out.getvalue()


class Bomb:
    """Would do harm if it were unpickled."""

    def __reduce__(self):
        return (os.abort, ())


def saved(writer, *arguments, **arrays):
    out = io.BytesIO()
    writer(out, *arguments, **arrays)
    return out.getvalue()


FOREIGN = {
    "empty": b"",
    "text": b"step,seconds\n1,2\n",
    "one array": saved(np.save, np.zeros(3)),
    "no words": saved(np.savez, weights=np.zeros(3)),
    "words that are none": saved(np.savez, **{"about.json": np.array([1, 2], dtype=np.uint8)}),
    "words of another sort": saved(np.savez, **{"about.json": np.frombuffer(b"[1]", "u1")}),
    "pickle in an array": saved(np.savez, weights=np.array([Bomb()], dtype=object)),
    "pickle": b"\x80\x04\x95\x00\x00\x00\x00\x00\x00\x00\x00c__main__\nBomb\n.",
    "zip of something": saved(lambda out: zipfile.ZipFile(out, "w").close()),
}


@pytest.mark.parametrize("name", FOREIGN)
def test_foreign_files_are_refused_and_pickles_are_not_opened(tmp_path, name):
    (tmp_path / "foreign.npz").write_bytes(FOREIGN[name])
    with pytest.raises(StoreError, match=r"foreign\.npz: is (damaged|a foreign file)"):
        read_arrays(tmp_path / "foreign.npz", "test")


def test_an_array_that_is_not_what_it_claims_is_refused(tmp_path, content):
    (tmp_path / "odd.npz").write_bytes(damaged_shape(content))
    with pytest.raises(StoreError, match=r"odd\.npz: is damaged"):
        read_arrays(tmp_path / "odd.npz", "test")


def test_what_is_missing_is_left_to_the_caller(tmp_path):
    with pytest.raises(FileNotFoundError):
        read_arrays(tmp_path / "nothing.npz", "test")


def test_objects_are_not_written(tmp_path):
    with pytest.raises(ValueError, match="allow_pickle"):
        write_arrays(tmp_path / "a.npz", {"odd": np.array([Bomb()], dtype=object)}, ABOUT)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("step", ["fsync", "replace"])
def test_a_file_that_cannot_be_written_leaves_the_old_one_as_it_was(
    tmp_path, content, monkeypatch, step
):
    def full(*arguments):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, step, full)
    with pytest.raises(OSError, match="No space left"):
        write_arrays(tmp_path / "whole.npz", {"other": np.ones(9)}, ABOUT)
    assert [file.name for file in tmp_path.iterdir()] == ["whole.npz"]
    assert (tmp_path / "whole.npz").read_bytes() == content
