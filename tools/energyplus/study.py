"""Sets what EnergyPlus makes of heliotile's tables beside its own reflections (see tools/energyplus/run).

In: names of models. Out: a table, target/energyplus/table.csv and by-surface.csv; exit code 1 if a bound is broken.
"""

import argparse
import csv
import json
import os
import pathlib
import shutil
import sys

import numpy as np

import block
import channel
import compare
import light
import models
import parts
import runs
import variants

HELIOTILE = pathlib.Path(os.environ.get("HELIOTILE", runs.ROOT / "target" / "release" / "heliotile"))
LIGHT_DAYS = 14
CHANNEL = ("plain", "hourly", "six-steps", "interior")
SUN_BOUND = 3.0
DAILY_BOUND = 1.0
HEAD = f"{'model':<26}{'heating %':>10}{'cooling %':>10}{'daily RMS %':>12}{'sun W/m2':>10}  {'worst surface':<44}{'seconds':>9}"


def row(name, found, seconds):
    (surface, word), most = found.worst()
    worst = f"{most:+.2f} % {surface.capitalize()}, {word}"
    return (
        f"{name:<26}{found.heating:>+10.3f}{found.cooling:>+10.3f}{found.daily_rms:>12.3f}{found.transmitted_rms_w_m2:>10.3f}"
        f"  {worst:<44}{seconds:>9.1f}"
    )


class Table:
    """Rows as they come: printed, kept for the CSV files, and judged."""

    def __init__(self):
        self.rows, self.surfaces, self.broken = [], [], []
        print(HEAD, flush=True)

    def add(self, model, run, found, seconds, bounds=None):
        print(row(f"{model} {run}", found, seconds), flush=True)
        self.rows.append(
            [model, run, found.heating, found.cooling, found.daily_rms, found.transmitted_rms_w_m2, found.worst()[1], seconds]
        )
        self.surfaces += [[model, run, surface, word, value] for (surface, word), value in found.sun.items()]
        values = {"heating": found.heating, "cooling": found.cooling, "daily": found.daily_rms, "sun": found.worst()[1]}
        values["transmitted"] = found.transmitted_rms_w_m2
        for what, most in (bounds or {}).items():
            if not abs(values[what]) <= most:
                self.broken.append(f"{model} {run}: {what} {values[what]:+.4f}, bound {most}")

    def end(self, folder):
        """Writes the files and returns the exit code."""
        head = [
            "model",
            "run",
            "heating_pct",
            "cooling_pct",
            "daily_rms_pct",
            "transmitted_rms_w_m2",
            "worst_surface_pct",
            "user_s",
        ]
        write(folder / "table.csv", head, self.rows)
        write(folder / "by-surface.csv", ["model", "run", "surface", "light", "deviation_pct"], self.surfaces)
        for line in self.broken:
            print("error above its limit:", line)
        return 1 if self.broken else 0


def write(path, head, rows):
    path.parent.mkdir(parents=True, exist_ok=True)
    with open(path, "w", newline="") as file:
        csv.writer(file).writerows([head, *rows])


def baselines(case, folder, frequency="Hourly"):
    """EnergyPlus without and with its own reflections."""
    model = parts.outputs(case.model, frequency)
    return [
        runs.run(runs.with_distribution(model, own), case.weather, folder / name)
        for name, own in (("none", False), ("own", True))
    ]


def through_channel(name, folder, table):
    """EnergyPlus's own reflected light injected again: nothing may change."""
    case = variants.case(name, folder / "weather")
    here = folder / f"channel-{name}"
    _, own = baselines(case, here, "Timestep")
    series = own.series()
    model, file = channel.injected(case.model, series, here)
    again = runs.run(model, case.weather, here / "injected", [file])
    found = compare.deviation(series, again.series(), models.window_areas(case.model))
    table.add(f"channel {name}", "injected", found, again.user_s, {"heating": 0.001, "cooling": 0.001, "transmitted": 0.01})


def heliotile(model, folder, *options):
    """The model that `heliotile energyplus` makes of `model`, and its CPU seconds."""
    source, out = folder / "given.epJSON", folder / "heliotile"
    folder.mkdir(parents=True, exist_ok=True)
    source.write_text(json.dumps(model, indent=1))
    shutil.rmtree(out, ignore_errors=True)
    seconds = runs.seconds([HELIOTILE, "energyplus", source, *options, "-o", out, "--quiet"])
    return out / "model.epJSON", seconds


