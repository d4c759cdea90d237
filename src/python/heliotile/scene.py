"""Scenes, and archives that are traced from them."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import _heliotile, given
from .archive import Archive, absolute
from .options import MEMORY, Progress
from .tables import columns_of, csv_of
from .weather import Weather


#: Rasters from which a city is read.
_RASTERS = ("dsm", "dem", "canopy", "landcover")


class Scene:
    """Geometry with its materials, read from files.

    Parameters
    ----------
    files
        One path or several, which become one scene, or a `site.toml` that lists them, as `heliotile
        build` takes them. Metres, x east, y north, z up.
    materials
        A `materials.toml`: reflectances by name; they replace those of the files.
    materials_only
        True to ignore the materials of the files.
    ground
        True to put a plane below a scene without ground.
    crs, latitude, longitude
        EPSG number of the coordinates, or degrees, north and east positive; each replaces that of
        the files.
    rotate_deg, elevation, scale
        Direction of y clockwise from north, degrees; height of z = 0 above the sea, metres; metres
        per unit.
    grid_north
        Azimuths in tables of points count from the y axis, in place of true north.
    up
        The axis that points up in OBJ, PLY and STL files: `"z"`, with y to the north, or `"y"`, with z to the south.
    height, storey_height, base, height_above
        Heights of footprints: a column of heights above the base, metres for all, or several
        sources, of which the first with a value counts. Metres per storey. Base of buildings: a
        column, or metres. `height_above="sea"` for columns of absolute heights of roofs, from which
        the terrain or `base` is taken.
    layer
        Layers to read of a GeoPackage with several: one name, or a list; default: those of
        buildings.
    dsm, dem, canopy, landcover
        Rasters from which a city is read (GeoTIFF, Esri ASCII grid): heights of the surface and of
        the ground above the sea, heights of crowns above the ground, codes of land cover. With
        `dsm` no other file is needed, nor with `dem` and `canopy`: ground with trees alone.
    """

    def __init__(
        self,
        files: str | os.PathLike[str] | Sequence[str | os.PathLike[str]] = (),
        *,
        materials: str | os.PathLike[str] | None = None,
        materials_only: bool = False,
        ground: bool = True,
        crs: int | str | None = None,
        latitude: float | None = None,
        longitude: float | None = None,
        rotate_deg: float | None = None,
        grid_north: bool = False,
        elevation: float | None = None,
        scale: float | None = None,
        up: str | None = None,
        height: str | float | Sequence[str | float] = (),
        storey_height: float | None = None,
        base: str | float | None = None,
        height_above: str | None = None,
        layer: str | Sequence[str] = (),
        dsm: str | os.PathLike[str] | None = None,
        dem: str | os.PathLike[str] | None = None,
        canopy: str | os.PathLike[str] | None = None,
        landcover: str | os.PathLike[str] | None = None,
    ) -> None:
        listed = [files] if isinstance(files, (str, os.PathLike)) else files
        self.files = [os.fspath(file) for file in listed]
        self._args: dict[str, Any] = {
            "files": self.files,
            "materials": None if materials is None else os.fspath(materials),
            "materials_only": materials_only,
            "assume_ground": ground,
            "crs": given.epsg(crs),
            "latitude": given.number("latitude", latitude, "give degrees, north positive"),
            "longitude": given.number("longitude", longitude, "give degrees, east positive"),
            "rotate_deg": given.number("rotate_deg", rotate_deg),
            "grid_north": grid_north,
            "elevation": given.number("elevation", elevation),
            "scale": given.number("scale", scale),
            "up": up,
            "height": [str(source) for source in ([height] if isinstance(height, (str, float, int)) else height)],
            "storey_height": given.number("storey_height", storey_height, "give metres"),
            "base": None if base is None else str(base),
            "height_above": height_above,
            "layer": [layer] if isinstance(layer, str) else list(layer),
        }
        rasters = {"dsm": dsm, "dem": dem, "canopy": canopy, "landcover": landcover}
        self._args |= {name: None if path is None else os.fspath(path) for name, path in rasters.items()}
        self._handle = _heliotile.SceneHandle.load(self._args)

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

    def cover(
        self,
        output: str | os.PathLike[str],
        *,
        on: Sequence[str] = (),
        types: Sequence[str] = (),
        spacing: float = 2.0,
        per_surface: int | None = None,
        offset: float = 0.02,
        min_area: float = 0.1,
        progress: Progress | None = None,
    ) -> str:
        """Covers surfaces with receivers and writes their table, which `build` takes: `heliotile
        receivers`, byte by byte.

        `on`: some of `"roof", "wall", "window", "ground", "floor", "shade"`, `"all"`, or names of
        materials; default: roofs, walls and windows of buildings. `types`: types of objects of a
        city model. `spacing` and `offset` off the surface in metres, `min_area` in m2;
        `per_surface`: number of receivers on each surface. Returns a summary as text. The scene
        files are read again.
        """
        args = {
            "on": [on] if isinstance(on, str) else list(on),
            "types": [types] if isinstance(types, str) else list(types),
            "spacing": given.number("spacing", spacing, "give metres"),
            "per_surface": given.whole("per_surface", per_surface),
            "offset": given.number("offset", offset, "give metres"),
            "min_area": given.number("min_area", min_area, "give m2"),
        }
        return self._handle.cover(os.fspath(output), args, progress)[1]

    def request(self) -> dict[str, Any]:
        """Returns the scene for a request."""
        frame = {"crs": "epsg", "latitude": "latitude_deg", "longitude": "longitude_deg", "rotate_deg": "rotate_deg", "elevation": "elevation_m"}
        frame |= {"scale": "scale", "up": "up", "grid_north": "grid_north"}
        said = {key: self._args[name] for name, key in frame.items() if self._args[name] not in (None, False)}
        request = {"files": self.files, "materials_only": self._args["materials_only"], "no_ground": not self._args["assume_ground"], "frame": said}
        footprints = {"height": self._args["height"], "storey_height_m": self._args["storey_height"], "base": self._args["base"]}
        footprints |= {"height_above": self._args["height_above"], "layer": self._args["layer"]}
        footprints = {name: value for name, value in footprints.items() if value not in (None, [])}
        request |= {"footprints": footprints} if footprints else {}
        request |= {} if self._args["materials"] is None else {"materials": self._args["materials"]}
        rasters = {name: self._args[name] for name in _RASTERS if self._args[name] is not None}
        return request | ({"surface": rasters} if rasters else {})

    def __reduce__(self) -> tuple[Any, ...]:
        whole = {"files": [absolute(file) for file in self.files], "materials": self._args["materials"] and absolute(self._args["materials"])}
        whole |= {name: self._args[name] and absolute(self._args[name]) for name in _RASTERS}
        return _reload, (type(self), self._args | whole)

    def __repr__(self) -> str:
        files = self.files + [self._args[name] for name in _RASTERS if self._args[name] is not None]
        return f"Scene({', '.join(files)}: {self.triangles} triangles)"


def scene_request(scene: Any) -> dict[str, Any]:
    """Returns a `Scene`, or its files, for a request."""
    if isinstance(scene, Scene):
        return scene.request()
    files = [scene] if isinstance(scene, (str, os.PathLike)) else scene
    return {"files": [os.fspath(file) for file in files], "frame": {}}


def _reload(cls: type[Scene], args: dict[str, Any]) -> Scene:
    """Reads the scene of a pickle again from its files."""
    args = dict(args)
    return cls(args.pop("files"), ground=args.pop("assume_ground"), **args)


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
    *,
    quality: str = "standard",
    error: float | str | None = None,
    error_weather: Any = None,
    settings: Mapping[str, object] | None = None,
    effects: str = "auto",
    with_scene: bool = True,
    before: str | os.PathLike[str] | None = None,
    preview: float | str | None = None,
    fresh: bool = False,
    checkpoint: float = 30.0,
    memory: int = MEMORY,
    progress: Progress | None = None,
) -> Archive:
    """Traces every receiver once and writes the archive: `heliotile build`, byte by byte.

    Parameters
    ----------
    scene
        A `Scene`, or the files of one.
    receivers
        Path of a CSV file, a DataFrame or a mapping of arrays: `receiver` (id), `x, y, z` in
        metres, `tilt_deg, azimuth_deg` (from true north) or `nx, ny, nz`, and optionally `area_m2`, `surface` and
        others on the book's page on receivers.
    output
        Path of the archive. An older archive at this path is replaced; any other file is an error.
    quality
        `"draft"`, `"standard"`, `"fine"` or `"reference"`.
    error, error_weather
        Largest RMSE of hourly totals in percent of their mean, in place of a quality. It is
        estimated under this weather file, or `Weather` of a file.
    settings
        Single settings by name, as in `{"hit": 16}`.
    effects
        Light paths: `"auto"`, `"all"`, `"none"`, or some of `"diffuse,bounces,mirrors,canopies,leaves"`.
    with_scene
        True to store the scene's triangles in the archive, for viewers.
    before
        Archive of this scene before it was changed. Only what the change can alter is traced; the
        new archive has the same bytes as without `before`.
    preview
        With `before`: keeps what the change can alter by less than this percentage of the light on
        open ground, in the mean over the sky. The archive is then marked as a preview; the same
        call without this argument completes it.
    fresh
        Discards an interrupted build at the output. Without it, a build of the same inputs goes on:
        Ctrl-C, and the same call again.
    checkpoint
        Seconds between checkpoints, the most that a crash loses.
    memory
        Memory for the work, bytes.
    progress
        Called now and then with the stage, the number of items done, and the number of all (None:
        unknown).
    """
    source = receivers
    if isinstance(receivers, os.PathLike):
        source = os.fspath(receivers)
    elif not isinstance(receivers, str):
        table = columns_of(receivers, "receivers")
        for name in {"area", "area_m2"} & set(table):
            if table[name].dtype.kind == "f":
                # Unknown areas become empty cells.
                areas = table[name].astype(object)
                areas[np.isnan(table[name])] = None
                table[name] = areas
        source = csv_of(table)
    if not isinstance(scene, Scene):
        scene = Scene(scene)
    path = os.fspath(output)
    weather, about_weather = (None, {}) if error_weather is None else Weather.of(error_weather).request()
    args: dict[str, Any] = {
        "output": path,
        "quality": quality,
        "error": given.percent("error", error),
        "error_weather": weather,
        "about_error_weather": json.dumps(about_weather),
        "settings": [f"{name}={value}" for name, value in (settings or {}).items()],
        "effects": effects,
        "with_scene": with_scene,
        "before": given.path(before),
        "preview": given.percent("preview", preview),
        "fresh": fresh,
        "checkpoint": given.number("checkpoint", checkpoint, "give seconds"),
        "memory": given.whole("memory", memory, "give bytes, as in 1 << 30"),
    }
    handle, seconds, rays, length, found = scene._handle.build(source, args, progress)
    archive = Archive(handle, path)
    archive.built = BuildReport(dict(seconds), rays, length, found)
    return archive
