"""Checks and edits of archives: the program's `audit`, `verify`, `repair` and `update`. In:
archives, their scenes. Out: what was found or done. Arguments fill the same requests as the command
line."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Unpack

from . import _heliotile
from .given import Asked, asked
from .options import Progress, RepairOptions, VerifyOptions
from .scene import scene_options

if TYPE_CHECKING:
    from .archive import Archive


@dataclass(frozen=True)
class Known:
    """A number with its confidence interval of 95 %."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class WorstPair:
    """Hour of a receiver with the largest error."""

    receiver: str
    condition: str
    off_w_m2: float
    """Irradiance of the archive minus that of the reference path tracer."""
    reference_w_m2: float
    """Irradiance of the reference path tracer."""
    standard_error_w_m2: float
    """Standard error of the reference path tracer's result."""


@dataclass(frozen=True)
class ComponentErrors:
    """Errors of a component or of the total, W/m2 and percent of the mean total."""

    component: str
    bias_w_m2: Known
    """Mean difference, above 0 if the archive's results are too large."""
    rmse_w_m2: Known
    bias_percent: Known
    rmse_percent: Known
    worst: WorstPair | None


@dataclass(frozen=True)
class SkyViewErrors:
    """Errors of the totals of receivers with a similar sky view."""

    sky_view: tuple[float, float, float]
    """Smallest, mean and largest share of their hemispheres that is sky."""
    mean_w_m2: float
    rmse_w_m2: Known


@dataclass(frozen=True)
class HourKindErrors:
    """Errors of the totals in hours of one kind: `no direct sun`, `mostly reflected`."""

    kind: str
    share: float
    """Share of these hours among all hours of all receivers."""
    mean_w_m2: float
    rmse_w_m2: Known
    stated_percent: float | None
    """RMSE that the archive states for these hours, percent of their mean."""


@dataclass(frozen=True)
class AuditReport:
    """Errors of an archive against the independent reference path tracer."""

    archive: str
    weather: str
    receivers: int
    hours: int
    """Number of hours of all receivers together."""
    mean_w_m2: float
    """Mean of the totals of the reference path tracer."""
    verdict: str
    """`nothing_stated`, `holds` or `refuted`: the archive states no error, its statement may be
    right, or it is wrong."""
    sentence: str
    """The verdict as a sentence."""
    stated_percent: float | None
    """RMSE of the totals that the archive states, percent of their mean."""
    components: dict[str, ComponentErrors]
    """Errors by column: the six components and the `total`."""
    sky_views: list[SkyViewErrors] = field(repr=False)
    hour_kinds: list[HourKindErrors] = field(repr=False)
    table: str = field(repr=False)
    """All results, as text for people."""


@dataclass(frozen=True)
class Problem:
    """A part of an archive that differs from what was written."""

    part: str
    """Name of the block, such as `sky/3`."""
    offset: int
    """Start of the block in the file, bytes."""
    reason: str


@dataclass(frozen=True)
class CheckedArchive:
    """Result of the check of an archive."""

    archive: str
    blocks: int
    stored_bytes: int
    trailing_bytes: int
    """Bytes behind its end, which are ignored."""
    problems: list[Problem]
    misplaced: str | None
    """Reason why it is not the archive of its part of an atlas."""
    text: str = field(repr=False)
    """All results, as text for people."""

    @property
    def is_good(self) -> bool:
        """True if the archive has no problem and is in its place."""
        return not self.problems and self.misplaced is None


@dataclass(frozen=True)
class RepairDone:
    """Result of a repair."""

    archive: str
    """Path of the repaired archive."""
    problems: list[Problem]
    """Problems of the damaged archive; empty if there were none."""
    rays: int
    """Number of rays that were traced again."""
    text: str = field(repr=False)

    def open(self) -> Archive:
        """Opens the archive."""
        from .archive import Archive

        return Archive.open(self.archive)


@dataclass(frozen=True)
class UpdateDone:
    """Changes of the receivers by an update."""

    kept: int
    """Number of receivers that were kept."""
    moved: int
    """Number of receivers that moved with their object."""
    gone: int
    """Number of receivers that were removed with their object, or with its former shape."""
    new: int
    """Number of receivers on surfaces that are new or have another shape."""
    buried: list[str]
    """Names of receivers that are now inside an object or covered, and are left out."""
    rays: int
    """Number of rays traced."""
    text: str = field(repr=False)


def update(keywords: Asked, progress: Progress | None) -> tuple[str, UpdateDone]:
    """Returns the archive of an edited scene; `Archive.update` fills the request."""
    path, (kept, moved, gone, new), buried, rays, text = _heliotile.update(keywords.args(), progress)
    return os.fspath(path), UpdateDone(kept, moved, gone, new, buried, rays, text)


def audit(keywords: Asked, progress: Progress | None) -> AuditReport:
    """Runs an audit; `Archive.audit` fills the request."""
    text, table = _heliotile.audit(keywords.args(), progress)
    found = json.loads(text)
    components = {one["component"]: _errors(ComponentErrors, one) for one in found.pop("components")}
    sky_views = [_errors(SkyViewErrors, one | {"sky_view": tuple(one["sky_view"])}) for one in found.pop("sky_views")]
    hour_kinds = [_errors(HourKindErrors, one) for one in found.pop("hour_kinds")]
    return AuditReport(**found, components=components, sky_views=sky_views, hour_kinds=hour_kinds, table=table)


def verify(place: str | os.PathLike[str], **options: Unpack[VerifyOptions]) -> list[CheckedArchive]:
    """Checks every block of an archive, or of all archives of an atlas: `heliotile archive verify`, finding
    by finding.

    `place` is a path or an address; a damaged archive need not open. `deep` also decodes every
    layer and follows every reference between blocks.
    """
    return [
        CheckedArchive(os.fspath(name), blocks, stored, trailing, [Problem(*problem) for problem in problems], misplaced, text)
        for name, blocks, stored, trailing, problems, misplaced, text in _heliotile.verify(asked("verify", VerifyOptions, options, archive=place).args())
    ]


def repair(
    archive: str | os.PathLike[str],
    scene: Any,
    output: str | os.PathLike[str] | None = None,
    **options: Unpack[RepairOptions],
) -> RepairDone:
    """Repairs a damaged archive: `heliotile archive repair`, byte by byte. Good blocks are kept; the others
    are traced again.

    `scene`: the `Scene` of the archive, or its files. `receivers`: their table, needed if the
    archive's own is damaged. Without an `output` the damaged archive is replaced.
    """
    plain: dict[str, Any] = {name: value for name, value in options.items() if name != "receivers"}
    keywords = asked("repair", RepairOptions, plain, archive=archive, output=output, **original_scene(scene))
    if (table := options.get("receivers")) is not None:
        keywords.receivers(os.fspath(table))
    path, problems, rays, text = _heliotile.repair(keywords.args(), options.get("progress"))
    return RepairDone(os.fspath(path), [Problem(*problem) for problem in problems], rays, text)


def _errors(errors: type[Any], found: dict[str, Any]) -> Any:
    """Returns the errors of a group from JSON."""
    intervals = {name: Known(**value) for name, value in found.items() if isinstance(value, dict) and name != "worst"}
    worst = {"worst": WorstPair(**found["worst"])} if found.get("worst") is not None else {}
    return errors(**found | intervals | worst)


def original_scene(scene: Any) -> dict[str, Any]:
    """Returns the keywords of the scene of an archive, without the location, which the archive
    states."""
    return {name: said for name, said in scene_options(scene).items() if name not in ("crs", "latitude", "longitude", "rotate_deg", "grid_north")}
