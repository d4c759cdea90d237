"""heliotile. In: a scene, conditions, a weather file. Out: per setting the components [condition][receiver] and CPU seconds of
build, of a query and of a year of hours."""
import csv
import hashlib
from dataclasses import dataclass

import numpy as np

import programs

LADDER = {name: ["--quality", name] for name in ("draft", "standard", "fine", "reference")}  # arguments of `build`


@dataclass
class Ours:
    """W/m2 [condition][receiver], mirrored light with the direct one; CPU seconds of the whole scene."""
    sun: np.ndarray
    sky: np.ndarray
    reflected: np.ndarray
    build_s: float
    query_s: float
    year_s: float

    def total(self):
        return self.sun + self.sky + self.reflected


def ours(scene, name, conditions, weather, folder):
    """Components and costs of a step of the ladder, from the work folder if this program made them; `conditions` and `weather`
    are files."""
    given = repr((LADDER[name], scene.digest())).encode() + conditions.read_bytes() + programs.HELIOTILE.read_bytes()
    kept = folder / f"ours-{hashlib.sha256(given).hexdigest()[:16]}.npz"
    if not kept.exists():
        np.savez(kept, **vars(measured(scene, name, conditions, weather, folder)))
    found = np.load(kept)
    costs = (float(found[name]) for name in ("build_s", "query_s", "year_s"))
    return Ours(found["sun"], found["sky"], found["reflected"], *costs)


def measured(scene, name, conditions, weather, folder):
    """Builds, asks and replays."""
    program, archive, table = programs.HELIOTILE, folder / f"{name}.helio", folder / f"{name}.csv"
    inputs = [scene.obj, "-m", scene.materials, "-r", scene.receivers]
    _, build = programs.run([program, "build", *inputs, "-o", archive, "--fresh", *LADDER[name]], folder)
    _, query = programs.run([program, "replay", archive, "--conditions", conditions, "-o", table], folder)
    hours = folder / "year.npy"
    _, year = programs.run([program, "replay", archive, "--weather", weather, "--every", "hour", "-o", hours], folder)
    hours.unlink()
    return Ours(*components(table, scene.ids), build, query, year)


SUN, SKY, REFLECTED = ("sun_direct", "sun_mirrored"), ("sky_direct", "sky_mirrored"), ("sun_reflected", "sky_reflected")


def components(table, ids):
    """Sun, sky and reflected light of a query's CSV, [condition][receiver] in the order of `ids`."""
    place, conditions = {name: i for i, name in enumerate(ids)}, {}
    with open(table, newline="") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        conditions.setdefault(row["condition"], len(conditions))
    out = np.full((3, len(conditions), len(ids)), np.nan)
    for row in rows:
        at = conditions[row["condition"]], place[row["receiver"]]
        for k, kind in enumerate((SUN, SKY, REFLECTED)):
            out[k][at] = sum(float(row[column]) for column in kind)
    return out


def tracer(scene, conditions, paths, folder):
    """What the reference path tracer of `audit` gives for all receivers: total [condition][receiver] and its standard error, W/m2."""
    names = [row["condition"] for row in csv.DictReader(conditions.read_text().splitlines())]
    given = repr(("tracer", paths, scene.digest())).encode() + conditions.read_bytes() + programs.HELIOTILE.read_bytes()
    kept = folder / f"tracer-{hashlib.sha256(given).hexdigest()[:16]}.npz"
    if not kept.exists():
        archive = folder / "draft.helio"
        inputs = [scene.obj, "-m", scene.materials]
        programs.run([programs.HELIOTILE, "build", *inputs, "-r", scene.receivers, "-o", archive, "--fresh", "--quality", "draft"], folder)
        programs.run([programs.HELIOTILE, "archive", "audit", archive, *inputs, "--conditions", conditions, "--samples", str(len(scene.ids)),
                      "--paths", str(paths), "-o", folder / "tracer"], folder)
        place = {name: i for i, name in enumerate(scene.ids)}
        total = np.full((2, len(names), len(scene.ids)), np.nan)
        with open(folder / "tracer" / "audit.csv", newline="") as file:
            for row in csv.DictReader(file):
                at = names.index(row["condition"]), place[row["receiver"]]
                total[(0, *at)], total[(1, *at)] = float(row["total_reference_w_m2"]), float(row["total_standard_error_w_m2"])
        np.savez(kept, total=total[0], error=total[1])
    found = np.load(kept)
    return found["total"], found["error"]
