"""Options of replays and queries. In: keyword arguments. Out: arguments of the engine, or an error
that names the argument."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, TypeAlias, TypedDict

import numpy as np

from . import given
from .tables import columns_of, csv_of, refused
from .weather import Weather

#: `progress(stage, done, items)` is called up to twenty times a second; `items` is None if their
#: number is unknown. An exception of it stops the work.
Progress = Callable[[str, int, "int | None"], object]

#: A number, a path of a CSV file, or a value for each row of the weather, or for each month.
Follow = Any

#: Ids, a table with a column `receiver`, a path of a CSV file (`pathlib.Path`), or one of `{"objects": names}`, `{"surfaces": names}`, `{"bbox": (xmin, ymin, xmax, ymax)}`.
Wanted: TypeAlias = "Sequence[str] | str | os.PathLike[str] | Mapping[str, str | Sequence[str] | Sequence[float]]"

#: Selection of receivers as the engine takes it.
WantedArgs: TypeAlias = "list[str] | str | dict[str, list[Any]] | None"

#: Default memory for the work, bytes.
MEMORY = 4 << 30


class LightOptions(TypedDict, total=False):
    """Options of the light that counts, for all requests to archives.

    reflectance, transmittance
        Reflectance or transmittance by group, material or class: a number from 0 to 1, the path of
        a CSV file, an array with a value for each row of the weather, or an array of twelve for the
        months.
    sky
        The name of a model, or the path of a file: radiances of patches (CSV, a matrix of
        Radiance), or a photograph of the sky. A name has no dot and no slash; a `pathlib.Path` is
        always a file. See the book's page on skies.
    sky_scale, sky_white
        `"dhi"` scales the light of the file to the diffuse irradiance, `"given"` keeps it; the
        radiance of white in a photograph, W/m2/sr.
    clouds
        The path of a file of cloud transmittances: a table of patches, or a picture.
    image_top
        Azimuth of the top of pictures of sky and clouds, degrees clockwise from true north;
        default: north.
    patches, paths, bounces
        As on the command line: see the book's page on query and replay.
    memory
        Memory for the work, besides the results, bytes.
    progress
        Called now and then with the stage, the number of items done, and the number of all.
    """

    reflectance: Mapping[str, Follow] | None
    transmittance: Mapping[str, Follow] | None
    sky: str | os.PathLike[str]
    sky_scale: str | None
    sky_white: float | None
    clouds: str | os.PathLike[str] | None
    image_top: float | None
    patches: int | None
    paths: str | Sequence[str]
    bounces: int | None
    memory: int
    progress: Progress | None


class QueryOptions(LightOptions, total=False):
    """Options of a query, which a replay has, too.

    columns
        Names of components; default: the six and their `total`.
    bands
        Bands of the light, whose columns follow the others: some of `"uv"`, `"visible"`, `"par"`,
        `"nir"` and paths of files with other bands. See the book's page on bands.
    receivers
        An id, ids, a table with a column `receiver`, or one of `{"objects": names}` (buildings
        too), `{"surfaces": names}` and `{"bbox": (xmin, ymin, xmax, ymax)}`, followed by `zmin,
        zmax` if heights count; default: all. A `pathlib.Path` is a CSV file with a column
        `receiver`; a string is always an id. Tiles without any of them are neither read nor computed.
    """

    columns: Sequence[str] | None
    bands: Sequence[str | os.PathLike[str]] | str | None
    receivers: Wanted | None


class PeriodOptions(TypedDict, total=False):
    """Options of the hours of a weather file that count, and of the periods of rows.

    every
        `"hour"`: means over the intervals of the weather, W/m2. `"day"`, `"month"`, `"year"`, `"total"`: sums, kWh/m2.
    snow, snow_reflectance
        `"depth"` or `"albedo"`: the ground follows the weather's snow depth, or its albedo.
    temperature
        Temperature of `ground` and `obstruction`, degrees Celsius, for the column `longwave`; types
        as in `reflectance`.
    steps
        Number of positions of the sun in an interval.
    stamp
        Moment of the interval that labels a row of means: `"start"`, `"middle"` or `"end"`.
    year
        Year of all rows, in place of their own.
    start, end
        First and last day, or moment, that counts: `"2019-03-01"`, `"03-01T06:00"`.
    """

    every: str
    snow: str | None
    snow_reflectance: float
    temperature: Mapping[str, Follow] | None
    steps: int | None
    stamp: str
    year: int | None
    start: str | None
    end: str | None


class ReplayOptions(QueryOptions, PeriodOptions, total=False):
    """Options of a replay."""


class ComfortOptions(LightOptions, PeriodOptions, total=False):
    """Options of comfort, besides those of people and surfaces."""


def check(function: str, options: Mapping[str, Any], known: type) -> None:
    """Raises an error for a keyword that a TypedDict does not have."""
    names = known.__optional_keys__  # type: ignore[attr-defined]
    for name in options:
        if name not in names:
            raise TypeError(f"{function}() got an unexpected keyword argument {name!r}; known arguments: {', '.join(sorted(names))}")


def wanted_args(receivers: Wanted | None) -> WantedArgs:
    """Returns the selection of receivers for the engine."""
    if receivers is None or isinstance(receivers, os.PathLike):
        return given.path(receivers)
    if isinstance(receivers, str):
        return [receivers]
    if isinstance(receivers, Mapping):
        for by, of in receivers.items():
            if not (isinstance(of, Iterable) and (by != "bbox" or not isinstance(of, str))):
                raise refused("receivers", f"`{by}` is `{of}`", 'give names or numbers, as in {"objects": names} and {"bbox": (xmin, ymin, xmax, ymax)}')
        return {by: [of] if isinstance(of, str) else list(of) for by, of in receivers.items()}
    if hasattr(receivers, "columns") or hasattr(receivers, "column_names"):
        table = columns_of(receivers, "receivers")
        if "receiver" not in table:
            raise refused("receivers", f"has no column `receiver`, but {', '.join(table)}", "give a table with the ids, or the ids themselves")
        receivers = table["receiver"]  # type: ignore[assignment]
    if not hasattr(receivers, "__array__"):
        # Sets, keys, generators.
        receivers = list(receivers)  # type: ignore[arg-type]
    ids = np.asarray(receivers)
    if ids.dtype.kind == "b" and ids.size:
        raise refused("receivers", "is a mask, and ids are needed", 'give site.receivers()["receiver"][mask]')
    if ids.ndim > 1:
        raise refused("receivers", f"has the shape {ids.shape}", "give ids one after the other")
    return [str(receiver) for receiver in np.atleast_1d(ids).tolist()]


def _follow(changes: Mapping[str, Follow] | None, column: str) -> list[tuple[str, Any]]:
    """Returns numbers and paths as they are, arrays as the bytes of a schedule."""
    found: list[tuple[str, Any]] = []
    for name, value in given.named(column, changes, f'give a mapping, as in {column}={{"ground": 0.3}}').items():
        if isinstance(value, os.PathLike):
            value = os.fspath(value)
        elif not isinstance(value, str) and np.ndim(value) > 0:
            value = csv_of(columns_of({column: np.asarray(value, dtype=float)}, f"{column}[{name!r}]"))
        elif not isinstance(value, str):
            value = given.number(f"{column}[{name!r}]", value)
            if value is None:
                raise given.wrong(f"{column}[{name!r}]", "is None", "leave it out, or give a number")
        found.append((str(name), value))
    return found


def _sky(sky: str | os.PathLike[str]) -> str:
    """Returns a name as it is, and a path as a text that cannot be a name."""
    if isinstance(sky, os.PathLike):
        path = os.fspath(sky)
        return path if "." in path or os.sep in path else os.path.join(".", path)
    return given.word("sky", sky, 'give a name, such as "perez", or the path of a file')


def light_args(options: QueryOptions) -> dict[str, Any]:
    """Returns the options of light for the engine."""
    columns, paths = options.get("columns"), options.get("paths", "all")
    joined = [columns] if isinstance(columns, str) else columns
    bands = options.get("bands")
    named = [bands] if isinstance(bands, (str, os.PathLike)) else bands
    return {
        "columns": None if joined is None else ",".join(str(column) for column in joined),
        "bands": None if named is None else ",".join(os.fspath(band) for band in named),
        "sky": _sky(options.get("sky", "perez")),
        "sky_scale": options.get("sky_scale"),
        "sky_white": given.number("sky_white", options.get("sky_white"), "give W/m2/sr"),
        "clouds": given.path(options.get("clouds")),
        "image_top": given.number("image_top", options.get("image_top"), "give degrees clockwise from true north"),
        "patches": given.whole("patches", options.get("patches"), "give 145, 577 or 2305"),
        "paths": paths if isinstance(paths, str) else ",".join(str(path) for path in paths),
        "bounces": given.whole("bounces", options.get("bounces"), "give a number of reflections from 1 to 64, or leave it out for all"),
        "reflectance": _follow(options.get("reflectance"), "reflectance"),
        "transmittance": _follow(options.get("transmittance"), "transmittance"),
        "memory": given.whole("memory", options.get("memory", MEMORY), "give bytes, as in 1 << 30"),
    }


def replay_args(weather: Any, options: ReplayOptions) -> dict[str, Any]:
    """Returns the options of a replay for the engine."""
    return {
        **Weather.of(weather).args(),
        "every": given.word("every", options.get("every", "hour"), 'give "hour", "day", "month", "year" or "total"'),
        "stamp": given.word("stamp", options.get("stamp", "start"), 'give "start", "middle" or "end"'),
        "year": given.whole("year", options.get("year"), "give a year, as in year=2019"),
        "from": given.moment("start", options.get("start")),
        "to": given.moment("end", options.get("end")),
        "steps": given.whole("steps", options.get("steps"), "give 1 to 60"),
        "snow": options.get("snow"),
        "snow_reflectance": given.number("snow_reflectance", options.get("snow_reflectance", 0.6)),
        "temperature": _follow(options.get("temperature"), "temperature_c"),
    }


def conditions_source(conditions: Any) -> dict[str, Any]:
    """Returns a table of conditions for the engine."""
    if isinstance(conditions, (str, os.PathLike)):
        return {"name": os.fspath(conditions), "bytes": None}
    table = columns_of(conditions, "conditions")
    if "condition" not in table and table:
        table["condition"] = np.arange(len(next(iter(table.values()))))
    return {"name": "conditions", "bytes": csv_of(table)}
