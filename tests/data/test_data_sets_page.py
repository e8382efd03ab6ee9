"""The page on data sets says what is so: its program runs, and its table has every array."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

from taskbuilder.data.dataset import load_dataset

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "data-sets.md").read_text()


def test_its_program_runs(pictured, tmp_path, monkeypatch, capsys):
    shutil.copytree(pictured, tmp_path / "data" / "handover")
    monkeypatch.chdir(tmp_path)
    (block,) = re.findall(r"^```python\n(.*?)^```$", PAGE, re.M | re.S)
    scope = {"__name__": "page"}
    exec(compile(block, "data-sets.md", "exec"), scope)
    scope["env"].close()
    assert capsys.readouterr().out.count("stick") == 3


def test_its_table_has_every_array(pictured):
    table = PAGE.partition("| array | shape | contents |")[2].partition("\n\n")[0]
    firsts = [row.split("|")[1] for row in table.splitlines() if row.startswith("| `")]
    shown = [name for first in firsts for name in re.findall(r"`([^`]+)`", first)]
    patterns = [re.sub(r"\b(A|C|LABEL|NAME)\b", ".+", name) for name in shown]
    names = load_dataset(pictured)[0].arrays
    assert [n for n in names if not any(re.fullmatch(p, n) for p in patterns)] == []
    assert [p for p in patterns if not any(re.fullmatch(p, n) for n in names)] == []


def test_it_names_every_file(pictured):
    text = PAGE.partition("## Format")[2].partition("```\n")[0]
    shown = set(re.findall(r"(\w+(?:\.\w+)*\.(?:json|npz|mp4|mkv|md))\b", text))
    files = {file.name for file in pictured.rglob("*") if file.is_file()}
    assert {name.replace("left_wrist", "front") for name in files} <= shown
