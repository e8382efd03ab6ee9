"""Pictures of a world: stills, depth and segmentation images, and a contact sheet of all."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from taskbuilder.cameras import BACKGROUND, LARGEST_SIDE, Image
from taskbuilder.files import write_whole
from taskbuilder.world.pictures import capture
from taskbuilder.world.segments import FLOOR
from taskbuilder.world.world import World

if TYPE_CHECKING:
    from PIL.ImageFont import FreeTypeFont

Modality = Literal["rgb", "depth", "mask"]

SUPERSAMPLE = 2
"""How many times larger stills are drawn than shown; edges become smooth."""

Pixels = NDArray[np.uint8]

INK, GRAY, PAPER = (43, 40, 38), (122, 116, 110), (252, 251, 250)
MARGIN = 24
_TITLE, _CAPTION = 78, 30
_FONTS = Path(__file__).with_name("fonts")
_FONT_SCALE = 0.95  # DejaVu Sans runs wide


@dataclass(frozen=True)
class Still:
    """What one camera saw.

    Attributes:
        camera: The camera's name.
        image: Its picture, depth and mask.
    """

    camera: str
    image: Image

    def colored(self, modality: Modality) -> Pixels:
        """The image of a modality as people look at it: (height, width, 3) uint8, RGB."""
        if modality == "rgb":
            return self.image.rgb
        return self.colored_depth() if modality == "depth" else self.colored_mask()

    def colored_depth(self) -> Pixels:
        """Depth in colours, from near (bright) to far (dark); nothing is black."""
        there = self.image.mask > 0
        shown = np.zeros((*there.shape, 3), dtype=np.uint8)
        if there.any():
            depth = self.image.depth
            near, far = np.percentile(depth[there], [1, 99])
            share = np.clip((far - depth) / max(far - near, 1e-6), 0.0, 1.0)
            colors = cv2.applyColorMap((share * 255).astype(np.uint8), cv2.COLORMAP_VIRIDIS)
            shown[there] = colors[:, :, ::-1][there]
        return shown

    def colored_mask(self) -> Pixels:
        """A colour for each thing of the scene; see `legend`."""
        colors = {"": (255, 255, 255), **self._colors()}
        by_number = np.array([colors[_thing(name)] for name in self.image.names], dtype=np.uint8)
        shown: Pixels = by_number[self.image.mask]
        return shown

    def depth_mm(self) -> NDArray[np.uint16]:
        """Depth in whole millimetres, 0 where nothing is: (height, width) uint16."""
        depth = np.where(self.image.mask > 0, self.image.depth * 1000.0, 0.0)
        return np.clip(np.round(depth), 0, 65535).astype(np.uint16)

    def legend(self) -> dict[str, list[int]]:
        """The colour [r, g, b] of every thing in the mask; nothing is white."""
        return {thing: list(color) for thing, color in self._colors().items()}

    def _colors(self) -> dict[str, tuple[int, int, int]]:
        """Hues spread evenly over the things of the scene, in the order of the mask."""
        things = [*dict.fromkeys(thing for name in self.image.names if (thing := _thing(name)))]
        hues = np.array([[[round(180 * i / len(things)), 150, 215] for i in range(len(things))]])
        colors = cv2.cvtColor(hues.astype(np.uint8), cv2.COLOR_HSV2RGB)[0].tolist()
        return {thing: (r, g, b) for thing, (r, g, b) in zip(things, colors, strict=True)}


def _thing(name: str) -> str:
    """The thing of the scene that a name in a mask belongs to; "" for the background."""
    if name in (BACKGROUND, FLOOR):
        return "floor" if name == FLOOR else ""
    return name.partition(".")[0]


def take_still(world: World, camera: str, size: tuple[int, int] | None = None) -> Still:
    """Take a supersampled picture, lit and with shadows.

    Args:
        world: The world as it stands.
        camera: A camera of the scene.
        size: Width and height in pixels; by default the camera's own.

    Raises:
        UnknownNameError: The scene has no such camera.
        SimulationError: The picture would be too large.
    """
    world.move_markers()
    view = world.camera(camera, size)
    roomy = SUPERSAMPLE * max(view.width, view.height) <= LARGEST_SIDE
    image = capture(
        world,
        view,
        studio=True,
        supersample=SUPERSAMPLE if roomy else 1,
        shadow=world.scene.cameras[camera].mount is None,  # coarse when seen from near
    )
    return Still(camera, image)


def contact_sheet(
    title: str, subtitle: str, stills: Sequence[Still], modalities: Sequence[Modality]
) -> Pixels:
    """All pictures on one page: a row for each modality if there are several, else a grid."""
    cells = [(still, modality) for modality in modalities for still in stills]
    columns = len(stills) if len(modalities) > 1 else min(len(cells), 2)
    width = max(240, min(640, 1600 // max(columns, 1)))
    tiles = [_tile(still, modality, width) for still, modality in cells]
    rows = [tiles[start : start + columns] for start in range(0, len(tiles), columns)]
    return page(title, subtitle, rows, width)


def seeds_sheet(
    title: str,
    subtitle: str,
    stills: Sequence[tuple[int, Still]],
    modalities: Sequence[Modality] = ("rgb",),
) -> Pixels:
    """Pictures of several episodes on one page, up to four in a row.

    Args:
        title: In large letters.
        subtitle: Below it.
        stills: Each with the seed of its episode.
        modalities: Kinds of image.
    """
    cells = [
        (still, modality, f"{still.camera} · seed {seed}")
        for seed, still in stills
        for modality in modalities
    ]
    columns, width = min(len(cells), 4), 400
    tiles = [_tile(still, modality, width, caption) for still, modality, caption in cells]
    rows = [tiles[start : start + columns] for start in range(0, len(tiles), columns)]
    return page(title, subtitle, rows, width)


def page(title: str, subtitle: str, rows: Sequence[Sequence[Pixels]], width: int) -> Pixels:
    """Tiles on paper, below a heading.

    Args:
        title: In large letters.
        subtitle: Below it; cut where it does not fit.
        rows: Tiles from left to right, from top to bottom; the first row is the longest.
        width: Of every tile, in pixels.
    """
    columns = len(rows[0])
    page_width = columns * (width + MARGIN) + MARGIN
    header = np.full((_TITLE, page_width, 3), PAPER, dtype=np.uint8)
    write_text(header, title, (MARGIN, 40), 24, INK, 600)
    write_text(header, _shortened(subtitle, page_width), (MARGIN, 64), 15, GRAY, 400)
    return np.vstack([header, *(_row(row, columns, width) for row in rows)])


def _tile(still: Still, modality: Modality, width: int, words: str = "") -> Pixels:
    picture = still.colored(modality)
    height = round(picture.shape[0] * width / picture.shape[1])
    small = cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA)
    caption = np.full((_CAPTION, width, 3), PAPER, dtype=np.uint8)
    words = words or f"{still.camera} · {modality}"
    write_text(caption, words, (0, 20), 14, GRAY, 400)
    return np.vstack([small, caption]).astype(np.uint8)


def _row(tiles: Sequence[Pixels], columns: int, width: int) -> Pixels:
    height = max(tile.shape[0] for tile in tiles)
    row = np.full((height, columns * (width + MARGIN) + MARGIN, 3), PAPER, dtype=np.uint8)
    for index, tile in enumerate(tiles):
        left = MARGIN + index * (width + MARGIN)
        row[: tile.shape[0], left : left + width] = tile
    return row


def write_text(
    picture: Pixels, text: str, at: tuple[int, int], size: int, color: Iterable[int], weight: int
) -> None:
    """Put a line of letters on a picture; it begins `at` a column, on a row."""
    letters = _letters(text, size, weight)
    left, top = at[0], at[1] - _ascent(size, weight)
    rows = slice(max(top, 0), max(top + letters.shape[0], 0))
    columns = slice(max(left, 0), max(left + letters.shape[1], 0))
    under = picture[rows, columns]  # what of it lies on the picture
    ink = letters[rows.start - top :, columns.start - left :][: under.shape[0], : under.shape[1]]
    ink = ink[..., None]
    picture[rows, columns] = np.rint(under * (1.0 - ink) + np.array([*color]) * ink)


def _shortened(text: str, width: int) -> str:
    """A subtitle cut after as many words as fit on the page."""
    shown, words = text, text.split()
    while words and text_width(shown, 15, 400) > width - 2 * MARGIN:
        words.pop()
        shown = f"{' '.join(words)} …"
    return shown


def text_width(text: str, size: int, weight: int) -> int:
    """How many columns `write_text` takes for a text."""
    return round(_font(size, weight).getlength(text))


@lru_cache(maxsize=512)
def _letters(text: str, size: int, weight: int) -> NDArray[np.float64]:
    """How much of each pixel is ink, from 0 to 1."""
    from PIL import Image as Paper
    from PIL import ImageDraw

    font = _font(size, weight)
    extent = (text_width(text, size, weight) + size, sum(font.getmetrics()))
    page = Paper.new("L", extent)
    ImageDraw.Draw(page).text((0, _ascent(size, weight)), text, 255, font, anchor="ls")
    return np.asarray(page) / 255.0


def _ascent(size: int, weight: int) -> int:
    return int(_font(size, weight).getmetrics()[0])


@cache
def _font(size: int, weight: int) -> FreeTypeFont:
    """DejaVu Sans, of which `fonts` has the letters of Latin, Greek and Cyrillic, and signs."""
    from PIL import ImageFont

    face = "DejaVuSans-Bold.ttf" if weight > 500 else "DejaVuSans.ttf"
    return ImageFont.truetype(_FONTS / face, round(_FONT_SCALE * size))


def save_image(path: Path, pixels: NDArray[Any]) -> None:
    """Write a PNG, whole or not at all; (h, w, 3) is RGB, (h, w) uint16 is kept as it is.

    Raises:
        OSError: The file cannot be written.
    """
    ordered = pixels[:, :, ::-1] if pixels.ndim == 3 else pixels
    done, encoded = cv2.imencode(".png", np.ascontiguousarray(ordered))
    if not done:
        raise OSError(f"{path} cannot be encoded as PNG")
    write_whole(path, encoded.tobytes())


def save_still(still: Still, stem: Path, modalities: Sequence[Modality]) -> list[Path]:
    """Write a still's images beside each other: colours, depth in mm, mask and its legend.

    Args:
        still: What a camera saw.
        stem: Path of the files without their endings.
        modalities: Which to write.

    Returns:
        The files.

    Raises:
        OSError: A file cannot be written.
    """
    written = []
    for modality in modalities:
        file = stem.with_name(stem.name + ("" if modality == "rgb" else f"-{modality}") + ".png")
        save_image(file, still.depth_mm() if modality == "depth" else still.colored(modality))
        written.append(file)
        if modality == "mask":
            legend = file.with_suffix(".json")
            write_whole(legend, (json.dumps(still.legend(), indent=2) + "\n").encode())
            written.append(legend)
    return written
