#!/usr/bin/env python3
"""Seconds and peak memory of a year of minutes: writes 525,600 rows of CSV (clear days of a plain sine) and replays them.

    tools/minute-year.py [PROGRAM]      PROGRAM: target/release/heliotile

The archive is that of README's receivers, 64 of them. Needs Python 3.9 on Linux or macOS; about a minute.
"""

import math
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PROGRAM = Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "target/release/heliotile").resolve()
HAGUE = ROOT / "tests/data/hague"
RUNS = [["--every", "day"], ["--every", "hour"]]


def write_weather(path):
    """DNI follows the sine of the hour angle between 6 and 18 h; DHI a tenth of it."""
    with open(path, "w") as out:
        out.write("time,dni,dhi\n")
        for minute in range(365 * 1440):
            day, rest = divmod(minute, 1440)
            up = max(0.0, math.sin(math.pi * (rest - 360) / 720)) if 360 <= rest < 1080 else 0.0
            date = time.strftime("%Y-%m-%d", time.gmtime(1546300800 + 86400 * day))
            out.write(f"{date}T{rest // 60:02}:{rest % 60:02}+01:00,{800 * up:.1f},{80 * up:.1f}\n")


def measured(arguments):
    """Wall seconds, CPU seconds and peak memory in MB of one run, in a process of its own so that its peak is its own."""
    code = ("import resource, subprocess, sys, time; t = time.time(); subprocess.run(sys.argv[1:], check=True, stderr=-3); "
            "u = resource.getrusage(resource.RUSAGE_CHILDREN); print(time.time() - t, u.ru_utime + u.ru_stime, u.ru_maxrss)")
    done = subprocess.run([sys.executable, "-c", code, *map(str, arguments)], check=True, capture_output=True, text=True)
    wall, cpu, peak = map(float, done.stdout.split()[-3:])
    return wall, cpu, peak / (1e6 if sys.platform == "darwin" else 1e3)


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_weather(folder / "minutes.csv")
        lines = (HAGUE / "receivers.csv").read_text().splitlines()[:65]
        (folder / "receivers.csv").write_text("\n".join(lines) + "\n")
        archive = folder / "site.helio"
        build = [PROGRAM, "build", HAGUE / "scene.obj", "-m", HAGUE / "materials.toml", "-r", folder / "receivers.csv", "-o", archive]
        subprocess.run(build, check=True, capture_output=True)
        print("| rows | wall s | CPU s | peak MB |\n| --- | --- | --- | --- |")
        for every in RUNS:
            place = ["--latitude", "52.1", "--longitude", "4.3", "--time-zone", "+01:00"]
            replay = [PROGRAM, "replay", archive, "--weather", folder / "minutes.csv", *place, *every, "-o", folder / "x.parquet"]
            wall, cpu, peak = measured(replay)
            print(f"| {' '.join(every)} | {wall:.1f} | {cpu:.1f} | {peak:.0f} |")


if __name__ == "__main__":
    main()
