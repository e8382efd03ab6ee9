"""Immutable poses and boxes, in plain floats.

Vectors are tuples of floats and quaternions are in x, y, z, w order. Tuples rather than arrays:
they are immutable, compare and hash by value, and three-element arithmetic on them costs a tenth
of what numpy's dispatch does, which matters in a control loop.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import reduce
from itertools import product

Vec3 = tuple[float, float, float]
Quat = tuple[float, float, float, float]

ORIGIN: Vec3 = (0.0, 0.0, 0.0)
NO_TURN: Quat = (0.0, 0.0, 0.0, 1.0)


def total(values: Iterable[float]) -> float:
    """Sum, added from left to right.

    The built-in ``sum`` compensates rounding from Python 3.12 on, so its last digit would depend on
    the version of Python.
    """
    return reduce(operator.add, values, 0.0)


def add(a: Vec3, b: Vec3) -> Vec3:
    """Sum."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def subtract(a: Vec3, b: Vec3) -> Vec3:
    """Difference: a without b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def scale(a: Vec3, factor: float) -> Vec3:
    """A times a number."""
    return (a[0] * factor, a[1] * factor, a[2] * factor)


def dot(a: Vec3, b: Vec3) -> float:
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vec3, b: Vec3) -> Vec3:
    """Vector product."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def norm(a: Vec3) -> float:
    """Euclidean length."""
    return math.hypot(*a)


def unit(a: Vec3) -> Vec3:
    """The direction of a.

    Raises:
        ValueError: ``a`` has no length.
    """
    length = norm(a)
    if length < 1e-12:
        raise ValueError("a vector of length zero has no direction")
    return scale(a, 1.0 / length)


def multiply(a: Quat, b: Quat) -> Quat:
    """The rotation b followed by the rotation a (Hamilton product)."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def conjugate(q: Quat) -> Quat:
    """The inverse of a unit quaternion."""
    return (-q[0], -q[1], -q[2], q[3])


def rotate(q: Quat, v: Vec3) -> Vec3:
    """The vector v turned by the unit quaternion q."""
    axis = (q[0], q[1], q[2])
    twice = scale(cross(axis, v), 2.0)
    return add(add(v, scale(twice, q[3])), cross(axis, twice))


def normalized(q: Quat) -> Quat:
    """The unit quaternion of the same rotation.

    Raises:
        ValueError: ``q`` has no length.
    """
    length = math.hypot(*q)
    if length < 1e-12:
        raise ValueError("a quaternion of length zero is no rotation")
    return (q[0] / length, q[1] / length, q[2] / length, q[3] / length)


def from_rpy(roll: float, pitch: float, yaw: float) -> Quat:
    """Quaternion of turns about the fixed x, y and z axes, in that order (URDF), in radians."""
    cr, sr = math.cos(roll / 2), math.sin(roll / 2)
    cp, sp = math.cos(pitch / 2), math.sin(pitch / 2)
    cy, sy = math.cos(yaw / 2), math.sin(yaw / 2)
    return (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )


def from_rpy_deg(rpy_deg: Vec3) -> Quat:
    """Like `from_rpy`, in degrees."""
    return from_rpy(*(math.radians(angle) for angle in rpy_deg))


def to_rpy_deg(quaternion: Quat) -> Vec3:
    """Roll, pitch and yaw in degrees; the inverse of `from_rpy_deg`.

    Where the pitch is 90 or -90 degrees, many triples are the same rotation; the roll is then 0.
    """
    x, y, z, w = quaternion
    sine = max(-1.0, min(1.0, 2.0 * (w * y - z * x)))
    if abs(sine) > 1.0 - 1e-9:
        roll, yaw = 0.0, 2.0 * math.atan2(z, w)
    else:
        roll = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
        yaw = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return math.degrees(roll), math.degrees(math.asin(sine)), math.degrees(yaw)


def from_axes(x: Vec3, y: Vec3, z: Vec3) -> Quat:
    """Quaternion of the frame whose axes are the given orthonormal, right-handed vectors."""
    # Shepperd's method: divide by the largest of the four candidates, so by nothing near zero.
    trace = x[0] + y[1] + z[2]
    candidates = (x[0], y[1], z[2], trace)
    largest = candidates.index(max(candidates))
    raw: Quat
    if largest == 3:
        raw = (y[2] - z[1], z[0] - x[2], x[1] - y[0], 1.0 + trace)
    elif largest == 0:
        raw = (1.0 + x[0] - y[1] - z[2], x[1] + y[0], z[0] + x[2], y[2] - z[1])
    elif largest == 1:
        raw = (x[1] + y[0], 1.0 - x[0] + y[1] - z[2], y[2] + z[1], z[0] - x[2])
    else:
        raw = (z[0] + x[2], y[2] + z[1], 1.0 - x[0] - y[1] + z[2], x[1] - y[0])
    return normalized(raw)


def turn_onto(a: Vec3, b: Vec3) -> Quat:
    """The shortest rotation that takes the direction of a to that of b.

    If they are opposite, any half turn is the shortest; it is then about an axis of no meaning.

    Raises:
        ValueError: One of them has no length.
    """
    a, b = unit(a), unit(b)
    cosine = dot(a, b)
    if cosine < -1.0 + 1e-12:
        across = cross(a, (1.0, 0.0, 0.0) if abs(a[0]) < 0.9 else (0.0, 1.0, 0.0))
        return (*unit(across), 0.0)
    return normalized((*cross(a, b), 1.0 + cosine))


def turn_between(a: Quat, b: Quat) -> float:
    """Angle of the rotation that leads from a to b, in radians, 0 to pi."""
    x, y, z, w = multiply(conjugate(a), b)
    return 2.0 * math.atan2(math.hypot(x, y, z), abs(w))


@dataclass(frozen=True, slots=True)
class Pose:
    """Position (m) and orientation (xyzw) of a frame, expressed in another.

    ``world_from_stick @ stick_from_end`` composes; ``.inverse()`` swaps the two frames.
    """

    position: Vec3 = ORIGIN
    quaternion: Quat = NO_TURN

    @classmethod
    def from_rpy_deg(cls, position: Vec3, rpy_deg: Vec3) -> Pose:
        """Pose from roll, pitch and yaw about fixed x, y, z, in degrees."""
        return cls(position, from_rpy_deg(rpy_deg))

    def __matmul__(self, other: Pose) -> Pose:
        return Pose(
            add(self.position, rotate(self.quaternion, other.position)),
            multiply(self.quaternion, other.quaternion),
        )

    def inverse(self) -> Pose:
        """The pose of the reference frame as seen from this one."""
        back = conjugate(self.quaternion)
        return Pose(scale(rotate(back, self.position), -1.0), back)

    def apply(self, point: Vec3) -> Vec3:
        """A point given in this frame, expressed in the reference frame."""
        return add(self.position, rotate(self.quaternion, point))

    def axis(self, index: int) -> Vec3:
        """This frame's x (0), y (1) or z (2) axis as a unit vector of the reference frame."""
        basis = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
        return rotate(self.quaternion, basis[index])

    def tilt(self, index: int = 2) -> float:
        """Angle in rad between this frame's x (0), y (1) or z (2) axis and the reference's z."""
        return math.acos(max(-1.0, min(1.0, self.axis(index)[2])))

    def moved(self, offset: Vec3) -> Pose:
        """The same orientation, displaced by an offset in the reference frame."""
        return Pose(add(self.position, offset), self.quaternion)


