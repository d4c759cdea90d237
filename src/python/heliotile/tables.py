"""Tables in memory as the engine's readers take them. In: a DataFrame, a mapping of arrays. Out: the bytes of a CSV file.

One reader checks files and tables alike, so that a wrong cell has the same message in both.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from typing import Any

import numpy as np

from .errors import InputError


def columns_of(table: Any, name: str) -> dict[str, np.ndarray]:
    """The columns of a mapping, or of a table of pandas, Polars or Arrow: `[row]` each, all of one length. `name` is for messages."""
    if isinstance(table, Mapping):
        found = {str(key): np.asarray(values) for key, values in table.items()}
    elif hasattr(table, "column_names"):
        # Arrow, whose `columns` are not names.
        found = {str(key): np.asarray(table[key]) for key in table.column_names}
    elif hasattr(table, "collect") and not hasattr(table, "__array__") and not hasattr(table, "to_numpy"):
        raise refused(name, f"is of the type {type(table).__name__}", "collect it first: table.collect()")
    elif hasattr(table, "columns"):
        found = {str(key): np.asarray(table[key]) for key in table.columns}
    else:
        raise refused(name, f"is of the type {type(table).__name__}", "give a path, a DataFrame or a mapping of arrays")
    return checked(found, name)


def checked(columns: dict[str, np.ndarray], name: str) -> dict[str, np.ndarray]:
    """Refuses columns of different lengths, and arrays that are none."""
    lengths = {key: values.shape for key, values in columns.items()}
    for key, shape in lengths.items():
        if len(shape) != 1:
            raise refused(name, f"column `{key}` has the shape {shape}", "give one value a row: an array of one dimension")
    if len(set(lengths.values())) > 1:
        told = ", ".join(f"`{key}` has {shape[0]}" for key, shape in lengths.items())
        raise refused(name, f"columns have different numbers of rows: {told}", "give all of them the same length")
    return columns


def csv_of(columns: Mapping[str, np.ndarray]) -> bytes:
    """Numbers are written so that they are read again to the last bit."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns.keys())
    writer.writerows(zip(*(_cells(values) for values in columns.values()), strict=True))
    return text.getvalue().encode()


def _cells(values: np.ndarray) -> list[Any]:
    """Cells of a column; what is missing by pandas' word, and None, is empty."""
    if values.dtype.kind == "M":
        # To milliseconds, as a calendar has them.
        return ["" if text == "NaT" else text for text in np.datetime_as_string(values.astype("datetime64[ms]")).tolist()]
    cells = values.tolist()
    if values.dtype.kind in "OUST":
        # A lone carriage return would end the row.
        cells = [None if _is_missing(cell) else cell.replace("\r", " ") if isinstance(cell, str) else cell for cell in cells]
    return cells


def _is_missing(cell: Any) -> bool:
    # pandas' NA and NaT are known by their types, so that pandas need not be here.
    return cell is None or type(cell).__name__ in ("NAType", "NaTType")


def refused(name: str, what: str, hint: str) -> InputError:
    """An error of a table, in the words of all others."""
    error = InputError(f"{name}: {what}\n  to fix: {hint}")
    error.what, error.hint = what, hint
    return error
