"""Which part of the library may import which; the page on the architecture shows these layers."""

from __future__ import annotations

import ast
import io
import re
import sys
import tokenize
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]

FOUNDATION = (
    "_lazy",
    "arguments",
    "engine",
    "errors",
    "extensions",
    "extras",
    "geometry",
    "intervals",
    "interpreters",
    "quiet",
    "wording",
)

FILES = ("schema", "assets", *FOUNDATION)
TASKS_LOADED = ("task", "description", *FILES)
SIMULATED = ("world", "sim", "kinematics", "cameras", "shapes", "hulls", *TASKS_LOADED)

# Each part of taskbuilder, top to bottom, and the parts that it may import besides itself.
# What is not listed is refused: nothing imports upward, and neighbours do not know each other.
LAYERS: dict[str, tuple[str, ...]] = {
    "cli": (
        "agent_tools",
        *("view", "steering", "multiplying", "validate", "bench", "sharing", "benchmark"),
        *("learn", "evaluation", "importing"),
        *("trials", "visual", "expert"),
        *(
            "policies",
            "rollout",
            "env",
            "digests",
            "data",
            "carried",
            "machine",
            "sources",
            "reference",
            "diagnostics",
            "cluster",
            "jobs",
            "processes",
            "arrays",
            "fixes",
            "files",
            "untrusted",
            *SIMULATED,
        ),
    ),
    "agent_tools": ("extras", "errors", "schema"),
    "view": (
        *(
            "steering",
            "validate",
            "data",
            "policies",
            "visual",
            "expert",
            "rollout",
            "env",
            "fixes",
            "files",
        ),
        *SIMULATED,
    ),
    "steering": (
        *("data", "policies", "expert", "rollout", "env", "arrays"),
        *SIMULATED,
    ),
    "multiplying": (
        *("data", "policies", "expert", "rollout", "env", "carried", "arrays", "digests"),
        *("processes", *SIMULATED),
    ),
    "validate": (
        *("bench", "visual", "expert", "rollout", "env"),
        *("diagnostics", "jobs", "digests", "arrays", "files", "processes", *SIMULATED),
    ),
    "bench": ("visual", "expert", "rollout", "env", *SIMULATED),
    "sharing": (
        *("evaluation", "data", "policies", "carried", "digests", "arrays", "files", "untrusted"),
        *("task", "schema", "errors", "wording", "extras", "_version", "_lazy"),
    ),
    "benchmark": (
        *("learn", "evaluation", "data", "policies", "visual", "expert", "env"),
        *("cluster", "jobs", "machine", "files", "untrusted", *SIMULATED),
    ),
    "learn": (
        *("evaluation", "data", "policies", "visual", "expert", "rollout", "env"),
        *("jobs", "processes", "machine", "arrays", "files", "untrusted"),
        *SIMULATED,
    ),
    "evaluation": (
        *("policies", "visual", "expert", "rollout", "env", "sources", "jobs", "processes"),
        *("machine", "digests", "files", "untrusted", "reference", *SIMULATED),
    ),
    "data": (
        *("policies", "rollout", "env", "carried", "sources", "jobs", "processes", "machine"),
        *("digests", "arrays", "files", "untrusted", *SIMULATED),
    ),
    "policies": (*("expert", "rollout", "env", "arrays", "digests", "untrusted", *SIMULATED),),
    "importing": ("trials", *SIMULATED),
    "trials": SIMULATED,
    "visual": ("rollout", "env", "files", *SIMULATED),
    "expert": ("rollout", "env", *SIMULATED),
    "rollout": ("env", "arrays", *SIMULATED),
    "env": ("processes", *SIMULATED),
    "carried": ("sources", "task", "digests", "schema", "errors"),
    "versions": ("sources", "schema", "digests"),
    "sources": ("task", "schema", "assets", "digests"),
    "reference": ("diagnostics", "description", *FILES),
    "task": ("description", *FILES),
    "world": ("sim", "raster", "kinematics", "cameras", "shapes", *FILES),
    "description": ("processes", *FILES),
    "sim": ("raster", "cameras", "shapes", "hulls", "assets", "files", *FOUNDATION),
    "raster": (),
    "kinematics": ("assets", *FOUNDATION),
    "cameras": FOUNDATION,
    "shapes": ("assets", *FOUNDATION),
    "hulls": (),
    "schema": ("assets", "_library", *FOUNDATION),
    "assets": FOUNDATION,
    "cluster": ("jobs", "processes", "machine", "digests", "_library", "extras", "errors"),
    "jobs": ("processes", "errors"),
    "processes": ("errors", "interpreters", "quiet"),
    "machine": ("digests", "engine"),
    "digests": (),
    "fixes": ("files", "errors"),
    "arrays": ("files", "untrusted", *FOUNDATION),
    "files": (),
    "untrusted": (),
    "diagnostics": ("extensions", "errors"),
    "engine": ("errors",),
    "extensions": ("errors", "wording", "quiet"),
    "extras": ("errors",),
    "arguments": ("errors", "wording"),
    "geometry": (),
    "errors": (),
    "wording": (),
    "intervals": (),
    "quiet": (),
    "interpreters": (),
    "_lazy": (),
    "_library": (),
    "_version": (),
}

