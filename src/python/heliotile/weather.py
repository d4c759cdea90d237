"""Weather for replays. In: a file, or a DataFrame with pvlib's names. Out: what the engine's weather reader takes."""

from __future__ import annotations

import os
from collections.abc import Mapping
from datetime import datetime, timedelta, timezone
from typing import Any, TypedDict
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

import numpy as np

from . import given
from .tables import checked, columns_of, csv_of, refused

#: What messages and provenance call weather that was given as a table.
TABLE = "weather"


class WeatherArgs(TypedDict):
    """As the engine takes it."""

    weather: dict[str, Any]
    latitude: float | None
    longitude: float | None
    time_zone: str | None
    shift: str | None
    weather_stamp: str | None


class Weather:
    """Weather of a file, or of a table, and what is said about it.

    Parameters
    ----------
    source
        Path of an EPW, TMY3, NSRDB, PVGIS, SURFRAD or CSV file, packed with gzip or not; or a pandas DataFrame with some of
        pvlib's columns `ghi`, `dni`, `dhi` (W/m2), and perhaps `temp_air` (degrees Celsius), `albedo`, `snow_depth` (cm) and what
        else the book's page of weather lists, whose index are times with a zone; or a table of Polars or Arrow, or a mapping of arrays, with
        a column `time`; or a table and its metadata, as pvlib's readers give both.
    latitude, longitude
        Degrees, north and east positive, in place of the file's. Where neither says, the archive's place is taken.
    time_zone
        Hours ahead of UTC in standard time, such as `"+01:00"`, or the name of a zone, `"America/Denver"`, in place of the file's.
    shift
        Moves time stamps: `"41min"`, `"-0.5h"` or `"auto"`.
    stamp
        Where in its interval a time stamp stands: `"start"`, `"middle"` or `"end"`. Default: what the format says; start for tables.
    name
        What messages and provenance call a table.
    """

    def __init__(
        self,
        source: Any,
        *,
        latitude: float | None = None,
        longitude: float | None = None,
        time_zone: str | float | None = None,
        shift: str | None = None,
        stamp: str | None = None,
        name: str = TABLE,
    ) -> None:
        self.name = name
        self._bytes: bytes | None = None
        if isinstance(source, tuple) and len(source) == 2 and isinstance(source[1], Mapping):
            # What pvlib's readers give: a table, and what is known of its place.
            source, about = source
            latitude = about.get("latitude") if latitude is None else latitude
            longitude = about.get("longitude") if longitude is None else longitude
        if isinstance(source, (str, os.PathLike)):
            self.name = os.fspath(source)
        else:
            self._bytes, zone = _table(source, name, time_zone is not None)
            time_zone = time_zone if time_zone is not None else zone
        self._said = (given.number("latitude", latitude), given.number("longitude", longitude), _hours(time_zone), shift, stamp)

    @classmethod
    def of(cls, source: Any) -> Weather:
        """Weather as it is, or of a path or a table about which there is nothing to say."""
        return source if isinstance(source, cls) else cls(source)

    def args(self) -> WeatherArgs:
        """As the engine takes it."""
        latitude, longitude, time_zone, shift, stamp = self._said
        return {
            "weather": {"name": self.name, "bytes": self._bytes},
            "latitude": latitude,
            "longitude": longitude,
            "time_zone": time_zone,
            "shift": shift,
            "weather_stamp": stamp,
        }

    def __repr__(self) -> str:
        return f"Weather({self.name!r})"


def _table(source: Any, name: str, has_zone: bool) -> tuple[bytes, str | None]:
    """The bytes of a table, and the zone of its clock if its times say it."""
    columns, zone = columns_of(source, name), None
    times: Any = None if isinstance(source, Mapping) else _zoned(source)
    index: Any = getattr(source, "index", None)
    if "time" not in columns and hasattr(index, "tz"):
        if index.tz is None and not has_zone:
            hint = f'say which clock it is, as in table.tz_localize("Etc/GMT-1") for UTC+01:00, or {name}=Weather(table, time_zone="+01:00")'
            raise refused(name, "its index has no time zone", hint)
        if index.tz is not None:
            times = index.tz_convert("UTC").tz_localize(None).to_numpy(), index.tz
        else:
            columns = {"time": np.array([stamp.isoformat() for stamp in index], dtype=object), **columns}
    if times is not None:
        utc, of = times
        offset = standard_offset(of, utc)
        local = utc + np.timedelta64(int(offset.total_seconds()), "s")
        clock = datetime.min.replace(tzinfo=timezone(offset)).isoformat()[-6:]
        texts = np.char.add(np.datetime_as_string(local.astype("datetime64[ms]")), clock)
        columns = {"time": texts.astype(object), **{key: values for key, values in columns.items() if key != "time"}}
        zone = str(offset.total_seconds() / 3600)
    # Other times than `time`, and shares of yes and no, are nothing that a weather file has.
    numbers = {key: values for key, values in columns.items() if key == "time" or values.dtype.kind in "fiuOUST"}
    if "time" not in numbers:
        raise refused(name, "has no times", "give a DataFrame whose index are times with a zone, or a column `time`")
    return csv_of(checked(numbers, name)), zone


def _zoned(source: Any) -> tuple[np.ndarray, Any] | None:
    """Moments in UTC and the zone of a column `time` of pandas, Polars or Arrow, if it has a zone."""
    names = getattr(source, "column_names", None) or getattr(source, "columns", ())
    if "time" not in list(names):
        return None
    column: Any = source["time"]
    of = getattr(column.dtype, "tz", None) or getattr(column.dtype, "time_zone", None) if hasattr(column, "dtype") else getattr(column.type, "tz", None)
    if of is None:
        return None
    if hasattr(column, "dt") and hasattr(column.dt, "tz_convert"):
        return column.dt.tz_convert("UTC").dt.tz_localize(None).to_numpy(), of
    # Polars and Arrow hold UTC, and give it away without its zone.
    values = column.to_numpy()
    return values.astype("datetime64[ns]"), ZoneInfo(of) if isinstance(of, str) else of


def standard_offset(of: Any, utc: np.ndarray) -> timedelta:
    """How far the clock of a zone is ahead of UTC in standard time, never that of summer, in the year of the first of some moments."""
    year = int(str(utc[0])[:4]) if len(utc) else 2000
    offsets = [datetime(year, month, 1, tzinfo=timezone.utc).astimezone(of).utcoffset() for month in (1, 7)]
    return min(offset for offset in offsets if offset is not None)


def _hours(time_zone: Any) -> str | None:
    """Hours ahead of UTC as text, of a name such as `America/Denver` those of standard time."""
    if time_zone is None or not isinstance(time_zone, str) or "/" not in time_zone:
        return None if time_zone is None else str(time_zone)
    try:
        return str(standard_offset(ZoneInfo(time_zone), np.array([])).total_seconds() / 3600)
    except (ZoneInfoNotFoundError, ValueError):
        return time_zone
