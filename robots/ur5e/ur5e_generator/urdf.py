"""The robot as URDF."""

from __future__ import annotations

from robot_modelling.urdf import robot_text

from ur5e_generator.figures import COLORS
from ur5e_generator.robot import joints, links

NOTE = "Written by generate.py; change it there. Metres, kilograms, radians."


def urdf_text() -> str:
    """Return the whole robot as URDF."""
    return robot_text("ur5e", NOTE, COLORS, links(), joints())
