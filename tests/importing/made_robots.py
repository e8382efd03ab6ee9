"""Robots, grippers and meshes as texts."""

from __future__ import annotations

from pathlib import Path

import numpy as np

INERTIAL = """<inertial><origin xyz="0 0 0.05"/><mass value="1"/>
<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>"""


def box_mesh(size: tuple[float, float, float], shift: tuple[float, float, float] = (0, 0, 0)):
    import trimesh

    mesh = trimesh.creation.box(size)
    mesh.apply_translation(shift)
    return mesh


def ascii_stl(mesh) -> bytes:
    return mesh.export(file_type="stl_ascii").encode()


def link(
    name: str, geometry: str, *, inertial: str = INERTIAL, roles=("visual", "collision")
) -> str:
    shapes = "".join(
        f'<{role}><origin xyz="0 0 0.05"/><geometry>{geometry}</geometry></{role}>'
        for role in roles
    )
    return f'<link name="{name}">{inertial}{shapes}</link>\n'


def joint(
    name: str,
    parent: str,
    child: str,
    at: str = "0 0 0.1",
    axis: str = "0 1 0",
    kind: str = "revolute",
    extra: str = '<limit lower="-2" upper="2" effort="50" velocity="2"/>',
) -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{at}"/><axis xyz="{axis}"/>{extra}</joint>\n'
    )


BOX = '<box size="0.05 0.05 0.1"/>'
AXES = ("0 0 1", "0 1 0", "0 1 0", "0 0 1", "0 1 0", "0 0 1")


def arm(geometry: str = BOX) -> str:
    """Six joints; the last link is l6."""
    text = link("l0", geometry)
    for number, axis in enumerate(AXES, start=1):
        text += link(f"l{number}", geometry)
        text += joint(f"j{number}", f"l{number - 1}", f"l{number}", axis=axis)
    return text


def two_fingers(mimic: bool = True) -> str:
    """Fingers that slide along x, the second mimicking the first, each with a pad fixed to it."""
    text = ""
    for side, sign in (("a", 1), ("b", -1)):
        follow = '<mimic joint="slide_a" multiplier="1"/>' if mimic and side == "b" else ""
        limit = '<limit lower="0" upper="0.03" effort="10" velocity="0.1"/>'
        small = INERTIAL.replace('value="1"', 'value="0.02"').replace("0.01", "1e-5")
        text += link(f"finger_{side}", '<box size="0.01 0.02 0.05"/>', inertial=small)
        text += joint(
            f"slide_{side}", "l6", f"finger_{side}", f"{0.01 * sign} 0 0.1", f"{sign} 0 0",
            "prismatic", limit + follow,
        )  # fmt: skip
        text += link(f"pad_{side}", '<box size="0.004 0.02 0.02"/>', inertial="")
        text += joint(
            f"glue_{side}", f"finger_{side}", f"pad_{side}", f"{-0.005 * sign} 0 0.01",
            kind="fixed", extra="",
        )  # fmt: skip
    return text


def jaw() -> str:
    """One jaw that turns against a fixed one."""
    fixed = link("l7", '<box size="0.01 0.03 0.12"/>')
    moving = link("moving_jaw", '<box size="0.01 0.03 0.1"/>')
    limit = '<limit lower="-0.1" upper="1.6" effort="5" velocity="2"/>'
    return (
        fixed
        + joint("wrist", "l6", "l7", "0 0 0.1", "0 0 1")
        + moving
        + joint("gripper", "l7", "moving_jaw", "0.02 0 0.02", "0 1 0", "revolute", limit)
    )


def snapshot(folder: Path) -> dict[str, bytes]:
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def open_box() -> object:
    """A box without its lid: hollow, so that its hull is far off."""
    import trimesh

    sides = [
        trimesh.creation.box((0.1, 0.1, 0.006)),
        trimesh.creation.box((0.006, 0.1, 0.1)),
        trimesh.creation.box((0.006, 0.1, 0.1)),
        trimesh.creation.box((0.1, 0.006, 0.1)),
        trimesh.creation.box((0.1, 0.006, 0.1)),
    ]
    for mesh, shift in zip(
        sides,
        ((0, 0, 0), (0.047, 0, 0.05), (-0.047, 0, 0.05), (0, 0.047, 0.05), (0, -0.047, 0.05)),
        strict=True,
    ):
        mesh.apply_translation(np.array(shift, float))
    return trimesh.util.concatenate(sides)
