"""What can be asked for irradiance: an archive, or an atlas like one archive. In: weather or conditions. Out: results."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from . import _heliotile, given
from .results import Results
from .tables import columns_of, csv_of, refused
from .weather import Weather

if TYPE_CHECKING:
    import xarray as xr

#: `progress(stage, done, items)` is called up to twenty times a second; `items` is None where nobody knows how many there are. What it
#: raises stops the work.
Progress = Callable[[str, int, "int | None"], object]

#: A number, a path of a CSV file, or a value for each row of the weather, or for each month.
Follow = Any

#: Ids, a table with a column `receiver`, a path of a CSV file, or one of `{"objects": names}`, `{"surfaces": names}`, `{"bbox": (xmin, ymin, xmax, ymax)}`.
Wanted: TypeAlias = "Sequence[str] | str | os.PathLike[str] | Mapping[str, str | Sequence[str] | Sequence[float]]"

#: The same as the engine takes it.
WantedArgs: TypeAlias = "list[str] | str | dict[str, list[Any]] | None"

#: What a session works in unless more is said, bytes.
MEMORY = 4 << 30


@dataclass(frozen=True)
class Place:
    """Where an archive lies."""

    latitude_deg: float
    longitude_deg: float
    convergence_deg: float
    """How far y lies clockwise from true north."""
    epsg: int | None


@dataclass(frozen=True)
class Material:
    """What surfaces of one name reflect, shares of the light."""

    name: str
    diffuse: float
    specular: float
    transmittance: float | None
    group: str | None
    kind: str
    """`ground` or `obstruction`."""


@dataclass(frozen=True)
class Factors:
    """The five factors of EnergyPlus over the sun's position, for ground that reflects all."""

    by: str
    names: list[str]
    """Receivers, surfaces and so on."""
    azimuths_deg: np.ndarray
    altitudes_deg: np.ndarray
    values: dict[str, np.ndarray]
    """`ReflFac...`: float64, shape (names, azimuths, altitudes)."""

    def __getitem__(self, factor: str) -> np.ndarray:
        return self.values[factor]

    def __repr__(self) -> str:
        shape = f"{len(self.names)} x {len(self.azimuths_deg)} azimuths x {len(self.altitudes_deg)} altitudes"
        return f"Factors(by {self.by}: {shape}, {', '.join(self.values)})"

    def to_xarray(self) -> xr.Dataset:
        """A Dataset with the dimensions of the names, `sun_azimuth_deg` and `sun_altitude_deg`."""
        import xarray as xr

        dims = (self.by, "sun_azimuth_deg", "sun_altitude_deg")
        coordinates = dict(zip(dims, (np.array(self.names), self.azimuths_deg, self.altitudes_deg), strict=True))
        return xr.Dataset({name: (dims, values, {"units": "1"}) for name, values in self.values.items()}, coordinates)


