"""A robot alone in a physics client, with a block to take hold of."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from taskbuilder.assets.looks import with_looks
from taskbuilder.assets.urdf import resolved_text
from taskbuilder.geometry import ORIGIN, Pose
from taskbuilder.quiet import captured
from taskbuilder.schema.grasping import Grasping
from taskbuilder.schema.objects import ObjectSpec
from taskbuilder.schema.robots import RobotModel
from taskbuilder.shapes import CylinderShape, Part, Shape, bounds
from taskbuilder.sim.bodies import create_body, load_urdf
from taskbuilder.sim.body import Body
from taskbuilder.sim.client import Client
from taskbuilder.world.robot import Robot
from taskbuilder.world.robot_building import arm_chain, build_robot
from taskbuilder.world.scene_objects import SceneObject
from taskbuilder.world.touch import Touch

PHYSICS_HZ = 120
"""Physics steps a second: the default of task files."""

BLOCK_KG, BLOCK_FRICTION = 0.1, 0.8
ROBOT, BLOCK = "robot", "block"
_COLOR = (0.9, 0.5, 0.1, 1.0)
_AWAY = Pose((0.0, 0.0, 500.0))


@dataclass(frozen=True)
class Stand:
    """A robot whose base is fixed, in a client without gravity or floor.

    Attributes:
        client: The physics.
        robot: The robot, at home.
    """

    client: Client
    robot: Robot

    def steps(self, seconds: float) -> int:
        """How many physics steps some time takes."""
        return round(seconds * self.client.physics_hz)

    def at_home(self) -> None:
        """Put the robot home, at rest, without gravity."""
        self.client.set_gravity(ORIGIN)
        self.robot.go_home()

    @contextmanager
    def block(self, shape: Shape, pose: Pose) -> Iterator[TrialBlock]:
        """A block at a pose in the world; afterwards it is far away."""
        part = Part(shape, Pose(), _COLOR)
        body = create_body(
            self.client, {BLOCK: part}, mass=BLOCK_KG, pose=pose, friction=BLOCK_FRICTION
        )
        spec = ObjectSpec.model_validate(
            {"shape": _written(shape), "mass": BLOCK_KG, "position": pose.position}
        )
        thing = SceneObject(BLOCK, spec, body, {BLOCK: bounds(shape)}, {})
        touch = Touch(self.client, {ROBOT: self.robot}, {BLOCK: thing})
        try:
            yield TrialBlock(body, self.robot, touch)
        finally:
            body.place(_AWAY)
            self.client.collide()


@dataclass(frozen=True)
class TrialBlock:
    """A block on the stand."""

    body: Body
    robot: Robot
    touch: Touch

    def held(self) -> bool:
        """Whether the robot holds it, as the condition `Held` has it."""
        self.touch.refresh()
        return self.touch.held(BLOCK, ROBOT)

    def forces(self) -> Sequence[float]:
        """Force of each finger on it, in newtons."""
        self.touch.refresh()
        return self.touch.grip_forces(BLOCK, ROBOT)

    def in_hand(self) -> Pose:
        """Its pose in the frame of the tcp."""
        return self.robot.tcp.inverse() @ self.body.pose()


@contextmanager
def stand(model: RobotModel, *, rigid: bool = False) -> Iterator[Stand]:
    """A stand with a robot.

    Args:
        model: The robot; its URDF must be known to load.
        rigid: Whether the motors of the arm are as strong as it takes, so that only the gripper is
            on trial.
    """
    with (
        tempfile.TemporaryDirectory(prefix="taskbuilder-") as folder,
        Client(physics_hz=PHYSICS_HZ, gravity=ORIGIN) as client,
    ):
        copy = Path(folder) / model.urdf.path.name
        bare = with_looks(model.urdf, lambda _: ())
        copy.write_text(resolved_text(bare), encoding="utf-8")
        with captured():  # the picture has told what the engine says of the file
            body = load_urdf(client, copy, name=ROBOT, fixed_base=True)
        chain = arm_chain(model)
        how = Grasping() if model.spec.gripper is not None else None
        robot = build_robot(
            body, ROBOT, model, chain=chain, home=model.home, grasping=how, rigid=rigid
        )
        yield Stand(client, robot)


def _written(shape: Shape) -> dict[str, object]:
    if isinstance(shape, CylinderShape):
        return {"cylinder": {"radius": shape.radius, "length": shape.length}}
    box = bounds(shape)
    return {"box": tuple(2.0 * half for half in box.half)}
