"""Make the pictures of the documentation.

    python docs/make_images.py [TASK | POLICY | robot:NAME | curves | objects | stills ...]

Writes, to docs/images/, for each task of the library the film of its expert, a still and the strip
of the film and the chart of its reward, and for those of the README a picture, all from the first
camera of the task file; the film of each policy of the zoo; the curves of each task's training; the
stages reached in the ablation of Handover; a picture of each robot; objects.png, all objects of the
shelf; and tasks.png, the three tasks of the README side by side. Given tasks or policies of the
zoo, such as zoo:handover/demos, it makes theirs only, given `robot:` and a name the picture of that
robot only, given `curves` the curves and the chart of the ablation only, and given `objects` those
only. Given `stills` it takes the stills from the films that are there.
"""

from __future__ import annotations

import contextlib
import io
import shutil
import subprocess
import sys
import tempfile
from contextlib import closing
from itertools import product
from pathlib import Path

import cv2
import numpy as np
from generators.results import read
from generators.training import LONGER, WAYS, ablation
from PIL import Image
from stage_bars import stage_bars

from taskbuilder import load_task, parallel_env
from taskbuilder.cli import main as taskbuilder
from taskbuilder.env.parallel import TaskEnv
from taskbuilder.expert import Expert
from taskbuilder.policies.fitting import options_of
from taskbuilder.policies.zoo import load_policy, zoo_names
from taskbuilder.rollout import Rollout, play
from taskbuilder.schema.catalogue import Catalogue
from taskbuilder.schema.object_files import load_object
from taskbuilder.visual.film import save_film
from taskbuilder.visual.object_picture import take_object_picture
from taskbuilder.visual.still import Pixels, save_image
from taskbuilder.visual.video import GIF_COLORS

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))

from kept_runs import unpack

CURVES, OBJECTS, STILLS, ROBOT = "curves", "objects", "stills", "robot:"
COLORS, CHART_COLORS = 256, 64
"""Colours of a still and of a chart: a fifth of the size, and no difference to be seen."""

TILE, ABREAST = 170, 6
"""Edge of the picture of an object in pixels, and how many are in a row."""
INK = (60, 60, 64)
IMAGES = Path(__file__).parent / "images"
RUNS = {"": "learning", "-earlier": "learning_earlier"}
"""Groups of training runs, by what the names of their curves have."""
PAPER = {
    "pick_push_place": ("Pick-Push-Place", ("pick_push_place-1",)),
    "pick_push_place-attach": (
        "Pick-Push-Place",
        ("pick_push_place-1", "pick_push_place-attach-11"),
    ),
    "collaborative_lift": ("Collaborative Lift", ("collaborative_lift-1",)),
    "handover": ("Handover", ("handover-1",)),
}
"""Runs of the paper's learner that one picture shows, with their title."""
SHOWN = {
    "pick_push_place": "Pick-Push-Place",
    "collaborative_lift": "Collaborative Lift",
    "handover": "Handover",
}
TRACKS = ("demos", "scratch", "own", "resets")
TRIALS = ("saturated", "regularised", "brake", "constant")
"""Last words of the names of trials that the page on learning shows with their curves."""

SIZES = ((800, 600), (640, 480))
"""Sizes of a task's picture: the first that is small enough."""
PICTURE_BYTES = 150_000
THUMBNAIL = (480, 360)
_LARGE = ((480, 360), (400, 300), (360, 270), (320, 240))
_SMALL = ((320, 240), (280, 210), (240, 180))
FILMS = (
    *((size, 12, GIF_COLORS) for size in _LARGE),
    *((size, 8, GIF_COLORS) for size in _SMALL[:-1]),
    *((size, 5, 128) for size in _SMALL),
)
"""Size, frames a second and colours of a film of the gallery: the first that is small enough."""
FILM_BYTES = 300_000

STILL_AT, STILL_QUALITY = 0.45, 80
"""Where in a film its still is taken, as a share of its frames, and its quality as WebP."""

_PAPER, _INK = (255, 255, 255), (58, 62, 66)
_GAP, _CAPTION = 16, 40


