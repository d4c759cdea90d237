"""Archives as xarray Datasets: `xarray.open_dataset("site.helio", engine="heliotile",
weather="x.epw")`. A replay runs when values are read, and only for the tiles that hold the
receivers."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from xarray.backends import BackendArray, BackendEntrypoint
from xarray.core import indexing

from .archive import Archive
from .options import MEMORY, Follow, ReplayOptions, Wanted, light_args, replay_args, wanted_args
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

    description = "Archives of heliotile, replayed under weather when values are read"
    url = "https://docs.xarray.dev/en/stable/user-guide/io.html"

    def open_dataset(  # type: ignore[override]
        self,
        filename_or_obj: Any,
        *,
        drop_variables: str | Iterable[str] | None = None,
        weather: Any = None,
        every: str = "hour",
        columns: Sequence[str] | None = None,
        bands: Sequence[str | os.PathLike[str]] | str | None = None,
        reflectance: Mapping[str, Follow] | None = None,
        transmittance: Mapping[str, Follow] | None = None,
        snow: str | None = None,
        snow_reflectance: float = 0.6,
        temperature: Mapping[str, Follow] | None = None,
        sky: str | os.PathLike[str] = "perez",
        sky_scale: str | None = None,
        sky_white: float | None = None,
        clouds: str | os.PathLike[str] | None = None,
        image_top: float | None = None,
        patches: int | None = None,
        paths: str | Sequence[str] = "all",
        bounces: int | None = None,
        steps: int | None = None,
        stamp: str = "start",
        year: int | None = None,
        start: str | None = None,
        end: str | None = None,
        access: str = "map",
        grid_north: bool = False,
        receivers: Wanted | None = None,
        memory: int = MEMORY,
        cache_bytes: int = CACHE,
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
        # xarray reads the names of its options from the signature.
        options = ReplayOptions(
            columns=columns, bands=bands, reflectance=reflectance, transmittance=transmittance, sky=sky, sky_scale=sky_scale, sky_white=sky_white,
            clouds=clouds, image_top=image_top, patches=patches, paths=paths, bounces=bounces, memory=memory, every=every, stamp=stamp, year=year, start=start, end=end, steps=steps, snow=snow, snow_reflectance=snow_reflectance,
            temperature=temperature,
        )
        replay = LazyReplay(archive, light_args(options), replay_args(weather, options), cache_bytes)
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
        if receivers is None:
            return data
        [ids] = archive._handle.chosen(wanted_args(receivers), memory)
        return data if ids is None else data.sel(receiver=ids)

    def guess_can_open(self, filename_or_obj: Any) -> bool:
        """Returns True for the name of an archive."""
        return isinstance(filename_or_obj, (str, os.PathLike)) and os.fspath(filename_or_obj).endswith(".helio")
