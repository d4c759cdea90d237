"""Variants of a site. In: an archive before a change, archives after it, weather or conditions.
Out: light before and after, its change, and a summary of gains and losses."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np

from .archive import Archive
from .askable import Askable
from .given import asked
from .options import CompareOptions

if TYPE_CHECKING:
    import pandas as pd

#: A path, or an `Archive`.
Site = Any


@dataclass(frozen=True)
class Comparison:
    """Light before and after a change: `comparison["change_total_kwh_m2"]` has the shape (places,
    labels).

    Only the summary is set if several variants are compared or a file was written.
    """

    summary: list[dict[str, Any]]
    """A row for each changed archive, by the names of the columns of `heliotile compare
    --summary`."""
    text: str
    """The summary as text."""
    by: str = "receiver"
    label: str = "time"
    """`time` or `condition`."""
    places: list[str] = field(default_factory=list)
    """Receivers, surfaces and so on of both sides."""
    labels: list[str] = field(default_factory=list)
    units: dict[str, str] = field(default_factory=dict)
    """Names of columns, and their units."""
    values: np.ndarray = field(default_factory=lambda: np.zeros((0, 0, 0), np.float32))
    """float32, shape (places, labels, columns); NaN where there is no change in percent."""
    provenance: dict[str, Any] = field(default_factory=dict)

    @property
    def columns(self) -> list[str]:
        """Names of the columns."""
        return list(self.units)

    def __getitem__(self, column: str) -> np.ndarray:
        return self.values[:, :, self.columns.index(column)]

    def __repr__(self) -> str:
        return self.text

    def to_pandas(self) -> pd.DataFrame:
        """Returns a table with a row for each place and label; its columns have the names of
        files."""
        import pandas as pd

        count = len(self.labels)
        names = {self.label: self.labels * len(self.places), self.by: np.repeat(self.places, count)}
        return pd.DataFrame(names | {column: self[column].ravel() for column in self.columns})


def compare(
    before: Site,
    after: Site | Sequence[Site],
    weather: Any = None,
    **options: Unpack[CompareOptions],
) -> Comparison:
    """Compares the light of receivers before and after a change of a site: `heliotile compare`,
    value by value.

    `before` and `after` are paths or archives; `before` may be an `Atlas`. Several archives after
    the change give a summary. Give `weather` with the options of `Archive.replay`, where the
    default of `every` is `"total"`, or `conditions` with the options of `Archive.query`. The
    default of `columns` is `["total"]`. `output`: a table or a map that is written instead of
    values in memory. The other options are those of `heliotile.options.CompareOptions`.
    """
    said: dict[str, Any] = {"columns": ["total"], **options}
    variants = [after] if isinstance(after, (str, os.PathLike, Archive)) else list(after)
    in_memory = options.get("output") is None and not options.get("plots") and len(variants) == 1
    with tempfile.TemporaryDirectory() as folder:
        table = Path(folder) / "change.npz"
        if in_memory:
            said["output"] = table
        keywords = asked("compare", CompareOptions, said, weather=weather, after=[_path(variant) for variant in variants])
        site = before if isinstance(before, Askable) else Archive.open(before)
        rows, text = site._ask("compare", keywords, options)
        made = Comparison(rows, text)
        return _with_values(made, table, options.get("by") or "receiver") if in_memory else made


def _path(site: Site) -> str:
    return os.fspath(site.path if isinstance(site, Archive) else site)


def _with_values(made: Comparison, table: Path, by: str) -> Comparison:
    """Adds the values of a table to a comparison."""
    with np.load(table) as arrays:
        names = [str(name) for name in arrays["column"]]
        label = next(name for name in ("time", "condition") if name in arrays)
        units = np.broadcast_to(arrays["unit"], len(names))
        return Comparison(
            made.summary,
            made.text,
            by,
            label,
            [str(name) for name in arrays[by]],
            [str(name) for name in arrays[label]],
            dict(zip(names, map(str, units), strict=True)),
            arrays["values"],
            json.loads(str(arrays["provenance"])),
        )
