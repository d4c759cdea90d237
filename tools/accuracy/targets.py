#!/usr/bin/env python3
"""Whether builds keep the error that they were asked for, and state.

    targets.py HELIOTILE FOLDER WEATHER.epw    every site in FOLDER, targets of 5, 2, 1 and 0.5 %

Each site is built for each target under the hours of the weather file, and audited: all receivers, other hours, other paths. The factor is the
audited error over the stated one.
"""
import os
import re
import resource
import subprocess
import sys
import tempfile

TARGETS = (5, 2, 1, 0.5)


def run(*args):
    """Standard output of a command, and its CPU seconds."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(args, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if done.returncode not in (0, 1):
        sys.exit(f"{' '.join(args)}: {done.stderr}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return done.stdout, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main(program, folder, weather):
    print(f"{'site':<11}{'wanted %':>9}{'expected %':>11}{'stated %':>9}{'audited % (95 %)':>24}{'factor':>8}{'misses':>8}"
          f"{'CPU s':>7}{'pilot s':>8}{'build s':>8}  settings")
    factors = []
    for site in sorted(os.listdir(folder)):
        at = f"{folder}/{site}"
        scene = [f"{at}/scene.obj", "-m", f"{at}/materials.toml"]
        with tempfile.TemporaryDirectory() as scratch:
            archive = f"{scratch}/site.helio"
            for target in TARGETS:
                text, cpu = run(program, "build", *scene, "-r", f"{at}/receivers.csv", "--fresh", "-o", archive,
                                "--error", f"{target}%", "--error-weather", weather)
                expected, stated = map(float, re.search(r"error: ([\d.]+) % expected, ([\d.]+) % \(", text).groups())
                taken, pilot = map(float, re.search(r"([\d.]+) s taken, .* ([\d.]+) s", text).groups())
                settings = re.findall(r"(?:sky_fine|hit|cell_floor_m|probe|closed_m)=[\d.]+", text)
                audit, _ = run(program, "audit", archive, *scene, "--weather", weather, "--samples", "1000", "--paths", "16384",
                               "--seed", "7")
                found, low, high = map(float, re.search(r"^total.*\)\s+([\d.]+) \(\s*([\d.]+) to\s+([\d.]+)\)", audit, re.M).groups())
                factor = found / stated if stated > 0 else float("inf")
                factors.append(max(factor, 1 / factor) if factor > 0 else float("inf"))
                missed = "says so" if stated > target else "" if low <= target else "yes"
                print(f"{site:<11}{target:>9}{expected:>11.2f}{stated:>9.2f}{found:>9.2f} ({low:.2f} to {high:.2f}){factor:>8.2f}{missed:>8}"
                      f"{cpu:>7.1f}{pilot:>8.1f}{taken:>8.1f}  {' '.join(settings)}", flush=True)
    factors.sort()
    print(f"factor between stated and audited: median {factors[len(factors) // 2]:.2f}, largest {factors[-1]:.2f}; "
          f"{sum(f <= 1.5 for f in factors)} of {len(factors)} within 1.5")


if __name__ == "__main__":
    main(*sys.argv[1:4])
