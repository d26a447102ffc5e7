"""Parallel map over tasks by a running Dask cluster."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import CancelledError, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from itertools import chain
from typing import Any, TypeVar
from uuid import uuid4

from ..errors import AttitudeError, InputError, one_line
from ..runtime.optional_imports import needed
from ..version import __version__

Task = TypeVar("Task")
Result = TypeVar("Result")

SCHEDULER_ADDRESS = "the address of a running Dask cluster, such as tcp://10.0.0.1:8786"
TASKS_PER_THREAD = 2  # submitted at a time: one that runs, and one that waits for it
CONNECT_TIMEOUT = "10 s"  # of the scheduler, and until it has a worker


def mapped_by_cluster(
    work: Callable[[Task], Result], tasks: Sequence[Task], address: str
) -> Generator[Result, None, None]:
    """Results of `work` for all tasks, in the order in which they are ready.

    Raises
    ------
    InputError : no scheduler answers at the address, or it has no workers.
    FormatError : the extra `ensemble` is not installed.
    AttitudeError : the cluster is lost, or the same task has killed several of its workers.
    """
    client = _client(address)
    try:
        yield from _ClusterMap(client, work, address).results(tasks)
    finally:
        client.close(timeout=5)


def _client(address: str) -> Any:
    """Return a client of a cluster that has workers."""
    try:
        # a Client whose scheduler does not answer leaves threads behind that retry for ever
        with ThreadPoolExecutor(1) as pool:  # this thread may run an event loop, as in a notebook
            pool.submit(asyncio.run, probe(address)).result()
        client = _distributed().Client(address, timeout=CONNECT_TIMEOUT, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise InputError("scheduler", address, f"{SCHEDULER_ADDRESS} ({one_line(error)})") from None
    try:
        client.wait_for_workers(1, timeout=CONNECT_TIMEOUT)
    except TimeoutError:
        client.close(timeout=5)
        expected = f"a cluster with workers: none came in {CONNECT_TIMEOUT}"
        raise InputError("scheduler", address, expected) from None
    return client


async def probe(address: str) -> None:
    """Raise OSError or ValueError unless something listens at the address."""
    connect = needed("distributed.comm", "a cluster", "ensemble").connect
    security = _distributed().Security().get_connection_args("client")
    (await connect(address, timeout=CONNECT_TIMEOUT, **security)).abort()


class _ClusterMap:
    """Tasks that are submitted to a cluster, and the work that they share.

    The work itself is a task too, whose result all others take: it is sent once and passed on from worker
    to worker.  Unlike scattered data, it is made again when every worker that held it is dead.
    """

    def __init__(self, client: Any, work: Any, address: str):
        import dask

        self._client, self._address = client, address
        self._name = f"attitude-{uuid4().hex}"
        with dask.config.set({"distributed.admin.large-graph-warning-threshold": "1 TiB"}):  # sent only once
            self._work = client.submit(lambda work: work, work, key=f"{self._name}-work", pure=False)
        self._pending: dict[Any, Sequence[Any]] = {}  # batches of tasks by their futures
        self._completed = _distributed().as_completed(loop=client.loop)

    def results(self, tasks: Sequence[Any]) -> Iterator[Any]:
        submitted = 0
        try:
            submitted = self._submit(tasks, submitted)
            for futures in self._completed.batches():
                for future in futures:
                    self._check(future, self._pending.pop(future))
                submitted = self._submit(tasks, submitted)  # before results are consumed: no worker idles
                with self._loss_named():
                    results = self._client.gather(futures)
                yield from chain.from_iterable(results)
        finally:
            with suppress(OSError, TimeoutError):  # of a cluster that is lost
                self._client.cancel([*self._pending, self._work], force=True)

    def _submit(self, tasks: Sequence[Any], submitted: int) -> int:
        """Submit what keeps the present workers busy; returns how many tasks are submitted then.

        A submission costs scheduler and client some milliseconds, whatever it computes.  So it is a batch of
        tasks: a fourth of the remaining ones, divided by the threads, so that all finish together.
        """
        with self._loss_named():
            threads = max(1, sum(self._client.nthreads().values()))
        while submitted < len(tasks) and len(self._pending) < TASKS_PER_THREAD * threads:
            share = (len(tasks) - submitted) // (4 * threads)
            batch = tasks[submitted : submitted + min(max(share, 1), 16)]
            key = f"{self._name}-{submitted}"
            future = self._client.submit(_compute, __version__, self._work, batch, key=key, pure=False)
            self._pending[future] = batch
            self._completed.add(future)
            submitted += len(batch)
        return submitted

    def _check(self, future: Any, batch: Sequence[Any]) -> None:
        if future.cancelled():  # by the scheduler's end: nothing here cancels before the results are complete
            raise AttitudeError(f"the cluster at {self._address} is lost")
        if future.status != "error":
            return
        error = future.exception()
        if isinstance(error, _distributed().scheduler.KilledWorker):
            tasks = f"{batch[0]}" if len(batch) == 1 else f"{len(batch)} parts from {batch[0]} on"
            raise AttitudeError(f"every worker died that computed {tasks} (out of memory?)") from None
        raise error

    @contextmanager
    def _loss_named(self) -> Iterator[None]:
        try:
            yield
        except (OSError, TimeoutError, CancelledError) as error:
            raise AttitudeError(f"the cluster at {self._address} is lost ({one_line(error)})") from None


def _distributed() -> Any:
    return needed("distributed", "a cluster", "ensemble")


def _compute(version: str, work: Any, batch: Sequence[Any]) -> list[Any]:
    """Return the results of a batch; runs at a worker."""
    if __version__ != version:
        raise AttitudeError(f"a worker has version {__version__} of this library, and its client {version}")
    return [work(task) for task in batch]
