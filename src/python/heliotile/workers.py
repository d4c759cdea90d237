"""Threads of processes that are workers of Dask. In: a task that runs. Out: work that runs on as many threads as its worker has."""

import sys

from . import _heliotile


def share_threads() -> None:
    """On a worker of Dask, makes replays run on its threads, all of its tasks together; elsewhere does nothing.

    Without it each process would take all cores of its machine: those of other workers, too.
    """
    if (distributed := sys.modules.get("distributed")) is None:
        return
    try:
        worker = distributed.get_worker()
    except ValueError:
        return
    _heliotile.use_threads(worker.state.nthreads)
