"""Tables in memory for the engine's readers. In: a DataFrame, a mapping of arrays. Out: the bytes
of a CSV file.

One reader checks files and tables, so a wrong cell has the same message in both.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from typing import Any

import numpy as np

from .errors import InputError


def columns_of(table: Any, name: str) -> dict[str, np.ndarray]:
    """Returns the columns of a mapping, or of a table of pandas, Polars or Arrow: `[row]` each, all
    of one length. `name` is for messages."""
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
    """Checks that columns have one dimension and the same length."""
    lengths = {key: values.shape for key, values in columns.items()}
    for key, shape in lengths.items():
        if len(shape) != 1:
            raise refused(name, f"column `{key}` has the shape {shape}", "give one value a row: an array of one dimension")
    if len(set(lengths.values())) > 1:
        told = ", ".join(f"`{key}` has {shape[0]}" for key, shape in lengths.items())
        raise refused(name, f"columns have different numbers of rows: {told}", "give all of them the same length")
    return columns


def csv_of(columns: Mapping[str, np.ndarray]) -> bytes:
    """Writes a CSV file. Numbers read back to the last bit."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns.keys())
    writer.writerows(zip(*(_cells(values) for values in columns.values()), strict=True))
    return text.getvalue().encode()


def _cells(values: np.ndarray) -> list[Any]:
    """Returns the cells of a column; None and pandas' missing values are empty."""
    if values.dtype.kind == "M":
        # Text to the millisecond.
        return ["" if text == "NaT" else text for text in np.datetime_as_string(values.astype("datetime64[ms]")).tolist()]
    cells: list[Any] = values.tolist()
    if values.dtype.kind in "OUST":
        # A lone carriage return would end the row.
        cells = [None if _is_missing(cell) else cell.replace("\r", " ") if isinstance(cell, str) else cell for cell in cells]
    return cells


def _is_missing(cell: Any) -> bool:
    # pandas' NA and NaT are known by the names of their types, so pandas is not needed.
    return cell is None or type(cell).__name__ in ("NAType", "NaTType")


def refused(name: str, what: str, hint: str) -> InputError:
    """Returns an error about a table, in the usual form."""
    error = InputError(f"{name}: {what}\n  to fix: {hint}")
    error.what, error.hint = what, hint
    return error
