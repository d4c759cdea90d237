"""Work that writes folders and archives: the program's `run`, `pv`, `comfort`, `energyplus`,
`tradeoff`, `merge` and `diff`. In: keyword arguments. Out: files, and a summary. Arguments fill the
same requests as the command line."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from . import _heliotile, given
from .archive import Archive
from .atlas import Atlas
from .options import MEMORY, Progress
from .scene import scene_request
from .weather import Weather, weather_request

#: Files of a scene, or a `Scene`.
Files = Any


@dataclass(frozen=True)
class Study:
    """Files of a study."""

    folder: str
    archive: str
    files: list[str]
    """Names relative to the folder."""
    table: str
    """Sums, as text for people."""

    def open(self) -> Archive:
        """Opens the archive."""
        return Archive.open(self.archive)


def run(
    scene: Files,
    weather: Any,
    output: str | os.PathLike[str] | None = None,
    *,
    cover: Mapping[str, Any] | None = None,
    receivers: str | os.PathLike[str] | None = None,
    quality: str = "standard",
    error: float | str | None = None,
    error_weather: Any = None,
    every: Sequence[str] = (),
    rules: Sequence[str | os.PathLike[str]] = (),
    by: str = "receiver",
    year: int | None = None,
    format: str = "csv",
    maps: Sequence[str] = (),
    with_scene: bool = True,
    replace: bool = False,
    memory: int = MEMORY,
    progress: Progress | None = None,
) -> Study:
    """Computes a year's sun from scene files in one go: `heliotile run`, file by file.

    Parameters
    ----------
    scene, weather, output
        A `Scene` or its files; a weather file, or a `Weather` of one; the folder, by default the name of the first scene file with `.sun`.
    cover, receivers
        Options of `Scene.cover` (`{"on": ["roof"], "spacing": 1.0}`) to place receivers, or the
        path of their table.
    quality, error, error_weather
        As in `build`.
    rules
        Rules of sunlight, such as `"tno-light"` or files that end with .toml; their results become
        a table.
    every, by, year, format
        Periods of the tables, what a row stands for, the year of the rows, the ending of the
        tables' names.
    maps
        Some of `"glb", "fgb", "geojson", "geoparquet", "vtu", "cityjson"`.
    replace
        True to discard results of other inputs in the folder.
    """
    request: dict[str, Any] = {
        "scene": scene_request(scene),
        **weather_request(weather),
        "cover": _cover(cover),
        "accuracy": _accuracy(quality, error, error_weather),
        "with_scene": with_scene,
        "every": [every] if isinstance(every, str) else list(every),
        "rules": [rules] if isinstance(rules, str) else [os.fspath(rule) for rule in rules],
        "by": by,
        "year": given.whole("year", year),
        "format": format,
        "maps": [maps] if isinstance(maps, str) else list(maps),
        "replace": replace,
    }
    request |= {name: os.fspath(path) for name, path in (("folder", output), ("receivers", receivers)) if path is not None}
    return _study(_heliotile.run(json.dumps(request), memory, progress))


def pv(
    scene: Files,
    weather: Any,
    output: str | os.PathLike[str],
    *,
    points: str | os.PathLike[str] | None = None,
    rows: str | os.PathLike[str] | None = None,
    search: bool = False,
    tilts: tuple[float, float] = (0.0, 90.0),
    azimuths: tuple[float, float] = (0.0, 360.0),
    bifaciality: float = 0.8,
    sky: str = "perez",
    hourly: bool = True,
    format: str = "csv",
    year: int | None = None,
    snow: str | None = None,
    snow_reflectance: float = 0.6,
    quality: str = "standard",
    replace: bool = False,
    memory: int = MEMORY,
    progress: Progress | None = None,
) -> Study:
    """Computes light on solar modules: `heliotile pv`, file by file. Give a table of `points`, or
    `rows` of modules; the book's page on pv has their layouts. Rows with receivers on the `ground`
    among them add `ground.csv` and `ground_months.csv` to the files of the study."""
    request: dict[str, Any] = {
        "scene": scene_request(scene),
        **weather_request(weather),
        "folder": os.fspath(output),
        "search": search,
        "tilts_deg": list(tilts),
        "azimuths_deg": list(azimuths),
        "bifaciality": bifaciality,
        "sky": sky,
        "hourly": hourly,
        "format": format,
        "year": given.whole("year", year),
        "snow": snow,
        "snow_reflectance": given.number("snow_reflectance", snow_reflectance),
        "accuracy": _accuracy(quality, None),
        "replace": replace,
    }
    request |= {name: os.fspath(path) for name, path in (("points", points), ("rows", rows)) if path is not None}
    return _study(_heliotile.pv(json.dumps(request), memory, progress))


def comfort(
    scene: Files,
    output: str | os.PathLike[str],
    *,
    weather: Any = None,
    points: str | os.PathLike[str] | None = None,
    on: str | Sequence[str] = "ground",
    spacing: float = 2.0,
    body_height: float = 1.1,
    quality: str = "standard",
    error: float | str | None = None,
    error_weather: Any = None,
    replace: bool = False,
    memory: int = MEMORY,
    progress: Progress | None = None,
) -> Archive:
    """Builds the archive of a scene with people and opens it, the first step of `heliotile
    comfort`, with six receivers for each point. `Archive.comfort` replays it.

    Parameters
    ----------
    scene, output
        A `Scene` or its files; the folder of `receivers.csv` and `site.helio`. An archive of the
        same inputs is used again.
    weather
        A weather file, or a `Weather` of one, for the later replays. Weather without the air that
        UTCI and PET need is an error before any ray is traced. `error` is estimated under this
        weather if there is no `error_weather`.
    points
        A table `point,x,y` and optionally `z` or `height`: where people stand. Without it they
        stand `on` these kinds of surfaces or materials, `spacing` metres apart.
    body_height
        Height of the middle of a person above the surface, metres.
    quality, error, error_weather
        As in `build`.
    replace
        True to discard results of other inputs in the folder.
    """
    site: dict[str, Any] = {
        "scene": scene_request(scene),
        "folder": os.fspath(output),
        "on": [on] if isinstance(on, str) else list(on),
        "spacing_m": given.number("spacing", spacing),
        "height_m": given.number("body_height", body_height),
        "accuracy": _accuracy(quality, error, weather if error_weather is None and error is not None else error_weather),
        "replace": replace,
    }
    site |= {"points": os.fspath(points)} if points is not None else {}
    return Archive.open(_heliotile.comfort(json.dumps({"site": site, **weather_request(weather)}), memory, progress))


def energyplus(
    model: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    scene: Files = (),
    at: Sequence[float] | None = None,
    crs: int | str | None = None,
    weather: str | os.PathLike[str] | None = None,
    delete_surroundings: bool = False,
    physics: str = "full",
    run: bool = False,
    energyplus: str | os.PathLike[str] | None = None,
    spacing: float | None = None,
    quality: str = "standard",
    replace: bool = False,
    memory: int = MEMORY,
    progress: Progress | None = None,
) -> str:
    """Writes an EnergyPlus model with the sunlight that its surroundings reflect: `heliotile
    energyplus`, file by file. Returns the folder.

    `scene`: files of the surroundings; `at`: position of the model's origin in them, metres.
    `weather` belongs to `run`, which runs EnergyPlus from the folder `energyplus`, and to
    `delete_surroundings`. The book's page on energyplus lists the files.
    """
    files = [scene] if isinstance(scene, (str, os.PathLike)) else scene
    request: dict[str, Any] = {
        "model": os.fspath(model),
        "folder": os.fspath(output),
        "scene": [os.fspath(file) for file in files],
        "crs": given.epsg(crs),
        "delete_surroundings": delete_surroundings,
        "physics": physics,
        "run": run,
        "spacing_m": given.number("spacing", spacing),
        "accuracy": _accuracy(quality, None),
        "replace": replace,
    }
    if at is not None:
        request["at"] = [*map(float, at), 0.0][:3]
    request |= {name: os.fspath(path) for name, path in (("weather", weather), ("energyplus", energyplus)) if path is not None}
    _heliotile.energyplus(json.dumps(request), memory, progress)
    return os.fspath(output)


def partition(
    scene: Files,
    output: str | os.PathLike[str],
    *,
    part_size: float = 500.0,
    halo: float = 300.0,
    skyline: float = 5.0,
    cover: Mapping[str, Any] | None = None,
    quality: str = "standard",
    with_scene: bool = True,
    sample: int = 256,
    replace: bool = False,
    memory: int = MEMORY,
    progress: Progress | None = None,
) -> Atlas:
    """Cuts a region into parts that are built one by one, and opens the atlas: `heliotile
    partition`. Lengths in metres; `cover` as in `run`.

    `sample` receivers are also traced with three times the halo, to estimate the halo's error; 0
    skips that.
    """
    cut = {"part_size_m": part_size, "halo_m": halo, "skyline_deg": skyline, "scene": scene_request(scene), "cover": _cover(cover)}
    cut |= {"accuracy": _accuracy(quality, None), "no_scene": not with_scene}
    _heliotile.partition(json.dumps(cut), os.fspath(output), replace, sample, memory, progress)
    return Atlas.open(output)


@dataclass(frozen=True)
class LadderStep:
    """Settings with their cost and errors. Errors are percent of the mean of hourly totals."""

    name: str
    """Name of the quality, or the parts that the settings are made of."""
    settings: dict[str, float]
    error_percent: float
    """RMSE of hourly totals."""
    bias_percent: float
    yearly_percent: float
    """RMSE of means over all conditions."""
    components_percent: dict[str, float]
    """RMSE by column."""
    trace_s: float
    compress_s: float
    replay_s: float
    """CPU seconds to replay a year of hours into sums."""
    rays: int
    bytes: int
    frontier: bool
    """True if no other step is both faster and more accurate."""


@dataclass(frozen=True)
class Tradeoff:
    """Cost of accuracy on a site."""

    page: str
    """Path of the page with all results; tables and pictures are beside it."""
    table: str
    """All results, as text for people."""
    steps: list[LadderStep]
    """Steps from coarse to fine."""
    receivers: int
    """Number of receivers on which settings were tried."""
    mean_w_m2: float
    sources: list[dict[str, Any]] | None
    """Results of each setting alone, by the columns of `sources.csv`; None without `sources`."""


def tradeoff(
    scene: Files,
    receivers: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    sample: int = 32,
    weather: Any = None,
    sources: bool = False,
    effects: str = "auto",
    memory: int = MEMORY,
    progress: Progress | None = None,
) -> Tradeoff:
    """Measures the cost of accuracy on a site: `heliotile tradeoff`. Writes a folder with tables,
    pictures and a page.

    `sample`: number of receivers to try settings on. `weather`: a file, or a `Weather` of one,
    under which errors are estimated; default: suns from all sides. `sources` tries each setting
    alone, too. `effects`: as in `build`.
    """
    request = {
        "scene": scene_request(scene),
        "receivers": os.fspath(receivers),
        "folder": os.fspath(output),
        "sample": given.whole("sample", sample),
        **weather_request(weather),
        "sources": sources,
        "effects": effects,
    }
    found = json.loads(_heliotile.tradeoff(json.dumps(request), memory, progress))
    ladder = found["ladder"]
    steps = [LadderStep(**step) for step in ladder["steps"]]
    return Tradeoff(found["page"], found["table"], steps, ladder["receivers"], ladder["mean_w_m2"], found["sources"])


def merge(
    first: str | os.PathLike[str],
    second: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    memory: int = MEMORY,
    progress: Progress | None = None,
) -> Archive:
    """Writes the union of two archives of one scene and opens it: `heliotile merge`, byte by byte."""
    _heliotile.merge([os.fspath(first), os.fspath(second)], os.fspath(output), memory, progress)
    return Archive.open(output)


def diff(first: str | os.PathLike[str], second: str | os.PathLike[str], *, memory: int = MEMORY) -> tuple[bool, str]:
    """Compares two archives, as `heliotile diff`. Returns True if they are equal, and their
    differences as text."""
    return _heliotile.diff([os.fspath(first), os.fspath(second)], memory)


def _study(done: tuple[str, str, list[str], str]) -> Study:
    folder, archive, files, table = done
    return Study(os.fspath(folder), os.fspath(archive), files, table)


def _cover(cover: Mapping[str, Any] | None) -> dict[str, Any]:
    """Returns the placement of receivers for a request, from the names of `Scene.cover`."""
    names = {"on": "on", "types": "types", "offset": "offset_m", "min_area": "min_area_m2", "spacing": "density", "per_surface": "density"}
    request: dict[str, Any] = {}
    for name, value in (cover or {}).items():
        if name not in names:
            raise given.wrong("cover", f"has no option `{name}`", f"give some of {', '.join(names)}")
        request[names[name]] = {name: value} if names[name] == "density" else [value] if isinstance(value, str) else value
    return request


def _accuracy(quality: str, error: float | str | None, error_weather: Any = None) -> dict[str, Any]:
    """Returns the accuracy for a request."""
    request: dict[str, Any] = {"quality": quality}
    if (percent := given.percent("error", error)) is not None:
        request["error_percent"] = percent
    if error_weather is not None:
        request["error_weather"], about_weather = Weather.of(error_weather).request()
        request |= {"weather_options": about_weather} if about_weather else {}
    return request