class Askable(ABC):
    """A site that was traced: replay any weather, ask for any sun and sky."""

    @abstractmethod
    def _open(self, wanted: WantedArgs) -> _heliotile.ArchiveHandle:
        """What holds the receivers that are asked for, open."""

    @property
    def count(self) -> int:
        """Number of receivers."""
        return self._open(None).count

    @property
    def tiles(self) -> int:
        """Number of tiles, of 64 receivers each; what is computed at a time."""
        return self._open(None).tiles

    @property
    def place(self) -> Place | None:
        """Where it lies, if its files said so."""
        return None if (place := self._open(None).place) is None else Place(*place)

    @property
    def settings(self) -> dict[str, str]:
        """Settings of the build."""
        return dict(self._open(None).settings)

    def _table(self, opened: _heliotile.ArchiveHandle, wanted: WantedArgs, memory: int) -> dict[str, np.ndarray]:
        return {name: np.asarray(values) for name, values in opened.receivers(wanted, memory).items()}

    def materials(self) -> list[Material]:
        """Whose reflectance a replay can change."""
        return [Material(*row) for row in self._open(None).materials()]

    def receivers(self, receivers: Wanted | None = None, *, memory: int = MEMORY) -> dict[str, np.ndarray]:
        """All receivers, or those that are asked for as in `replay`, in the order of results: `pandas.DataFrame(site.receivers())`.

        Read-only arrays of shape `(receivers,)`: `receiver` (id), `x, y, z` in metres, the unit normal `nx, ny, nz`, `area` in m2 (NaN where
        nobody says), `surface, object, building, kind` (empty where nobody says), and the shares of the hemisphere `sky_view, ground_view,
        obstruction_view`.
        """
        wanted = wanted_args(receivers)
        return self._table(self._open(wanted), wanted, memory)

    def replay(
        self,
        weather: Any,
        *,
        every: str = "hour",
        columns: Sequence[str] | None = None,
        receivers: Wanted | None = None,
        reflectance: Mapping[str, Follow] | None = None,
        transmittance: Mapping[str, Follow] | None = None,
        snow: str | None = None,
        snow_reflectance: float = 0.6,
        temperature: Mapping[str, Follow] | None = None,
        sky: str = "perez",
        patches: int | None = None,
        paths: str | Sequence[str] = "all",
        bounces: int | None = None,
        steps: int | None = None,
        stamp: str = "start",
        year: int | None = None,
        start: str | None = None,
        end: str | None = None,
        memory: int = MEMORY,
        progress: Progress | None = None,
    ) -> Results:
        """Irradiance through weather: `heliotile replay`, value by value.

        Parameters
        ----------
        weather
            A path, a DataFrame with pvlib's names, or a `Weather`.
        every
            `"hour"`: means over the intervals of the weather, W/m2. `"day"`, `"month"`, `"year"`, `"total"`: sums, kWh/m2.
        columns
            Names of components; default: the six and their `total`.
        receivers
            Ids, or a table or the path of a CSV file with a column `receiver`, or one of `{"objects": names}` (buildings too), `{"surfaces": names}` and
            `{"bbox": (xmin, ymin, xmax, ymax)}`, with `zmin, zmax` behind it if heights count; default: all. Tiles without any of them are
            neither read nor computed.
        reflectance, transmittance
            By group, material or class: a number from 0 to 1, the path of a CSV file, or an array with a value for each row of the
            weather, or twelve for the months.
        snow, snow_reflectance
            `"depth"` or `"albedo"`: the ground follows the weather's snow depth, or its albedo.
        temperature
            For the column `longwave`, of `ground` and `obstruction`, degrees Celsius: as `reflectance`.
        sky, patches, paths, bounces, steps
            As in the program: the book's page of query and replay.
        stamp
            Which moment of its interval a row of means is labelled with: `"start"`, `"middle"` or `"end"`.
        year
            Puts all rows into one year.
        start, end
            First and last day, or moment, that counts: `"2019-03-01"`, `"03-01T06:00"`.
        memory
            Bytes to work in, besides the results.
        progress
            Called now and then with the stage, how much of it is done, and how much there is.
        """
        light = light_args(columns, reflectance, transmittance, sky, patches, paths, bounces, memory)
        args = replay_args(weather, every, stamp, year, start, end, steps, snow, snow_reflectance, temperature)
        wanted = wanted_args(receivers)
        opened = self._open(wanted)
        return self._results(opened, opened.replay(light, args, wanted, progress), wanted, memory)

    def query(
        self,
        conditions: Any,
        *,
        columns: Sequence[str] | None = None,
        receivers: Wanted | None = None,
        reflectance: Mapping[str, Follow] | None = None,
        transmittance: Mapping[str, Follow] | None = None,
        sky: str = "perez",
        patches: int | None = None,
        paths: str | Sequence[str] = "all",
        bounces: int | None = None,
        memory: int = MEMORY,
        progress: Progress | None = None,
    ) -> Results:
        """Irradiance under suns and skies, W/m2: `heliotile query`, value by value.

        `conditions` is the path of a CSV file, a DataFrame or a mapping of arrays with the columns `sun_azimuth_deg` (clockwise from true
        north), `sun_altitude_deg` (without refraction: pvlib's `elevation`), `dni_w_m2`, `dhi_w_m2`, and `condition`, a name for each, which may be left out. The rest is as in `replay`.
        """
        light = light_args(columns, reflectance, transmittance, sky, patches, paths, bounces, memory)
        source: dict[str, Any] = {"name": "conditions", "bytes": None}
        if isinstance(conditions, (str, os.PathLike)):
            source["name"] = os.fspath(conditions)
        else:
            table = columns_of(conditions, "conditions")
            if "condition" not in table and table:
                table["condition"] = np.arange(len(next(iter(table.values()))))
            source["bytes"] = csv_of(table)
        wanted = wanted_args(receivers)
        opened = self._open(wanted)
        return self._results(opened, opened.query(light, source, wanted, progress), wanted, memory)

    def _results(self, opened: _heliotile.ArchiveHandle, made: _heliotile.Recombined, wanted: WantedArgs, memory: int) -> Results:
        return Results(made, lambda: self._table(opened, wanted, memory))

    def factors(
        self,
        *,
        azimuth_step: float = 10.0,
        altitude_step: float = 5.0,
        by: str = "receiver",
        receivers: Wanted | None = None,
        memory: int = MEMORY,
        progress: Progress | None = None,
    ) -> Factors:
        """What surroundings reflect as EnergyPlus' five factors over the sun's position: `heliotile factors`.

        Steps are in degrees; `by` is `"receiver"`, `"surface"`, `"object"`, `"building"` or `"kind"`: means by area.
        """
        steps = (azimuth_step, altitude_step)
        wanted = wanted_args(receivers)
        found = self._open(wanted).factors(steps, by, wanted, memory, progress)
        return Factors(by, found[0], np.array(found[1]), np.array(found[2]), {name: np.asarray(v) for name, v in found[3]})


