"""Spread work over the nodes of a Ray cluster: the same results in the same order as on one.

A node needs the same version of taskbuilder, byte for byte, and tasks that are not the library's
under the same paths, for example on a shared file system. Work runs in the working directory of
the machine that asks, where a node has such a folder. A piece of work whose node or process is lost
is done again elsewhere.
"""

from __future__ import annotations

import logging
import os
import pickle
import socket
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

from taskbuilder._library import folder
from taskbuilder.digests import digest_of, digests_of_folder
from taskbuilder.errors import UsageError
from taskbuilder.extras import extra_needed
from taskbuilder.jobs import DONE, LostError, Map, carry_out, packed
from taskbuilder.processes import Fault

LOCAL = "local"
"""The address of a cluster of this machine alone, which is started and ended with the work."""

AHEAD = 2
"""Pieces of work under way per core, so that none waits for the next."""

_log = logging.getLogger(__name__)

_LOOK_S = 0.5  # between looks at pieces that are not done
_ANSWERS_S = 5.0  # how long the head of a cluster may take to accept a connection


@contextmanager
def cluster(address: str = LOCAL, *, beat: Callable[[], None] = lambda: None) -> Iterator[Map]:
    """A `map` over the nodes of a Ray cluster; see `jobs.workers`.

    Args:
        address: ``host:port`` of the cluster's head, ``auto`` for the cluster that this machine
            belongs to, or ``local``.
        beat: Called again and again while results are waited for.

    Raises:
        UsageError: Ray is missing, or there is no such cluster.
    """
    ray = _connected(address)
    try:
        yield _Cluster(ray, beat).spread
    finally:
        ray.shutdown()


def _connected(address: str) -> Any:
    """Ray, connected to a cluster.

    Raises:
        UsageError: Ray is missing, or there is no such cluster.
    """
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")  # it would tell its makers of the run
    with extra_needed("ray", "--ray"):
        import ray
    if address not in (LOCAL, "auto"):
        _check_answers(address)
    try:
        ray.init(
            address,
            log_to_driver=False,
            logging_level=logging.ERROR,
            include_dashboard=False if address == LOCAL else None,
        )
    except ConnectionError:
        raise UsageError(
            "this machine belongs to no Ray cluster; run `ray start --head` here, give the "
            f"address of one, or leave it out for {LOCAL}"
        ) from None
    return ray


def _check_answers(address: str) -> None:
    """Look whether somebody listens at an address, which Ray would wait minutes for.

    Raises:
        UsageError: It is none, or nobody does.
    """
    host, _, port = address.rpartition(":")
    if not host or not port.isdigit() or not 0 < int(port) < 1 << 16:
        raise UsageError(
            f'"{address}" is no address of a Ray cluster; write host:port, such as '
            f"192.168.0.2:6379, auto, or {LOCAL}"
        )
    try:
        socket.create_connection((host, int(port)), timeout=_ANSWERS_S).close()
    except OSError as error:
        why = error.strerror or "no answer"
        raise UsageError(f"no Ray cluster answers at {address} ({why})") from None


class _Asker(NamedTuple):
    """The machine that work is done for.

    Attributes:
        library: Digest of its taskbuilder.
        kind: What bits depend on besides; see `machine_kind`.
        directory: Its working directory.
    """

    library: str
    kind: str
    directory: str


class _Cluster:
    """Distributes pieces of work over a cluster."""

    def __init__(self, ray: Any, beat: Callable[[], None]) -> None:
        self._ray, self._beat = ray, beat
        self._asker = _Asker(library_digest(), machine_kind(), str(Path.cwd()))
        self._told: set[str] = set()
        self._remote = ray.remote(num_cpus=1)(_carry_out_here)

    def spread(self, function: Callable[[Any], Any], items: Iterable[Any]) -> Iterator[Any]:
        """Have work done; results come in the order of the items.

        Work that nobody waits for any more goes on until the cluster is left. It is not cancelled:
        Ray ends the whole process if a piece of work is cancelled in the moment it is done.
        """
        waiting = deque(items)
        begun: deque[tuple[Any, Any]] = deque()
        while waiting or begun:
            while waiting and len(begun) < self._most():
                item = waiting.popleft()
                begun.append((self._remote.remote(self._asker, packed(function, item)), item))
            yield self._result(*begun[0])
            begun.popleft()

    def _most(self) -> int:
        """How many pieces may be under way; nodes may join and leave."""
        cores = self._ray.cluster_resources().get("CPU", 1)
        return max(1, int(AHEAD * cores))

    def _result(self, reference: Any, item: Any) -> Any:
        while not self._ray.wait([reference], timeout=_LOOK_S)[0]:
            self._beat()
        self._beat()
        try:
            other, answer = self._ray.get(reference)
        except self._ray.exceptions.RayTaskError as error:
            raise error.cause from None
        except self._ray.exceptions.RayError as error:
            first = str(error).strip().partition("\n")[0]
            fault = Fault(f"of the Ray cluster was lost: {first}", "", outside=True)
            raise LostError(fault, item) from None
        self._tell_of(other)
        kind, value = pickle.loads(answer)  # noqa: S301  # a node that runs our code; see docs/clusters.md
        if kind == DONE:
            return value
        raise value

    def _tell_of(self, other: str) -> None:
        if other and other not in self._told:
            self._told.add(other)
            _log.warning("%s is another kind of machine; its results may differ in bits", other)


# --- on a node


def _carry_out_here(asker: _Asker, work: bytes) -> tuple[str, bytes]:
    """The answer, after the name of this machine if it is of another kind, or ""."""
    if library_digest() != asker.library:
        raise UsageError(
            f"{socket.gethostname()} has another taskbuilder than the machine that asks; install "
            "the same version on all nodes"
        )
    with suppress(OSError):
        os.chdir(asker.directory)
    other = socket.gethostname() if machine_kind() != asker.kind else ""
    return other, carry_out(work)


@lru_cache(maxsize=1)
def machine_kind() -> str:
    """A digest of all but the kernel that bits may depend on: processor, C library, versions."""
    from taskbuilder.machine import processor, system, versions  # loads NumPy

    told = {name: value for name, value in system().items() if name != "kernel"}
    return digest_of([processor(), told, versions()])


@lru_cache(maxsize=1)
def library_digest() -> str:
    """The digest of all files of this library, its tasks and robots included."""
    folders = (Path(__file__).resolve().parent, folder("tasks"), folder("robots"))
    return digest_of([digests_of_folder(each) for each in folders])
