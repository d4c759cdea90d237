"""Threads of processes that are Dask workers. In: a task that runs. Out: work on as many threads as
the worker has."""

import sys

from . import _heliotile


def share_threads() -> None:
    """Makes replays in a Dask worker run on its threads, shared by all of its tasks. Does nothing
    elsewhere.

    Otherwise each process would use all cores of its machine, also those of other workers.
    """
    if (distributed := sys.modules.get("distributed")) is None:
        return
    try:
        worker = distributed.get_worker()
    except ValueError:
        return
    _heliotile.use_threads(worker.state.nthreads)
