"""How an episode looks where looks vary: light, background, furniture, distractors and cameras.

Nothing of it is felt by the physics. A look is drawn from a random-number generator of its own, so
that episodes with the same seed happen alike with it and without.
"""

from __future__ import annotations

import colorsys
import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from taskbuilder.cameras import DAYLIGHT, STUDIO, Backdrop, Light
from taskbuilder.geometry import Vec3
from taskbuilder.schema.camera import CameraSpec
from taskbuilder.schema.scene import SceneSpec
from taskbuilder.schema.task import LOOK_PARTS, LookPart, TaskSpec
from taskbuilder.schema.values import frozen
from taskbuilder.shapes import RGBA
from taskbuilder.sim.body import Body
from taskbuilder.sim.client import Client
from taskbuilder.sim.scenery import Distractor, PatternKind, Scenery, Texture
from taskbuilder.world.scene_objects import SceneObject

PAINT_SHARE = 0.7
"""Of a drawn colour, in what is painted; the rest is its own, so that parts stay apart."""

TEXTURED = 0.6
"""How often furniture and the floor have a texture."""

FURNITURE_PERIOD_M, FLOOR_PERIOD_M = (0.04, 0.16), (0.15, 0.6)
"""How often a texture repeats."""

PATTERNS: tuple[PatternKind, ...] = ("checks", "stripes", "grain", "speckles")

ELEVATION_DEG = (40.0, 80.0)
WARMTH = 0.1
"""How much of its red or blue a lamp may lack."""

SHIFT_M = 0.06
"""How far a camera that stands may be, along each axis, from where the task puts it; it looks past
its point by half of that."""

MOUNTED_SHIFT_M = 0.006
"""The same for one with a mount, as mounts are stiff."""

SHIFT_SHARE = 0.1
"""No shift is larger than this share of the distance between a camera and its point."""

MOST_TURN_DEG = math.degrees(math.asin(1.5 * math.sqrt(3.0) * SHIFT_SHARE))
"""How far a camera turns at most, 15.1°: when its position and its point move apart the most."""

ZOOM = (0.97, 1.1)
"""Opening angles are rather wider than narrower, so that nothing leaves the picture."""


@dataclass(frozen=True)
class CameraChange:
    """What differs in a camera.

    Attributes:
        eye: Added to its position, in its frame, m.
        aim: Added to the point that it looks at, in its frame, m.
        zoom: Factor of its opening angle.
    """

    eye: Vec3 = (0.0, 0.0, 0.0)
    aim: Vec3 = (0.0, 0.0, 0.0)
    zoom: float = 1.0


@dataclass(frozen=True)
class Look:
    """The look of an episode.

    Attributes:
        light: The lamp.
        backdrop: Behind everything; None where the look does not vary.
        paints: Colours of furniture, by object.
        floor: Colour of the floor, or None.
        cameras: What differs in each camera.
        textures: Of furniture, by object.
        floor_texture: Of the floor, or None.
        distractors: Things that are only drawn.
    """

    light: Light = DAYLIGHT
    backdrop: Backdrop | None = None
    paints: Mapping[str, Vec3] = field(default_factory=lambda: frozen({}))
    floor: Vec3 | None = None
    cameras: Mapping[str, CameraChange] = field(default_factory=lambda: frozen({}))
    textures: Mapping[str, Texture] = field(default_factory=lambda: frozen({}))
    floor_texture: Texture | None = None
    distractors: tuple[Distractor, ...] = ()

    @property
    def studio(self) -> Backdrop:
        """What is behind everything in pictures for people."""
        return self.backdrop or STUDIO


AS_WRITTEN = Look()
"""The look of the task file."""


def draw_look(
    task: TaskSpec,
    scene: SceneSpec,
    rng: np.random.Generator,
    parts: Collection[LookPart] = LOOK_PARTS,
) -> Look:
    """A look without distractors, from the generator of an episode's looks.

    Args:
        task: The task.
        scene: The scene that was built.
        rng: Random numbers. As many are drawn, whatever parts there are.
        parts: What is drawn; the rest is as written.
    """
    light = _light(rng)
    backdrop = Backdrop(_eight_bit(_pale(rng)), _eight_bit(_pale(rng)))
    floor = _pale(rng)
    painted = furniture(task, scene)
    paints = {name: _paint(rng) for name in painted}
    cameras = {name: _camera(camera, rng) for name, camera in scene.cameras.items()}
    drawn = {name: _texture(rng, FURNITURE_PERIOD_M) for name in painted}
    textures = {name: texture for name, texture in drawn.items() if texture}
    floor_texture = _texture(rng, FLOOR_PERIOD_M)
    return Look(
        light=light if "light" in parts else DAYLIGHT,
        backdrop=backdrop if "background" in parts else None,
        paints=frozen(paints if "furniture" in parts else {}),
        floor=floor if "background" in parts else None,
        cameras=frozen(cameras if "cameras" in parts else {}),
        textures=frozen(textures if "textures" in parts else {}),
        floor_texture=floor_texture if "textures" in parts else None,
    )


