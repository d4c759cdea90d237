"""Arguments as users give them. In: a value of any type. Out: the plain type that the engine takes,
or an error that names the argument."""

from __future__ import annotations

import os
from collections.abc import Mapping
from datetime import date, datetime
from typing import Any

from .errors import ArgumentError


def wrong(argument: str, what: str, hint: str) -> ArgumentError:
    """Returns an error about an argument, in the usual form."""
    error = ArgumentError(f"{argument}: {what}\n  to fix: {hint}")
    error.argument, error.what, error.hint = argument, what, hint
    return error


def number(argument: str, value: Any, hint: str = "give a number") -> float | None:
    """Returns a number, also from NumPy's numbers; None for None."""
    if value is None:
        return None
    try:
        return float(value)
    except (TypeError, ValueError):
        raise wrong(argument, f"`{value}` is not a number", hint) from None


def whole(argument: str, value: Any, hint: str = "give a whole number") -> int | None:
    """Returns a whole number from 0, also from text; None for None."""
    if value is None:
        return None
    try:
        found = int(value)
        if found != float(value) or found < 0:
            raise ValueError
    except (TypeError, ValueError, OverflowError):
        raise wrong(argument, f"`{value}` is not a whole number, 0 or more", hint) from None
    return found


def word(argument: str, value: Any, hint: str) -> str:
    """Returns text; other types are an error."""
    if not isinstance(value, str):
        raise wrong(argument, f"`{value}` is not a string", hint)
    return value


def moment(argument: str, value: Any) -> str | None:
    """Returns a day or a moment as text: text as it is, dates and times by the calendar; None for
    None."""
    if value is None or isinstance(value, str):
        return value
    if hasattr(value, "astype") and getattr(value, "dtype", None) is not None and value.dtype.kind == "M":
        return str(value.astype("datetime64[m]"))
    if isinstance(value, datetime):
        if value.tzinfo is not None:
            raise wrong(argument, f"`{value}` has a time zone", "give the moment by the clock of the weather, without a zone")
        return value.strftime("%Y-%m-%dT%H:%M")
    if isinstance(value, date):
        return value.isoformat()
    raise wrong(argument, f"`{value}` is not a day or a moment", 'give a string such as "2019-03-01" or "03-01T06:00", or a date')


def named(argument: str, value: Any, hint: str) -> Mapping[str, Any]:
    """Returns a mapping; an empty one for None."""
    if value is None:
        return {}
    if not isinstance(value, Mapping):
        raise wrong(argument, f"`{value}` is not a mapping", hint)
    return value


def percent(argument: str, value: Any) -> float | None:
    """Returns percent, from a number or from text with or without its sign; None for None."""
    if isinstance(value, str):
        value = value.strip().removesuffix("%")
    return number(argument, value, 'give percent, as in error=2 or error="2%"')


def epsg(value: Any) -> int | None:
    """Returns the number of a coordinate system, also from `EPSG:28992`; None for None."""
    if isinstance(value, str) and value.upper().startswith("EPSG:"):
        value = value[5:]
    return whole("crs", value, 'give an EPSG number: 28992 or "EPSG:28992"')


def path(value: str | os.PathLike[str] | None) -> str | None:
    """Returns a path as text; None for None."""
    return None if value is None else os.fspath(value)
