"""The files of a small sound task without an expert."""

from __future__ import annotations

GOOD = """\
task: good
summary: One arm lifts a cube.
scene:
  robots:
    arm: {model: ur5e, base: {position: [0, 0, 0]}}
  objects:
    cube: {shape: {box: [0.04, 0.04, 0.04]}, mass: 0.1, position: [0.5, 0, 0.02]}
"""
DESCRIPTION = """\
from taskbuilder.description import Above, Bonus, Description


class Good(Description):
    success = Above("cube", height=0.2)
    reward = (Bonus("done", success, 1.0),)
"""
