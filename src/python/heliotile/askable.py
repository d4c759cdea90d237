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
from .given import MEMORY, Asked, WantedArgs, asked, wanted_args, wanted_of
from .options import (
    BuildingsOptions,
    ComfortOptions,
    EnvelopeOptions,
    FactorsOptions,
    GlareOptions,
    PlacesOptions,
    QueryOptions,
    ReplayOptions,
    ShadingOptions,
    SunlightOptions,
    Wanted,
    WriteOptions,
)
from .results import Results

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
        if unknown), and the shares of the hemisphere `sky_view` (leaves count as sky),
        `ground_view, obstruction_view`.
        """
        wanted = wanted_args(receivers)
        return self._table(self._open(wanted), wanted, memory)

    def replay(self, weather: Any, **options: Unpack[ReplayOptions]) -> Results:
        """Computes irradiance under weather: `heliotile replay`, value by value.

        `weather` is a path, a DataFrame with pvlib's names, or a `Weather`. The options are those
        of `heliotile.options.ReplayOptions`.
        """
        keywords, wanted = asked("Archive.replay", ReplayOptions, options, weather=weather), wanted_of(options)
        opened = self._open(wanted)
        made = opened.replay(keywords.args(), wanted, options.get("progress"))
        return Results(made, lambda: self._table(opened, wanted, MEMORY))

    def query(self, conditions: Any = None, **options: Unpack[QueryOptions]) -> Results:
        """Computes irradiance under suns and skies, W/m2: `heliotile replay --conditions`, value by
        value.

        `conditions` is the path of a CSV file, a DataFrame or a mapping of arrays with the columns
        `sun_azimuth_deg` (clockwise from true north), `sun_altitude_deg` (without refraction:
        pvlib's `elevation`), `dni_w_m2`, `dhi_w_m2`, and optionally `condition`, a name for each. One
        sun and sky are given by `sun=(azimuth, altitude)`, `dni` and `dhi` in their place.
        The options are those of `heliotile.options.QueryOptions`.
        """
        keywords, wanted = asked("Archive.query", QueryOptions, options, conditions=conditions), wanted_of(options)
        opened = self._open(wanted)
        made = opened.replay(keywords.args(), wanted, options.get("progress"))
        return Results(made, lambda: self._table(opened, wanted, MEMORY))

    def write(
        self,
        output: str | os.PathLike[str],
        weather: Any = None,
        *,
        conditions: Any = None,
        **options: Unpack[WriteOptions],
    ) -> str | None:
        """Writes irradiance to a file, tile by tile: a table or a map by the ending of its name, as
        `heliotile replay --output`.

        Give `weather` with the options of `replay`, or `conditions` with the options of `query`;
        the options of files are those of `heliotile.options.WriteOptions`. Returns a sentence about
        what was written, if there is one.
        """
        keywords = asked("Archive.write", WriteOptions, options, output=output, weather=weather, conditions=conditions)
        sentence: str | None = self._ask("write", keywords, options)
        return sentence

    def buildings(self, output: str | os.PathLike[str], weather: Any, **options: Unpack[BuildingsOptions]) -> tuple[int, int]:
        """Writes a solar cadastre from sums over a year, as `heliotile buildings`. Returns the
        numbers of buildings and of roof faces. The options are those of
        `heliotile.options.BuildingsOptions`."""
        keywords = asked("Archive.buildings", BuildingsOptions, options, output=output, weather=weather)
        first, second = self._ask("buildings", keywords, options)
        return first, second

    def places(self, output: str | os.PathLike[str], weather: Any, **options: Unpack[PlacesOptions]) -> tuple[int, int]:
        """Writes the best places for modules by sums over a year, as `heliotile places`. Returns
        the numbers of places and of receivers to choose from. The options are those of
        `heliotile.options.PlacesOptions`."""
        keywords = asked("Archive.places", PlacesOptions, options, output=output, weather=weather)
        first, second = self._ask("places", keywords, options)
        return first, second

    def shading(self, output: str | os.PathLike[str], weather: Any, **options: Unpack[ShadingOptions]) -> str:
        """Writes the direct light of sun and sky that each building, tree and terrain takes from
        receivers, and the light that it reflects to them: `heliotile shading`. Returns a sentence
        about it. The options are those of `heliotile.options.ShadingOptions`."""
        keywords = asked("Archive.shading", ShadingOptions, options, output=output, weather=weather)
        sentence: str = self._ask("shading", keywords, options)
        return sentence

    def comfort(self, output: str | os.PathLike[str], weather: Any, **options: Unpack[ComfortOptions]) -> tuple[int, int]:
        """Writes thermal comfort of people at the points of an archive of `heliotile.comfort`.
        Returns the numbers of points and of hours. `output`: a table or a map by its ending. The
        options are those of `heliotile.options.ComfortOptions`."""
        keywords = asked("Archive.comfort", ComfortOptions, options, output=output, weather=weather)
        first, second = self._ask("comfort", keywords, options)
        return first, second

    def sunlight(self, output: str | os.PathLike[str], dates: str | Sequence[str] = (), **options: Unpack[SunlightOptions]) -> dict[str, Any]:
        """Writes hours of possible sun on some days, or how rules rate them: `heliotile sunlight`.

        `output`: a table or a map by its ending. `dates`: `"03-21"`, `"2026-03-21"`,
        `"02-19..10-21"` or `"year"`. The options are those of `heliotile.options.SunlightOptions`.
        Returns the numbers of `places` and `days`, and for each of the `rules` how many places meet
        it, break it, or are too close to it to decide.
        """
        keywords = asked("Archive.sunlight", SunlightOptions, options, output=output, dates=dates)
        found: dict[str, Any] = self._ask("sunlight", keywords, options)
        return found

    def glare(self, output: str | os.PathLike[str], dates: str | Sequence[str] = "year", **options: Unpack[GlareOptions]) -> dict[str, Any]:
        """Writes when mirrors and glass reflect the sun to receivers, or how rules rate that:
        `heliotile glare`. Arguments are those of `sunlight`, options those of
        `heliotile.options.GlareOptions`. A plot that ends with .svg is a calendar."""
        keywords = asked("Archive.glare", GlareOptions, options, output=output, dates=dates)
        found: dict[str, Any] = self._ask("glare", keywords, options)
        return found

    def envelope(self, output: str | os.PathLike[str], within: str | os.PathLike[str], **options: Unpack[EnvelopeOptions]) -> dict[str, Any]:
        """Writes the largest building on a plot that leaves the receivers around it hours of sun:
        `heliotile envelope`. `within`: a file of polygons, or a box `"xmin,ymin,xmax,ymax"`. The
        options are those of `heliotile.options.EnvelopeOptions`. Returns `plot_m2`, `volume_m3`,
        `height_m`, and the numbers of `places`, of those that limit it (`bound`), and of those with
        less sun than is asked for today (`short`).
        """
        keywords = asked("Archive.envelope", EnvelopeOptions, options, output=output, within=within)
        found: dict[str, Any] = self._ask("envelope", keywords, options)
        return found

    def factors(self, **options: Unpack[FactorsOptions]) -> Factors:
        """Computes what surroundings reflect, as EnergyPlus' five factors over the sun's position:
        `heliotile energyplus factors`. With an `output` the table is written, too. The options are those of
        `heliotile.options.FactorsOptions`."""
        keywords, wanted = asked("Archive.factors", FactorsOptions, options), wanted_of(options)
        found = self._open(wanted).factors(keywords.args(), wanted, options.get("progress"))
        values = {name: np.asarray(values) for name, values in found[3]}
        return Factors(options.get("by") or "receiver", found[0], np.array(found[1]), np.array(found[2]), values)

    def _ask(self, question: str, keywords: Asked, options: Mapping[str, Any]) -> Any:
        """Answers a question by files. Returns its summary."""
        wanted = wanted_of(options)
        return json.loads(_heliotile.ask(self._open(wanted), question, keywords.args(), wanted, options.get("progress")))
