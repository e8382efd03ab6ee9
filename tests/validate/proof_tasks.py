"""A small task for two arms with an expert, to validate in full."""

from __future__ import annotations

PAIR = """\
task: pair
summary: The left arm brings the cube to the goal while the right arm points at the lamp.
timing: {control_hz: 10, physics_hz: 120, episode_steps: 30}
scene:
  robots:
    left:
      model: ur5e
      base: {position: [-0.7, 0, 0]}
      home: {tcp: {position: [-0.35, -0.1, 0.2]}}
    right:
      model: ur5e
      base: {position: [0.7, 0, 0], rpy_deg: [0, 0, 180]}
      home: {tcp: {position: [0.35, 0, 0.2], rpy_deg: [180, 0, 180]}}
  objects:
    cube:
      shape: {box: [0.045, 0.045, 0.045]}
      mass: 0.08
      grasps: {top: {at: [0, 0, 0.01], across: y}}
      place: {center: [-0.4, -0.2, 0.023], size: [0.1, 0.1, 0]}
  sites:
    goal: {position: [-0.2, -0.1, 0.2]}
    lamp: {position: [0.05, 0.25, 0.2]}
observe: {left: [self.tcp, cube.position], right: [self.tcp, cube.position]}
expert:
  - {left: {grasp: cube.top}, right: {reach: lamp}}
  - {left: {bring: cube, to: goal}}
variations:
  - {cube.color: green}
"""
DESCRIPTION = """\
import random

from taskbuilder.description import *


class Pair(Description):
    success = Near("cube", "goal", within=0.05) & Near("right.tcp", "lamp", within=0.05)
    stages = {"held": Held("cube")}
    reward = (
        Distance("carry", "cube", "goal"),
        Distance("point", "right.tcp", "lamp", agent="right"),
    )
"""
