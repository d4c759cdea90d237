#!/usr/bin/env python3
"""Whether builds keep the error that they were asked for, and state.

    targets.py HELIOTILE FOLDER [SITE ...]               every site in FOLDER, or some, targets of 2 and 1 %, suns from all sides
    targets.py HELIOTILE FOLDER --weather FILE.epw       the same under the hours of a weather file, targets of 5, 2, 1 and 0.5 %

Each site is built for each target and audited: all receivers, other suns or hours, other paths. Errors are stated and audited in all hours, in
those when the sun lights what a receiver sees and not the receiver (no direct sun), and in those of them in which more than half of the light
is reflected. The factor is the audited error over the stated one.
"""
import argparse
import math
import os
import random
import re
import resource
import subprocess
import sys
import tempfile

KINDS = ("all", "no direct sun", "mostly reflected")


def run(*args):
    """Standard output of a command, and its CPU seconds."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(args, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if done.returncode not in (0, 1):
        sys.exit(f"{' '.join(args)}: {done.stderr}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return done.stdout, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def write_suns(path, count=1024):
    """Suns from all sides, 4 to 72 degrees high, drawn at random: half of the skies clear, a quarter half covered, a quarter overcast."""
    draw = random.Random(7)
    with open(path, "w") as out:
        out.write("condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2\n")
        for i in range(count):
            sine = draw.uniform(math.sin(math.radians(4)), math.sin(math.radians(72)))
            # Meinel and Meinel 1976, with the air mass of Kasten and Young 1989.
            altitude = math.degrees(math.asin(sine))
            mass = 1 / (sine + 0.50572 * (altitude + 6.07995) ** -1.6364)
            dni, dhi = 1353 * 0.7 ** mass**0.678, 40 + 80 * sine
            kind = draw.random()
            if kind >= 0.5:
                dni, dhi = (0.45 * dni, 80 + 220 * sine) if kind < 0.75 else (0, 40 + 330 * sine)
            out.write(f"{i},{draw.uniform(0, 360):.3f},{altitude:.3f},{dni:.1f},{dhi:.1f}\n")


def audited(text):
    """Percent of the mean by kind of hours: what is stated, what was found."""
    found = {}
    total = re.search(r"^total.*\)\s+([\d.]+) \(", text, re.M)
    stated = re.search(r"stated: ([\d.]+) %", text)
    found["all"] = float(stated.group(1)), float(total.group(1))
    for kind in KINDS[1:]:
        row = re.search(rf"^{kind}.*\)\s+([\d.]+)\s+([\d.]+)$", text, re.M)
        if row:
            found[kind] = float(row.group(2)), float(row.group(1))
    return found


def main(args):
    print(f"{'% of the mean':<17}" + "".join(f"{kind:>25}" for kind in KINDS))
    print(f"{'site':<10}{'wanted':>7}" + f"{'stated':>9}{'audited':>8}{'factor':>8}" * len(KINDS) + f"{'CPU s':>8}  settings")
    factors = []
    for site in args.sites or sorted(os.listdir(args.folder)):
        at = f"{args.folder}/{site}"
        scene = [f"{at}/scene.obj", "-m", f"{at}/materials.toml"]
        with tempfile.TemporaryDirectory() as scratch:
            archive, suns = f"{scratch}/site.helio", f"{scratch}/suns.csv"
            write_suns(suns)
            under, other = ([], ["--conditions", suns]) if args.weather is None else (
                ["--error-weather", args.weather], ["--weather", args.weather])
            for target in args.targets or ((2, 1) if args.weather is None else (5, 2, 1, 0.5)):
                text, cpu = run(args.program, "build", *scene, "-r", f"{at}/receivers.csv", "--fresh", "-o", archive,
                                "--error", f"{target}%", "-v", *under)
                settings = re.findall(r"(?:sky_fine|hit|cell_floor_m|probe|closed_m)=[\d.]+", text)
                audit, _ = run(args.program, "archive", "audit", archive, *scene, *other, "--samples", "1000", "--hours", "32", "--paths", "8192",
                               "--seed", "7")
                row = ""
                for kind in KINDS:
                    stated, found = audited(audit).get(kind, (0, 0))
                    if stated > 0:
                        factor = found / stated
                        factors.append(max(factor, 1 / factor) if factor > 0 else float("inf"))
                        row += f"{stated:>9.2f}{found:>8.2f}{factor:>8.2f}"
                    else:
                        row += f"{'-':>9}{'-':>8}{'-':>8}"
                print(f"{site:<10}{target:>7g}{row}{cpu:>8.1f}  {' '.join(settings)}", flush=True)
    factors.sort()
    print(f"factor between stated and audited: median {factors[len(factors) // 2]:.2f}, largest {factors[-1]:.2f}; "
          f"{sum(f <= 1.5 for f in factors)} of {len(factors)} within 1.5")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("folder")
    parser.add_argument("sites", nargs="*")
    parser.add_argument("--weather")
    parser.add_argument("--targets", type=lambda text: [float(part) for part in text.split(",")])
    main(parser.parse_args())
