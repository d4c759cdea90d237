"""Results in memory: irradiance of receivers under weather or conditions, for NumPy, pandas,
xarray, pvlib and Arrow."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterator
from datetime import timedelta, timezone
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _heliotile
from .errors import ArgumentError

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


class Frame:
    """Description of results: number of receivers, labels, columns, and provenance."""

    def __init__(self, frame: _heliotile.FrameHandle) -> None:
        self.receivers: int = frame.receivers
        self.labels: list[str] = frame.labels
        self.columns: dict[str, str] = dict(frame.columns)
        self.label: str = frame.label
        self.unit: str = frame.unit
        self._about: dict[str, tuple[str, str]] = dict(zip(self.columns, zip(frame.units, frame.meanings, strict=True), strict=True))
        self.provenance: dict[str, str] = frame.provenance
        self.time_utc: np.ndarray | None = None
        self.utc_offset: timedelta | None = None
        if (instants := frame.instants) is not None:
            self.time_utc = np.asarray(instants[0]).astype("datetime64[s]")
            self.utc_offset = timedelta(minutes=instants[1])

    def index(self) -> pd.Index:
        """Returns the labels for pandas: times with their zone, or text."""
        import pandas as pd

        if self.time_utc is None or self.utc_offset is None:
            return pd.Index(self.labels, name=self.label)
        return pd.DatetimeIndex(self.time_utc, name=self.label, tz="UTC").tz_convert(timezone(self.utc_offset))

    def coordinates(self, table: dict[str, np.ndarray]) -> dict[str, Any]:
        """Returns the coordinates of a Dataset: labels, and the properties of the receivers."""
        coordinates: dict[str, Any] = {"receiver": ("receiver", table["receiver"], {"long_name": "receiver", "cf_role": "timeseries_id"})}
        coordinates[self.label] = self._labels()
        for name, values in table.items():
            if name != "receiver":
                coordinates[name] = ("receiver", values, COORDINATES[name])
        return coordinates

    def _labels(self) -> tuple[str, np.ndarray, dict[str, str]]:
        if self.time_utc is None or self.utc_offset is None:
            return self.label, np.array(self.labels), {"long_name": self.label}
        local = self.time_utc + np.timedelta64(int(self.utc_offset.total_seconds()), "s")
        stamp = self.provenance.get("heliotile.stamp", "start")
        about = {
            "standard_name": "time",
            "long_name": f"{stamp} of the interval, local standard time",
            "utc_offset": self.provenance.get("heliotile.utc_offset", ""),
        }
        return self.label, local.astype("datetime64[ns]"), about

    def attributes(self, column: str) -> dict[str, str]:
        """Returns the attributes of a column's variable."""
        unit, meaning = self._about[column]
        method = {"W/m2": "time: mean", "kWh/m2": "time: sum"}[self.unit] if self.label == "time" else ""
        about = {"long_name": meaning, "units": UNITS.get(unit, unit)}
        return about | ({"cell_methods": method} if method else {})


#: Units in the spelling of CF and UDUNITS.
UNITS = {"W/m2": "W m-2", "kWh/m2": "kW h m-2", "umol/(m2 s)": "umol m-2 s-1", "mol/m2": "mol m-2"}

#: Attributes of the receivers' properties.
COORDINATES: dict[str, dict[str, str]] = {
    "x": {"standard_name": "projection_x_coordinate", "long_name": "x, east", "units": "m"},
    "y": {"standard_name": "projection_y_coordinate", "long_name": "y, north", "units": "m"},
    "z": {"long_name": "z, up", "units": "m", "positive": "up"},
    "nx": {"long_name": "normal of the receiver, x", "units": "1"},
    "ny": {"long_name": "normal of the receiver, y", "units": "1"},
    "nz": {"long_name": "normal of the receiver, z", "units": "1"},
    "area_m2": {"long_name": "area that the receiver stands for", "units": "m2"},
    "surface": {"long_name": "surface that the receiver is on"},
    "object": {"long_name": "object of the model"},
    "building": {"long_name": "building of the model"},
    "kind": {"long_name": "roof, wall, window, ground, floor or shade"},
    "sky_view": {"long_name": "share of the hemisphere that is sky", "units": "1"},
    "ground_view": {"long_name": "share of the hemisphere that is ground", "units": "1"},
    "obstruction_view": {"long_name": "share of the hemisphere that is obstruction", "units": "1"},
}


