"""Weather for replays. In: a file, or a DataFrame with pvlib's names. Out: what the engine's weather reader takes."""

from __future__ import annotations

import os
from datetime import timezone
from typing import Any, TypedDict

import numpy as np

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
        else the book's page of weather lists, whose index are times with a zone; or a mapping of arrays with a column `time`.
    latitude, longitude
        Degrees, north and east positive, in place of the file's. Where neither says, the archive's place is taken.
    time_zone
        Hours ahead of UTC in standard time, such as `"+01:00"`, in place of the file's.
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
        if isinstance(source, (str, os.PathLike)):
            self.name = os.fspath(source)
        else:
            self._bytes, zone = _table(source, name, time_zone is not None)
            time_zone = time_zone if time_zone is not None else zone
        self._said = (latitude, longitude, None if time_zone is None else str(time_zone), shift, stamp)

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
    index: Any = getattr(source, "index", None)
    if "time" not in columns and hasattr(index, "tz"):
        if index.tz is None and not has_zone:
            hint = f'say which clock it is, as in table.tz_localize("Etc/GMT-1") for UTC+01:00, or {name}=Weather(table, time_zone="+01:00")'
            raise refused(name, "its index has no time zone", hint)
        if index.tz is not None:
            # Standard time: never that of summer, if there is a winter among the rows.
            offset = min((stamp.utcoffset() for stamp in index[:: max(1, len(index) // 400)]), default=None)
            if offset is not None:
                index = index.tz_convert(timezone(offset))
                zone = str(offset.total_seconds() / 3600)
        columns = {"time": np.array([stamp.isoformat() for stamp in index], dtype=object), **columns}
    numbers = {key: values for key, values in columns.items() if key == "time" or values.dtype.kind in "fiu"}
    if "time" not in numbers:
        raise refused(name, "has no times", "give a DataFrame whose index are times with a zone, or a column `time`")
    return csv_of(checked(numbers, name)), zone
