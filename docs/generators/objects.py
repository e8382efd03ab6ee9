"""The objects of the library."""

from __future__ import annotations

from generators.results import read
from taskbuilder.reference.markdown import table
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.object_files import load_object


def household(_: str) -> str:
    """How fast a scene with objects of the shelf is, beside one with boxes."""
    told = read("household.json")
    rows = [
        [
            {"rest": "at rest", "stirred": "stirred every quarter of a second"}[how],
            *(f"{rates[name]:,}" for name in ("empty", "boxes", "household")),
            f"{told['household_by_boxes'][how]:.2f}",
        ]
        for how, rates in told["steps_per_cpu_second"].items()
    ]
    return table(["objects", "none", "ten boxes", "ten of the shelf", "share"], rows)


def library(_: str) -> str:
    """A table of the objects."""
    objects = [load_object(entry) for entry in Catalogue().objects.values() if entry.module]
    rows = [
        [
            f"`{model.entry.name}`",
            model.spec.summary,
            f"{1000.0 * model.spec.mass:.0f} g" if model.spec.mass else "–",
            ", ".join(f"`{name}`" for name in model.spec.grasps) or "–",
        ]
        for model in objects
    ]
    return table(["object", "what it is", "mass", "grasp points"], rows)
