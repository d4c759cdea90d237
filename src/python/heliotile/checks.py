"""Whether archives are what they say, and archives that are edited: the program's `audit`, `verify`, `repair` and `update`. In: archives, their
scenes. Out: what was found or done. Arguments fill the requests that the program fills."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from . import _heliotile
from .options import MEMORY, Progress
from .scene import Scene, scene_request

if TYPE_CHECKING:
    from .archive import Archive


@dataclass(frozen=True)
class Known:
    """A number that is known so well: an interval of 95 %."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class WorstPair:
    """The hour of a receiver that is farthest off."""

    receiver: str
    condition: str
    off_w_m2: float
    """What the archive gives less what the judge found."""
    judged_w_m2: float
    standard_error_w_m2: float
    """Of what the judge found."""


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
    """Errors of the totals of receivers that see about as much of the sky."""

    sky_view: tuple[float, float, float]
    """Smallest, mean and largest share of their hemispheres that is sky."""
    mean_w_m2: float
    rmse_w_m2: Known


@dataclass(frozen=True)
class HourKindErrors:
    """Errors of the totals in hours of one kind: `no direct sun`, `mostly reflected`."""

    kind: str
    share: float
    """Of all hours of all receivers."""
    mean_w_m2: float
    rmse_w_m2: Known
    stated_percent: float | None
    """What the archive states of that RMSE, percent of the mean of these hours."""


@dataclass(frozen=True)
class AuditReport:
    """What an independent judge found of an archive's errors."""

    archive: str
    weather: str
    receivers: int
    hours: int
    """Of all receivers together."""
    mean_w_m2: float
    """Mean of the totals that the judge found."""
    verdict: str
    """`nothing_stated`, `holds` or `refuted`: whether what the archive states of its error may be right."""
    sentence: str
    """The verdict in words."""
    stated_percent: float | None
    """What the archive states of the RMSE of the totals, percent of their mean."""
    components: dict[str, ComponentErrors]
    """By column: the six components and the `total`."""
    sky_views: list[SkyViewErrors] = field(repr=False)
    hour_kinds: list[HourKindErrors] = field(repr=False)
    table: str = field(repr=False)
    """All of it as text for people."""


@dataclass(frozen=True)
class Problem:
    """A part of an archive that is not as it was written."""

    part: str
    """Name of the block, such as `sky/3`."""
    offset: int
    """Where it starts in the file."""
    reason: str


@dataclass(frozen=True)
class CheckedArchive:
    """What was found of an archive."""

    archive: str
    blocks: int
    stored_bytes: int
    trailing_bytes: int
    """Bytes behind its end, which are ignored."""
    problems: list[Problem]
    misplaced: str | None
    """Why it is not the archive of its part of an atlas."""
    text: str = field(repr=False)
    """All of it as text for people."""

    @property
    def is_good(self) -> bool:
        """Whether nothing is wrong with it."""
        return not self.problems and self.misplaced is None


@dataclass(frozen=True)
class RepairDone:
    """What a repair did."""

    archive: str
    """The whole archive."""
    problems: list[Problem]
    """What was wrong; nothing if the archive was whole."""
    rays: int
    """Rays that were traced again."""
    text: str = field(repr=False)

    def open(self) -> Archive:
        """The archive."""
        from .archive import Archive

        return Archive.open(self.archive)


@dataclass(frozen=True)
class UpdateDone:
    """What an update did with the receivers."""

    kept: int
    """How many stand where they stood."""
    moved: int
    """How many moved with their object."""
    gone: int
    """How many went with their object, or with the shape that it had."""
    new: int
    """How many are on what is new or has another shape."""
    buried: list[str]
    """Names of those that are inside something or covered now, and are left out."""
    rays: int
    """Rays that were traced."""
    text: str = field(repr=False)


def update(request: dict[str, Any], memory: int, progress: Progress | None) -> tuple[str, UpdateDone]:
    """The archive of an edited scene; `Archive.update` fills the request."""
    path, (kept, moved, gone, new), buried, rays, text = _heliotile.update(json.dumps(request), memory, progress)
    return os.fspath(path), UpdateDone(kept, moved, gone, new, buried, rays, text)


def audit(request: dict[str, Any], output: str | os.PathLike[str] | None, memory: int, progress: Progress | None) -> AuditReport:
    """What an audit finds; `Archive.audit` fills the request."""
    text, table = _heliotile.audit(json.dumps(request), None if output is None else os.fspath(output), memory, progress)
    found = json.loads(text)
    components = {one["component"]: _errors(ComponentErrors, one) for one in found.pop("components")}
    sky_views = [_errors(SkyViewErrors, one | {"sky_view": tuple(one["sky_view"])}) for one in found.pop("sky_views")]
    hour_kinds = [_errors(HourKindErrors, one) for one in found.pop("hour_kinds")]
    return AuditReport(**found, components=components, sky_views=sky_views, hour_kinds=hour_kinds, table=table)


def verify(place: str | os.PathLike[str], *, deep: bool = False) -> list[CheckedArchive]:
    """Checks every block of an archive, or of those of an atlas: `heliotile verify`, finding by finding.

    `place` is a path or an address; what is damaged need not open. `deep` also decodes every layer and follows every reference between blocks.
    """
    return [
        CheckedArchive(os.fspath(name), blocks, stored, trailing, [Problem(*problem) for problem in problems], misplaced, text)
        for name, blocks, stored, trailing, problems, misplaced, text in _heliotile.verify(os.fspath(place), deep)
    ]


def repair(
    archive: str | os.PathLike[str],
    scene: Any,
    output: str | os.PathLike[str] | None = None,
    *,
    receivers: str | os.PathLike[str] | None = None,
    memory: int = MEMORY,
    progress: Progress | None = None,
) -> RepairDone:
    """Makes a damaged archive whole: `heliotile repair`, byte by byte. What is good is kept, what is not is traced again.

    `scene`: the `Scene` that it was built from, or its files. `receivers`: their table, where the archive's own are damaged. Without an `output` the
    damaged archive is replaced.
    """
    request = {"archive": os.fspath(archive), "scene": original_scene(scene)}
    request |= {name: os.fspath(path) for name, path in (("output", output), ("receivers", receivers)) if path is not None}
    path, problems, rays, text = _heliotile.repair(json.dumps(request), memory, progress)
    return RepairDone(os.fspath(path), [Problem(*problem) for problem in problems], rays, text)


def _errors(errors: type[Any], found: dict[str, Any]) -> Any:
    """Errors of a group, as JSON has them."""
    intervals = {name: Known(**value) for name, value in found.items() if isinstance(value, dict) and name != "worst"}
    worst = {"worst": WorstPair(**found["worst"])} if found.get("worst") is not None else {}
    return errors(**found | intervals | worst)


def original_scene(scene: Any) -> dict[str, Any]:
    """The scene of an archive as requests have it: where a `Scene` lies the archive says, too."""
    request = scene_request(scene)
    if isinstance(scene, Scene):
        request["frame"] = {name: said for name, said in request["frame"].items() if name in ("elevation_m", "scale", "up")}
    return request