@dataclass(frozen=True, slots=True)
class Box:
    """An axis-aligned box in some frame: centre and half edge lengths, in metres."""

    center: Vec3
    half: Vec3

    @classmethod
    def around(cls, low: Vec3, high: Vec3) -> Box:
        """The box between two opposite corners."""
        return cls(scale(add(low, high), 0.5), scale(subtract(high, low), 0.5))

    @property
    def low(self) -> Vec3:
        """The corner of smallest coordinates."""
        return subtract(self.center, self.half)

    @property
    def high(self) -> Vec3:
        """The corner of largest coordinates."""
        return add(self.center, self.half)

    def corners(self) -> Iterator[Vec3]:
        """The eight corners."""
        for signs in product((-1.0, 1.0), repeat=3):
            yield (
                self.center[0] + signs[0] * self.half[0],
                self.center[1] + signs[1] * self.half[1],
                self.center[2] + signs[2] * self.half[2],
            )

    def seen_from(self, frame_from_box: Pose) -> Box:
        """The smallest axis-aligned box of another frame that contains this one."""
        x, y, z = (scale(frame_from_box.axis(i), self.half[i]) for i in range(3))
        half = (
            abs(x[0]) + abs(y[0]) + abs(z[0]),
            abs(x[1]) + abs(y[1]) + abs(z[1]),
            abs(x[2]) + abs(y[2]) + abs(z[2]),
        )
        return Box(frame_from_box.apply(self.center), half)

    def contains(self, point: Vec3, margin: float = 0.0) -> bool:
        """Whether a point lies at least ``margin`` inside."""
        return all(abs(point[i] - self.center[i]) <= self.half[i] - margin for i in range(3))


@dataclass(frozen=True, slots=True)
class Ball(Box):
    """The box around a sphere, which is as large in every frame, however the sphere has rolled."""

    def seen_from(self, frame_from_box: Pose) -> Box:
        """The box around the same sphere, along the axes of another frame."""
        return Ball(frame_from_box.apply(self.center), self.half)


def bounding_box(points: list[Vec3]) -> Box:
    """The smallest axis-aligned box around points.

    Raises:
        ValueError: There are no points.
    """
    if not points:
        raise ValueError("no points to bound")
    xs, ys, zs = zip(*points, strict=True)
    return Box.around((min(xs), min(ys), min(zs)), (max(xs), max(ys), max(zs)))
