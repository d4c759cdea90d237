"""Sunlight on every point of a site: trace a site once, replay any weather, reflectance and season.

>>> import heliotile
>>> scene = heliotile.Scene("city.city.json", crs=28992)                    # doctest: +SKIP
>>> site = heliotile.build(scene, "receivers.csv", "site.helio")            # doctest: +SKIP
>>> months = site.replay("x.epw", every="month")                            # doctest: +SKIP
>>> months["total"]                   # kWh/m2, shape (receivers, months)   # doctest: +SKIP
"""

from . import errors
from ._heliotile import __version__
from .archive import Archive
from .askable import Factors, Material, Place
from .atlas import Atlas, AtlasPart
from .checks import AuditReport, CheckedArchive, RepairDone, UpdateDone, repair, verify
from .comparing import Comparison, compare
from .errors import (
    ArgumentError,
    ChangedError,
    CorruptError,
    Error,
    FileError,
    HeliotileWarning,
    IncompleteError,
    InputError,
    LimitError,
    MissingFileError,
    StoppedError,
    UnsupportedError,
)
from .results import Results
from .scene import BuildReport, Plan, Scene, build, plan
from .studies import LadderStep, Study, Tradeoff, comfort, diff, energyplus, merge, partition, pv, report, run, tradeoff
from .weather import Weather

__all__ = [
    "Archive",
    "ArgumentError",
    "Atlas",
    "AtlasPart",
    "AuditReport",
    "BuildReport",
    "CheckedArchive",
    "ChangedError",
    "Comparison",
    "CorruptError",
    "Error",
    "Factors",
    "FileError",
    "HeliotileWarning",
    "IncompleteError",
    "InputError",
    "LadderStep",
    "LimitError",
    "Material",
    "MissingFileError",
    "Place",
    "Plan",
    "RepairDone",
    "Results",
    "Scene",
    "StoppedError",
    "Study",
    "Tradeoff",
    "UnsupportedError",
    "UpdateDone",
    "Weather",
    "__version__",
    "build",
    "comfort",
    "compare",
    "diff",
    "energyplus",
    "errors",
    "merge",
    "partition",
    "plan",
    "pv",
    "repair",
    "report",
    "run",
    "tradeoff",
    "verify",
]
