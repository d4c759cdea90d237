#!/usr/bin/env python3
"""Errors of settings under single suns, all against one truth: to compare settings, or a program with an earlier one.

    rungs.py HELIOTILE FOLDER [SITE ...]                        every site in FOLDER, or some, at standard, fine and reference
    rungs.py HELIOTILE FOLDER --settings "standard hit=16" ...  the same at other settings, each a quality and what is set beside it
    rungs.py HELIOTILE FOLDER --before EARLIER                  each by an earlier program, too

FOLDER holds sites as `sites.py` writes them, and maybe others: scene.obj or scene.city.json, receivers.csv, maybe materials.toml. The
reference path tracer follows paths once for up to 128 receivers of a site under 60 suns and skies (kept in FOLDER/SITE/truth); every archive is asked for the same.
RMSE and bias of the total, of the sun and the sky seen directly and of light of either that is reflected, in percent of the mean total; the
path tracer's own noise is taken off. CPU milliseconds and bytes are those of a receiver.
"""
import argparse
import csv
import math
import os
import subprocess
import tempfile

from targets import run, write_suns

LIGHTS = {"direct": ("sun_direct", "sky_direct", "sun_mirrored", "sky_mirrored"), "sun_reflected": ("sun_reflected",), "sky_reflected": ("sky_reflected",)}
SUNS = 60
SAMPLES = 128


def rows(path):
    with open(path, newline="") as table:
        return list(csv.DictReader(table))


def scene_of(at):
    scene = next(path for path in (f"{at}/scene.obj", f"{at}/scene.city.json") if os.path.exists(path))
    return [scene, *(["-m", f"{at}/materials.toml"] if os.path.exists(f"{at}/materials.toml") else [])]


def build(program, at, archive, settings):
    quality, *numbers = settings.split()
    set_ = [word for number in numbers for word in ("--set", number)]
    return run(program, "build", *scene_of(at), "-r", f"{at}/receivers.csv", "--fresh", "-o", archive, "--quality", quality, *set_)[1]


def truth_of(program, at, suns, paths):
    """The reference path tracer's values and their variances, by receiver and condition."""
    if not os.path.exists(f"{at}/truth/audit.csv"):
        with tempfile.TemporaryDirectory() as scratch:
            build(program, at, f"{scratch}/site.helio", "standard")
            run(program, "archive", "audit", f"{scratch}/site.helio", *scene_of(at), "--conditions", suns, "--samples", str(SAMPLES), "--paths", str(paths),
                "--seed", "7", "-o", f"{at}/truth")
    value = lambda row, names, kind, power: sum(float(row[f"{name}_{kind}_w_m2"]) ** power for name in names)
    of = lambda row: {light: (value(row, names, "reference", 1), value(row, names, "standard_error", 2)) for light, names in LIGHTS.items()}
    return {(row["receiver"], row["condition"]): of(row) for row in rows(f"{at}/truth/audit.csv")}


def errors(program, archive, suns, truth, scratch):
    """(RMSE, bias) of the total and by light, percent of the mean total."""
    run(program, "replay", archive, "--conditions", suns, "-o", f"{scratch}/query.csv")
    off = {light: [] for light in ("total", *LIGHTS)}
    noise, mean = dict.fromkeys(off, 0.0), 0.0
    for row in rows(f"{scratch}/query.csv"):
        reference = truth.get((row["receiver"], row["condition"]))
        if reference is None:
            continue
        by = {light: sum(float(row[name]) for name in names) - reference[light][0] for light, names in LIGHTS.items()}
        for light in LIGHTS:
            off[light].append(by[light])
            noise[light] += reference[light][1]
            noise["total"] += reference[light][1]
            mean += reference[light][0]
        off["total"].append(sum(by.values()))
    mean /= len(off["total"])
    rmse = lambda light: math.sqrt(max(0, sum(x * x for x in off[light]) - noise[light]) / len(off[light])) / mean * 100
    return {light: (rmse(light), sum(off[light]) / len(off[light]) / mean * 100) for light in off}


def main(args):
    print(f"{'RMSE, bias, %':<12}{'':<38}{'total':>16}" + "".join(f"{light:>16}" for light in LIGHTS) + f"{'CPU ms':>9}{'bytes':>8}")
    programs = [*([("before", args.before)] if args.before else []), ("now" if args.before else "", args.program)]
    for site in args.sites or sorted(os.listdir(args.folder)):
        at = f"{args.folder}/{site}"
        with tempfile.TemporaryDirectory() as scratch:
            suns, archive = f"{scratch}/suns.csv", f"{scratch}/site.helio"
            write_suns(suns, SUNS)
            truth = truth_of(args.program, at, suns, args.paths)
            count = len(rows(f"{at}/receivers.csv"))
            for settings in args.settings:
                for name, program in programs:
                    cpu = build(program, at, archive, settings)
                    found = errors(program, archive, suns, truth, scratch)
                    print(f"{site:<12}{settings:<31}{name:<7}" + "".join(f"{rmse:>9.2f}{bias:>+7.2f}" for rmse, bias in found.values())
                          + f"{cpu / count * 1000:>9.1f}{os.path.getsize(archive) / count:>8.0f}", flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("folder")
    parser.add_argument("sites", nargs="*")
    parser.add_argument("--settings", nargs="+", default=["standard", "fine", "reference"])
    parser.add_argument("--before", metavar="EARLIER")
    parser.add_argument("--paths", type=int, default=16384, help="paths of the reference path tracer, from each receiver")
    main(parser.parse_args())
