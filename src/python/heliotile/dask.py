"""Atlases on clusters: Dask's workers build and replay the parts. Workers need the scene files
under the same paths. They also need the folder of the atlas, unless it is at an address. Only names
and arguments are sent."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from .archive import Archive, absolute
from .given import FOLLOWED, MEMORY
from .options import Wanted
from .atlas import Atlas
from .workers import share_threads

if TYPE_CHECKING:
    import dask.dataframe as dd
    import pandas as pd
    from distributed import Client


def build(atlas: Atlas | str, client: Client, *, parts: Sequence[str] | None = None, threads: int = 1, retries: int = 3) -> list[str]:
    """Builds the missing parts, or the named ones, and waits for them. Returns the names of the
    parts.

    A build runs within the worker on `threads` threads of its own, and a worker runs as many builds
    at once as it has threads. With the default of 1 they fill its cores. Builds share half of the
    worker's memory limit. Their stages are events of Dask with the topic `heliotile`. A build whose
    worker is lost is tried again elsewhere, and goes on where that one stopped. A build that fails,
    or that Dask gives up because too many workers were lost, is tried again up to `retries` times.
    A part gets its archive only when it is complete, so no part is built twice or by half.
    """
    from distributed import KilledWorker, wait

    atlas = atlas if isinstance(atlas, Atlas) else Atlas.open(atlas)
    wanted = [part.name for part in atlas.parts() if part.state == "missing"] if parts is None else list(parts)
    left = wanted
    for turn in range(retries + 1):
        # Not pure: a part that was removed is built again.
        futures = dict(zip(left, client.map(_build, left, atlas=absolute(atlas.path), threads=threads, retries=retries, pure=False), strict=True))
        wait(list(futures.values()))
        left = [name for name, future in futures.items() if isinstance(future.exception(), KilledWorker)]
        # Other errors are raised here; after the last turn, those of the builds that were given up,
        # too.
        client.gather([future for name, future in futures.items() if turn == retries or name not in left])
        if not left:
            break
    return wanted


def replay(atlas: Atlas | str, weather: Any, *, receivers: Wanted | None = None, **choices: Any) -> dd.DataFrame:
    """Returns the rows of `Atlas.replay(...).to_pandas()` as a Dask DataFrame, with a partition for
    each part that holds some of the `receivers`. Replays run when rows are computed."""
    import dask.dataframe as dd

    atlas = atlas if isinstance(atlas, Atlas) else Atlas.open(atlas)
    chosen = [(absolute(archive), ids) for _, archive, ids in atlas._chosen(receivers)]
    weather = absolute(os.fspath(weather)) if isinstance(weather, (str, os.PathLike)) else weather
    follow = {name: choices[name] for name in FOLLOWED if isinstance(choices.get(name), Mapping)}
    whole = {name: {of: absolute(os.fspath(v)) if isinstance(v, (str, os.PathLike)) else v for of, v in pairs.items()} for name, pairs in follow.items()}
    choices = choices | whole
    first, ids = chosen[0]
    some = ids or Archive.open(first).receivers()["receiver"].tolist()
    meta = _rows((first, some[:1]), weather, choices, atlas.grid_north).iloc[:0]
    return dd.from_map(_rows, chosen, weather=weather, choices=choices, grid_north=atlas.grid_north, meta=meta)


def _build(part: str, atlas: str, threads: int) -> str:
    """Builds a part in a task of a worker."""
    from distributed import get_worker

    worker = get_worker()
    limit = worker.memory_manager.memory_limit
    memory = MEMORY if limit is None else min(MEMORY, limit * threads // (2 * worker.state.nthreads))
    stages: set[str] = set()

    def tell(stage: str, done: int, items: int | None) -> None:
        if stage not in stages:
            stages.add(stage)
            worker.log_event("heliotile", {"part": part, "stage": stage, "items": items})

    return Atlas.open(atlas).build(part, threads=threads, memory=memory, progress=tell).name


def _rows(chosen: tuple[str, list[str] | None], weather: Any, choices: dict[str, Any], grid_north: bool) -> pd.DataFrame:
    share_threads()
    archive, ids = chosen
    rows = Archive.open(archive, grid_north=grid_north).replay(weather, receivers=ids, **choices).to_pandas()
    # Parts have different categories.
    return rows.astype({"receiver": str})