# Packages that only some modules may import, so that they can be told apart, replaced, or left
# unloaded by commands that do without them.
ONLY_IN: dict[str, tuple[str, ...]] = {
    "pybullet": ("taskbuilder/sim/bullet.py", "taskbuilder/sim/engine_output.py"),
    "pydantic": (
        "taskbuilder/policies/about.py",
        *("taskbuilder/schema/", "taskbuilder/reference/", "taskbuilder/data/records.py"),
        *("taskbuilder/learn/settings.py", "taskbuilder/benchmark/"),
    ),
    "pydantic_core": ("taskbuilder/schema/",),
    "yaml": ("taskbuilder/schema/",),
    "argparse": ("taskbuilder/cli/",),
    "cv2": (
        *("taskbuilder/visual/", "taskbuilder/sim/pictures.py", "taskbuilder/sim/mesh_colors.py"),
        "taskbuilder/data/videos.py",
    ),
    "numba": ("taskbuilder/raster/",),
    "fast_simplification": ("taskbuilder/raster/", "taskbuilder/importing/"),
    "trimesh": ("taskbuilder/importing/",),
    "coacd": ("taskbuilder/importing/",),
    "xacro": ("taskbuilder/importing/",),
    "jinja2": ("taskbuilder/validate/html/templates.py",),
    "matplotlib": ("taskbuilder/visual/curves.py", "taskbuilder/visual/profiles.py"),
    "pyarrow": ("taskbuilder/data/formats/lerobot_tables.py",),
    "av": ("taskbuilder/data/videos.py", "taskbuilder/visual/video.py"),
    "h5py": ("taskbuilder/data/formats/robomimic.py", "taskbuilder/data/formats/minari.py"),
    "PIL": (
        *("taskbuilder/visual/still.py", "taskbuilder/visual/video.py"),
        "taskbuilder/validate/html/pictures.py",
        "taskbuilder/importing/mesh_files.py",
    ),
}

# Only these parts know Bullet's numbers of bodies, links and joints; all others go by names.
WITH_NUMBERS = ("world", "sim")
NUMBERED = {"bullet", "indices", "link_pose", "link_state", "joint_states", "reset_joints"}

# Checking files takes no numpy, so that it takes no time.
WITHOUT_NUMPY = {"diagnostics", "reference", *TASKS_LOADED}

# These stand above the layers: they hand out, by name, what is below.
ABOVE = tuple(
    f"taskbuilder/{name}.py"
    for name in ("__init__", "__main__", "gym", "tasks/__init__", "robots/__init__")
)

MOST_CODE = 350
"""Lines of code in a module, which docstrings, comments and blank lines are not."""

LIBRARY = sorted(path.relative_to(ROOT).as_posix() for path in (ROOT / "taskbuilder").rglob("*.py"))
TASKS = sorted(path.relative_to(ROOT).as_posix() for path in (ROOT / "tasks").glob("*.py"))


