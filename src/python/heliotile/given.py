"""Keywords as the engine takes them. In: values of any type. Out: texts by name, and tables in
memory; or an error that names the argument. Ranges and names are checked by the engine, from the
requests that the command line fills, too."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from datetime import date, datetime
from typing import Any, TypeAlias

import numpy as np

from .errors import wrong
from .options import Wanted
from .tables import columns_of, csv_of, refused
from .weather import Weather

#: Selection of receivers as the engine takes it.
WantedArgs: TypeAlias = "list[str] | str | dict[str, list[Any]] | None"

#: Default memory for the work, bytes.
MEMORY = 4 << 30

#: Keywords whose values may be arrays with a value for each row of the weather, and the columns of
#: their tables.
FOLLOWED = {"reflectance": "reflectance", "transmittance": "transmittance", "temperature": "temperature_c"}

#: Keywords of a `Weather`, and the fields of a request that they fill.
OF_WEATHER = ("latitude", "longitude", "time_zone", "shift", "weather_stamp", "date_order")


@dataclass
class Asked:
    """Keywords of a call, as the engine takes them."""

    function: str
    texts: list[tuple[str, bool | list[str]]] = field(default_factory=list)
    tables: dict[str, bytes] = field(default_factory=dict)

    def add(self, **values: Any) -> Asked:
        """Adds keywords; None leaves one out."""
        for name, value in values.items():
            if value is not None:
                getattr(self, f"_add_{name}", self._add)(name, value)
        return self

    def args(self) -> dict[str, Any]:
        """Returns what the engine takes."""
        return {"function": self.function, "texts": self.texts, "tables": self.tables}

    def absolute(self) -> Asked:
        """Returns these keywords with absolute paths of files, for processes in other folders."""
        whole = [(name, text if isinstance(text, bool) else [self._absolute(name, one) for one in text]) for name, text in self.texts]
        return Asked(self.function, whole, self.tables)

    def _absolute(self, name: str, text: str) -> str:
        before, equals, path = text.rpartition("=")
        is_file = name in (*FOLLOWED, "weather", "schedule", "sky", "clouds", "bands") and path not in self.tables and os.path.exists(path)
        return before + equals + os.path.abspath(path) if is_file else text

    def _add(self, name: str, value: Any) -> None:
        if isinstance(value, Mapping):
            texts = [f"{key}={_follow(name, key, one)}" for key, one in value.items()]
        elif isinstance(value, (str, os.PathLike)) or np.ndim(value) == 0 and not isinstance(value, Iterable):
            texts = _text(name, value)
        else:
            texts = [text for one in value for text in _text(name, one) if isinstance(text, str)]
        self.texts.append((name, texts))

    def _add_memory(self, name: str, value: Any) -> None:
        self.texts.append((name, [value if isinstance(value, str) else f"{_whole(name, value)}B"]))

    def _add_height(self, name: str, value: Any) -> None:
        """Metres for all buildings have their unit."""
        values = value if isinstance(value, (str, Mapping)) or np.ndim(value) > 0 else [value]
        metres = [one if isinstance(one, str) else f"{_number(name, one)}m" for one in values] if isinstance(values, (list, tuple)) else values
        self._add(name, metres)

    def _add_base(self, name: str, value: Any) -> None:
        self._add(name, value if isinstance(value, str) else f"{_number(name, value)}m")

    def _add_start(self, name: str, value: Any) -> None:
        self._add(name, _moment(name, value))

    _add_end = _add_start

    def _add_sky(self, name: str, value: Any) -> None:
        """A path is never the name of a model."""
        if isinstance(value, os.PathLike):
            path = os.fspath(value)
            value = path if "." in path or os.sep in path else os.path.join(".", path)
        self._add(name, value)

    def _add_reflectance(self, name: str, value: Any) -> None:
        """Numbers are reflectances, all others are schedules."""
        for key, one in _mapping(name, value).items():
            is_number = not isinstance(one, (str, os.PathLike)) and np.ndim(one) == 0
            self._follow(name, "reflectance" if is_number else "schedule", key, one)

    def _add_followed(self, name: str, value: Any) -> None:
        for key, one in _mapping(name, value).items():
            self._follow(name, name, key, one)

    _add_transmittance = _add_temperature = _add_schedule = _add_followed

    def _follow(self, name: str, row: str, key: str, value: Any) -> None:
        label = f"{name}[{key!r}]"
        if value is None:
            raise wrong(label, "is None", "leave it out, or give a number")
        if isinstance(value, (str, os.PathLike)):
            text = os.fspath(value)
        elif np.ndim(value) > 0:
            text = f'{name}["{key}"]'
            column = FOLLOWED.get(name, "reflectance")
            self.tables[text] = csv_of(columns_of({column: np.asarray(value, dtype=float)}, label))
        else:
            text = _number(label, value)
        known = next((texts for known, texts in self.texts if known == row), None)
        if isinstance(known, list):
            known.append(f"{key}={text}")
        else:
            self.texts.append((row, [f"{key}={text}"]))

    def _add_weather(self, name: str, value: Any) -> None:
        weather = Weather.of(value)
        self._add(name, weather.name)
        if (table := weather.table) is not None:
            if self.tables.setdefault(weather.name, table) != table:
                raise wrong(name, f"is another table with the name `{weather.name}`", 'name it, as in Weather(table, name="other")')
        # Statements about the weather come before those about that of an error target.
        stated = {known for known, _ in self.texts} if name == "error_weather" else ()
        for option, said in zip(OF_WEATHER, weather.said, strict=True):
            if said is not None and option not in stated:
                self._add(option, said)

    _add_error_weather = _add_weather

    def _add_conditions(self, name: str, value: Any) -> None:
        if isinstance(value, (str, os.PathLike)):
            return self._add(name, value)
        table = columns_of(value, name)
        if "condition" not in table and table:
            table["condition"] = np.arange(len(next(iter(table.values()))))
        self._table(name, table)

    def _table(self, name: str, table: dict[str, np.ndarray]) -> None:
        self.tables[name] = csv_of(table)
        self._add(name, name)

    def receivers(self, receivers: Any) -> Asked:
        """Adds a table of receivers: a file, or a table in memory."""
        if isinstance(receivers, (str, os.PathLike)):
            self._add("receivers", receivers)
            return self
        table = columns_of(receivers, "receivers")
        for name in {"area", "area_m2"} & set(table):
            if table[name].dtype.kind == "f":
                # Unknown areas become empty cells.
                areas = table[name].astype(object)
                areas[np.isnan(table[name])] = None
                table[name] = areas
        self._table("receivers", table)
        return self


def asked(function: str, known: type, options: Mapping[str, Any], **more: Any) -> Asked:
    """Returns the keywords of a call. An error: a keyword that the TypedDict `known` does not
    have."""
    names = known.__optional_keys__  # type: ignore[attr-defined]
    for name in options:
        if name not in names:
            raise TypeError(f"{function}() got an unexpected keyword argument {name!r}; known arguments: {', '.join(sorted(names))}")
    if "scene" in more:
        for name in ("weather", "error_weather"):
            _of_scene(name, options.get(name, more.get(name)))
    plain = {name: value for name, value in options.items() if name not in ("progress", "receivers", "bbox", "surfaces", "objects")}
    return Asked(function).add(**more, **plain)


def wanted_of(options: Mapping[str, Any]) -> WantedArgs:
    """Returns the receivers that the keywords of a call select."""
    ways = {name: options[name] for name in ("receivers", "bbox", "surfaces", "objects") if options.get(name) is not None}
    if len(ways) > 1:
        raise wrong(", ".join(ways), "only one of them can be given", "select receivers in one way")
    if "receivers" in ways or not ways:
        return wanted_args(ways.get("receivers"))
    return wanted_args(ways)


def wanted_args(wanted: Wanted | None) -> WantedArgs:
    """Returns a selection of receivers for the engine."""
    receivers: Any = wanted
    if receivers is None:
        return None
    if isinstance(receivers, os.PathLike):
        return os.fspath(receivers)
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
        receivers = table["receiver"]
    if not hasattr(receivers, "__array__"):
        # Sets, keys, generators.
        receivers = list(receivers)
    ids = np.asarray(receivers)
    if ids.dtype.kind == "b" and ids.size:
        raise refused("receivers", "is a mask, and ids are needed", 'give site.receivers()["receiver"][mask]')
    if ids.ndim > 1:
        raise refused("receivers", f"has the shape {ids.shape}", "give ids one after the other")
    return [str(receiver) for receiver in np.atleast_1d(ids).tolist()]


def file_only(weather: Any) -> None:
    """Refuses weather of a table."""
    if weather is not None and (found := Weather.of(weather)).table is not None:
        raise wrong(found.name, "is a table, and this function reads weather from a file only", "write the table to a CSV file and give its path")


def _of_scene(name: str, weather: Any) -> None:
    """Refuses weather with a location of its own where the scene states it."""
    if weather is not None and Weather.of(weather).said[:2] != (None, None):
        raise wrong(name, "states its location, and this function takes that of the scene", "give latitude and longitude to the `Scene`")


def _text(name: str, value: Any) -> Any:
    """Returns the texts of one value; a truth value as it is."""
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    if isinstance(value, (str, os.PathLike)):
        return [os.fspath(value)]
    return [_number(name, value)]


def _number(name: str, value: Any) -> str:
    """Returns a number as text, also NumPy's numbers."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise wrong(name, f"`{value}` is not a number", "give a number") from None
    return str(int(number)) if number.is_integer() and abs(number) < 1e15 else repr(number)


