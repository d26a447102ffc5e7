"""Parts of the work, computed by Dask: by threads of this machine, or by a cluster that is running.

Results come as they are ready, in no certain order; what is computed of a part does not depend on where.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import CancelledError, ThreadPoolExecutor
from contextlib import closing, contextmanager, suppress
from functools import partial
from itertools import chain
from queue import Empty, Queue
from threading import Thread
from typing import Any, TypeVar
from uuid import uuid4

from ..errors import AttitudeError, InputError
from ..runtime.optional_imports import needed
from ..runtime.threads import processors
from ..stopping import Stop, stoppable
from ..version import __version__

Part = TypeVar("Part")
Result = TypeVar("Result")

GRAPH = 4096  # tasks that Dask's threads are given at a time: it holds something for each
CLUSTER = 64  # threads that a cluster may have
AHEAD = 2  # tasks for each thread of a cluster: one at work, one that waits for it
# A task of a cluster costs its scheduler and client some milliseconds, whatever it does: so it is of several
# parts, fewer towards the end, where some thread would be the last to have many.
MOST_TOGETHER = 16
SHARES = 4  # of what is left, for each thread
PATIENCE = "10 s"  # for a cluster to answer, and for the first of its workers
ADDRESS = "the address of a running Dask cluster, such as tcp://10.0.0.1:8786"


def check(scheduler: Any, workers: Any) -> None:
    """Raises InputError for what `mapped` cannot take."""
    if scheduler is not None and not (isinstance(scheduler, str) and scheduler):
        raise InputError("scheduler", scheduler, ADDRESS)
    if workers is None:
        return
    if scheduler is not None:
        raise InputError("workers", workers, "no number of workers beside a scheduler, which has its own")
    if isinstance(workers, bool) or not isinstance(workers, int) or workers < 1:
        raise InputError("workers", workers, "a whole number, at least 1")


def mapped(
    work: Callable[[Part], Result],
    parts: Sequence[Part],
    scheduler: str | None = None,
    workers: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> Generator[Result, None, None]:
    """Results of `work` for all parts, in the order in which they are ready.

    Parameters
    ----------
    work : what can be pickled, if for a cluster; sent there once
    scheduler : address of a running Dask cluster; None for threads of this machine
    workers : threads of this machine; by default as many as it has processors
    progress : called with the fraction that is done

    Threads wait until their results are taken: who may leave before the end uses `contextlib.closing`.
    A bounded number of parts is under way at any time.  What the work raises is raised here at once; a
    worker that dies takes nothing along, for what it was at is computed again by another.

    Raises
    ------
    InputError : scheduler or workers cannot be taken.
    FormatError : the extra `ensemble` is not installed.
    AttitudeError : the cluster is lost, or the same part has killed a number of its workers.
    """
    check(scheduler, workers)
    if not parts:
        return
    if scheduler is None:
        results = _by_threads(work, parts, workers or processors())
    else:
        results = _by_cluster(work, parts, scheduler)
    with closing(results):  # now, whatever is raised, and not when nobody holds its traceback any more
        for done, result in enumerate(results, 1):
            yield result
            if progress is not None:
                progress(done / len(parts))


def threads(scheduler: str | None, workers: int | None) -> int:
    """About how many compute at once: of a cluster nobody knows beforehand, and more may come."""
    return CLUSTER if scheduler is not None else workers or processors()


# -- threads ----------------------------------------------------------------------------------------

_END = object()


class _Raised:
    def __init__(self, error: BaseException):
        self.error = error


def _by_threads(
    work: Callable[[Part], Result], parts: Sequence[Part], workers: int
) -> Generator[Result, None, None]:
    """Through Dask's threaded scheduler, which gives each thread its next task when it is free.

    That scheduler returns when all is done, and keeps what tasks return.  So it runs beside this thread,
    and tasks hand their results through a queue: whoever takes them can follow the progress, and waits
    for no slower part; and where he is slower himself, the queue fills and the threads wait for him.
    """
    get = needed("dask.threaded", "an ensemble", "ensemble").get
    results: Queue[Any] = Queue(AHEAD * workers)
    stop = Stop()

    def one(part: Part) -> None:
        with stoppable(stop):
            stop.check()  # what it raises ends Dask's graph
            results.put(work(part))

    def all_of_them() -> None:
        try:
            with ThreadPoolExecutor(workers, "attitude-ensemble") as pool:
                for first in range(0, len(parts), GRAPH):
                    some = parts[first : first + GRAPH]
                    graph = {f"part-{i}": (partial(one, part),) for i, part in enumerate(some)}
                    get(graph, list(graph), pool=pool)
            results.put(_END)
        except BaseException as error:
            results.put(_Raised(error))

    runner = Thread(target=all_of_them, name="attitude-ensemble", daemon=True)
    runner.start()
    try:
        while (result := results.get()) is not _END:
            if isinstance(result, _Raised):
                raise result.error
            yield result
    finally:
        stop.set()
        while runner.is_alive():  # what is under way stops; no thread may wait for room in the queue
            with suppress(Empty):
                results.get(timeout=0.01)


# -- a cluster --------------------------------------------------------------------------------------


def _by_cluster(
    work: Callable[[Part], Result], parts: Sequence[Part], address: str
) -> Generator[Result, None, None]:
    client = _client(address)
    try:
        yield from _Following(client, work, address).results(parts)
    finally:
        client.close(timeout=5)


def _client(address: str) -> Any:
    """Connected, to a cluster that has workers."""
    try:
        # a Client that finds nobody leaves threads behind that go on trying
        with ThreadPoolExecutor(1) as aside:  # this thread may have a loop of its own, as in a notebook
            aside.submit(asyncio.run, _answer(address)).result()
        client = _distributed().Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:  # nobody there; or it is no address
        why = " ".join(str(error).split())
        raise InputError("scheduler", address, f"{ADDRESS} ({why})") from None
    try:
        client.wait_for_workers(1, timeout=PATIENCE)
    except TimeoutError:
        client.close(timeout=5)
        raise InputError("scheduler", address, f"a cluster with workers: none came in {PATIENCE}") from None
    return client


async def _answer(address: str) -> None:
    """Returns when somebody listens there; raises OSError or ValueError otherwise."""
    connect = needed("distributed.comm", "a cluster", "ensemble").connect
    security = _distributed().Security().get_connection_args("client")
    (await connect(address, timeout=PATIENCE, **security)).abort()


class _Following:
    """Parts that a cluster is at, and those that it is not at yet.

    The work itself is one more task, whose result all others take: sent once, passed on from worker to
    worker, and, unlike data that is scattered, made again from what the scheduler has of it when every
    worker that had it is dead.
    """

    def __init__(self, client: Any, work: Any, address: str):
        import dask

        self._client, self._address = client, address
        self._name = f"attitude-{uuid4().hex}"
        with dask.config.set({"distributed.admin.large-graph-warning-threshold": "1 TiB"}):  # once, not often
            self._work = client.submit(_itself, work, key=f"{self._name}-work", pure=False)
        self._pending: dict[Any, Sequence[Any]] = {}  # parts by their futures
        self._ready = _distributed().as_completed(loop=client.loop)

    def results(self, parts: Sequence[Any]) -> Iterator[Any]:
        given = 0
        try:
            given = self._submit(parts, given)
            for futures in self._ready.batches():
                for future in futures:
                    self._check(future, self._pending.pop(future))
                given = self._submit(
                    parts, given
                )  # before anybody looks at results: no worker waits for that
                with self._lost():
                    results = self._client.gather(futures)
                yield from chain.from_iterable(results)
        finally:
            with suppress(OSError, TimeoutError):  # of a cluster that is lost
                self._client.cancel([*self._pending, self._work], force=True)

    def _submit(self, parts: Sequence[Any], given: int) -> int:
        """Give as many as keep the workers busy that there are now; returns how many are given then."""
        with self._lost():
            threads = max(1, sum(self._client.nthreads().values()))
        while given < len(parts) and len(self._pending) < AHEAD * threads:
            together = min(max((len(parts) - given) // (SHARES * threads), 1), MOST_TOGETHER)
            some = parts[given : given + together]
            name = f"{self._name}-{given}"
            future = self._client.submit(_each, __version__, self._work, some, key=name, pure=False)
            self._pending[future] = some
            self._ready.add(future)
            given += len(some)
        return given

    def _check(self, future: Any, parts: Sequence[Any]) -> None:
        if future.cancelled():  # by nobody here
            raise AttitudeError(f"the cluster at {self._address} is lost")
        if future.status != "error":
            return
        error = future.exception()
        if isinstance(error, _distributed().scheduler.KilledWorker):
            what = f"{parts[0]}" if len(parts) == 1 else f"{len(parts)} parts from {parts[0]} on"
            raise AttitudeError(f"every worker died that computed {what} (out of memory?)") from None
        raise error

    @contextmanager
    def _lost(self) -> Iterator[None]:
        try:
            yield
        except (OSError, TimeoutError, CancelledError) as error:
            why = " ".join(str(error).split()) or type(error).__name__
            raise AttitudeError(f"the cluster at {self._address} is lost ({why})") from None


def _distributed() -> Any:
    return needed("distributed", "a cluster", "ensemble")


def _itself(work: Any) -> Any:
    return work


def _each(version: str, work: Any, parts: Sequence[Any]) -> list[Any]:
    """At a worker."""
    if __version__ != version:
        message = f"a worker has version {__version__} of this library, and the one who asks has {version}"
        raise AttitudeError(message)
    return [work(part) for part in parts]
