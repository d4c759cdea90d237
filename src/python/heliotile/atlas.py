"""Regions in parts: an atlas is a folder that `heliotile partition` makes and whose parts are built one by one."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from . import _heliotile
from .archive import Archive
from .errors import Error, InputError

if TYPE_CHECKING:
    import xarray as xr

    from .results import Results

#: xmin, ymin, xmax, ymax in the coordinates of the scene files, metres.
Box = tuple[float, float, float, float]


@dataclass(frozen=True)
class AtlasPart:
    """A part of a region: a square whose receivers are in one archive."""

    name: str
    low: tuple[float, float]
    """South-west corner, metres."""
    high: tuple[float, float]
    state: str
    """`built`, `empty` (no receiver lies in it) or `missing`."""
    archive: str | None
    """Path or address of its archive, if it is built."""


class Atlas:
    """A region in parts. Nothing is opened before it is asked for; it pickles by its path."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = os.fspath(path)
        _heliotile.atlas_parts(self.path, (0.0, 0.0, 0.0, 0.0))

    @classmethod
    def open(cls, path: str | os.PathLike[str]) -> Atlas:
        """The atlas of a folder, or of an address such as `s3://bucket/atlas`."""
        return cls(path)

    def parts(self, bbox: Box | None = None) -> list[AtlasPart]:
        """Its parts by name, those that a box touches if there is one, as they are now."""
        return [AtlasPart(*row) for row in _heliotile.atlas_parts(self.path, bbox)]

    def archives(self, bbox: Box | None = None) -> Iterator[tuple[AtlasPart, Archive]]:
        """Parts that hold receivers, opened one after the other; one that is not built is an error."""
        parts = self.parts(bbox)
        missing = [part.name for part in parts if part.state == "missing"]
        if missing:
            what = f"{len(missing)} of its parts are not built yet: {', '.join(missing[:5])}"
            raise InputError(f"{_heliotile.shown(self.path)}: {what}\n  to fix: Atlas.build(name), heliotile.dask.build(atlas, client), or another bbox")
        for part in parts:
            if part.archive is not None:
                yield part, Archive.open(part.archive)

    def build(self, part: str, *, threads: int | None = None, fresh: bool = False) -> AtlasPart:
        """Builds a part, by its name, in a process of its own; one that is there and fits is kept. Below an address, it is published when it is whole.

        `threads` are those of the build (all cores without it). `fresh` replaces what is there of other inputs.
        """
        words = [sys.executable, "-m", "heliotile", "build", self.path, "--part", part, "--quiet"]
        words += ["--threads", str(threads)] if threads else []
        words += ["--fresh"] if fresh else []
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        if done.returncode:
            raise Error(done.stderr.strip().removeprefix("heliotile: ") or f"the build of {part} ended with {done.returncode}")
        return next(known for known in self.parts() if known.name == part)

    def replay(self, weather: Any, *, bbox: Box | None = None, **choices: Any) -> Iterator[tuple[AtlasPart, Results]]:
        """Results part by part; arguments are those of `Archive.replay`. With `bbox` only receivers of parts that it touches."""
        for part, archive in self.archives(bbox):
            yield part, archive.replay(weather, **choices)

    def to_xarray(self, weather: Any, *, bbox: Box | None = None, **choices: Any) -> xr.Dataset:
        """One Dataset of all parts, a chunk each: nothing is replayed before values are asked for. Needs xarray and dask.

        Arguments are those of `xarray.open_dataset(..., engine="heliotile")`; receivers have a coordinate `part`.
        """
        import xarray as xr

        opened: list[xr.Dataset] = []
        for part, archive in self.archives(bbox):
            one = xr.open_dataset(archive, engine="heliotile", weather=weather, chunks={}, **choices)  # type: ignore[arg-type]
            opened.append(one.chunk({"receiver": -1}).assign_coords(part=("receiver", [part.name] * one.sizes["receiver"])))
        if not opened:
            raise InputError(f"{_heliotile.shown(self.path)}: no part holds a receiver there\n  to fix: bbox is in the coordinates of the scene files")
        return xr.concat(opened, dim="receiver", data_vars="all", coords="minimal", compat="override", join="override", combine_attrs="drop_conflicts")

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.path,)

    def __repr__(self) -> str:
        parts = self.parts()
        built = sum(part.state == "built" for part in parts)
        return f"Atlas({_heliotile.shown(self.path)!r}, {len(parts)} parts, {built} built)"
