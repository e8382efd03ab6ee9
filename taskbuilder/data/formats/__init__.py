"""Formats that data sets are exported to, and the registry of them."""

from __future__ import annotations

import shutil
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from secrets import token_hex

from taskbuilder.data.card import export_card_text
from taskbuilder.data.dataset import Dataset
from taskbuilder.data.formats.lerobot import write_lerobot
from taskbuilder.data.formats.minari import write_minari
from taskbuilder.data.formats.robomimic import write_robomimic
from taskbuilder.data.layout import CARD
from taskbuilder.errors import UnknownNameError, UsageError, display_path
from taskbuilder.extensions import DATA_FORMATS, ForeignPart


@dataclass(frozen=True)
class ExportOptions:
    """How a data set is exported.

    Attributes:
        pictures: Keep pictures as PNG instead of videos, where the format has both.
        language: Whether sub-tasks are written as language, which LeRobot 0.5 and earlier refuse.
        warn: Called with what users should know about an export; by default, it is shown as a
            warning of Python's.
    """

    pictures: bool = False
    language: bool = True
    warn: Callable[[str], None] = warnings.warn


def _lerobot(dataset: Dataset, folder: Path, options: ExportOptions) -> None:
    write_lerobot(
        dataset,
        folder,
        pictures=options.pictures,
        language=options.language,
        warn=options.warn,
    )


def _robomimic(dataset: Dataset, folder: Path, options: ExportOptions) -> None:
    del options  # it has pictures alone
    write_robomimic(dataset, folder)


def _minari(dataset: Dataset, folder: Path, options: ExportOptions) -> None:
    write_minari(dataset, folder, warn=options.warn)


DatasetWriter = Callable[[Dataset, Path, ExportOptions], None]
"""Writes the episodes of one task to an empty folder."""

FORMATS: Mapping[str, DatasetWriter] = {
    "lerobot": _lerobot,
    "robomimic": _robomimic,
    "minari": _minari,
}
"""The library's own formats by name."""


def _find(form: str) -> DatasetWriter:
    """What writes a format; also one that another package adds.

    Raises:
        UsageError: There is no such format.
        ExtensionError: It is of another package, and cannot be used.
    """
    try:
        part = DATA_FORMATS.part(form, FORMATS)
    except UnknownNameError as error:
        raise UsageError(str(error)) from None
    if part is None:
        return FORMATS[form]
    write = load_writer(part)

    def write_foreign(dataset: Dataset, folder: Path, options: ExportOptions) -> None:
        with part.at_work():
            write(dataset, folder, options)
        if not any(folder.iterdir()):
            raise part.error("has written nothing")

    return write_foreign


def load_writer(part: ForeignPart) -> DatasetWriter:
    """What writes a format that another package adds.

    Raises:
        ExtensionError: It cannot be used.
    """
    write: DatasetWriter = part.load(
        lambda writer: None if callable(writer) else "cannot be called"
    )
    return write


def export_dataset(
    dataset: Dataset,
    form: str,
    out: Path,
    options: ExportOptions = ExportOptions(),
) -> Path:
    """Export a data set to another format; the folder is there whole or not at all.

    A data set of several tasks becomes a folder for each, because their numbers differ.

    Args:
        dataset: The data set.
        form: One of `FORMATS`, or a format that an installed package adds.
        out: Folder to write to; it must not exist, or be empty.
        options: How it is exported.

    Returns:
        The folder.

    Raises:
        UsageError: Something is in the way, there are no episodes, there is no such format, or a
            package is not installed.
        ExtensionError: The format is of another package, and cannot be used.
        StoreError: The data set is damaged.
        OSError: It cannot be written.
    """
    write = _find(form)
    place, source = out.resolve(), dataset.folder.resolve()
    if place.is_relative_to(source) or source.is_relative_to(place):
        raise UsageError(
            f"{display_path(out)} is not apart from the data set {display_path(dataset.folder)}; "
            "name a folder beside it"
        )
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise UsageError(f"{display_path(out)} exists; name a new or empty folder")
    if not len(dataset):
        raise UsageError(f"{display_path(dataset.folder)} has no episodes")
    out.parent.mkdir(parents=True, exist_ok=True)
    for left in place.parent.glob(f".{place.name}.{'[0-9a-f]' * 8}"):  # by one that was killed
        shutil.rmtree(left)
    aside = place.with_name(f".{place.name}.{token_hex(4)}")
    aside.mkdir()
    try:
        for task in dataset.tasks:
            part = aside if len(dataset.tasks) == 1 else aside / task.replace("/", "-")
            part.mkdir(parents=True, exist_ok=True)
            episodes = dataset.of_task(task).with_steps()
            if len(episodes) < len(dataset.of_task(task)):
                options.warn(f"episodes of {task} that end before their first step are left out")
            if not len(episodes):
                raise UsageError(f"{display_path(dataset.folder)} has no control step of {task}")
            write(episodes, part, options)
            card = export_card_text(episodes.about, episodes.contents, form)
            (part / CARD).write_text(card, encoding="utf-8")
        if out.exists():
            out.rmdir()
        aside.rename(out)
    finally:
        shutil.rmtree(aside, ignore_errors=True)
    return out
