"""Parallel map over the tasks of an ensemble: threads of this machine, or a running Dask cluster.

Results come as they are ready, in no certain order; what a task computes does not depend on where it runs.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import closing
from itertools import islice
from typing import Any, TypeVar

from ..errors import InputError, whole_number
from ..runtime.threads import processors
from ..stopping import Stop, stoppable
from .cluster import SCHEDULER_ADDRESS, TASKS_PER_THREAD, mapped_by_cluster

Task = TypeVar("Task")
Result = TypeVar("Result")


def check(scheduler: Any, workers: Any) -> None:
    """Raise InputError for a scheduler or a number of workers that `mapped` does not accept."""
    if scheduler is not None and not (isinstance(scheduler, str) and scheduler):
        raise InputError("scheduler", scheduler, SCHEDULER_ADDRESS)
    if workers is None:
        return
    if scheduler is not None:
        raise InputError("workers", workers, "no number of workers beside a scheduler, which has its own")
    whole_number(workers, "workers")


def mapped(
    work: Callable[[Task], Result],
    tasks: Sequence[Task],
    scheduler: str | None = None,
    workers: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> Generator[Result, None, None]:
    """Results of `work` for all tasks, in the order in which they are ready.

    Parameters
    ----------
    work : for a cluster it has to be picklable; it is sent there once
    scheduler : address of a running Dask cluster; None for threads of this machine
    workers : threads of this machine; by default as many as it has processors
    progress : called with the fraction of the tasks that are done

    A bounded number of tasks is submitted at any time, and no more until results are consumed: a caller that
    may leave before the end uses `contextlib.closing`.  An error of the work is raised at once.  A task
    whose worker process dies is computed again by another worker.

    Raises
    ------
    InputError : scheduler or workers are not accepted.
    FormatError : a scheduler is given, and the extra `ensemble` is not installed.
    AttitudeError : the cluster is lost, or the same task has killed several of its workers.
    """
    check(scheduler, workers)
    if not tasks:
        return
    if scheduler is None:
        results = _by_threads(work, tasks, workers or processors())
    else:
        results = mapped_by_cluster(work, tasks, scheduler)
    with closing(results):  # at once, and not when the traceback of an error is collected
        for done, result in enumerate(results, 1):
            yield result
            if progress is not None:
                progress(done / len(tasks))


def threads(scheduler: str | None, workers: int | None) -> int:
    """Return the number of threads to share work among; a guess for a cluster, whose workers come and go."""
    return 64 if scheduler is not None else workers or processors()


def _by_threads(
    work: Callable[[Task], Result], tasks: Sequence[Task], workers: int
) -> Generator[Result, None, None]:
    stop, remaining = Stop(), iter(tasks)

    def compute(task: Task) -> Result:
        with stoppable(stop):
            stop.check()
            return work(task)

    pool = ThreadPoolExecutor(workers, "attitude-ensemble")
    pending: set[Future[Result]] = set()
    done: set[Future[Result]] = set()
    try:
        while True:
            vacant = TASKS_PER_THREAD * workers - len(pending)
            pending |= {pool.submit(compute, task) for task in islice(remaining, vacant)}
            if not pending:
                return
            done, pending = wait(pending, return_when=FIRST_COMPLETED)
            while done:  # popped: a future holds its result
                yield done.pop().result()
    finally:
        stop.set()
        pool.shutdown(cancel_futures=True)
