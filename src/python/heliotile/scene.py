"""Scenes, and archives that are traced from them."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Unpack

from . import _heliotile
from .archive import Archive, absolute
from .given import asked
from .options import BuildOptions, CoverOptions, PlanOptions, SceneOptions

#: Options that are files: of materials, and rasters from which a city is read.
_FILES = ("materials", "dsm", "dem", "canopy", "landcover")


class Scene:
    """Geometry with its materials, read from files.

    Parameters
    ----------
    files
        One path or several, which become one scene, or a `site.toml` that lists them, as `heliotile
        build` takes them. Metres, x east, y north, z up.
    options
        Those of `heliotile.options.SceneOptions`: materials, place, heights of footprints, rasters.
        With `dsm` no other file is needed, nor with `dem` and `canopy`: ground with trees alone.
    """

    def __init__(self, files: str | os.PathLike[str] | Sequence[str | os.PathLike[str]] = (), **options: Unpack[SceneOptions]) -> None:
        listed = [files] if isinstance(files, (str, os.PathLike)) else files
        self.files = [os.fspath(file) for file in listed]
        self.options: dict[str, Any] = dict(options)
        self._handle = _heliotile.SceneHandle.load(asked("Scene", SceneOptions, self.options, scene=self.files).args())

    @property
    def triangles(self) -> int:
        """Number of triangles."""
        return self._handle.triangles

    @property
    def materials(self) -> dict[str, tuple[float, float]]:
        """Diffuse and specular reflectance by name, shares of the light."""
        return {name: (diffuse, specular) for name, diffuse, specular in self._handle.materials}

    @property
    def place(self) -> tuple[float, float] | None:
        """Latitude and longitude in degrees, if files or arguments state them."""
        return self._handle.place

    @property
    def notes(self) -> list[str]:
        """Assumptions of the reader about what the files do not state."""
        return self._handle.notes

    def cover(self, output: str | os.PathLike[str], **options: Unpack[CoverOptions]) -> str:
        """Covers surfaces with receivers and writes their table, which `build` takes: `heliotile
        receivers`, byte by byte. Returns a summary as text. The scene files are read again. The
        options are those of `heliotile.options.CoverOptions`.
        """
        said = {name: value for name, value in scene_options(self).items() if name != "grid_north"}
        keywords = asked("Scene.cover", CoverOptions, options, output=output, **said)
        return _heliotile.receivers(keywords.args(), options.get("progress"))

    def __reduce__(self) -> tuple[Any, ...]:
        whole = {name: absolute(os.fspath(self.options[name])) for name in _FILES if self.options.get(name) is not None}
        return _reload, (type(self), [absolute(file) for file in self.files], self.options | whole)

    def __repr__(self) -> str:
        files = self.files + [os.fspath(self.options[name]) for name in _FILES[1:] if self.options.get(name) is not None]
        return f"Scene({', '.join(files)}: {self.triangles} triangles)"


def scene_options(scene: Any) -> dict[str, Any]:
    """Returns the keywords of a `Scene`, or of its files."""
    if isinstance(scene, Scene):
        return {"scene": scene.files, **scene.options}
    files = [scene] if isinstance(scene, (str, os.PathLike)) else scene
    return {"scene": [os.fspath(file) for file in files]}


def _reload(cls: type[Scene], files: list[str], options: dict[str, Any]) -> Scene:
    """Reads the scene of a pickle again from its files."""
    return cls(files, **options)


@dataclass(frozen=True)
class BuildReport:
    """Report of a build."""

    seconds: dict[str, float]
    """Seconds by stage."""
    rays: int
    bytes: int
    """Length of the archive."""
    error_percent: float | None
    """RMSE of hourly totals on a sample of the receivers, in percent of their mean; None unless
    `error` was given."""


def build(
    scene: Scene | str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    receivers: Any,
    output: str | os.PathLike[str],
    **options: Unpack[BuildOptions],
) -> Archive:
    """Traces every receiver once and writes the archive: `heliotile build`, byte by byte.

    Parameters
    ----------
    scene
        A `Scene`, or the files of one.
    receivers
        Path of a CSV file, a DataFrame or a mapping of arrays: `receiver` (id), `x, y, z` in
        metres, `tilt_deg, azimuth_deg` (from true north) or `nx, ny, nz`, and optionally `area_m2`,
        `surface` and others on the book's page on receivers.
    output
        Path of the archive. An older archive at this path is replaced; any other file is an error.
    options
        Those of `heliotile.options.BuildOptions`. Without `fresh`, a build of the same inputs goes
        on: Ctrl-C, and the same call again.
    """
    if not isinstance(scene, Scene):
        scene = Scene(scene)
    keywords = asked("build", BuildOptions, options, output=output, **scene_options(scene)).receivers(receivers)
    handle, seconds, rays, length, found = scene._handle.build(keywords.args(), options.get("progress"))
    archive = Archive(handle, os.fspath(output))
    archive.built = BuildReport(dict(seconds), rays, length, found)
    return archive


@dataclass(frozen=True)
class Plan:
    """Forecast of a build."""

    receivers: int
    """Number of receivers."""
    text: str
    """Rays and seconds of each light path, and with `weather` the light that each adds."""


def plan(scene: Scene | str | os.PathLike[str] | Sequence[str | os.PathLike[str]], receivers: Any, **options: Unpack[PlanOptions]) -> Plan:
    """Forecasts the rays and seconds of a build: `heliotile build --dry-run`. Arguments are those of `build`,
    options those of `heliotile.options.PlanOptions`."""
    keywords = asked("plan", PlanOptions, options, dry_run=True, **scene_options(scene)).receivers(receivers)
    return Plan(*_heliotile.plan(keywords.args(), options.get("progress")))
