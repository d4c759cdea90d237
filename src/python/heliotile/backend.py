"""Archives as xarray Datasets: `xarray.open_dataset("site.helio", engine="heliotile",
weather="x.epw")`. A replay runs when values are read, and only for the tiles that hold the
receivers."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Any, Unpack

import numpy as np
import xarray as xr
from xarray.backends import BackendArray, BackendEntrypoint
from xarray.core import indexing

from .archive import Archive
from .given import MEMORY, asked, wanted_of
from .options import ReplayOptions
from .lazy import LazyReplay

#: Number of receivers of a tile, which is computed as a whole.
TILE = 64

#: Bytes of tiles that are kept, so that the columns of a receiver are computed once.
CACHE = 512 << 20


class LazyColumn(BackendArray):
    """A column of a replay, shape (receivers, labels)."""

    def __init__(self, replay: LazyReplay, column: str, shape: tuple[int, int]) -> None:
        self.replay, self.column, self.shape = replay, column, shape
        self.dtype = np.dtype(np.float32)

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.OUTER, self._outer)

    def _outer(self, key: tuple[Any, ...]) -> np.ndarray:
        receivers, labels = key
        rows = np.atleast_1d(np.arange(self.shape[0])[receivers])
        columns = slice(labels, labels + 1) if isinstance(labels, (int, np.integer)) and labels >= 0 else labels
        if isinstance(labels, (int, np.integer)) and labels < 0:
            columns = [int(labels)]
        values = self.replay.rows(self.column, rows, columns)
        if isinstance(labels, (int, np.integer)):
            values = values[:, 0]
        return values[0] if isinstance(receivers, (int, np.integer)) else values


class HeliotileBackend(BackendEntrypoint):
    """Opens `.helio` archives under weather."""

    # xarray reads names of options from a signature, and the options of a replay are keywords.
    open_dataset_parameters = ("filename_or_obj", "drop_variables", "weather", "access", "grid_north", "cache_bytes", *sorted(ReplayOptions.__optional_keys__))
    description = "Archives of heliotile, replayed under weather when values are read"
    url = "https://docs.xarray.dev/en/stable/user-guide/io.html"

    def open_dataset(  # type: ignore[override]
        self,
        filename_or_obj: Any,
        *,
        drop_variables: str | Iterable[str] | None = None,
        weather: Any = None,
        access: str = "map",
        grid_north: bool = False,
        cache_bytes: int = CACHE,
        **options: Unpack[ReplayOptions],
    ) -> xr.Dataset:
        """A Dataset with the dimensions `receiver` and `time`; arguments are those of `Archive.replay`.

        A tile of 64 receivers is computed when the first of them is read, with all columns of the
        Dataset. The last `cache_bytes` of tiles are kept. So name the `columns` that you need.
        """
        if weather is None:
            raise TypeError('give weather: xarray.open_dataset(path, engine="heliotile", weather="x.epw")')
        archive = filename_or_obj
        if not isinstance(archive, Archive):
            archive = Archive.open(filename_or_obj, access=access, grid_north=grid_north)
        keywords = asked("Archive.replay", ReplayOptions, options, weather=weather)
        replay = LazyReplay(archive, keywords, cache_bytes)
        frame = replay.frame
        shape = (frame.receivers, len(frame.labels))
        dims = ("receiver", frame.label)
        dropped = {drop_variables} if isinstance(drop_variables, str) else set(drop_variables or ())
        encoding = {"preferred_chunks": {"receiver": TILE, frame.label: shape[1]}}
        variables = {
            column: xr.Variable(
                dims, indexing.LazilyIndexedArray(LazyColumn(replay, column, shape)), frame.attributes(column), encoding
            )
            for column in frame.columns
            if column not in dropped
        }
        coordinates = {k: v for k, v in frame.coordinates(archive.receivers()).items() if k not in dropped}
        data = xr.Dataset(variables, coordinates, frame.provenance)
        if (wanted := wanted_of(options)) is None:
            return data
        [ids] = archive._handle.chosen(wanted, MEMORY)
        return data if ids is None else data.sel(receiver=ids)

    def guess_can_open(self, filename_or_obj: Any) -> bool:
        """Returns True for the name of an archive."""
        return isinstance(filename_or_obj, (str, os.PathLike)) and os.fspath(filename_or_obj).endswith(".helio")
