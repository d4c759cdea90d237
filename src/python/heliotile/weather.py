"""Weather for replays. In: a file, or a DataFrame with pvlib's names. Out: arguments of the
engine's weather reader."""

from __future__ import annotations

import os
from collections.abc import Mapping
from datetime import datetime, timedelta, timezone
from typing import Any
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

import numpy as np

from .errors import ArgumentError, wrong
from .tables import checked, columns_of, csv_of, refused

#: Name of weather from a table, for messages and provenance.
TABLE = "weather"


class Weather:
    """Weather of a file or of a table, with options of how to read it.

    Parameters
    ----------
    source
        Path of a file in any layout that the book's page on weather lists, compressed or not. Or a
        pandas DataFrame with some of pvlib's columns `ghi`, `dni`, `dhi` (W/m2), and optionally
        `temp_air` (degrees Celsius), `albedo`, `snow_depth` (cm) and others on that page, indexed
        by times with a zone. Or a table of Polars or Arrow, a Dataset of xarray or a mapping of
        arrays, with a column of time. Or a table and its metadata, as pvlib's readers return both.
        A name may state its unit, `ghi (kW/m2)`. An index or column `period_end` has the ends of
        the intervals.
    latitude, longitude
        Degrees, north and east positive, in place of the file's. If neither states a location, that
        of the archive is used.
    time_zone
        Hours ahead of UTC in standard time, such as `"+01:00"`, or the name of a zone, such as
        `"Europe/Amsterdam"`, whose clock bounds the days, in summer and winter, in place of the
        file's. An index of times names the zone of its days itself; times without a zone are those
        of this clock.
    shift
        Moves time stamps: `"41min"`, `"-0.5h"` or `"auto"`.
    stamp
        Position of a time stamp in its interval: `"start"`, `"middle"` or `"end"`. Default: that of
        the format, or that in the name of the index or column of time; else the start for tables.
    date_order
        Order of dates of three numbers, `"dmy"`, `"mdy"` or `"ymd"`. Default: the order that the
        whole column shows.
    name
        Name of a table for messages and provenance.
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
        date_order: str | None = None,
        name: str = TABLE,
    ) -> None:
        self.name = name
        self._bytes: bytes | None = None
        if isinstance(source, tuple) and len(source) == 2 and isinstance(source[1], Mapping):
            # pvlib's readers return a table and the metadata of its location.
            source, about = source
            place = _place_of(about)
            latitude = place.get("latitude") if latitude is None else latitude
            longitude = place.get("longitude") if longitude is None else longitude
            stamp = stamp or _stamp_of(about)
        if isinstance(source, (str, os.PathLike)):
            self.name = os.fspath(source)
            zone = None if time_zone is None else str(time_zone)
        else:
            self._bytes, zone = _table(source, name, time_zone)
        self.said: tuple[float | None, float | None, str | None, str | None, str | None, str | None] = (latitude, longitude, zone, shift, stamp, date_order)
        """Statements about the weather: latitude, longitude, zone, shift, stamp, order of dates."""

    @classmethod
    def of(cls, source: Any) -> Weather:
        """Returns a `Weather` as it is, or the weather of a path or a table without options."""
        return source if isinstance(source, cls) else cls(source)

    @property
    def table(self) -> bytes | None:
        """Table in memory, as the text of a CSV file; None for a file."""
        return self._bytes

    def __repr__(self) -> str:
        return f"Weather({self.name!r})"


#: Names of times, without case, blanks and underscores, that the engine's reader knows; the usual
#: ones first.
TIMES = ("time", "timestamp", "datetime", "periodstart", "starttime", "intervalstart", "periodend", "endtime", "intervalend", "periodmid", "validtime", "date")
#: Names of columns that give the time together with others.
PARTS = ("year", "month", "day", "hour", "minute", "date")


def _plain(name: Any) -> str:
    """Returns a name without case, blanks and underscores, and without a zone at its end."""
    plain = str(name).lower().replace("_", "").replace(" ", "").replace("-", "").split("(")[0].split("[")[0]
    return plain.removesuffix("utc") or plain


def _time_of(columns: Mapping[str, np.ndarray]) -> str | None:
    """Returns the name of the column of times."""
    plain = {_plain(name): name for name in reversed(list(columns))}
    return next((plain[name] for name in TIMES if name in plain), None)


def _table(source: Any, name: str, time_zone: Any) -> tuple[bytes, str | None]:
    """Returns the bytes of a table and the zone of its clock, from its times or from
    `time_zone`."""
    source = _frame_of(source)
    columns = columns_of(source, name)
    # Order of preference: a column `time`, an index of times, columns with other names of times.
    has_times = hasattr(getattr(source, "index", None), "tz_localize")
    key = "time" if "time" in columns else None if has_times else _time_of(columns)
    is_index = key is None
    given_times: Any = source[key] if key is not None else getattr(source, "index", None)
    # The name of an index may state the position in the interval: `period_end`.
    key = key or next((str(told) for told in [getattr(given_times, "name", None)] if _plain(told) in TIMES), "time")
    found = None if given_times is None else _moments(given_times)
    if found is None and is_index and given_times is not None and hasattr(given_times, "tz_localize"):
        # An index of times without a zone.
        if time_zone is None:
            hint = f'state the zone, as in table.tz_localize("Etc/GMT-1") for UTC+01:00, or {name}=Weather(table, time_zone="+01:00")'
            raise refused(name, "its index has no time zone", hint)
        if _is_name(time_zone):
            found = _moments(_localized(given_times, time_zone, name))
        else:
            columns = {key: np.asarray(given_times.to_numpy()), **columns}
    if found is None:
        zone = None if time_zone is None else str(time_zone)
    else:
        utc, of = found
        offset = standard_offset(of, utc)
        columns = {key: _texts(utc, offset), **{other: values for other, values in columns.items() if other != key}}
        for other in [other for other in columns if other != key and _plain(other) in TIMES]:
            # The second time stamp of a row, by the same clock.
            if (pair := _moments(source[other])) is not None:
                columns[other] = _texts(pair[0], offset)
        zone = _name_of(of) or str(offset.total_seconds() / 3600) if time_zone is None else str(time_zone)
    # Other columns of times and of True and False are not part of weather.
    def is_told(other: str, values: np.ndarray) -> bool:
        is_time = _plain(other) in TIMES
        return other == key or (values.dtype.kind in "fiuOUST" and not (is_time and is_index)) or (is_time and not is_index)

    numbers = {other: values for other, values in columns.items() if is_told(other, values)}
    if key not in numbers and not any(_plain(other) in PARTS for other in numbers):
        raise refused(name, "has no times", "give a DataFrame whose index are times with a zone, or a column `time`")
    return csv_of(checked(numbers, name)), zone


def _texts(utc: np.ndarray, offset: timedelta) -> np.ndarray:
    """Returns moments as text by a clock that is `offset` ahead of UTC."""
    local = utc + np.timedelta64(int(offset.total_seconds()), "s")
    clock = datetime(2000, 1, 1, tzinfo=timezone(offset)).isoformat()[-6:]
    return np.where(np.isnat(utc), "", np.char.add(np.datetime_as_string(local.astype("datetime64[ms]")), clock)).astype(object)


def _frame_of(source: Any) -> Any:
    """Returns a Dataset of xarray as a mapping of its variables and of its only coordinate of
    times, with units in the names."""
    if not (hasattr(source, "data_vars") and hasattr(source, "coords") and hasattr(source, "dims")):
        return source

    def named(key: Any, variable: Any) -> str:
        unit = variable.attrs.get("units") if variable.dtype.kind in "fiu" and "(" not in str(key) else None
        return f"{key} ({unit})" if unit else str(key)

    flat = source.squeeze()
    times = {str(key): flat[key].to_numpy() for key in flat.coords if flat[key].ndim == 1}
    return {**times, **{named(key, flat[key]): flat[key].to_numpy() for key in flat.data_vars if flat[key].ndim == 1}}


def _moments(times: Any) -> tuple[np.ndarray, Any] | None:
    """Returns moments in UTC, datetime64, and their zone; None for times without a zone."""
    # An index or series of pandas, also with Arrow's types.
    accessor = times.dt if hasattr(times, "dt") and hasattr(times.dt, "tz_convert") else times
    if hasattr(accessor, "tz_convert") and getattr(accessor, "tz", None) is not None:
        utc = accessor.tz_convert("UTC")
        utc = utc.dt.tz_localize(None) if hasattr(utc, "dt") else utc.tz_localize(None)
        return utc.to_numpy(dtype="datetime64[ns]"), accessor.tz
    # Polars and Arrow hold UTC and convert to NumPy without the zone.
    of = getattr(getattr(times, "dtype", None), "time_zone", None) or getattr(getattr(times, "type", None), "tz", None)
    if of is not None:
        return np.asarray(times.to_numpy()).astype("datetime64[ns]"), _zone(of)
    # Objects of datetime.
    told = np.asarray(times)
    first = next((moment for moment in told.tolist() if isinstance(moment, datetime)), None) if told.dtype.kind == "O" else None
    if first is None or first.tzinfo is None:
        return None
    utc = [moment.astimezone(timezone.utc).replace(tzinfo=None) if isinstance(moment, datetime) else "NaT" for moment in told.tolist()]
    return np.array(utc, dtype="datetime64[us]"), first.tzinfo


def _localized(index: Any, time_zone: str, name: str) -> Any:
    """Adds the zone to times of a wall clock; an hour that the clock shows twice or never is an
    error."""
    try:
        return index.tz_localize(_zone(time_zone))
    except ArgumentError:
        raise
    except Exception as error:
        hint = "give standard time or UTC, which have each hour once"
        raise refused(name, f"the clock of `{time_zone}` shows an hour of the index twice or never: {error}", hint) from None


def standard_offset(of: Any, utc: np.ndarray) -> timedelta:
    """Returns the offset of a zone's standard time from UTC, never that of summer, in the year of
    the first moment."""
    known = utc[~np.isnat(utc)]
    year = int(str(known[0])[:4]) if len(known) else 2000
    offsets = [datetime(year, month, 1, tzinfo=timezone.utc).astimezone(of).utcoffset() for month in (1, 7)]
    return min(offset for offset in offsets if offset is not None)


def _place_of(about: Mapping[Any, Any]) -> Mapping[Any, Any]:
    """Returns the part of a reader's metadata with latitude and longitude."""
    inputs = about.get("inputs")
    # PVGIS states its inputs beside its outputs.
    location = inputs.get("location") if isinstance(inputs, Mapping) else None
    return location if isinstance(location, Mapping) and "latitude" not in about else about


