"""Small scenes with one object of the shelf, in front of an arm."""

from __future__ import annotations

from pathlib import Path

from taskbuilder.task import Task, load_task

TABLE_M = 0.4
"""Height of the table."""

SCENE = """\
task: trial
summary: An arm takes one object.
instructions: [take it, lift it, pick it up, hold it up, raise it]
timing: {{control_hz: 10, physics_hz: 240, episode_steps: 100}}
scene:
  robots:
    arm:
      model: ur5e
      base: {{position: [-0.55, 0, 0.4]}}
      home: {{tcp: {{position: [-0.1, 0, 0.75], rpy_deg: [180, {pitch}, 0]}}}}
      action: {{turn: full}}
  objects:
    table: {{shape: {{box: [1.6, 1.0, 0.04]}}, fixed: true, position: [0, 0, 0.38], color: wood}}
    {others}
    thing: {{{thing}, position: [{x}, 0, {z}], rpy_deg: [{roll}, 0, 0]}}
  sites:
    up: {{position: [{x}, 0, {up}], rpy_deg: [{roll}, 0, 0]}}
observe: {{arm: [self.tcp]}}
expert:
  - arm: {{grasp: thing.{grasp}}}
  - arm: {{bring: thing, to: up}}
"""

DESCRIPTION = '''\
"""One object, lifted."""

from taskbuilder.description import Description, Distance, Held, Near


class Trial(Description):
    """The arm holds the object up."""

    success = Held("thing", by="arm") & Near("thing", "up", within=0.02)
    reward = (Distance("carry", "thing", "up"),)
'''

STAND = "stand: {{shape: {{box: [0.12, 0.12, {high}]}}, fixed: true, position: [{x}, 0, {z}]}}"


def trial(
    folder: Path,
    thing: str,
    *,
    grasp: str = "grasp",
    x: float = 0.0,
    stand: float = 0.0,
    above: float = 0.0,
    roll: float = 0.0,
    sideways: bool = False,
    others: str = "",
) -> Task:
    """A task with one object.

    Args:
        folder: Where its files are written.
        thing: Keys of the object, such as ``object: mug``.
        grasp: Grasp point that the expert takes.
        x: Where the object is, m.
        stand: Height of a stand below it, m.
        above: Height of its origin above what it stands on, m.
        roll: How it is turned about x, degrees.
        sideways: Whether the tool starts horizontal.
        others: More objects.
    """
    if stand:
        others += STAND.format(high=stand, x=x, z=TABLE_M + stand / 2)
    z = TABLE_M + stand + above
    text = SCENE.format(
        thing=thing,
        grasp=grasp,
        x=x,
        z=z,
        up=z + 0.1,
        roll=roll,
        pitch=-90 if sideways else 0,
        others=others,
    )
    file = folder / "trial.yaml"
    file.write_text(text, encoding="utf-8")
    file.with_suffix(".py").write_text(DESCRIPTION, encoding="utf-8")
    return load_task(file)
