"""YAML read safely, by YAML 1.2's rules for scalars, with the place of every key and value."""

from __future__ import annotations

import contextlib
import math
import os
from pathlib import Path

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from taskbuilder.errors import FileError, Location
from taskbuilder.schema.source import MAX_BYTES, dotted, read_source

any_folder = settings(suppress_health_check=[HealthCheck.function_scoped_fixture])


def refused(source, text) -> str:
    """The one finding that keeps a text from being read."""
    with pytest.raises(FileError) as caught:
        source(text)
    assert len(caught.value.findings) == 1
    return str(caught.value)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1", 1),
        ("-12", -12),
        ("+3", 3),
        ("012", 12),
        ("0o17", 15),
        ("0x1F", 31),
        ("1e-3", 0.001),
        ("1E3", 1000.0),
        ("-.5", -0.5),
        ("2.", 2.0),
        (".inf", math.inf),
        ("-.INF", -math.inf),
        ("~", None),
        ("", None),
        ("null", None),
        ("true", True),
        ("FALSE", False),
        *((text, text) for text in ("off", "on", "yes", "no", "y", "tRUE", "nUll")),
        *((text, text) for text in ("1_000", "0b11", "-0x1F", "0o8", "1:30", "2026-01-31")),
        *((text, text) for text in (".", "1e", "inf", "nan", "1.2.3", "=", "0x")),
        ('"5"', "5"),
        ("'true'", "true"),
        ('""', ""),
        ("|\n  7\n", "7\n"),
        (">-\n  null\n", "null"),
    ],
)
def test_scalars_mean_what_yaml_1_2_says(source, text, value):
    read = source(f"key: {text}").data["key"]
    assert read == value
    assert type(read) is type(value)


def test_nan_is_a_number(source):
    assert math.isnan(source("key: .nan").data["key"])


def test_keys_are_always_text(source):
    text = "1: a\non: b\nnull: c\n1e3: d\n'': e\n"
    assert source(text).data == {"1": "a", "on": "b", "null": "c", "1e3": "d", "": "e"}


@pytest.mark.parametrize(
    "number", ["9" * 101, "0x" + "f" * 5000, "0o" + "7" * 200, "." + "1" * 100]
)
def test_a_number_longer_than_any_measurement_is_refused(source, number):
    assert refused(source, f"mass: {number}") == (
        "a.yaml:1:7: error[TB104] a number of over 100 digits"
    )


def test_block_and_flow_values_are_marked_by_line_and_column_from_1(source):
    read = source("a:\n  bb: 1\n  c: [10, {d: 20}]\n'e f':\n- x\n-  y\n")
    assert read.values == {
        (): (1, 1),
        ("a",): (2, 3),
        ("a", "bb"): (2, 7),
        ("a", "c"): (3, 6),
        ("a", "c", 0): (3, 7),
        ("a", "c", 1): (3, 11),
        ("a", "c", 1, "d"): (3, 15),
        ("e f",): (5, 1),
        ("e f", 0): (5, 3),
        ("e f", 1): (6, 4),
    }
    assert read.keys == {
        ("a",): (1, 1),
        ("a", "bb"): (2, 3),
        ("a", "c"): (3, 3),
        ("a", "c", 1, "d"): (3, 12),
        ("e f",): (4, 1),
    }


def test_columns_count_characters_rather_than_bytes(source):
    assert source("{grün: 1, ä: 2}").keys[("ä",)] == (1, 11)


def test_a_place_that_does_not_exist_is_that_of_its_nearest_ancestor(source):
    read = source("a:\n  b: 1\n")
    here = Path("a.yaml")
    assert read.locate(("a", "b")) == Location(here, 2, 6)
    assert read.locate(("a", "b"), key=True) == Location(here, 2, 3)
    assert read.locate(("a", "missing")) == Location(here, 1, 1)
    assert read.locate(("a", "b", "c", 0)) == Location(here, 2, 3)
    assert read.locate(("nothing",)) == Location(here, 1, 1)


def test_values_are_looked_up_by_path_without_fuss(source):
    read = source("a: {b: [1, {c: 2}]}")
    assert read.get("a", "b", 1, "c") == 2
    assert read.get("a", "b", 7) is None
    assert read.get("a", "b", "c") is None
    assert dict(read.entries("a", "b", 1)) == {"c": 2}
    assert dict(read.entries("a", "b")) == {}


def test_paths_are_written_as_people_do():
    assert dotted(()) == ""
    assert dotted(("expert", 2, "left", "grasp")) == "expert[2].left.grasp"


