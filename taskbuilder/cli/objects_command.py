"""`taskbuilder objects`, `objects check` and `objects import`."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import Any

from taskbuilder.assets.model import Urdf, UrdfJoint
from taskbuilder.assets.paths import AssetError
from taskbuilder.cli.object_figures import (
    ObjectFigures,
    grasp_lines,
    measured,
    print_figures,
    print_lines_of_task,
)
from taskbuilder.cli.output import paint, print_json, print_table, show_finding
from taskbuilder.cli.tasks import catalogue_of, make_folder, tell_of_clashes
from taskbuilder.errors import (
    FileError,
    Finding,
    Location,
    UnknownNameError,
    UsageError,
    display_path,
    in_reading_order,
)
from taskbuilder.schema.bodies import Grasp
from taskbuilder.schema.catalogue import Catalogue, CatalogueEntry, looks_like_path
from taskbuilder.schema.object_files import MESHES, ObjectModel, bare_object, load_object
from taskbuilder.visual.object_picture import take_object_picture
from taskbuilder.visual.still import save_image
from taskbuilder.world.inertias import check_inertias


def run(arguments: argparse.Namespace) -> int:
    """List the objects, check one, or import one."""
    actions = {"list": _list, "check": _check, "import": _import}
    return actions[arguments.action or "list"](arguments, catalogue_of(arguments))


# --- list


def _list(arguments: argparse.Namespace, catalogue: Catalogue) -> int:
    if arguments.object is not None:
        raise UsageError("list takes no name; to check an object: taskbuilder objects check NAME")
    tell_of_clashes(catalogue, "object")
    objects = [_describe(entry, catalogue) for entry in catalogue.objects.values()]
    if arguments.json:
        print_json({"objects": objects})
        return 0
    rows = [["object", "grasp points", "joints", "summary"]]
    rows += [
        [
            each["name"],
            ", ".join(each["grasps"]) or "-",
            ", ".join(each["joints"]) or "-",
            each["summary"],
        ]
        for each in objects
    ]
    print_table(rows, prose=True)
    for each in objects:
        if each["shape"] is None:
            hint = f"to see what is wrong: taskbuilder objects check {each['path']}"
            print(paint(f"\n{hint}", "dim"))
    return 0


def _describe(entry: CatalogueEntry, catalogue: Catalogue) -> dict[str, Any]:
    known = {"name": entry.name, "path": display_path(entry.file)}
    try:
        model = load_object(entry, catalogue.folders)
    except FileError:
        return {**known, "shape": None, "grasps": [], "joints": [], "summary": "(has errors)"}
    return {**known, **_data(model)}


def _data(model: ObjectModel) -> dict[str, Any]:
    """What there is to know of an object that can be read."""
    main = model.assets.main
    shape = model.spec.shape
    return {
        "shape": shape.kind if shape else "parts",
        "grasps": list(model.spec.grasps),
        "joints": [joint.name for joint in main.moving_joints] if isinstance(main, Urdf) else [],
        "summary": model.spec.summary,
    }


# --- check


def _check(arguments: argparse.Namespace, catalogue: Catalogue) -> int:
    if arguments.object is None:
        raise UsageError(
            "check which object? give a name, a folder, or the path of an object.yaml, a URDF or a "
            "mesh"
        )
    findings: list[Finding] = []
    model = picture = mass = figures = None
    try:
        model = _read(arguments.object, catalogue)
    except FileError as error:
        findings += error.findings
    if model is not None:
        findings += () if model.entry.trusted else _doubts(model)
        file = arguments.out or Path("renders", f"{model.entry.name}.png")
        picture, mass = _picture(model, file, findings)
        if picture is not None:
            figures = measured(model, catalogue)
    ok = not any(finding.severity == "error" for finding in findings)
    if arguments.json:
        print_json(
            {
                "object": arguments.object,
                "ok": ok,
                **(_data(model) if model else {}),
                "mass": mass,
                **(figures.as_data() if figures else {}),
                "findings": [finding.as_data() for finding in in_reading_order(findings)],
                "picture": display_path(picture) if picture else None,
            }
        )
        return 0 if ok else 1
    if model is not None:
        _print_object(model, mass)
        if figures is not None:
            print_figures(figures, mass)
            _print_use(model, figures)
    for finding in in_reading_order(findings):
        print(show_finding(finding))
    print(paint("ok", "green") if ok else paint("failed", "red"))
    if picture:
        print(display_path(picture))
    return 0 if ok else 1


def _read(reference: str, catalogue: Catalogue) -> ObjectModel:
    """The object of a name, a folder, an object file, a URDF or a mesh.

    Raises:
        FileError: Files are wrong.
        UnknownNameError: There is no such object.
    """
    path = Path(reference)
    if path.is_dir() and looks_like_path(reference) and not (path / "object.yaml").is_file():
        path = _urdf_in(path)
    if path.is_file() and path.suffix.lower() in (*MESHES, ".urdf", ".xml"):
        return bare_object(path)
    if path.is_file() and path.suffix.lower() not in (".yaml", ".yml"):
        raise UnknownNameError(
            f"{display_path(path)} is not read as it is; taskbuilder objects import "
            f"{display_path(path)} makes a URDF of DAE, GLB, PLY, SDF, MJCF and xacro files"
        )
    return load_object(catalogue.object(reference, Path()), catalogue.folders)


def _urdf_in(folder: Path) -> Path:
    """The only URDF of a folder, such as one that an import wrote.

    Raises:
        UnknownNameError: There is none, or there are several.
    """
    found = sorted(folder.glob("*.urdf"))
    if len(found) == 1:
        return found[0]
    several = f"; name one of {', '.join(file.name for file in found)}" if found else ""
    raise UnknownNameError(
        f"{display_path(folder)} has no object.yaml and {len(found) or 'no'} URDF"
        f"{'s' * (len(found) > 1)} in it{several}"
    )


def _print_use(model: ObjectModel, figures: ObjectFigures) -> None:
    """The lines of a task file for an object that is not in the catalogue, and grasp points."""
    grasps = grasp_lines(figures)
    if model.entry.file.suffix not in (".yaml", ".yml"):
        print_lines_of_task(model.entry.name, model.entry.file, figures)
    elif grasps:
        print("  it has no grasp points; these fit:\n")
        print("\n".join(f"    {line}" for line in grasps), end="\n\n")


def _doubts(model: ObjectModel) -> list[Finding]:
    """What is doubtful about the files and the inertias of an object."""
    spec, main = model.spec, model.assets.main
    stated = isinstance(main, Urdf) and spec.density is None and spec.inertia is None
    found = check_inertias(main, fixed=False) if isinstance(main, Urdf) and stated else ()
    return [*model.assets.warnings, *found]


def _picture(
    model: ObjectModel, file: Path, findings: list[Finding]
) -> tuple[Path | None, float | None]:
    """Take the picture, unless the engine does not survive the asset; and weigh the object."""
    place = Location(model.entry.file)
    try:
        pixels, mass, said = take_object_picture(model)
    except AssetError as error:
        findings.append(error.finding(location=place))
        return None, None
    if not model.entry.trusted:
        findings += [Finding("TB407", text, "", place, "warning") for text in said]
    make_folder(file.parent)
    save_image(file, pixels)
    return file, mass


def _print_object(model: ObjectModel, mass: float | None) -> None:
    spec, main = model.spec, model.assets.main
    weight = f" · {mass:.3g} kg" if mass is not None else ""
    print(paint(f"{model.entry.name}{weight} · {display_path(model.entry.file)}", "bold"))
    print(f"  {spec.summary}")
    rows = [[name, "grasp point", _grasped(grasp)] for name, grasp in spec.grasps.items()]
    if isinstance(main, Urdf):
        rows += [[each.name, f"{each.type} joint", _moving(each)] for each in main.moving_joints]
    if rows:
        print()
        print_table([["name", "kind", "how"], *rows], indent="  ")
    print()


def _grasped(point: Grasp) -> str:
    """A grasp point, in words."""
    frame = f" in the frame of {point.link}" if point.link else ""
    across = f", across {point.across}" if point.across else ""
    return f"at {list(point.at)}{frame}, approach {point.approach}{across}"


def _moving(joint: UrdfJoint) -> str:
    """What a joint moves, and how far."""
    if joint.lower is None or joint.upper is None:
        return f"moves {joint.child}, without limits"
    if joint.type == "prismatic":
        span = f"{joint.lower * 1000:.0f} to {joint.upper * 1000:.0f} mm"
    else:
        span = f"{math.degrees(joint.lower):.0f} to {math.degrees(joint.upper):.0f}°"
    return f"moves {joint.child} from {span}"


# --- import


def _import(arguments: argparse.Namespace, catalogue: Catalogue) -> int:
    from taskbuilder.cli.importing import run_import

    if arguments.object is None:
        raise UsageError("import takes a file: taskbuilder objects import FILE")
    arguments.file = arguments.object
    return run_import(arguments, robot=False, catalogue=catalogue)
