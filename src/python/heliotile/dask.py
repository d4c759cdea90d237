"""Atlases on clusters: parts built and replayed by the workers of Dask. Workers need the scene files under the same paths, and the folder of the
atlas, unless it lies at an address; nothing but names and arguments is sent."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from . import given
from .archive import Archive, absolute
from .options import Wanted
from .atlas import Atlas
from .workers import share_threads

if TYPE_CHECKING:
    import dask.dataframe as dd
    import pandas as pd
    from distributed import Client


def build(atlas: Atlas | str, client: Client, *, parts: Sequence[str] | None = None, threads: int = 1, retries: int = 3) -> list[str]:
    """Builds the parts that are missing, or those that are named, and waits for them. Names of what was built.

    A build runs in a process of its own with so many `threads`, and a worker runs as many builds at once as it has threads: with 1, the default,
    they fill its cores. One whose worker is lost is tried again elsewhere, one that fails up to `retries` times, and so is one that Dask gives up
    because too many workers were lost around it. A part has its archive when it is whole, so nothing is there twice or half.
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
        # What else failed is raised here; what was given up as well, in the end.
        client.gather([future for name, future in futures.items() if turn == retries or name not in left])
        if not left:
            break
    return wanted


def replay(atlas: Atlas | str, weather: Any, *, receivers: Wanted | None = None, **choices: Any) -> dd.DataFrame:
    """Rows of `Atlas.replay(...).to_pandas()` as a Dask DataFrame with a partition for each part that holds some of the `receivers`. Nothing is
    replayed before it is computed."""
    import dask.dataframe as dd

    atlas = atlas if isinstance(atlas, Atlas) else Atlas.open(atlas)
    chosen = [(absolute(archive), ids) for _, archive, ids in atlas._chosen(receivers)]
    weather = absolute(os.fspath(weather)) if isinstance(weather, (str, os.PathLike)) else weather
    follow = {name: given.named(name, choices[name], "say of what") for name in ("reflectance", "transmittance", "temperature") if choices.get(name)}
    whole = {name: {of: absolute(os.fspath(v)) if isinstance(v, (str, os.PathLike)) else v for of, v in pairs.items()} for name, pairs in follow.items()}
    choices = choices | whole
    first, ids = chosen[0]
    some = ids or Archive.open(first).receivers()["receiver"].tolist()
    meta = _rows((first, some[:1]), weather, choices, atlas.grid_north).iloc[:0]
    return dd.from_map(_rows, chosen, weather=weather, choices=choices, grid_north=atlas.grid_north, meta=meta)


def _build(part: str, atlas: str, threads: int) -> str:
    return Atlas.open(atlas).build(part, threads=threads).name


def _rows(chosen: tuple[str, list[str] | None], weather: Any, choices: dict[str, Any], grid_north: bool) -> pd.DataFrame:
    share_threads()
    archive, ids = chosen
    rows = Archive.open(archive, grid_north=grid_north).replay(weather, receivers=ids, **choices).to_pandas()
    # Categories of one part are not those of another.
    return rows.astype({"receiver": str})