def ours(case, folder, physics, deleted):
    """EnergyPlus with heliotile's light: its run, and the CPU seconds before. `deleted`: by series, without surroundings."""
    here = folder / (f"{physics}-deleted" if deleted else physics)
    options = ["--delete-surroundings", "--weather", case.weather] if deleted else []
    model, build_s = heliotile(case.model, here, "--physics", physics, *options)
    beside = []
    if deleted:
        (here / "run").mkdir(parents=True, exist_ok=True)
        beside = [shutil.copy(model.with_name("series.csv"), here / "run")]
    return runs.run(model, case.weather, here / "run", beside), build_s


def compared(case, folder, physics, deleted, table):
    """EnergyPlus without reflections and with heliotile's, beside its own."""
    none, own = baselines(case, folder)
    series, areas = own.series(), models.window_areas(case.model)
    table.add(case.name, "none", compare.deviation(series, none.series(), areas), none.user_s)
    run, build_s = ours(case, folder, physics, deleted)
    bounds = {"heating": case.bound, "cooling": case.bound}
    if case.name in models.YEARS:
        bounds |= {"daily": DAILY_BOUND, "sun": SUN_BOUND}
    found = compare.deviation(series, run.series(), areas)
    judged = physics == "energyplus" and not deleted
    table.add(case.name, "deleted" if deleted else physics, found, build_s + run.user_s, bounds if judged else None)
    took = f"EnergyPlus {none.user_s:.1f} s without, {own.user_s:.1f} s with its own, {run.user_s:.1f} s injected"
    print(f"{'':<26}{took}; tables {build_s:.1f} s")


def by_part(name, folder):
    """Prints and writes W/m2 of each surface by part of the light, ours beside EnergyPlus's, under its suns and irradiances."""
    case = variants.case(name, folder / "weather", LIGHT_DAYS)
    here = folder / f"light-{name}"
    series, surfaces = baselines(case, here, "Timestep")[1].series(), parts.exposed(case.model)
    heliotile(case.model, here, "--physics", "energyplus")
    archive = here / "heliotile" / "site.helio"
    lights = light.ours(HELIOTILE, archive, series, surfaces, here)
    rows = []
    for surface in surfaces:
        for part, theirs in light.own(series, surface).items():
            ours = lights[surface.upper()][part]
            rms = np.sqrt(np.mean((ours - theirs) ** 2))
            rows.append([surface, part, *(f"{value:.3f}" for value in (theirs.mean(), ours.mean(), rms))])
            print(f"{surface:<26}{part:<26}{theirs.mean():>9.2f}{ours.mean():>9.2f}{rms:>9.2f}")
    write(folder / f"light-{name}.csv", ["surface", "light", "energyplus_w_m2", "heliotile_w_m2", "rms_w_m2"], rows)


def main():
    parser = argparse.ArgumentParser(prog="tools/energyplus/run", description=__doc__.splitlines()[0])
    known = ["channel", *models.YEARS, "variants", *variants.VARIANTS, "dense"]
    parser.add_argument("--models", default="channel,box,l,office,variants", help=f"some of {', '.join(known)}")
    parser.add_argument("--days", type=int, help="run this number of days from 7 March instead of a year")
    parser.add_argument("--physics", choices=("energyplus", "full"), default="energyplus")
    parser.add_argument("--delete-surroundings", action="store_true", help="light by series, without surroundings")
    parser.add_argument(
        "--keep", type=pathlib.Path, default=runs.ROOT / "target" / "energyplus", help="folder of runs, reused if it exists"
    )
    parser.add_argument(
        "--paper", action="store_true", help="the dense block: seconds of each part, hours of a day at five surfaces"
    )
    parser.add_argument(
        "--light", choices=[*models.YEARS, *variants.VARIANTS], help="each part of the light by surface, heliotile's and EnergyPlus's"
    )
    parser.add_argument(
        "--public", metavar="MODELS", help="whole public models compared with EnergyPlus's own reflections: six, all, or names"
    )
    asked = parser.parse_args()
    if asked.public:
        import public

        sys.exit(public.public(asked.public, asked.keep))
    if asked.light:
        return by_part(asked.light, asked.keep)
    if asked.paper:
        import paper

        sys.exit(paper.experiment(asked.keep))
    names = [name.strip() for name in asked.models.split(",")]
    unknown = [name for name in names if name not in known]
    if unknown:
        parser.error(f"no model {', '.join(unknown)}; there are {', '.join(known)}")
    table = Table()
    if "channel" in names:
        for name in CHANNEL:
            through_channel(name, asked.keep, table)
    names = [one for name in names if name != "channel" for one in (variants.VARIANTS if name == "variants" else [name])]
    for name in names:
        case = block.case() if name == "dense" else variants.case(name, asked.keep / "weather", asked.days)
        folder = asked.keep / (name if asked.days is None else f"{name}-{asked.days}")
        compared(case, folder, asked.physics, asked.delete_surroundings, table)
    sys.exit(table.end(asked.keep))


if __name__ == "__main__":
    main()