def test_every_duplicate_key_is_reported_and_the_first_one_counts(source):
    read = source("a: 1\nb: {c: 1, c: 2}\na: 3\na: 4\n")
    assert read.data == {"a": 1, "b": {"c": 1}}
    assert [str(finding) for finding in read.findings] == [
        'a.yaml:2:11: error[TB004] the key "c" stands here for the second time; it is on line 2',
        'a.yaml:3:1: error[TB004] the key "a" stands here for the second time; it is on line 1',
        'a.yaml:4:1: error[TB004] the key "a" stands here for the second time; it is on line 1',
    ]


@pytest.mark.parametrize(
    "tag", ["!!python/object/apply:os.system", "!custom", "!!str", "!!binary", "!<tag:x,1:y>"]
)
def test_tags_are_reported_and_never_followed(source, tag):
    read = source(f"a: {tag} x")
    assert read.data == {"a": "x"}
    assert [finding.code for finding in read.findings] == ["TB005"]


@pytest.mark.parametrize("value", ["{b: 1}", "[1]"])
def test_tags_on_collections_are_reported(source, value):
    assert [finding.code for finding in source(f"a: !!set {value}").findings] == ["TB005"]


def test_tags_on_keys_are_reported(source):
    assert [finding.code for finding in source("!!python/name:os.system a: 1").findings] == [
        "TB005"
    ]


def test_merge_keys_are_refused(source):
    assert refused(source, "a: &a {b: 1}\nc: {<<: *a, d: 2}\n").startswith(
        "a.yaml:2:5: error[TB005] merge keys belong to YAML 1.1; "
    )
    assert source("'<<': 1").data == {"<<": 1}


def test_an_alias_repeats_a_value_where_it_stands(source):
    read = source("a: &here {b: [1, 2]}\nc: *here\n")
    assert read.data == {"a": {"b": (1, 2)}, "c": {"b": (1, 2)}}
    assert read.values[("c",)] == (2, 4)
    assert read.values[("c", "b")] == (1, 14)
    assert not read.findings


def test_an_alias_without_a_finished_anchor_is_refused(source):
    assert refused(source, "a: *b\n") == (
        'a.yaml:1:4: error[TB006] no anchor "&b" is complete before this alias'
    )
    assert "TB006" in refused(source, "a: &a [*a]\n")


def test_aliases_that_multiply_are_refused_before_anything_is_built(source):
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]" for i in range(1, 20)]
    assert "more than 20,000 values once aliases are written out" in refused(
        source, "\n".join(lines)
    )


def test_aliases_that_nest_are_bounded_in_depth(source):
    lines = ["a0: &a0 [x]", *(f"a{i}: &a{i} [*a{i - 1}]" for i in range(1, 40))]
    assert "nested deeper than 24 levels" in refused(source, "\n".join(lines))


@pytest.mark.parametrize("opening", ["[", "{a: ", "- "])
def test_deep_nesting_is_refused(source, opening):
    assert "nested deeper than 24 levels" in refused(source, "a:\n " + opening * 20_000)


def test_a_huge_file_is_refused_unread(source, folder):
    with (folder / "a.yaml").open("wb") as file:
        file.truncate(MAX_BYTES + 1)
    with pytest.raises(FileError, match=r"TB006\] 262,145 bytes; at most 262,144 are read"):
        read_source(Path("a.yaml"))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: b\n c: d", "a.yaml:2:3: error[TB003] not valid YAML: a ': ' within a text; put"),
        ("a: [1, 2", "a.yaml:2:1: error[TB003] not valid YAML: while parsing a flow sequence"),
        ("a: 'b", "a.yaml:1:6: error[TB003] not valid YAML: while scanning a quoted scalar"),
        (
            "a:\n\tb: 1",
            "a.yaml:2:1: error[TB003] not valid YAML: a tab; indent by spaces",
        ),
        ("a: 1\nb: x\0y", "a.yaml:2:5: error[TB003] not valid YAML: control character '\\x00'"),
        ("a: \x1b[0m", "a.yaml:1:4: error[TB003] not valid YAML: control character '\\x1b'"),
        ("a: 1\n--- \nb: 2", "a.yaml:2:1: error[TB003] a second document begins"),
        ("? [a]\n: 1", "a.yaml:1:3: error[TB003] a key must be a plain name"),
        ("", "a.yaml: error[TB007] the file is empty"),
        ("# only a comment\n", "a.yaml: error[TB007] the file is empty"),
        ("---\n...\n", "a.yaml: error[TB007] the file is empty"),
        ("- a\n- b\n", "a.yaml:1:1: error[TB007] the top level must be a mapping"),
        ("just text", "a.yaml:1:1: error[TB007] the top level must be a mapping"),
        (b"a: 1\nb: \xff\n", "a.yaml:2:1: error[TB002] byte 0xff is not UTF-8"),
        ("a: ä".encode("utf-16"), "a.yaml:1:1: error[TB002] byte 0xff is not UTF-8"),
        (b"a: \xed\xa0\x80", "a.yaml:1:1: error[TB002] byte 0xed is not UTF-8"),
    ],
)
def test_what_is_no_yaml_mapping_is_refused_where_it_goes_wrong(source, text, message):
    assert refused(source, text).startswith(message)