def furniture(task: TaskSpec, scene: SceneSpec) -> list[str]:
    """Objects that may have any colour: those that are fixed, and whose colour says nothing.

    A colour says something if the task's instructions, variations or randomised quantities name
    it. URDFs, and meshes to which the task file gives no colour, stay as they are, because their
    colours tell their parts.
    """
    told = {key for change in (*task.variations, task.randomize) for key in change}
    return [
        name
        for name, spec in scene.objects.items()
        if spec.fixed
        and spec.urdf is None
        and (spec.shape is None or not spec.shape.mesh or "color" in spec.model_fields_set)
        and f"{name}.color" not in told
        and not any(f"{{{name}.color}}" in text for text in task.instructions)
    ]


class Painter:
    """Paints the floor and furniture, and knows what they looked like before.

    Args:
        client: The world.
        objects: The objects of the scene.
        floor: The floor, if there is one.
        names: Objects that may be painted.
    """

    def __init__(
        self,
        client: Client,
        objects: Mapping[str, SceneObject],
        floor: Body | None,
        names: Collection[str],
    ) -> None:
        self._client = client
        self._bodies = {name: objects[name].body for name in names if name in objects}
        self._floor = floor
        self._own: dict[int, Mapping[int, RGBA]] = {}  # by body, when it is first painted

    def paint(self, look: Look) -> None:
        """Give everything its colours and textures in a look, and put its distractors there."""
        self._client.scenery = self._scenery(look)
        self._client.looks += 1
        for body, color in self._painted(look):
            own = self._own.setdefault(body.id, body.colors())
            for link, rgba in own.items():
                body.set_color(rgba if color is None else _mixed(color, rgba), link)

    def _scenery(self, look: Look) -> Scenery:
        textures = {
            body.id: look.textures[name]
            for name, body in self._bodies.items()
            if name in look.textures
        }
        if self._floor is not None and look.floor_texture is not None:
            textures[self._floor.id] = look.floor_texture
        return Scenery(textures, look.distractors)

    def _painted(self, look: Look) -> Iterator[tuple[Body, Vec3 | None]]:
        for name, body in self._bodies.items():
            yield body, look.paints.get(name)
        if self._floor is not None:
            yield self._floor, look.floor


def _mixed(paint: Vec3, own: RGBA) -> RGBA:
    red, green, blue = (
        PAINT_SHARE * new + (1.0 - PAINT_SHARE) * old
        for new, old in zip(paint, own[:3], strict=True)
    )
    return (red, green, blue, own[3])


def _light(rng: np.random.Generator) -> Light:
    azimuth = float(rng.uniform(0.0, 2.0 * math.pi))
    elevation = math.radians(float(rng.uniform(*ELEVATION_DEG)))
    flat = math.cos(elevation)
    warm = float(rng.uniform(-WARMTH, WARMTH))
    return Light(
        direction=(flat * math.cos(azimuth), flat * math.sin(azimuth), math.sin(elevation)),
        color=(1.0 + min(warm, 0.0), 1.0 - abs(warm) / 2.0, 1.0 - max(warm, 0.0)),
        ambient=float(rng.uniform(0.4, 0.6)),
        diffuse=float(rng.uniform(0.3, 0.55)),
    )


def _camera(camera: CameraSpec, rng: np.random.Generator) -> CameraChange:
    most = SHIFT_M if camera.mount is None else MOUNTED_SHIFT_M
    reach = min(most, SHIFT_SHARE * camera.distance)
    x, y, z = rng.uniform(-reach, reach, 3).tolist()
    u, v, w = rng.uniform(-reach / 2.0, reach / 2.0, 3).tolist()
    return CameraChange((x, y, z), (u, v, w), float(rng.uniform(*ZOOM)))


def _paint(rng: np.random.Generator) -> Vec3:
    """The colour of furniture: any hue, neither glaring nor black."""
    hue, saturation, value = rng.uniform((0.0, 0.0, 0.35), (1.0, 0.55, 0.95)).tolist()
    return colorsys.hsv_to_rgb(hue, saturation, value)


def _texture(rng: np.random.Generator, period: tuple[float, float]) -> Texture | None:
    """A texture, or none. As many numbers are drawn either way."""
    there, kind = float(rng.random()), PATTERNS[int(rng.integers(len(PATTERNS)))]
    color, length = _paint(rng), float(rng.uniform(*period))
    angle = float(rng.uniform(0.0, math.pi))
    return Texture(kind, color, length, angle) if there < TEXTURED else None


def _pale(rng: np.random.Generator) -> Vec3:
    """The colour of a floor or wall."""
    hue, saturation, value = rng.uniform((0.0, 0.0, 0.45), (1.0, 0.3, 1.0)).tolist()
    return colorsys.hsv_to_rgb(hue, saturation, value)


def _eight_bit(color: Vec3) -> tuple[int, int, int]:
    red, green, blue = (round(255.0 * share) for share in color)
    return (red, green, blue)
