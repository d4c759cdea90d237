"""Sites that can be replayed and queried: an archive, or an atlas used like one archive. In:
weather or conditions. Out: results."""

from __future__ import annotations

import json
import os
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np

from . import _heliotile
from .given import wrong
from .options import MEMORY, ComfortOptions, Progress, QueryOptions, ReplayOptions, Wanted, WantedArgs, check, conditions_source, light_args, replay_args, wanted_args
from .results import Results
from .weather import weather_request


if TYPE_CHECKING:
    import xarray as xr

@dataclass(frozen=True)
class Place:
    """Location of a site."""

    latitude_deg: float
    longitude_deg: float
    convergence_deg: float
    """Direction of y, degrees clockwise from true north."""
    epsg: int | None


@dataclass(frozen=True)
class Material:
    """Reflectance and transmittance of the surfaces with one name, shares of the light."""

    name: str
    diffuse: float
    specular: float
    transmittance: float | None
    group: str | None
    kind: str
    """`ground` or `obstruction`."""


@dataclass(frozen=True)
class Factors:
    """The five factors of EnergyPlus over the sun's position, for ground that reflects all
    light."""

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
        """Returns a Dataset with the dimensions of the names, `sun_azimuth_deg` and
        `sun_altitude_deg`."""
        import xarray as xr

        dims = (self.by, "sun_azimuth_deg", "sun_altitude_deg")
        coordinates = dict(zip(dims, (np.array(self.names), self.azimuths_deg, self.altitudes_deg), strict=True))
        return xr.Dataset({name: (dims, values, {"units": "1"}) for name, values in self.values.items()}, coordinates)


def files_request(output: str | os.PathLike[str], by: str, geo: bool, plots: Sequence[str | os.PathLike[str]]) -> dict[str, Any]:
    """Returns the output files for a request."""
    return {"output": os.fspath(output), "by": by, "geo": geo, "plots": [os.fspath(plot) for plot in plots]}


@dataclass(frozen=True)
class DayChoice:
    """Days, rules and clock of computations of sunlight and glare."""

    dates: str | Sequence[str]
    rules: str | os.PathLike[str] | Sequence[str | os.PathLike[str]]
    before: str | os.PathLike[str] | None
    zone: str | None
    year: int
    least_altitude: float
    exact: bool

    def request(self) -> dict[str, Any]:
        """Returns these choices for a request."""
        days = [self.dates] if isinstance(self.dates, str) else list(self.dates)
        named = [self.rules] if isinstance(self.rules, (str, os.PathLike)) else list(self.rules)
        request: dict[str, Any] = {"dates": days, "rules": [os.fspath(rule) for rule in named], "year": self.year}
        request |= {"least_altitude_deg": self.least_altitude, "exact": self.exact}
        request |= {} if self.zone is None else {"zone": self.zone}
        return request | ({} if self.before is None else {"before": os.fspath(self.before)})