def wanted_args(receivers: Wanted | None) -> WantedArgs:
    """Receivers that are chosen, as the engine takes them."""
    if receivers is None or isinstance(receivers, os.PathLike):
        return given.path(receivers)
    if isinstance(receivers, str):
        return receivers if receivers.endswith(".csv") or os.path.exists(receivers) else [receivers]
    if isinstance(receivers, Mapping):
        for by, of in receivers.items():
            if not (isinstance(of, Iterable) and (by != "bbox" or not isinstance(of, str))):
                raise refused("receivers", f"`{by}` is `{of}`", 'as in {"objects": names} and {"bbox": (xmin, ymin, xmax, ymax)}')
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
        raise refused("receivers", "is a mask, and ids are taken", 'site.receivers()["receiver"][mask] are those')
    if ids.ndim > 1:
        raise refused("receivers", f"has the shape {ids.shape}", "give ids one after the other")
    return [str(receiver) for receiver in np.atleast_1d(ids).tolist()]


def _follow(changes: Mapping[str, Follow] | None, column: str) -> list[tuple[str, Any]]:
    """Numbers and paths as they are, arrays as the bytes of a schedule."""
    found: list[tuple[str, Any]] = []
    for name, value in given.named(column, changes, f'say of what, as in {column}={{"ground": 0.3}}').items():
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


def light_args(
    columns: Sequence[str] | None,
    reflectance: Mapping[str, Follow] | None,
    transmittance: Mapping[str, Follow] | None,
    sky: str,
    patches: int | None,
    paths: str | Sequence[str],
    bounces: int | None,
    memory: int,
) -> dict[str, Any]:
    """Choices of light as the engine takes them."""
    joined = [columns] if isinstance(columns, str) else columns
    return {
        "columns": None if joined is None else ",".join(str(column) for column in joined),
        "sky": given.word("sky", sky, 'give "perez", "perez1990", "uniform", or "cie:1" to "cie:15"'),
        "patches": given.whole("patches", patches, "give 145, 577 or 2305"),
        "paths": paths if isinstance(paths, str) else ",".join(str(path) for path in paths),
        "bounces": given.whole("bounces", bounces, "give a number of reflections from 1 to 64, or leave it out for all"),
        "reflectance": _follow(reflectance, "reflectance"),
        "transmittance": _follow(transmittance, "transmittance"),
        "memory": given.whole("memory", memory, "give bytes, as in 1 << 30"),
    }


def replay_args(
    weather: Any,
    every: str,
    stamp: str,
    year: int | None,
    start: str | None,
    end: str | None,
    steps: int | None,
    snow: str | None,
    snow_reflectance: float,
    temperature: Mapping[str, Follow] | None,
) -> dict[str, Any]:
    """Choices of a replay as the engine takes them."""
    return {
        **Weather.of(weather).args(),
        "every": given.word("every", every, 'give "hour", "day", "month", "year" or "total"'),
        "stamp": given.word("stamp", stamp, 'give "start", "middle" or "end"'),
        "year": given.whole("year", year, "give a year, as in year=2019"),
        "from": given.moment("start", start),
        "to": given.moment("end", end),
        "steps": given.whole("steps", steps, "give 1 to 60"),
        "snow": snow,
        "snow_reflectance": given.number("snow_reflectance", snow_reflectance),
        "temperature": _follow(temperature, "temperature_c"),
    }