def make_task(name: str) -> None:
    """Make the pictures of a task anew."""
    camera = next(iter(load_task(name).file.spec.scene.cameras))
    with tempfile.TemporaryDirectory() as folder:
        if name in SHOWN:
            _picture(name, camera, Path(folder, f"{name}-{camera}.png"))
        _call("demo", name, "--camera", camera, "--out", folder, *_drawn())
        with closing(parallel_env(name)) as env, closing(Expert(env)) as expert:
            _film(env, expert.play(0), camera, Path(folder, name))
        for ending in (".gif", "-rewards.png"):
            _keep(Path(folder, f"{name}{ending}"), f"{name}{ending}")
        _keep(Path(folder, f"{name}-strip.png"), f"{name}-strip.webp")
    make_still(name)


def make_still(name: str) -> None:
    """Take the still of a film that is there, as large as the film."""
    with Image.open(IMAGES / f"{name}.gif") as film:
        film.seek(round(STILL_AT * (film.n_frames - 1)))
        frame = film.convert("RGB")
    frame.save(IMAGES / f"{name}.webp", quality=STILL_QUALITY, method=6)


def _picture(name: str, camera: str, file: Path) -> None:
    """Draw a task as large as a picture of the documentation may be."""
    for width, height in SIZES:
        size = ("--size", f"{width}x{height}")
        _call("render", name, "--camera", camera, "--out", str(file.parent), *_drawn(), *size)
        if file.stat().st_size < PICTURE_BYTES:
            break
    _keep(file, f"{name}.png")


def make_policy(name: str) -> None:
    """Make the film of a policy of the zoo anew, whatever becomes of its episode."""
    policy = load_policy(name)
    task, track = name.removeprefix("zoo:").split("/")
    with (
        tempfile.TemporaryDirectory() as folder,
        closing(parallel_env(task, **options_of(policy))) as env,
    ):
        _film(env, play(env, policy.player(), 0), "front", Path(folder, task))
        _keep(Path(folder, f"{task}.gif"), f"{task}-{track}.gif")


def _film(env: TaskEnv, played: Rollout, camera: str, stem: Path) -> None:
    """Film an episode as large as a film of the gallery may be."""
    density = 0.0  # bytes a pixel of the last film; a smaller one has as many, or more
    for (width, height), fps, colors in FILMS:
        pixels = width * height * fps
        if density * pixels > FILM_BYTES and colors == GIF_COLORS:
            continue
        size = (width, height)
        _, film = save_film(env, played, [camera], stem, size=size, fps=fps, gif_colors=colors)
        density = film.stat().st_size / pixels
        if film.stat().st_size <= FILM_BYTES:
            return


def make_all() -> None:
    """Make every picture anew."""
    IMAGES.mkdir(exist_ok=True)
    catalogue = Catalogue()
    for robot, entry in catalogue.robots.items():
        if entry.module:
            make_robot(robot)
    for name, entry in catalogue.tasks.items():
        if entry.module:
            make_task(name)
    for policy in zoo_names():
        make_policy(policy)
    make_curves()
    make_ablation()
    with tempfile.TemporaryDirectory() as folder:
        save_image(Path(folder, "tasks.png"), _side_by_side())
        _keep(Path(folder, "tasks.png"), "tasks.png")
    make_objects()


def make_robot(name: str) -> None:
    """Draw a robot at home, with the axes of its tcp."""
    with tempfile.TemporaryDirectory() as folder:
        _call("robots", "check", name, "--out", str(Path(folder, f"{name}.png")))
        _keep(Path(folder, f"{name}.png"), f"robot-{name}.png")


def make_objects() -> None:
    """Draw all objects of the shelf, side by side."""
    tiles = []
    for name, entry in Catalogue().objects.items():
        picture, _, _ = take_object_picture(load_object(entry))
        tile = cv2.resize(picture, (TILE, TILE), interpolation=cv2.INTER_AREA)
        cv2.putText(tile, name, (8, TILE - 10), cv2.FONT_HERSHEY_SIMPLEX, 0.5, INK, 1, cv2.LINE_AA)
        tiles.append(tile)
    tiles += [np.full_like(tiles[0], 255)] * (-len(tiles) % ABREAST)
    rows = [np.hstack(tiles[i : i + ABREAST]) for i in range(0, len(tiles), ABREAST)]
    save_image(IMAGES / "objects.png", np.vstack(rows))


def make_curves() -> None:
    """Draw the learning curves of all runs that the pages show."""
    with tempfile.TemporaryDirectory() as folder:
        _make_curves(Path(folder))


