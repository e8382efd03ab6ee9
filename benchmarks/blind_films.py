"""Do the films show what the tasks are about? Frames of each, for viewers who do not know them.

    python benchmarks/blind_films.py FOLDER

Writes a picture with eight frames of the film of every task in the library to FOLDER, in a random
order, under neutral names and without the captions; and which is which to FOLDER/../key.json, for
afterwards. What a viewer said is kept in benchmarks/results/blind_films.json, beside whether it
names the subject: the objects, and what the robots do to them. A title alone does not count.
"""

from __future__ import annotations

import argparse
import json
import random
from pathlib import Path

from PIL import Image

from taskbuilder import catalogue

FILMS = Path(__file__).parents[1] / "docs" / "images"
FRAMES, COLUMNS, GAP = 8, 4, 5
HEIGHT = 0.74
"""Of the picture in a frame, as a multiple of its width; the caption is below."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", type=Path, help="folder to write to")
    parser.add_argument("--seed", type=int, default=77, help="seed of the order")
    arguments = parser.parse_args()
    tasks = sorted(catalogue().tasks)
    random.Random(arguments.seed).shuffle(tasks)
    arguments.folder.mkdir(parents=True, exist_ok=True)
    key = {f"film_{number:02}": task for number, task in enumerate(tasks, start=1)}
    for name, task in key.items():
        sheet(FILMS / f"{task}.gif").save(arguments.folder / f"{name}.png")
    (arguments.folder.parent / "key.json").write_text(json.dumps(key, indent=1) + "\n")


def sheet(film: Path) -> Image.Image:
    """Frames of a film at equal distances, in two rows."""
    with Image.open(film) as image:
        last, width = getattr(image, "n_frames", 1) - 1, image.width
        height = round(width * HEIGHT)
        frames = []
        for number in range(FRAMES):
            image.seek(round(number * last / (FRAMES - 1)))
            frames.append(image.convert("RGB").crop((0, 0, width, height)))
    rows = -(-FRAMES // COLUMNS)
    size = (COLUMNS * (width + GAP) - GAP, rows * (height + GAP) - GAP)
    drawn = Image.new("RGB", size, "white")
    for number, frame in enumerate(frames):
        row, column = divmod(number, COLUMNS)
        drawn.paste(frame, (column * (width + GAP), row * (height + GAP)))
    return drawn


if __name__ == "__main__":
    main()
