"""Archives: open one and compute irradiance from it."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _heliotile
from .askable import Askable
from .errors import InputError
from .given import number, percent, whole
from .options import MEMORY, Progress, Wanted, WantedArgs, wanted_args
from .weather import weather_request

if TYPE_CHECKING:
    from .checks import AuditReport, CheckedArchive, UpdateDone
    from .scene import BuildReport


class Archive(Askable):
    """A site that was traced once. Replay any weather, or query any sun and sky. Several threads
    may use one archive; it pickles by its path.

    `Archive.open("site.helio")` opens one, and so does `Archive("site.helio")`.
    """

    def __init__(
        self,
        handle: _heliotile.ArchiveHandle | str | os.PathLike[str],
        path: str | None = None,
        access: str = "map",
        grid_north: bool = False,
    ) -> None:
        if isinstance(handle, (str, os.PathLike)):
            path = os.fspath(handle)
            handle = _heliotile.ArchiveHandle.open(path, access, grid_north)
        if path is None:
            raise TypeError("Archive needs the path of an archive: Archive.open(\"site.helio\")")
        self._handle = handle
        self._known: dict[str, np.ndarray] | None = None
        self.path, self.access, self.grid_north = path, access, grid_north
        self.built: BuildReport | None = None
        """Report of the build, if `build` returned this archive."""
        self.updated: UpdateDone | None = None
        """Report of the update, if `update` returned this archive."""

    @classmethod
    def open(cls, path: str | os.PathLike[str], *, access: str = "map", grid_north: bool = False) -> Archive:
        """Opens a finished archive.

        `access` is `"map"`, or `"pread"` for files that other programs may shorten and for network
        file systems. `grid_north` uses y as north and ignores the true north of the archive.
        """
        path = os.fspath(path)
        return cls(_heliotile.ArchiveHandle.open(path, access, grid_north), path, access, grid_north)

    def __enter__(self) -> Archive:
        return self

    def __exit__(self, *_: object) -> None:
        """Does nothing: the file is closed with the last reference, and nothing has to be
        written."""

    @property
    def root(self) -> str:
        """Hash of the archive's content."""
        return self._handle.root

    def extract(
        self,
        output: str | os.PathLike[str],
        receivers: Wanted,
        *,
        with_scene: bool = True,
        memory: int = MEMORY,
        progress: Progress | None = None,
    ) -> Archive:
        """Writes an archive of some receivers, selected as in `replay`, and opens it: `heliotile
        extract`, byte by byte."""
        handle = self._handle.extract(os.fspath(output), wanted_args(receivers), with_scene, memory, progress)
        return Archive(handle, os.fspath(output))

    def audit(
        self,
        scene: Any,
        *,
        weather: Any = None,
        conditions: str | os.PathLike[str] | None = None,
        samples: int | None = None,
        hours: int | None = None,
        seconds: float | None = None,
        paths: int = 4096,
        seed: int = 1,
        sky: str = "perez",
        output: str | os.PathLike[str] | None = None,
        memory: int = MEMORY,
        progress: Progress | None = None,
    ) -> AuditReport:
        """Compares the archive's errors with its stated accuracy, by the independent reference path
        tracer: `heliotile audit`, value by value.

        Parameters
        ----------
        scene
            The `Scene` of the archive, or its files.
        weather, conditions
            A weather file, or a `Weather` of one, whose hours count; or the CSV file of a table of
            suns and skies, as `query` takes it. Default: suns from all sides.
        samples, hours
            Number of receivers, default 256, or as many as `seconds` allow; hours of each, default
            8, or all of a table of up to 64 conditions.
        seconds
            Time limit: no receiver is started after it.
        paths, seed
            Paths of light from each receiver; another seed takes other receivers, hours and paths.
        output
            A folder for `audit.csv`, pictures and a page.
        """
        from . import checks

        request = {
            "archive": self.path,
            "scene": checks.original_scene(scene),
            **weather_request(weather),
            "conditions": None if conditions is None else os.fspath(conditions),
            "samples": whole("samples", samples),
            "hours": whole("hours", hours),
            "seconds": number("seconds", seconds, "give seconds"),
            "paths": whole("paths", paths),
            "seed": whole("seed", seed),
            "sky": sky,
        }
        return checks.audit(request, output, memory, progress)

    def update(
        self,
        output: str | os.PathLike[str],
        *,
        add: Any = None,
        remove: Sequence[str] = (),
        move: Mapping[str, Sequence[float]] | None = None,
        height: Mapping[str, str] | None = None,
        material: Mapping[str, str] | None = None,
        materials: str | os.PathLike[str] | None = None,
        on: Sequence[str] = (),
        spacing: float | None = None,
        preview: float | str | None = None,
        fresh: bool = False,
        memory: int = MEMORY,
        progress: Progress | None = None,
    ) -> Archive:
        """Edits the scene that the archive holds and opens the archive of the edited scene:
        `heliotile update`, byte by byte. Its `updated` counts the receivers that were kept, moved or
        removed. Only what an edit can alter is traced again.

        Parameters
        ----------
        add
            A `Scene` or scene files whose objects are added, in the coordinates of the scene.
        remove
            Names of objects or buildings to remove.
        move
            Offset along x, y and z in metres, by object or building. Its receivers move with it.
        height
            Change of height, `"+3m"` or `"-3m"`, or new height, `"12m"`, by object or building. Its
            walls follow its roofs.
        material
            New material of the whole object or building, by its name; a material of the scene or of
            `materials`.
        materials
            A TOML file with the reflectances of added or changed materials.
        on, spacing
            Kinds of surfaces to cover with receivers where the scene is new or has another shape,
            and the distance between receivers in metres. Default: roofs, walls and windows, about
            as far apart as the archive's own receivers.
        preview
            Keeps what the edits can alter by less than this percentage of the light on open ground,
            in the mean over the sky. The archive is then marked as a preview; the same call without
            this argument completes it.
        fresh
            Discards an interrupted update at the output.
        """
        from . import checks
        from .scene import scene_request

        added = {"files": [], "frame": {}} if add is None else scene_request(add)
        request = {
            "before": self.path,
            "output": os.fspath(output),
            "edits": {
                "remove": [remove] if isinstance(remove, str) else list(remove),
                "moves": [{"object": name, "by_m": [number("move", one) for one in by]} for name, by in (move or {}).items()],
                "heights": [{"object": name, "height": text} for name, text in (height or {}).items()],
                "materials": [{"object": name, "material": other} for name, other in (material or {}).items()],
            },
            "add": added | ({} if materials is None else {"materials": os.fspath(materials)}),
            "cover": {"on": list(on)},
            "density": None if spacing is None else {"spacing": number("spacing", spacing)},
            "preview_percent": percent("preview", preview),
            "fresh": fresh,
        }
        path, done = checks.update(request, memory, progress)
        archive = Archive.open(path)
        archive.updated = done
        return archive

    def verify(self, *, deep: bool = False) -> CheckedArchive:
        """Checks every block: `heliotile verify`, finding by finding. `heliotile.verify` also takes
        a path that does not open."""
        from . import checks

        return checks.verify(self.path, deep=deep)[0]

    def export(
        self,
        output: str | os.PathLike[str],
        receiver: str | None = None,
        *,
        sun: tuple[float, float] | None = None,
        dni: float = 0.0,
        dhi: float = 0.0,
        panel: bool = False,
        sky: str = "perez",
        patches: int | None = None,
        bounces: int | None = None,
        weather: Any = None,
        latitude: float | None = None,
        memory: int = MEMORY,
    ) -> None:
        """Writes the layers of a receiver, as values (`.exr`) or as a picture (`.png`), or without
        a receiver a table of all view factors: `heliotile export`.

        `sun`: azimuth, clockwise from true north, and altitude in degrees, with `dni` and `dhi` in
        W/m2. Values include its light, a picture marks its position, and `panel` makes six pictures
        of its light paths. `weather`, a file or a `Weather` of one, or `latitude`: place of the
        sun's paths in a picture.
        """
        request = {
            "place": self.path,
            "access": self.access,
            "output": os.fspath(output),
            "receiver": receiver,
            "panel": panel,
            "sun": None if sun is None else [number("sun", one) for one in sun],
            "dni_w_m2": number("dni", dni),
            "dhi_w_m2": number("dhi", dhi),
            "sky": sky,
            "patches": whole("patches", patches),
            "bounces": whole("bounces", bounces),
            **weather_request(weather),
            "latitude_deg": number("latitude", latitude),
        }
        _heliotile.export(json.dumps(request), memory)

    def view(
        self, output: str | os.PathLike[str], *, with_: str | os.PathLike[str] | Archive | None = None, weather: Any = None, memory: int = MEMORY
    ) -> None:
        """Writes a page that shows the archive in a browser, also from a disk: `heliotile export
        --html`, byte by byte.

        The page contains an archive of up to 50 MB, and the weather, a file or a `Weather` of one,
        if given. For a larger archive it asks for the file. `with_` is an archive of the same site
        after a change: the page then shows before, after and the change.
        """
        after = with_.path if isinstance(with_, Archive) else None if with_ is None else os.fspath(with_)
        request = {"archive": self.path, "with": after, "access": self.access, "output": os.fspath(output), **weather_request(weather)}
        _heliotile.view(json.dumps(request), memory)

    def _open(self, wanted: WantedArgs) -> _heliotile.ArchiveHandle:
        return self._handle

    def _table(self, opened: _heliotile.ArchiveHandle, wanted: WantedArgs, memory: int) -> dict[str, np.ndarray]:
        # The table of all receivers is kept, since it is used often.
        if wanted is not None:
            return super()._table(opened, wanted, memory)
        if self._known is None:
            self._known = super()._table(opened, None, memory)
        return dict(self._known)

    def __reduce__(self) -> tuple[Any, ...]:
        return _reopen, (type(self), absolute(self.path), self.access, self.grid_north, self.root)

    def __repr__(self) -> str:
        return f"Archive({_heliotile.shown(self.path)!r}, {self.count} receivers in {self.tiles} tiles, root {self.root[:16]})"


def absolute(path: str) -> str:
    """Returns a path for processes in other folders; a name without a file here, such as a URL,
    stays as it is."""
    return os.path.abspath(path) if os.path.exists(path) else path


def _reopen(cls: type[Archive], path: str, access: str, grid_north: bool, root: str) -> Archive:
    """Opens the archive of a pickle, if it has not changed."""
    archive = cls.open(path, access=access, grid_north=grid_north)
    if archive.root != root:
        raise InputError(f"{_heliotile.shown(path)}: is another archive than the one that was pickled\n  to fix: open the archive again and pickle the new object")
    return archive
