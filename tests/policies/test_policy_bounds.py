"""Files of numbers that ask for more memory than they have, and numbers that are none."""

from __future__ import annotations

import io
import json
import tracemalloc
import zipfile

import numpy as np
import pytest
from made_runs import sideways

from taskbuilder.arrays import StoreError, read_arrays, write_arrays
from taskbuilder.policies import zoo
from taskbuilder.policies.zoo import load_policy, save_policy

ABOUT = np.frombuffer(json.dumps({"kind": "policy", "squash": True}).encode(), dtype=np.uint8)


def refused(path, match, most=16 << 20):
    """Reading a file as a policy is refused, and takes no more memory than so many bytes."""
    tracemalloc.start()
    try:
        with pytest.raises(StoreError, match=match):
            load_policy(str(path))
        assert tracemalloc.get_traced_memory()[1] < most
    finally:
        tracemalloc.stop()


def npy(array=None, *, header=None):
    """A .npy file: of an array, or with a header of one's own."""
    out = io.BytesIO()
    if array is not None:
        np.lib.format.write_array(out, array)
    else:
        text = header.encode()
        out.write(b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text)
    return out.getvalue()


def zipped(path, parts, kind=zipfile.ZIP_STORED):
    with zipfile.ZipFile(path, "w", kind) as file:
        for name, content in {"about.json.npy": npy(ABOUT), **parts}.items():
            file.writestr(name, content)


def test_a_file_does_not_unpack_to_more_than_it_is(tmp_path):
    path = tmp_path / "bomb.npz"
    parts = {"a/0/weight.npy": npy(np.zeros((4_000, 4_000), np.float32)), "a/0/bias.npy": b""}
    zipped(path, parts, zipfile.ZIP_DEFLATED)
    assert path.stat().st_size < 100_000
    refused(path, r"bomb\.npz: .*packed")


def test_a_part_that_is_listed_many_times_is_not_read_many_times(tmp_path):
    with zipfile.ZipFile(tmp_path / "bomb.npz", "w") as file:
        file.writestr("about.json.npy", npy(ABOUT))
        file.writestr("a/0/weight.npy", npy(np.zeros(50_000)))
        file.filelist += 50 * file.filelist[-1:]
    refused(tmp_path / "bomb.npz", r"bomb\.npz: is damaged.*more than there is")


@pytest.mark.parametrize(
    "header",
    [
        "{'descr': '<f4', 'fortran_order': False, 'shape': (1000000000000,), }",
        "{'descr': '<f4', 'fortran_order': False, 'shape': (100000000,), }",
        "{'descr': '<f4', 'fortran_order': False, 'shape': (-1,), }",
        "{'descr': '<f4', 'fortran_order': False, 'shape': (True, 'x'), }",
        "{'descr': ('<f4', (1000000000,)), 'fortran_order': False, 'shape': (1,), }",
        "{'descr': '|S1000000000', 'fortran_order': False, 'shape': (1,), }",
        "{'descr': '|O', 'fortran_order': False, 'shape': (1,), }",
        "-" * 9_000 + "1",
        "(" * 9_000,
        "'''",
    ],
)
def test_a_part_that_claims_to_be_more_than_it_is_is_refused(header, tmp_path):
    zipped(tmp_path / "odd.npz", {"a/0/weight.npy": npy(header=header) + bytes(8)})
    refused(tmp_path / "odd.npz", r"odd\.npz: is damaged")


def test_a_file_larger_than_policies_are_is_not_read(tmp_path, monkeypatch):
    path = tmp_path / "large.npz"
    with path.open("wb") as file:
        file.truncate(zoo.LARGEST + 1)  # takes no place on the disk
    refused(path, r"large\.npz: is larger than a policy may be \(64 MiB\)")


@pytest.mark.parametrize("number", [np.nan, np.inf, -np.inf])
def test_weights_that_are_not_finite_are_refused_by_the_name_of_their_file(number, tmp_path):
    made = sideways()
    made.networks["arm"].layers[0][0][3, 1] = number
    save_policy(tmp_path / "odd.npz", made)
    with pytest.raises(StoreError, match=r"odd\.npz: arm/0/weight has numbers that are not finite"):
        load_policy(str(tmp_path / "odd.npz"))


@pytest.mark.parametrize("dtype", ["c8", "?", "U3"])
def test_weights_are_numbers_of_floating_point(dtype, tmp_path):
    zipped(
        tmp_path / "odd.npz",
        {"a/0/weight.npy": npy(np.zeros((2, 1), dtype)), "a/0/bias.npy": npy(np.zeros(1, dtype))},
    )
    with pytest.raises(StoreError, match=r"odd\.npz: (is damaged|lacks parts of a policy)"):
        load_policy(str(tmp_path / "odd.npz"))


def test_arrays_in_columns_are_read_as_they_are(tmp_path):
    array = np.asfortranarray(np.arange(6.0).reshape(2, 3))
    write_arrays(tmp_path / "a.npz", {"a": array}, {"kind": "test"})
    assert np.array_equal(read_arrays(tmp_path / "a.npz", "test")[0]["a"], array)