def imports(file: str) -> Iterator[tuple[int, str]]:
    """Line and dotted name of all that a file imports, inside functions and conditions too."""
    for node in ast.walk(ast.parse((ROOT / file).read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{file}:{node.lineno}: a relative import; write it out"
            # `from taskbuilder import geometry` imports a part as much as its own module does.
            for alias in node.names:
                yield node.lineno, f"{node.module}.{alias.name}"
        elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith("import_module"):
            names = [name for name in node.args[:1] if isinstance(name, ast.Constant)]
            yield from ((node.lineno, str(name.value)) for name in names)


def modules_below(root: Path) -> dict[str, Path]:
    """Every module of the library by its dotted name; packages by theirs."""
    files = (root / "taskbuilder").rglob("*.py")
    dotted = {".".join(file.relative_to(root).with_suffix("").parts): file for file in files}
    return {name.removesuffix(".__init__"): file for name, file in dotted.items()}


def is_lazy(file: Path) -> bool:
    """Whether it is a package that imports what it exports when that is first used."""
    return "exported(__name__" in file.read_text(encoding="utf-8")


def import_graph(root: Path) -> dict[str, set[str]]:
    """Modules and those that they import, for type checkers alone or inside functions too.

    Packages that import what they export when it is first used count as importing nothing.
    """
    modules = modules_below(root)
    graph: dict[str, set[str]] = {}
    for module, file in modules.items():
        names = [] if is_lazy(file) else [name for _, name in imports(str(file))]
        nearest = (name if name in modules else name.rpartition(".")[0] for name in names)
        graph[module] = {name for name in nearest if name in modules and name != module}
    return graph


def circle(graph: dict[str, set[str]]) -> list[str]:
    """Modules each of which is imported by the next, the first again at the end, or none."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        found: list[str] = error.args[1]
        return found
    return []


def code_lines(text: str) -> int:
    """The lines of a module that have code; a statement that is only a text documents another."""
    documented: set[int] = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            documented.update(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    idle = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT}
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    code = {
        line
        for token in tokens
        if token.type not in {*idle, tokenize.ENDMARKER}
        for line in range(token.start[0], token.end[0] + 1)
    }
    return len(code - documented)


def part_of(file: str) -> str:
    return file.removeprefix("taskbuilder/").partition("/")[0].removesuffix(".py")


def test_every_part_of_the_library_has_its_layer():
    parts = {part_of(file) for file in LIBRARY if file not in ABOVE}
    assert parts <= set(LAYERS), "a new part: give it a row in LAYERS"


def test_layers_import_only_from_layers_below():
    order = list(LAYERS)
    for part, allowed in LAYERS.items():
        below = order[order.index(part) + 1 :]
        assert set(allowed) <= set(below), part


@pytest.mark.parametrize("file", [file for file in LIBRARY if file not in ABOVE])
def test_a_module_imports_no_part_that_its_layer_may_not(file):
    allowed = {part_of(file), *LAYERS[part_of(file)], "_version", "__version__"}
    wrong = [
        f"{file}:{line} imports {name}"
        for line, name in imports(file)
        if name.split(".")[0] in ("taskbuilder", "tasks", "robots")
        and [*name.split("."), ""][1] not in allowed
    ]
    assert not wrong


@pytest.mark.parametrize("file", [file for file in LIBRARY if is_lazy(ROOT / file)])
def test_a_package_that_imports_on_first_use_tells_type_checkers_the_same(file):
    seen = {name.rpartition(".")[2]: name.rpartition(".")[0] for _, name in imports(file)}
    body = ast.parse((ROOT / file).read_text(encoding="utf-8")).body
    (homes,) = [
        ast.literal_eval(node.value)
        for node in body
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "_HOMES"
    ]
    assert homes == {name: seen.get(name) for name in homes}
    package = import_module(file.removesuffix("/__init__.py").replace("/", "."))
    assert set(homes) <= set(package.__all__)
    assert all(hasattr(package, name) for name in package.__all__)


def test_the_page_has_the_same_layers_in_the_same_order():
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    table = page.partition("| layer | contents |\n|---|---|\n")[2].partition("\n\n")[0]
    shown = [
        name for row in table.splitlines() for name in re.findall(r"`(\w+)`", row.split("|")[1])
    ]
    assert shown == [name for name in LAYERS if not name.startswith("_")]


def test_the_page_names_files_that_are_there():
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    section = page.partition("## How to extend it\n")[2].partition("\n## ")[0]
    named = set(re.findall(r"`([\w/]+/(?:\w+\.\w+)?)`", section))
    assert len(named) > 30
    folders = (ROOT, ROOT / "taskbuilder")
    lost = [name for name in named if not any((folder / name).exists() for folder in folders)]
    assert [name for name in lost if "NAME" not in name] == []


def test_no_modules_import_each_other():
    assert circle(import_graph(ROOT)) == []


def test_a_circle_is_found_even_where_it_is_for_type_checkers_alone(tmp_path):
    (tmp_path / "taskbuilder").mkdir()
    texts = {
        "low": "if TYPE_CHECKING:\n    from taskbuilder.high import High",
        "middle": "def f():\n    from taskbuilder import low",
        "high": "from taskbuilder.middle import f",
        "lazy": "if TYPE_CHECKING:\n    from taskbuilder.user import f\n"
        "__getattr__, __dir__ = exported(__name__, {})",
        "user": "from taskbuilder.lazy import f",
    }
    for name, text in texts.items():
        (tmp_path / "taskbuilder" / f"{name}.py").write_text(text)
    found = circle(import_graph(tmp_path))
    assert {*found} == {f"taskbuilder.{name}" for name in ("low", "middle", "high")}


@pytest.mark.parametrize("file", LIBRARY)
def test_a_package_with_a_home_of_its_own_is_imported_only_there(file):
    wrong = [
        f"{file}:{line} imports {name}"
        for line, name in imports(file)
        if not file.startswith(ONLY_IN.get(name.split(".")[0], ("",)))
    ]
    assert not wrong


@pytest.mark.parametrize("file", [file for file in TASKS if not file.endswith("__init__.py")])
def test_a_task_needs_nothing_but_the_description_package(file):
    known = {*sys.stdlib_module_names, "numpy"}
    wrong = [
        f"{file}:{line} imports {name}"
        for line, name in imports(file)
        if name.split(".")[0] not in known
        and name != "taskbuilder.description"
        and not (name.startswith("taskbuilder.description.") and name.count(".") == 2)
    ]
    assert not wrong


@pytest.mark.parametrize("file", [file for file in LIBRARY if part_of(file) in WITHOUT_NUMPY])
def test_checking_files_takes_no_numpy(file):
    assert "numpy" not in {name.split(".")[0] for _, name in imports(file)}


@pytest.mark.parametrize("file", [file for file in LIBRARY if part_of(file) not in WITH_NUMBERS])
def test_the_numbers_of_the_engine_stay_below(file):
    tree = ast.parse((ROOT / file).read_text(encoding="utf-8"))
    named = [node for node in ast.walk(tree) if isinstance(node, ast.Attribute)]
    wrong = [f"{file}:{node.lineno} .{node.attr}" for node in named if node.attr in NUMBERED]
    # Bodies are identified by name, not by number.
    wrong += [
        f"{file}:{n.lineno}" for n in named if ast.unparse(n).endswith(("body.id", "marker.id"))
    ]
    assert not wrong


@pytest.mark.parametrize("file", LIBRARY)
def test_a_module_is_short_enough_to_be_read(file):
    lines = code_lines((ROOT / file).read_text(encoding="utf-8"))
    assert lines <= MOST_CODE, "split it by what things are"


def test_docstrings_comments_and_blank_lines_are_no_code():
    text = '''"""A module.

It has a docstring."""

X = 1  # a comment beside code
"""What X is."""

# a comment


def f():
    """Return a text."""
    return """two
lines"""
'''
    assert code_lines(text) == 4


def test_the_walk_sees_imports_wherever_they_stand(tmp_path, monkeypatch):
    text = """
import a
if TYPE_CHECKING:
    from b.c import d
def f():
    import e.f as g
    importlib.import_module("pybullet")
"""
    (tmp_path / "x.py").write_text(text)
    monkeypatch.setattr(sys.modules[__name__], "ROOT", tmp_path)
    assert sorted(name for _, name in imports("x.py")) == ["a", "b.c.d", "e.f", "pybullet"]