def _whole(name: str, value: Any) -> int:
    """Returns a whole number from 0."""
    try:
        found = int(value)
        if found != float(value) or found < 0:
            raise ValueError
    except (TypeError, ValueError, OverflowError):
        raise wrong(name, f"`{value}` is not a whole number, 0 or more", "give a whole number") from None
    return found


def _moment(name: str, value: Any) -> str:
    """Returns a day or a moment as text: text as it is, dates and times by the calendar."""
    if isinstance(value, str):
        return value
    if hasattr(value, "astype") and getattr(value, "dtype", None) is not None and value.dtype.kind == "M":
        return str(value.astype("datetime64[m]"))
    if isinstance(value, datetime):
        if value.tzinfo is not None:
            raise wrong(name, f"`{value}` has a time zone", "give the moment by the clock of the weather, without a zone")
        return value.strftime("%Y-%m-%dT%H:%M")
    if isinstance(value, date):
        return value.isoformat()
    raise wrong(name, f"`{value}` is not a day or a moment", 'give a string such as "2019-03-01" or "03-01T06:00", or a date')


def _mapping(name: str, value: Any) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise wrong(name, f"`{value}` is not a mapping", f'give a mapping, as in {name}={{"ground": 0.3}}')
    return value


def _follow(name: str, key: str, value: Any) -> str:
    """Returns the value of a name in a mapping: a text, a number, or several numbers."""
    if isinstance(value, (str, os.PathLike)):
        return os.fspath(value)
    if np.ndim(value) > 0:
        return ",".join(_number(f"{name}[{key!r}]", one) for one in value)
    return _number(f"{name}[{key!r}]", value)
