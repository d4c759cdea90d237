"""Regions in parts: an atlas is a folder that `heliotile atlas partition` makes and whose parts are built one by one."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeAlias, Unpack

from . import _heliotile
from .archive import Archive, absolute
from .askable import Askable
from .errors import InputError, wrong
from .given import MEMORY, WantedArgs, asked, wanted_args
from .options import CatalogueOptions, Progress, Wanted

if TYPE_CHECKING:
    import xarray as xr

    from .checks import CheckedArchive

#: xmin, ymin, xmax, ymax in the coordinates of the scene files, metres; then zmin, zmax if heights
#: count.
Box: TypeAlias = Sequence[float]


@dataclass(frozen=True)
class AtlasPart:
    """A part of a region: a square whose receivers are in one archive."""

    name: str
    low: tuple[float, float]
    """South-west corner, metres."""
    high: tuple[float, float]
    state: str
    """`built`, `empty` (no receiver lies in it) or `missing`."""
    archive: str | None = field(repr=False)
    """Path or address of its archive, if it is built."""
    reach_m: float = field(repr=False)
    """Largest distance of its receivers beyond the square, metres: they stand off their
    surfaces."""


class Atlas(Askable):
    """A region in parts, used like one archive. Rows are those of the parts, one after the other,
    in the order of `parts()`. Parts are opened on demand; a selection of receivers by `bbox` opens
    only the parts that the box touches. An atlas pickles by its path.
    """

    def __init__(self, path: str | os.PathLike[str], grid_north: bool = False) -> None:
        self.path, self.grid_north = os.fspath(path), grid_north
        _heliotile.atlas_parts(self.path, (0.0, 0.0, 0.0, 0.0))

    @classmethod
    def open(cls, path: str | os.PathLike[str], *, grid_north: bool = False) -> Atlas:
        """Opens the atlas of a folder, or of an address such as `s3://bucket/atlas`. `grid_north`
        as in `Archive.open`."""
        return cls(path, grid_north)

    def catalogue(self, **options: Unpack[CatalogueOptions]) -> None:
        """Writes a static STAC catalogue of the built parts, with pictures and a page: `heliotile
        catalogue`."""
        _heliotile.catalogue(asked("Atlas.catalogue", CatalogueOptions, options, atlas=self.path).args())

    def parts(self, bbox: Box | None = None) -> list[AtlasPart]:
        """Returns the current parts by name, or only those that a box touches."""
        return [AtlasPart(*row) for row in _heliotile.atlas_parts(self.path, bbox)]

    def archives(self, bbox: Box | None = None) -> Iterator[tuple[AtlasPart, Archive]]:
        """Opens the parts that hold receivers, one after the other; a part that is not built is an
        error."""
        for part in self._built(bbox):
            if part.archive is not None:
                archive = Archive.open(part.archive, grid_north=self.grid_north)
                archive._handle.check_square(part.name, part.low, part.high, part.reach_m)
                yield part, archive

    def verify(self, *, deep: bool = False) -> list[CheckedArchive]:
        """Checks every block of the built archives: `heliotile archive verify`, finding by finding."""
        from . import checks

        return checks.verify(self.path, deep=deep)

    def _built(self, bbox: Box | None = None) -> list[AtlasPart]:
        """Returns the parts; one that is not built is an error."""
        parts = self.parts(bbox)
        missing = [part.name for part in parts if part.state == "missing"]
        if missing:
            what = f"{len(missing)} of its parts are not built yet: {', '.join(missing[:5])}"
            raise InputError(f"{_heliotile.shown(self.path)}: {what}\n  to fix: build them with Atlas.build(name) or heliotile.dask.build(atlas, client), or choose another bbox")
        return parts

    def build(
        self,
        part: str | int,
        *,
        threads: int | None = None,
        fresh: bool = False,
        memory: int = MEMORY,
        progress: Progress | None = None,
    ) -> AtlasPart:
        """Builds a part, by its name or number. A part that is built from the same inputs is kept,
        and an interrupted build goes on. At an address, a part is published when it is complete.

        `threads`: number of threads of the build; default: all cores. `fresh` replaces a build of
        other inputs. `memory`: memory for the work, bytes. `progress` is called now and then with
        the stage, the number of items done, and the number of all (None: unknown).
        """
        if part == "all":
            raise wrong("part", "`all` is not one part", "build one after the other (for part in atlas.parts(): atlas.build(part.name)), or use heliotile.dask.build(atlas, client)")
        _heliotile.build_part(self.path, str(part), fresh, threads, memory, progress)
        parts = self.parts()
        named = {known.name: known for known in parts}
        return named[str(part)] if str(part) in named else parts[int(part)]

    def _open(self, wanted: WantedArgs) -> _heliotile.ArchiveHandle:
        return _heliotile.ArchiveHandle.open_atlas(self.path, _box(wanted), self.grid_north)

    def _chosen(self, receivers: Wanted | None) -> list[tuple[AtlasPart, str, list[str] | None]]:
        """Returns the parts that hold selected receivers, their archives and the ids; None for all
        receivers."""
        wanted = wanted_args(receivers)
        opened = self._open(wanted)
        # Opening fails if a part is missing, so these are the open archives, in the same order.
        parts = [(part, part.archive) for part in self.parts(_box(wanted)) if part.archive is not None]
        ids = [None] * len(parts) if wanted is None else opened.chosen(wanted, MEMORY)
        return [(part, archive, some) for (part, archive), some in zip(parts, ids, strict=True) if some is None or some]

    def to_xarray(self, weather: Any, *, receivers: Wanted | None = None, **choices: Any) -> xr.Dataset:
        """Returns a Dataset of all parts, or of those that hold the `receivers`, with a chunk for
        each part. Replays run when values are read. Needs xarray and dask.

        Arguments are those of `xarray.open_dataset(..., engine="heliotile")`; receivers have a
        coordinate `part`.
        """
        import xarray as xr

        opened: list[xr.Dataset] = []
        for part, path, ids in self._chosen(receivers):
            archive: Any = Archive.open(path, grid_north=self.grid_north)
            one = xr.open_dataset(archive, engine="heliotile", weather=weather, chunks={}, **choices)
            one = one if ids is None else one.sel(receiver=ids)
            opened.append(one.chunk({"receiver": -1}).assign_coords(part=("receiver", [part.name] * one.sizes["receiver"])))
        return xr.concat(opened, dim="receiver", data_vars="all", coords="minimal", compat="override", join="override", combine_attrs="drop_conflicts")

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (absolute(self.path), self.grid_north)

    def __repr__(self) -> str:
        return f"Atlas({_heliotile.shown(self.path)!r})"


def _box(wanted: WantedArgs) -> list[float] | None:
    """Returns the box of a selection, if there is one; parts that it does not touch hold no
    selected receiver."""
    return wanted.get("bbox") if isinstance(wanted, dict) else None