class Results:
    """Irradiance of receivers: means in W/m2, or sums over periods in kWh/m2.

    `results["total"]` is a column as float32, shape `(receivers, labels)`; it is read-only, since pandas, xarray and Arrow share
    its memory (`.copy()` is yours). Names are those of `columns`.
    """

    def __init__(self, handle: _heliotile.Recombined, table: Callable[[], dict[str, np.ndarray]]) -> None:
        self._handle = handle
        self._frame = Frame(handle.frame())
        self._names: list[str] = handle.receivers
        self._table = table

    @property
    def receivers(self) -> list[str]:
        """Ids of receivers, in the order of rows, which is the archive's."""
        return self._names

    @property
    def columns(self) -> list[str]:
        """Names of the columns."""
        return list(self._frame.columns)

    @property
    def labels(self) -> list[str]:
        """Names of conditions, or times and periods as in CSV files. Shape: labels."""
        return self._frame.labels

    @property
    def time_utc(self) -> np.ndarray | None:
        """Times as datetime64[s] in UTC; None for other labels. Shape: labels."""
        return self._frame.time_utc

    @property
    def utc_offset(self) -> timedelta | None:
        """Offset of the weather's local standard time from UTC."""
        return self._frame.utc_offset

    @property
    def unit(self) -> str:
        """`W/m2` for means, `kWh/m2` for sums."""
        return self._frame.unit

    @property
    def provenance(self) -> dict[str, str]:
        """Provenance of the results: archive, root, weather, options."""
        return self._frame.provenance

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of receivers and labels."""
        return self._frame.receivers, len(self.labels)

    def __getitem__(self, column: str) -> np.ndarray:
        return np.asarray(self._handle.column(column))

    def __contains__(self, column: object) -> bool:
        return column in self._frame.columns

    def __iter__(self) -> Iterator[str]:
        return iter(self._frame.columns)

    def keys(self) -> list[str]:
        """Returns the names of the columns, so that `dict(results)` works."""
        return self.columns

    def __reduce__(self) -> Any:
        raise TypeError("results do not pickle: send to_pandas(), to_xarray() or their columns, or the archive, which pickles by its path")

    def __arrow_c_stream__(self, requested_schema: object = None) -> object:
        """Returns all rows as an Arrow stream; values are not copied: `pyarrow.table(results)`,
        `polars.from_arrow`... Columns have the names of files."""
        return self._handle.__arrow_c_stream__(requested_schema)

    def to_pandas(self) -> pd.DataFrame:
        """Returns a table with a row for each receiver and label; its columns have the names of
        files."""
        import pandas as pd

        receivers, labels = self.shape
        index = self._frame.index()
        if self.time_utc is None:
            index = pd.CategoricalIndex(index, categories=index.unique(), name=index.name)
        # Receivers of different parts of an atlas may have the same id.
        numbers, names = pd.factorize(np.array(self.receivers, dtype=object))
        codes = np.repeat(numbers.astype(np.int32), labels)
        data: dict[str, Any] = {
            self._frame.label: index.take(np.tile(np.arange(labels), receivers)),
            "receiver": pd.Categorical.from_codes(codes, categories=pd.Index(names)),
        }
        data |= {name: self[column].reshape(-1) for column, name in self._frame.columns.items()}
        return pd.DataFrame(data)

    def to_xarray(self) -> xr.Dataset:
        """Returns a Dataset with the dimensions `receiver` and `time` (or `condition`), and the
        receivers' table as coordinates."""
        import xarray as xr

        frame = self._frame
        dims = ("receiver", frame.label)
        variables = {column: (dims, self[column], frame.attributes(column)) for column in self.columns}
        return xr.Dataset(variables, frame.coordinates(self._table()), frame.provenance)

    def to_pvlib(self, receiver: str | int) -> pd.DataFrame:
        """Returns irradiance of one receiver by the names of
        `pvlib.irradiance.get_total_irradiance`, W/m2, a row for each hour.

        `poa_direct` is the sun, direct and by mirrors; `poa_sky_diffuse` is the sky, direct and by
        mirrors; `poa_ground_diffuse` is all diffusely reflected light. Times are those of the
        replay: `replay(..., stamp="middle")` gives the moments of the solar positions.
        """
        import pandas as pd

        if self.unit != "W/m2" or self._frame.label != "time":
            what = "pvlib needs the hours of a replay, and these are other results"
            raise ArgumentError(f'every: {what}\n  to fix: replay(weather, every="hour")')
        row = self._row(receiver)
        columns = {name: np.asarray(values) for name, values in self._handle.pvlib(row)}
        return pd.DataFrame(columns, index=self._frame.index())

    def _row(self, receiver: str | int) -> int:
        if not isinstance(receiver, str):
            row, count = operator.index(receiver), len(self.receivers)
            if not -count <= row < count:
                raise IndexError(f"receiver {row} is out of range: there are {count} receivers")
            return row % count
        try:
            return self.receivers.index(receiver)
        except ValueError:
            raise KeyError(f"no receiver `{receiver}` among the {len(self.receivers)} receivers of these results") from None

    def __repr__(self) -> str:
        receivers, labels = self.shape
        return f"Results({receivers} receivers x {labels} {self._frame.label}s, {', '.join(self.columns)}, {self.unit})"
