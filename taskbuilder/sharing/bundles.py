"""What can be shared, with its files: found by a name or path, and checked before it goes out."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from taskbuilder.carried import carry, digests_of
from taskbuilder.data import layout
from taskbuilder.data.checking import check_dataset
from taskbuilder.digests import digest
from taskbuilder.errors import UnknownNameError, UsageError, display_path
from taskbuilder.evaluation.certificate import read_certificate, task_version
from taskbuilder.evaluation.verification import compare_seals
from taskbuilder.policies.grammar import read_word
from taskbuilder.policies.zoo import LARGEST, POLICY_FILE, ZOO_PREFIX, load_policy, policy_file
from taskbuilder.schema.catalogue import Catalogue, looks_like_path, similar
from taskbuilder.sharing.manifest import Manifest, check_name
from taskbuilder.task import load_task
from taskbuilder.untrusted import place_within, read_plain
from taskbuilder.wording import suggestion

CERTIFICATE_FILE = "certificate.json"
"""Name that a certificate gets among the files that are shared."""


@dataclass(frozen=True)
class Bundle:
    """What is shared, with its files.

    Attributes:
        manifest: What it is.
        sources: The content or the place of each file, by its path in the manifest.
        remarks: What whoever shares it should know.
    """

    manifest: Manifest
    sources: Mapping[str, bytes | Path] = field(repr=False)
    remarks: tuple[str, ...] = ()


def bundle_of(what: str, name: str | None, catalogue: Catalogue) -> Bundle:
    """Find what a word stands for, and its files.

    Args:
        what: Name of a task, or the path of a task file, of the folder of a data set or of a
            training run, of a policy's file, or of a certificate; or a policy of the zoo.
        name: The name to share it by; by default its own.
        catalogue: Where tasks are looked up.

    Raises:
        UnknownNameError: There is nothing of this name.
        UsageError: It cannot be shared, or its name not be shared by.
        FileError: The task has errors.
        StoreError: The policy or the data set is damaged.
    """
    path = Path(what)
    if what.startswith(ZOO_PREFIX):
        return _policy(what, name or re.sub("[:/]", "-", what.removeprefix(ZOO_PREFIX)))
    if what in catalogue.tasks and not looks_like_path(what):
        if path.exists():
            raise UsageError(f"{what} is a task and a file here; write ./{what} for the file")
        return _task(what, name, catalogue)
    if path.suffix in (".yaml", ".yml"):
        return _task(what, name, catalogue)
    if (path / layout.ABOUT).is_file():
        return _data_set(path, name or path.resolve().name)
    if (path / POLICY_FILE).is_file() or (path.suffix == ".npz" and path.is_file()):
        return _policy(what, name or path.resolve().name.removesuffix(".npz"))
    if path.suffix == ".json" and path.is_file():
        return _certificate(path, name or path.stem)
    if path.exists():
        raise UsageError(
            f"{display_path(path)} is no task file, data set, training run, policy or certificate"
        )
    if looks_like_path(what):
        raise UnknownNameError(f"there is no file {display_path(path)}{similar(path)}")
    help_ = suggestion(what, catalogue.tasks, otherwise="`taskbuilder list` shows all tasks")
    raise UnknownNameError(f'there is no task or file "{what}"; {help_}')


def _bundle(
    kind: str,
    name: str,
    about: Mapping[str, Any],
    sources: Mapping[str, bytes | Path],
    digests: Mapping[str, str],
    remarks: tuple[str, ...] = (),
) -> Bundle:
    check_name(name)
    return Bundle(Manifest(kind, name, about, digests), sources, remarks)


def _task(reference: str, name: str | None, catalogue: Catalogue) -> Bundle:
    task = load_task(reference, catalogue=catalogue, guarded=True)
    carried = carry(task, packaged=True)
    if carried is None:
        raise UsageError(f"{task.name} has no files of its own to share")
    about = {
        "task": carried.name,
        "task_version": task.version,
        "file": carried.file,
        "folders": list(carried.folders),
    }
    return _bundle("task", name or carried.name, about, carried.files, digests_of(carried.files))


def _data_set(folder: Path, name: str) -> Bundle:
    checked = check_dataset(folder, 0.0)
    wrong = [*checked.damaged, *checked.invalid]
    if wrong:
        raise UsageError(
            f"{display_path(folder)} is damaged ({wrong[0]}); see taskbuilder dataset check"
        )
    files = dict(layout.read_manifest(folder)["files"])
    files[layout.MANIFEST] = layout.digest_file(folder, layout.MANIFEST)
    tasks = layout.read_about(folder)["tasks"]
    about = {"tasks": {task: each.get("task_version", 1) for task, each in tasks.items()}}
    return _bundle("data set", name, about, {file: folder / file for file in files}, files)


def _policy(policy: str, name: str) -> Bundle:
    about = load_policy(policy).about
    content = {POLICY_FILE: read_plain(policy_file(policy), LARGEST)}
    said = {"task": str(about.get("task")), "task_version": about.get("task_version", 1)}
    return _bundle("policy", name, said, content, digests_of(content))


def _certificate(file: Path, name: str) -> Bundle:
    """A certificate, with the policy that it names, if this lies in its folder."""
    data = read_certificate(file)
    edited = [said for point in compare_seals(data) for said in point.differs]
    if edited:
        raise UsageError(f"{display_path(file)} is not as it was written: {', '.join(edited)}")
    content = {CERTIFICATE_FILE: file.read_bytes()}
    remarks: tuple[str, ...] = ()
    policy = data["policy"]
    if not policy.startswith(ZOO_PREFIX) and read_word(policy) is None:
        beside = _policy_beside(file, policy, data["digests"]["policy"].get(policy))
        content |= beside
        if not beside:
            remarks = (
                f"its policy {policy} is not as certified in the folder of the certificate: push "
                "it, too, so that others can verify",
            )
    about = {"task": data["task"], "task_version": task_version(data), "policy": policy}
    return _bundle("certificate", name, about, content, digests_of(content), remarks)


def _policy_beside(certificate: Path, policy: str, certified: object) -> dict[str, bytes]:
    """The certified policy by its path in the folder of the certificate, if it is there."""
    try:
        place = place_within(certificate.resolve().parent, policy)
        if place.is_dir():
            policy, place = f"{policy}/{POLICY_FILE}", place / POLICY_FILE
        content = read_plain(place, LARGEST)
    except OSError:
        return {}
    return {policy: content} if digest(content) == certified else {}