def _make_curves(folder: Path) -> None:
    trained = sorted({run["task"] for run in read("learning.json")["runs"]})
    named = {
        f"{task}-{track}{when}": sorted(kept.glob(f"{task}-{track}-*"))
        for when, kept in ((when, unpack(group, folder)) for when, group in RUNS.items())
        for task, track in product(trained, TRACKS)
    }
    trials, deadlock = unpack("learning_trials", folder), unpack("deadlock", folder)
    for task, trial in product(SHOWN, TRIALS):
        named[f"{task}-{trial}"] = sorted(trials.glob(f"{task}-*-{trial}"))
    named["handover-longer"] = [deadlock / f"{way}-1" for way in LONGER]
    for name, runs in named.items():
        if runs:
            _call("plot", *map(str, runs), "--out", str(folder / "curves.png"))
            _keep(folder / "curves.png", f"{name}-curves.png")
    paper = unpack("paper", folder)
    for name, (title, shown) in PAPER.items():
        curves, folders = folder / "curves.png", [str(paper / run) for run in shown]
        title = f"{title}, the paper's learner"
        _call("plot", *folders, "--title", title, "--out", str(curves))
        _keep(curves, f"paper-{name}-curves.png")


def make_ablation() -> None:
    """Draw the furthest stages of the runs of the ablation of Handover."""
    groups = {
        WAYS[way]: [(f"seed {run['seed']}", run["stages"]) for run in runs]
        for way, runs in ablation().items()
    }
    title = "What is learned of Handover"
    chart = stage_bars(title, "furthest stage in 300 new episodes of each run", groups)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "ablation.png")
        file.write_bytes(chart)
        _keep(file, "handover-ablation.png")


def _drawn() -> tuple[str, ...]:
    # The renderer on the CPU draws the same picture on every machine.
    return ("--renderer", "tiny")


def _call(*words: str) -> None:
    with contextlib.redirect_stdout(io.StringIO()):
        status = taskbuilder(list(words))
    if status:
        sys.exit(status)


def _keep(file: Path, name: str) -> None:
    """Put a picture among those of the pages, a still with as many colours as a film may have."""
    if file.suffix == ".png":
        with Image.open(file) as picture:
            chart = file.stem.endswith(("rewards", "curves"))
            colors = CHART_COLORS if chart else COLORS
            small = picture.convert("RGB").quantize(colors, method=Image.Quantize.FASTOCTREE)
        if name.endswith(".webp"):
            small.convert("RGB").save(IMAGES / name, lossless=True, quality=100, method=4)
        else:
            small.save(IMAGES / name, optimize=True)
    else:
        (IMAGES / name).write_bytes(_packed(file))


def _packed(film: Path) -> bytes:
    """A film a quarter smaller, if gifsicle is installed; hardly anybody sees a difference."""
    if shutil.which("gifsicle") is None:
        sys.stderr.write(f"gifsicle is not installed; {film.name} is kept as it is\n")
        return film.read_bytes()
    command = ["gifsicle", "-O3", "--lossy=80", "--no-warnings", str(film)]
    return subprocess.run(command, check=True, capture_output=True).stdout


def _read(name: str) -> Pixels:
    picture = cv2.imread(str(IMAGES / f"{name}.png"))
    if picture is None:
        raise FileNotFoundError(name)
    return picture[:, :, ::-1].astype(np.uint8)


def _side_by_side() -> Pixels:
    """The tasks of the README in a row, each with its name below."""
    width, height = THUMBNAIL
    page = np.full(
        (height + _CAPTION, len(SHOWN) * (width + _GAP) - _GAP, 3), _PAPER, dtype=np.uint8
    )
    face = cv2.FontFace("sans")
    for index, (name, caption) in enumerate(SHOWN.items()):
        left = index * (width + _GAP)
        small = cv2.resize(_read(name), THUMBNAIL, interpolation=cv2.INTER_AREA)
        page[:height, left : left + width] = small
        (_, _, length, _) = cv2.getTextSize(page.shape[:2], caption, (0, 0), face, 20, 500)
        middle = left + (width - length) // 2
        cv2.putText(page, caption, (middle, height + 28), _INK, face, 20, 500)
    return page


if __name__ == "__main__":
    for name in sys.argv[1:]:
        if name == CURVES:
            make_curves()
            make_ablation()
        elif name == OBJECTS:
            make_objects()
        elif name == STILLS:
            for task, entry in Catalogue().tasks.items():
                if entry.module:
                    make_still(task)
        elif name.startswith(ROBOT):
            make_robot(name.removeprefix(ROBOT))
        elif name.startswith("zoo:"):
            make_policy(name)
        else:
            make_task(name)
    if not sys.argv[1:]:
        make_all()
