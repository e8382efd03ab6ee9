"""The library speaks the field's language: no private word names a module, class or attribute."""

from __future__ import annotations

import ast
import sys
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import pytest

LIBRARY = Path(__file__).resolve().parents[1] / "taskbuilder"

# By package, the words that its own modules, classes, functions and attributes are not called;
# beside each, what they are called.
PRIVATE: dict[str, dict[str, str]] = {
    "learn": {
        "done": "progress_fraction",
        "alike": "shared_reward",
        "said": "actions",
        "shown": "observations",
        "overview": "critic_input",
        "cloning": "bc_updates",
        "judging": "critic_warmup_updates",
        "renew": "reset_networks_after",
        "judge": "CheckpointEvaluator",
        "signals": "training_rewards",
        "expertise": "demonstrations",
        "journal": "logger",
        "comparison": "run_groups",
        "openings": "start_prefixes",
        "opening_share": "start_share",
        "patience": "no_progress_timeout_s",
    },
    "env": {
        "crew": "backends",
        "alone": "InProcess",
        "shard": "EnvGroup",
        "board": "SharedBuffers",
        "moment": "StepView",
        "arena": "Allocator",
        "form": "Signature",
        "orders": "WorkerConfig",
    },
    "expert": {
        "shadow": "CollisionWorld",
        "rehearsal": "dry_run",
        "performance": "Executor",
        "driving": "action_encoder",
        "trees": "rrt",
        "detours": "candidates",
        "blocked": "PlanningError",
    },
    "visual": {
        "chronicle": "timeline",
        "slate": "overlay",
        "shooting": "capture",
        "moments": "keyframes",
        "portrait": "robot_picture",
    },
    "description": {
        "aside": "quiet_import",
        "any_": "AnyOf",
        "least": "Minimum",
        "share": "Fraction",
    },
    "sim": {
        "chatter": "engine_output",
        "faults": "divergence",
        "stepper": "DifferentialIK",
    },
    "diagnostics": {"files": "yaml", "worlds": "scene", "proofs": "rollouts"},
    "validate": {
        "run": "runner",
        "running": "context",
        "studio": "env_cache",
        "places": "locate",
        "shares": "proportion",
        "share": "Proportion",
        "alone": "solo",
        "fresh": "fresh_process",
        "needs": "necessity",
        "pays": "incentives",
        "blame": "cases",
    },
    "world": {"thing": "SceneObject", "things": "scene_objects"},
    "cli": {
        "kinds": "argument_types",
        "place": "EnvFactory",
        "hire": "make_player",
    },
    "": {"spec": "schema", "codes": "diagnostics", "film": "visual", "portrait": "visual"},
}


def definitions(file: Path) -> Iterator[tuple[str, str]]:
    """Every name that a module gives: its own, and those of classes, functions and attributes."""
    where = str(file.relative_to(LIBRARY))
    yield (file.parent.name if file.stem == "__init__" else file.stem), where
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            yield node.name, f"{where}:{node.lineno}"
        elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            yield node.attr, f"{where}:{node.lineno}"
        if isinstance(node, ast.ClassDef):
            for line in node.body:
                if isinstance(line, ast.AnnAssign) and isinstance(line.target, ast.Name):
                    yield line.target.id, f"{where}:{line.lineno}"


@pytest.mark.parametrize("package", PRIVATE)
def test_no_private_word_names_anything(package):
    words = PRIVATE[package]
    files = sorted((LIBRARY / package).rglob("*.py") if package else LIBRARY.glob("*/__init__.py"))
    assert files
    found = [
        f"{where}: {name}; it is called {words[name.strip('_').lower()]}"
        for file in files
        for name, where in definitions(file)
        if name.strip("_").lower() in words and name != "__all__"
    ]
    assert not found, "\n".join(found)


def test_no_class_name_stands_for_two_things():
    places = defaultdict(list)
    for file in sorted(LIBRARY.rglob("*.py")):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ClassDef):
                places[node.name].append(f"{file.relative_to(LIBRARY)}:{node.lineno}")
    twice = {name: at for name, at in places.items() if len(at) > 1}
    assert not twice


# Words that say nothing of what a value is, and what it is called instead.
VAGUE = {
    "found": "the thing that is found: episodes, columns, checkpoint",
    "gains": "advantages",
    "gone": "lost",
    "known": "defaults, recorded or stored values",
    "later": "next_values, next_observations",
    "pay": "reward",
    "said": "text, or actions",
    "shown": "demonstrations, images",
    "sure": "what the comparison says",
    "taken": "loaded, actions",
    "thing": "the name of the object, or the object",
    "things": "objects",
    "told": "text, or rows",
    "way": "approach, direction",
    "ways": "baselines, directions",
    "worthless": "final, or the bootstrap mask",
}


def locals_of(file: Path) -> Iterator[tuple[str, str]]:
    """Every name that functions of a module bind: variables, arguments, and functions."""
    where = str(file.relative_to(LIBRARY))
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.id, f"{where}:{node.lineno}"
        elif isinstance(node, ast.arg):
            yield node.arg, f"{where}:{node.lineno}"
        elif isinstance(node, ast.FunctionDef):
            yield node.name, f"{where}:{node.lineno}"
        elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            yield node.attr, f"{where}:{node.lineno}"


def vague_names(file: Path) -> list[str]:
    return [
        f"{where}: {name}; call it {VAGUE[name.strip('_')]}"
        for name, where in locals_of(file)
        if name.strip("_") in VAGUE
    ]


@pytest.mark.parametrize("package", ["learn", "expert", "env", "data", "policies", "evaluation"])
def test_locals_say_what_they_are(package):
    files = sorted((LIBRARY / package).rglob("*.py"))
    wrong = [line for file in files for line in vague_names(file)]
    assert not wrong, "\n".join(wrong)


def test_a_vague_name_is_seen_wherever_it_is_bound(tmp_path, monkeypatch):
    monkeypatch.setattr(sys.modules[__name__], "LIBRARY", tmp_path)
    file = tmp_path / "x.py"
    file.write_text(
        "def _found(way):\n"
        "    for known in way:\n"
        "        gains = [pay for pay in known]\n"
        "    if (said := gains):\n"
        "        self._told = lambda thing: thing\n"
    )
    names = {line.split("; ")[0].rpartition(" ")[2] for line in vague_names(file)}
    assert names == {"_found", "way", "known", "gains", "pay", "said", "_told", "thing"}


# In these rooms, which share a vocabulary, an alias of a type means the same everywhere.
SHARED = ("cli", "data", "env", "evaluation", "expert", "learn", "policies", "rollout")


def test_no_alias_of_a_type_stands_for_two_types():
    meanings = defaultdict(lambda: defaultdict(list))
    for file in (file for room in SHARED for file in sorted((LIBRARY / room).rglob("*.py"))):
        for node in ast.parse(file.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
                name = node.targets[0].id
                if name[:1].isupper() and not name.isupper():
                    where = f"{file.relative_to(LIBRARY)}:{node.lineno}"
                    meanings[name][ast.unparse(node.value)].append(where)
    twice = {name: dict(places) for name, places in meanings.items() if len(places) > 1}
    assert not twice