def _stamp_of(about: Mapping[Any, Any]) -> str | None:
    """Returns the position of time stamps in their intervals, by a reader's metadata; None where it
    is that of other tables. TMY3 and SURFRAD are stamped with ends; NSRDB and PVGIS hold values of
    moments."""
    names = {str(name).lower() for name in about}
    if "usaf" in names or "surfrad_version" in names:
        return "end"
    is_nsrdb = "nsrdb" in str(about.get("Source", about.get("source", ""))).lower()
    return "middle" if is_nsrdb or "inputs" in names else None


def _name_of(of: Any) -> str | None:
    """Returns the name of a zone of the tz database, such as `Europe/Amsterdam`, if it has one."""
    name = getattr(of, "key", None) or getattr(of, "zone", None)
    return name if _is_name(name) else None


def _is_name(time_zone: Any) -> bool:
    """Returns True for the name of a zone, such as `America/Denver`."""
    return isinstance(time_zone, str) and "/" in time_zone


def _zone(of: Any) -> Any:
    """Returns the zone of a name, or of an offset such as `+01:00`."""
    if not isinstance(of, str):
        return of
    try:
        return datetime.fromisoformat(f"2000-01-01T00:00{of}").tzinfo if of[:1] in ("+", "-") else ZoneInfo(of)
    except (ZoneInfoNotFoundError, ValueError):
        raise wrong("time_zone", f"`{of}` is not a known time zone", 'give hours ahead of UTC, as in "+01:00", or a name such as "America/Denver"') from None
