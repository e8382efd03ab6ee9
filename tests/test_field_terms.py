"""The library speaks the field's language: no private word names a module, class or attribute."""

from __future__ import annotations

import ast
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
