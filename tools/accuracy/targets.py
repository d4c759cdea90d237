#!/usr/bin/env python3
"""Whether builds keep the error that they were asked for.

    targets.py HELIOTILE FOLDER WEATHER.epw    every site in FOLDER, targets of 10, 5, 2, 1 and 0.5 %

Each site is built for each target, and once with settings that are finer than all of the ladder. The error that is found is that of all
receivers under hours of the weather file: other receivers and other suns than those that the settings were chosen by.
"""
import csv
import datetime
import math
import os
import re
import resource
import subprocess
import sys
import tempfile

TARGETS = (10, 5, 2, 1, 0.5)
FINEST = ("sky_base=128 sky_fine=4096 hit=64 cell_factor=2 cell_floor_m=0.125 probe=64 probe_hits=64 closed_m=2 bounce_sky=16 "
          "bounce_hits=64 patches=2305").split()
HOURS = 96


def run(*args):
    """Standard output of a command, and its CPU seconds."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(args, check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return done.stdout, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def hours(weather, folder):
    """Conditions of hours with light, evenly chosen, as a file."""
    rows = []
    with open(weather) as lines:
        header = lines.readline().split(",")
        latitude, longitude, zone = float(header[6]), float(header[7]), float(header[8])
        for line in list(lines)[7:]:
            cells = line.split(",")
            month, day, hour = int(cells[1]), int(cells[2]), int(cells[3])
            azimuth, altitude = sun(month, day, hour - 0.5, latitude, longitude, zone)
            if altitude > 3 and float(cells[14]) + float(cells[15]) > 0:
                rows.append((f"{month}-{day}T{hour}", azimuth, altitude, float(cells[14]), float(cells[15])))
    chosen = [rows[i * len(rows) // HOURS] for i in range(HOURS)]
    path = f"{folder}/conditions.csv"
    with open(path, "w") as out:
        out.write("condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2\n")
        out.writelines("%s,%.4f,%.4f,%s,%s\n" % row for row in chosen)
    return path


def sun(month, day, hour, latitude, longitude, zone):
    """Azimuth and altitude by Spencer (1971): a tenth of a degree, which both sides of the comparison share."""
    number = datetime.date(2021, month, min(day, 28) if month == 2 else day).timetuple().tm_yday
    g = 2 * math.pi * (number - 1) / 365
    declination = (0.006918 - 0.399912 * math.cos(g) + 0.070257 * math.sin(g) - 0.006758 * math.cos(2 * g)
                   + 0.000907 * math.sin(2 * g) - 0.002697 * math.cos(3 * g) + 0.00148 * math.sin(3 * g))
    equation = 229.18 * (0.000075 + 0.001868 * math.cos(g) - 0.032077 * math.sin(g) - 0.014615 * math.cos(2 * g)
                         - 0.040849 * math.sin(2 * g))
    angle = math.radians((hour * 60 + equation + 4 * (longitude - 15 * zone)) / 4 - 180)
    phi = math.radians(latitude)
    up = math.sin(phi) * math.sin(declination) + math.cos(phi) * math.cos(declination) * math.cos(angle)
    east = -math.cos(declination) * math.sin(angle)
    north = math.cos(phi) * math.sin(declination) - math.sin(phi) * math.cos(declination) * math.cos(angle)
    return math.degrees(math.atan2(east, north)) % 360, math.degrees(math.asin(up))


def totals(program, archive, conditions, *more):
    text, _ = run(program, "query", archive, "--conditions", conditions, "--columns", "total", *more)
    return {(row["condition"], row["receiver"]): float(row["total"]) for row in csv.DictReader(text.splitlines())}


def main(program, folder, weather):
    print(f"{'site':<11}{'wanted %':>9}{'expected %':>11}{'on sample %':>12}{'on all %':>10}{'ratio':>7}"
          f"{'expected s':>11}{'taken s':>9}{'CPU s':>7}{'pilot s':>8}  settings")
    worst = 1.0
    for site in sorted(os.listdir(folder)):
        at = f"{folder}/{site}"
        inputs = [f"{at}/scene.obj", "-m", f"{at}/materials.toml", "-r", f"{at}/receivers.csv", "--fresh", "-o"]
        with tempfile.TemporaryDirectory() as scratch:
            finest, archive = f"{scratch}/finest.helio", f"{scratch}/site.helio"
            run(program, "build", *inputs, finest, *(word for s in FINEST for word in ("--set", s)))
            conditions = hours(weather, scratch)
            truth = totals(program, finest, conditions, "--patches", "2305")
            mean = sum(truth.values()) / len(truth)
            for target in TARGETS:
                text, cpu = run(program, "build", *inputs, archive, "--error", f"{target}%")
                expected, found = re.search(r"error: ([\d.]+) % expected, ([\d.]+) % found", text).groups()
                seconds, taken, pilot = re.search(r"time: ([\d.]+) s expected, ([\d.]+) s taken, .* ([\d.]+) s", text).groups()
                settings = re.findall(r"(?:sky_fine|hit|probe|closed_m|patches)=[\d.]+", text)
                values = totals(program, archive, conditions)
                error = 100 * math.sqrt(sum((values[key] - truth[key]) ** 2 for key in truth) / len(truth)) / mean
                # The finest settings of all cannot be judged by themselves.
                ratio = error / float(expected) if error > 0 else 1.0
                worst = max(worst, ratio, 1 / ratio)
                print(f"{site:<11}{target:>9}{expected:>11}{found:>12}{error:>10.2f}{ratio:>7.2f}{seconds:>11}{taken:>9}{cpu:>7.1f}"
                      f"{pilot:>8}  {' '.join(settings)}", flush=True)
    print(f"largest factor between the expected error and that of all receivers: {worst:.2f}")


if __name__ == "__main__":
    main(*sys.argv[1:4])