class Askable(ABC):
    """A site that was traced: replay any weather, or query any sun and sky."""

    @abstractmethod
    def _open(self, wanted: WantedArgs) -> _heliotile.ArchiveHandle:
        """Opens the archives that hold the selected receivers."""

    @property
    def count(self) -> int:
        """Number of receivers."""
        return self._open(None).count

    @property
    def tiles(self) -> int:
        """Number of tiles, of 64 receivers each. A tile is computed as a whole."""
        return self._open(None).tiles

    @property
    def place(self) -> Place | None:
        """Location, if the scene files or arguments stated it."""
        return None if (place := self._open(None).place) is None else Place(*place)

    @property
    def settings(self) -> dict[str, str]:
        """Settings of the build."""
        return dict(self._open(None).settings)

    def _table(self, opened: _heliotile.ArchiveHandle, wanted: WantedArgs, memory: int) -> dict[str, np.ndarray]:
        return {name: np.asarray(values) for name, values in opened.receivers(wanted, memory).items()}

    def materials(self) -> list[Material]:
        """Returns the materials, whose reflectance a replay can change."""
        return [Material(*row) for row in self._open(None).materials()]

    def receivers(self, receivers: Wanted | None = None, *, memory: int = MEMORY) -> dict[str, np.ndarray]:
        """Returns all receivers, or some, selected as in `replay`, in the order of results:
        `pandas.DataFrame(site.receivers())`.

        Read-only arrays of shape `(receivers,)`: `receiver` (id), `x, y, z` in metres, the unit
        normal `nx, ny, nz`, `area_m2` (NaN if unknown), `surface, object, building, kind` (empty
        if unknown), and the shares of the hemisphere `sky_view, ground_view, obstruction_view`.
        """
        wanted = wanted_args(receivers)
        return self._table(self._open(wanted), wanted, memory)

    def replay(self, weather: Any, **options: Unpack[ReplayOptions]) -> Results:
        """Computes irradiance under weather: `heliotile replay`, value by value.

        `weather` is a path, a DataFrame with pvlib's names, or a `Weather`. The options are those
        of `heliotile.options.ReplayOptions`: `every`, `columns`, `bands`, `receivers`,
        `reflectance`, `transmittance`, `snow`, `snow_reflectance`, `temperature`, `sky`,
        `sky_scale`, `sky_white`, `clouds`, `image_top`, `patches`, `paths`, `bounces`, `steps`,
        `stamp`, `year`, `start`, `end`, `memory`, `progress`.
        """
        check("replay", options, ReplayOptions)
        light, args = light_args(options), replay_args(weather, options)
        wanted = wanted_args(options.get("receivers"))
        opened = self._open(wanted)
        made = opened.replay(light, args, wanted, options.get("progress"))
        return self._results(opened, made, wanted, options.get("memory", MEMORY))

    def query(self, conditions: Any, **options: Unpack[QueryOptions]) -> Results:
        """Computes irradiance under suns and skies, W/m2: `heliotile query`, value by value.

        `conditions` is the path of a CSV file, a DataFrame or a mapping of arrays with the columns
        `sun_azimuth_deg` (clockwise from true north), `sun_altitude_deg` (without refraction:
        pvlib's `elevation`), `dni_w_m2`, `dhi_w_m2`, and optionally `condition`, a name for each.
        The options are those of `heliotile.options.QueryOptions`: `columns`, `bands`, `receivers`,
        `reflectance`, `transmittance`, `sky`, `sky_scale`, `sky_white`, `clouds`, `image_top`,
        `patches`, `paths`, `bounces`, `memory`, `progress`.
        """
        check("query", options, QueryOptions)
        light, source = light_args(options), conditions_source(conditions)
        wanted = wanted_args(options.get("receivers"))
        opened = self._open(wanted)
        made = opened.query(light, source, wanted, options.get("progress"))
        return self._results(opened, made, wanted, options.get("memory", MEMORY))

    def write(
        self,
        output: str | os.PathLike[str],
        weather: Any = None,
        *,
        conditions: Any = None,
        by: str = "receiver",
        plots: Sequence[str | os.PathLike[str]] = (),
        geo: bool = False,
        positions: bool = False,
        model: str | os.PathLike[str] | None = None,
        honeybee: str | os.PathLike[str] | None = None,
        **options: Unpack[ReplayOptions],
    ) -> str | None:
        """Writes irradiance to a file, tile by tile: a table or a map by the ending of its name, as
        `heliotile replay --output`.

        Give `weather` with the options of `replay`, or `conditions` with the options of `query`.
        `by`: what a row stands for, `"receiver"`, `"surface"`, `"object"`, `"building"` or
        `"kind"`. `plots`: pictures, `.png` maps and `.svg` charts. `geo`: Parquet files are maps.
        `positions`: position, direction and area of each receiver are columns, so that `build` can
        read the table as its receivers. `model`: the city model that the receivers were placed on; the output is this model with
        sums added. `honeybee`: a folder of Honeybee's results in place of the output. Returns a
        sentence about what was written, if there is one.
        """
        check("write", options, ReplayOptions if conditions is None else QueryOptions)
        files = files_request(output, by, geo, plots) | {"positions": positions}
        files |= {name: os.fspath(path) for name, path in (("model", model), ("honeybee", honeybee)) if path is not None}
        wanted = wanted_args(options.get("receivers"))
        if (weather is None) == (conditions is None):
            raise wrong("weather, conditions", "neither or both are given", "give one of the two")
        forcing = conditions_source(conditions) if weather is None else replay_args(weather, options)
        return self._open(wanted).write(light_args(options), forcing, wanted, json.dumps(files), options.get("progress"))

    def buildings(
        self,
        output: str | os.PathLike[str],
        weather: Any,
        *,
        faces: str | os.PathLike[str] | None = None,
        threshold: float = 900.0,
        min_area: float = 10.0,
        **options: Unpack[ReplayOptions],
    ) -> tuple[int, int]:
        """Writes a solar cadastre from sums over a year, as `heliotile buildings`. Returns the
        numbers of buildings and of roof faces.

        `faces`: a table of roof faces, too. `threshold`: smallest yearly sum of a usable receiver,
        kWh/m2. `min_area`: smallest area of a usable region, m2.
        """
        request = {"output": os.fspath(output), "threshold_kwh_m2": threshold, "least_m2": min_area}
        request |= {} if faces is None else {"faces": os.fspath(faces)}
        return self._of_year("buildings", weather, request, options)

    def places(
        self,
        output: str | os.PathLike[str],
        weather: Any,
        *,
        best: int = 10,
        module: tuple[float, float] = (1.1, 1.8),
        on: str = "roofs",
        clearance: float = 0.1,
        **options: Unpack[ReplayOptions],
    ) -> tuple[int, int]:
        """Writes the best places for modules by sums over a year, as `heliotile places`. Returns
        the numbers of places and of receivers to choose from.

        `module`: width and height, metres. `on`: `"roofs"`, `"facades"` or `"both"`. `clearance`: height above the surface, metres.
        """
        request = {"output": os.fspath(output), "best": best, "module_m": list(module), "on": on, "clearance_m": clearance}
        return self._of_year("places", weather, request, options)

    def comfort(
        self,
        output: str | os.PathLike[str],
        weather: Any,
        *,
        columns: Sequence[str] = (),
        above: Sequence[float] = (26.0, 32.0, 38.0, 46.0),
        posture: str = "standing",
        sun_on: str = "cylinder",
        surfaces: str = "sol-air",
        film: float = 17.0,
        emissivity: Mapping[str, float] | None = None,
        absorptance: Mapping[str, float] | None = None,
        wind: float | str | os.PathLike[str] = 1.0,
        plots: Sequence[str | os.PathLike[str]] = (),
        geo: bool = False,
        **options: Unpack[ComfortOptions],
    ) -> tuple[int, int]:
        """Writes thermal comfort of people at the points of an archive of `heliotile comfort`.
        Returns the numbers of points and of hours.

        `output`: a table or a map by its ending. `columns`: some of `"mrt"`, `"utci"`, `"pet"`,
        `"air"`, `"wind"`, `"shortwave"` and `"longwave"`. Rows of `every="day"` and longer count
        the hours with a UTCI `above` these, degrees Celsius. `posture`: `"standing"` or
        `"sitting"`. `sun_on`: `"cylinder"` or `"box"`. `surfaces`: their temperature, `"sol-air"`
        or `"air"`, where `temperature` gives none; `film` in W/m2K. `emissivity` and `absorptance`:
        values of `"ground"` and `"obstruction"`. `wind`: a factor of the weather's wind, or a CSV
        file with a column `wind_m_s`.
        """
        check("comfort", options, ComfortOptions)
        shares = [[f"{name}={share}" for name, share in (given or {}).items()] for given in (emissivity, absorptance)]
        choice = {"columns": list(columns), "above_c": list(above), "posture": posture, "sun_on": sun_on, "surfaces": surfaces, "film_w_m2_k": film}
        choice |= {"emissivity": shares[0], "absorptance": shares[1], "wind": os.fspath(wind) if isinstance(wind, os.PathLike) else str(wind)}
        asked = json.dumps({"choice": choice, "files": files_request(output, "receiver", geo, plots)})
        asking: ReplayOptions = {**options}
        return self._open(None).comfort(light_args(asking), replay_args(weather, asking), asked, options.get("progress"))

    def sunlight(
        self,
        output: str | os.PathLike[str],
        dates: str | Sequence[str] = (),
        *,
        rules: str | os.PathLike[str] | Sequence[str | os.PathLike[str]] = (),
        before: str | os.PathLike[str] | None = None,
        by: str = "receiver",
        every: str = "day",
        zone: str | None = None,
        year: int = 2017,
        least_altitude: float = 0.0,
        lit_share: float = 0.0,
        exact: bool = False,
        weather: Any = None,
        plots: Sequence[str | os.PathLike[str]] = (),
        geo: bool = False,
        receivers: Wanted | None = None,
        memory: int = MEMORY,
        progress: Progress | None = None,
    ) -> dict[str, Any]:
        """Writes hours of possible sun on some days, or how rules rate them: `heliotile sunlight`.

        `output`: a table or a map by its ending. `dates`: `"03-21"`, `"2026-03-21"`,
        `"02-19..10-21"` or `"year"`. `rules`: names such as `"tno-light"`, or files that end with
        .toml. `before`: the archive before a change, whose values are added. `by`: `"receiver"`,
        `"surface"`, `"window"`, `"object"`, `"building"` or `"kind"`. `every`: `"day"`, `"month"`,
        `"year"` or `"total"`. `zone`: `"+01:00"` or `"Europe/Amsterdam"`. `least_altitude` of the
        sun is in degrees, `lit_share` of the area of a group is from 0 to 1. `exact`: rays decide
        moments near an edge. Returns the numbers of `places` and `days`, and for each of the
        `rules` how many places meet it, break it, or are too close to it to decide.
        """
        request: dict[str, Any] = {"every": every, "lit_share": lit_share} | weather_request(weather)
        days = DayChoice(dates, rules, before, zone, year, least_altitude, exact)
        files = files_request(output, by, geo, plots)
        return self._of_days(request | days.request(), files, receivers, memory, progress)

    def glare(
        self,
        output: str | os.PathLike[str],
        dates: str | Sequence[str] = "year",
        *,
        rules: str | os.PathLike[str] | Sequence[str | os.PathLike[str]] = (),
        before: str | os.PathLike[str] | None = None,
        by: str = "receiver",
        every: str | None = None,
        zone: str | None = None,
        year: int = 2017,
        least_altitude: float = 0.0,
        least_deflection: float = 0.0,
        view_angle: float = 90.0,
        exact: bool = False,
        spells: str | os.PathLike[str] | None = None,
        panes: str | os.PathLike[str] | None = None,
        plots: Sequence[str | os.PathLike[str]] = (),
        geo: bool = False,
        receivers: Wanted | None = None,
        memory: int = MEMORY,
        progress: Progress | None = None,
    ) -> dict[str, Any]:
        """Writes when mirrors and glass reflect the sun to receivers, or how rules rate that:
        `heliotile glare`.

        Arguments are those of `sunlight` with these differences. `every` is `"total"` without
        `rules`. A reflected sun counts if it is seen at least `least_deflection` degrees from the
        sun itself and at most `view_angle` degrees from the direction in which the receiver looks.
        `spells`: a table with a row for each spell. `panes`: a table or map of the panes and the
        minutes that each causes. A plot that ends with .svg is a calendar.
        """
        files = files_request(output, by, geo, plots)
        glare: dict[str, Any] = {"least_deflection_deg": least_deflection, "view_angle_deg": view_angle}
        named = {"spells": spells, "panes": panes}
        glare |= {name: os.fspath(path) for name, path in named.items() if path is not None}
        days = DayChoice(dates, rules, before, zone, year, least_altitude, exact)
        request = days.request() | {"glare": glare, "every": every or ("day" if rules else "total")}
        return self._of_days(request, files, receivers, memory, progress)

    def _of_days(
        self,
        request: dict[str, Any],
        files: dict[str, Any],
        receivers: Wanted | None,
        memory: int,
        progress: Progress | None,
    ) -> dict[str, Any]:
        """Runs a request for sunlight, or for glare."""
        wanted = wanted_args(receivers)
        asked = json.dumps({"request": request, "files": files})
        return json.loads(self._open(wanted).sunlight(wanted, asked, memory, progress))

    def _of_year(self, question: str, weather: Any, request: dict[str, Any], options: ReplayOptions) -> tuple[int, int]:
        """Runs a request for sums over a year."""
        check(question, options, ReplayOptions)
        total: ReplayOptions = {**options, "every": "total", "columns": ["total"]}
        opened = self._open(None)
        ask = opened.buildings if question == "buildings" else opened.places
        return ask(light_args(total), replay_args(weather, total), json.dumps(request), options.get("progress"))

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
        """Computes what surroundings reflect, as EnergyPlus' five factors over the sun's position:
        `heliotile factors`.

        Steps are in degrees; `by` is `"receiver"`, `"surface"`, `"object"`, `"building"` or `"kind"`: means by area.
        """
        steps = (azimuth_step, altitude_step)
        wanted = wanted_args(receivers)
        found = self._open(wanted).factors(steps, by, wanted, memory, progress)
        return Factors(by, found[0], np.array(found[1]), np.array(found[2]), {name: np.asarray(v) for name, v in found[3]})
