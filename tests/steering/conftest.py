"""People who steer by keys alone, as a window passes them on."""

from __future__ import annotations

from collections.abc import Callable

from taskbuilder.geometry import Vec3, add, subtract
from taskbuilder.steering.operator import Operator
from taskbuilder.steering.session import Session, State

AXES = (("I", "K"), ("J", "L"), ("U", "O"))
NEAR_M, SLOW_M = 0.012, 0.03


class Person:
    """Presses the keys that bring a robot's tool to where it should be."""

    def __init__(self, session: Session, window: str, robot: str, name: str = "") -> None:
        self._session, self._robot = session, robot
        self._operator: Operator = session.steering.take(window, robot, name)

    def go(self, goal: Callable[[], Vec3], steps: int = 80) -> None:
        """Press keys until the tool is there, or for so many control steps."""
        for _ in range(steps):
            if self._session.state != State.RUNNING or not self._pressed(goal()):
                return
            self._session.step()

    def grip(self, steps: int = 6) -> None:
        """Open or close the gripper, and wait."""
        self._operator.press("G")
        for _ in range(steps):
            self._session.step()

    def _pressed(self, goal: Vec3) -> bool:
        world = self._session.env.episode.world
        gaps = subtract(goal, world.position(f"{self._robot}.tcp"))
        far = [(keys, gap) for keys, gap in zip(AXES, gaps, strict=True) if abs(gap) > NEAR_M]
        for (plus, minus), gap in far:
            self._operator.press(plus if gap > 0.0 else minus, fine=abs(gap) < SLOW_M)
        return bool(far)


def above(session: Session, frame: str, height: float = 0.0) -> Callable[[], Vec3]:
    """Where a frame is, so many metres higher."""
    return lambda: add(session.env.episode.world.position(frame), (0.0, 0.0, height))


def take_stick(session: Session, left: Person) -> None:
    """The left arm takes the stick of Handover to where the right one can take it."""
    left.go(above(session, "stick.left_end", 0.08))
    left.go(above(session, "stick.left_end"))
    left.grip()
    left.go(lambda: (-0.15, 0.0, 0.62))