def test_a_byte_order_mark_is_taken_for_none(source):
    read = source("\ufeffa: 1".encode())
    assert read.data == {"a": 1}
    assert read.keys[("a",)] == (1, 1)


def test_findings_from_before_a_fatal_one_are_kept(source):
    with pytest.raises(FileError) as caught:
        source("a: 1\na: 2\nb: [")
    assert [finding.code for finding in caught.value.findings] == ["TB004", "TB003"]


@pytest.mark.parametrize(
    ("path", "reason"),
    [
        ("missing.yaml", "there is no such file"),
        (".", "this is a folder; name the YAML file in it"),
        ("a.yaml/b.yaml", "cannot be read: Not a directory"),
        ("x" * 300 + ".yaml", "cannot be read: File name too long"),
        ("a\0.yaml", "cannot be read: its path contains a null character"),
    ],
)
def test_a_path_that_leads_to_no_file_is_refused(source, path, reason):
    source("a: 1")
    with pytest.raises(FileError) as caught:
        read_source(Path(path))
    assert str(caught.value) == f"{path}: error[TB001] {reason}"


def test_a_pipe_is_refused_rather_than_waited_for(folder):
    os.mkfifo("pipe.yaml")
    with pytest.raises(FileError, match="no plain file"):
        read_source(Path("pipe.yaml"))


@pytest.mark.parametrize("loader", ["CSafeLoader", "SafeLoader"])
def test_both_of_pyyaml_s_parsers_are_read_alike(source, monkeypatch, loader):
    monkeypatch.setattr("taskbuilder.schema.source.LOADER", getattr(yaml, loader))
    read = source("a: &a [1, '1', ~, 1e-3]\n'<<': *a\na: 2\n!t b: !!str c\n")
    assert read.data == {"a": (1, "1", None, 0.001), "<<": (1, "1", None, 0.001), "b": "c"}
    assert [finding.code for finding in read.findings] == ["TB004", "TB005", "TB005"]
    assert "TB005" in refused(source, "a: &a {b: 1}\nc: {<<: *a}")
    assert "TB003" in refused(source, "a: \0")


@any_folder
@given(st.text())
def test_no_text_raises_anything_but_a_file_error(source, text):
    with contextlib.suppress(FileError):
        source(text.encode("utf-8", "surrogatepass"))


@any_folder
@given(st.text(alphabet="ab:-[]{}&*!|>'\"#%?,.<0 1\n\t\\x~@`", max_size=40))
def test_no_text_of_yaml_signs_raises_anything_but_a_file_error(source, text):
    with contextlib.suppress(FileError):
        source(text)


@any_folder
@given(st.binary())
def test_no_bytes_raise_anything_but_a_file_error(source, data):
    with contextlib.suppress(FileError):
        source(data)


printable = st.text(st.characters(min_codepoint=32, max_codepoint=0x2FF, exclude_characters="\x7f"))
plain_data = st.recursive(
    st.booleans()
    | st.none()
    | st.integers(-(10**9), 10**9)
    | st.floats(allow_nan=False)
    | printable,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(printable, inner, max_size=4),
    max_leaves=12,
)


def as_read(value):
    """Plain data as the reader gives it back: tuples in place of lists."""
    if isinstance(value, list):
        return tuple(map(as_read, value))
    return {k: as_read(v) for k, v in value.items()} if isinstance(value, dict) else value


@any_folder
@given(st.dictionaries(printable, plain_data, min_size=1, max_size=4), st.booleans())
def test_what_pyyaml_writes_is_read_back_equal(source, data, flow):
    # Quoted, because PyYAML leaves plain what only YAML 1.1 takes for text, such as 1e3.
    text = yaml.dump(data, default_flow_style=flow, allow_unicode=True, Dumper=QuotedDumper)
    assert source(text).data == as_read(data)


class QuotedDumper(yaml.SafeDumper):
    """Writes all text in double quotes, keys too."""

    def ignore_aliases(self, data):
        return True


QuotedDumper.add_representer(
    str, lambda dumper, text: dumper.represent_scalar("tag:yaml.org,2002:str", text, style='"')
)
