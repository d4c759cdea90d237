"""Work that writes folders and archives: the program's `run`, `pv`, `comfort`, `energyplus`,
`tradeoff`, `report`, `merge` and `diff`. In: keyword arguments. Out: files, and a summary. Arguments fill the
same requests as the command line."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Unpack

from . import _heliotile
from .archive import Archive
from .atlas import Atlas
from .given import asked, file_only
from .options import (
    DiffOptions,
    EnergyplusOptions,
    MergeOptions,
    PartitionOptions,
    PeopleOptions,
    PvOptions,
    ReportOptions,
    RunOptions,
    TradeoffOptions,
)
from .scene import scene_options

#: Files of a scene, or a `Scene`.
Files = Any


@dataclass(frozen=True)
class Study:
    """Files of a study."""

    folder: str
    archive: str
    files: list[str]
    """Names relative to the folder."""
    table: str
    """Sums, as text for people."""

    def open(self) -> Archive:
        """Opens the archive."""
        return Archive.open(self.archive)


def run(scene: Files, weather: Any, output: str | os.PathLike[str] | None = None, **options: Unpack[RunOptions]) -> Study:
    """Computes a year's sun from scene files in one go: `heliotile run`, file by file.

    `scene`: a `Scene` or its files; `weather`: a weather file or a table; `output`: the folder, by
    default the name of the first scene file with `.sun`. The options are those of
    `heliotile.options.RunOptions`; `spacing=1.0, on=["roof"]` place receivers.
    """
    keywords = asked("run", RunOptions, options, weather=weather, output=output, **scene_options(scene))
    return _study(_heliotile.run(keywords.args(), options.get("progress")))


def pv(scene: Files, weather: Any, output: str | os.PathLike[str], **options: Unpack[PvOptions]) -> Study:
    """Computes light on solar modules: `heliotile pv`, file by file. Give a table of `points`, or
    `rows` of modules; the book's page on pv has their layouts. Rows with receivers on the `ground`
    among them add `ground.csv` and `ground_months.csv` to the files of the study. The options are
    those of `heliotile.options.PvOptions`."""
    keywords = asked("pv", PvOptions, options, weather=weather, output=output, **scene_options(scene))
    return _study(_heliotile.pv(keywords.args(), options.get("progress")))


def comfort(scene: Files, output: str | os.PathLike[str], *, weather: Any = None, **options: Unpack[PeopleOptions]) -> Archive:
    """Builds the archive of a scene with people and opens it, the first step of `heliotile
    comfort`, with six receivers for each point. `Archive.comfort` replays it.

    `output`: the folder of `receivers.csv` and `site.helio`. An archive of the same inputs is used
    again. `weather`: a weather file or a table, for the later replays. Weather without the air that
    UTCI and PET need is an error before any ray is traced. `error` is estimated under this weather
    if there is no `error_weather`. The options are those of `heliotile.options.PeopleOptions`.
    """
    keywords = asked("comfort", PeopleOptions, options, weather=weather, folder=output, **scene_options(scene))
    if options.get("error") is not None and options.get("error_weather") is None:
        keywords.add(error_weather=weather)
    return Archive.open(_heliotile.comfort(keywords.args(), options.get("progress")))


def energyplus(model: str | os.PathLike[str], output: str | os.PathLike[str], **options: Unpack[EnergyplusOptions]) -> str:
    """Writes an EnergyPlus model with the sunlight that its surroundings reflect: `heliotile
    energyplus`, file by file. Returns the folder.

    `scene`: files of the surroundings; `at`: position of the model's origin in them, metres.
    `weather` belongs to `run`, which runs EnergyPlus from the folder `energyplus`, and to
    `delete_surroundings`. The options are those of `heliotile.options.EnergyplusOptions`.
    """
    file_only(options.get("weather"))
    file_only(options.get("error_weather"))
    keywords = asked("energyplus", EnergyplusOptions, options, model=model, output=output)
    _heliotile.energyplus(keywords.args(), options.get("progress"))
    return os.fspath(output)


def partition(scene: Files, output: str | os.PathLike[str], **options: Unpack[PartitionOptions]) -> Atlas:
    """Cuts a region into parts that are built one by one, and opens the atlas: `heliotile
    partition`. The options are those of `heliotile.options.PartitionOptions`; lengths in metres."""
    keywords = asked("partition", PartitionOptions, options, output=output, **scene_options(scene))
    _heliotile.partition(keywords.args(), options.get("progress"))
    return Atlas.open(output)


@dataclass(frozen=True)
class LadderStep:
    """Settings with their cost and errors. Errors are percent of the mean of hourly totals."""

    name: str
    """Name of the quality, or the parts that the settings are made of."""
    settings: dict[str, float]
    error_percent: float
    """RMSE of hourly totals."""
    bias_percent: float
    yearly_percent: float
    """RMSE of means over all conditions."""
    components_percent: dict[str, float]
    """RMSE by column."""
    trace_s: float
    compress_s: float
    replay_s: float
    """CPU seconds to replay a year of hours into sums."""
    rays: int
    bytes: int
    frontier: bool
    """True if no other step is both faster and more accurate."""


@dataclass(frozen=True)
class Tradeoff:
    """Cost of accuracy on a site."""

    page: str
    """Path of the page with all results; tables and pictures are beside it."""
    table: str
    """All results, as text for people."""
    steps: list[LadderStep]
    """Steps from coarse to fine."""
    receivers: int
    """Number of receivers on which settings were tried."""
    mean_w_m2: float
    sources: list[dict[str, Any]] | None
    """Results of each setting alone, by the columns of `sources.csv`; None without `sources`."""


def tradeoff(scene: Files, receivers: str | os.PathLike[str], output: str | os.PathLike[str], **options: Unpack[TradeoffOptions]) -> Tradeoff:
    """Measures the cost of accuracy on a site: `heliotile tradeoff`. Writes a folder with tables,
    pictures and a page. The options are those of `heliotile.options.TradeoffOptions`."""
    keywords = asked("tradeoff", TradeoffOptions, options, receivers=receivers, output=output, **scene_options(scene))
    found = json.loads(_heliotile.tradeoff(keywords.args(), options.get("progress")))
    ladder = found["ladder"]
    steps = [LadderStep(**step) for step in ladder["steps"]]
    return Tradeoff(found["page"], found["table"], steps, ladder["receivers"], ladder["mean_w_m2"], found["sources"])


def report(tables: str | os.PathLike[str] | Sequence[str | os.PathLike[str]], output: str | os.PathLike[str], **options: Unpack[ReportOptions]) -> str:
    """Writes a statement about tables of results, as one HTML file that prints well: `heliotile
    report`. Returns a sentence about it.

    `tables`: CSV tables that heliotile wrote, each with its metadata file beside it. The options
    are those of `heliotile.options.ReportOptions`."""
    keywords = asked("report", ReportOptions, options, tables=tables, output=output)
    return _heliotile.report(keywords.args())


def merge(first: str | os.PathLike[str], second: str | os.PathLike[str], output: str | os.PathLike[str], **options: Unpack[MergeOptions]) -> Archive:
    """Writes the union of two archives of one scene and opens it: `heliotile archive merge`, byte by byte."""
    keywords = asked("merge", MergeOptions, options, first=first, second=second, output=output)
    _heliotile.merge(keywords.args(), options.get("progress"))
    return Archive.open(output)


def diff(first: str | os.PathLike[str], second: str | os.PathLike[str], **options: Unpack[DiffOptions]) -> tuple[bool, str]:
    """Compares two archives, as `heliotile archive diff`. Returns True if they are equal, and their
    differences as text."""
    return _heliotile.diff(asked("diff", DiffOptions, options, first=first, second=second).args())


def _study(done: tuple[str, str, list[str], str]) -> Study:
    folder, archive, files, table = done
    return Study(os.fspath(folder), os.fspath(archive), files, table)
