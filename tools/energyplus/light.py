"""The parts of the light, ours beside EnergyPlus's. In: an archive, a run whose series are of every time step. Out: W/m2 of each
surface and part, by step, both under EnergyPlus's own suns and irradiances."""

import csv
import subprocess

import numpy as np

import parts

# What heliotile calls the parts that EnergyPlus reports.
NAMES = {
    "Beam": "sun_direct",
    "Sky Diffuse": "sky_direct",
    "Beam To Diffuse Surface Reflected": "sun_reflected_obstruction",
    "Beam To Diffuse Ground Reflected": "sun_reflected_ground",
    "Sky Diffuse Surface Reflected": "sky_reflected_obstruction",
    "Sky Diffuse Ground Reflected": "sky_reflected_ground",
    "Beam To Beam Surface Reflected": "sun_mirrored",
}
LIGHT_W_M2 = 1.0
# EnergyPlus's sky is that of Perez 1990 for what comes straight from it, and uniform for what is reflected.
SKIES = ("perez1990", "uniform")


def own(series, surface):
    """Part -> W/m2 by step, as EnergyPlus reports them."""
    at = lambda name: series.values[(surface.upper(), f"Surface Outside Face Incident {name} Solar Radiation Rate per Area")]
    return {ours: at(theirs) for theirs, ours in NAMES.items()}


def conditions(series, path):
    """Writes EnergyPlus's suns and irradiances as a table for `query`: those of steps with light."""
    dni, dhi, _, azimuth, altitude = (series.site(name) for name in parts.SITE)
    steps = np.flatnonzero(dni + dhi > LIGHT_W_M2)
    with open(path, "w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["condition", "sun_azimuth_deg", "sun_altitude_deg", "dni_w_m2", "dhi_w_m2"])
        for k in steps:
            # Below the horizon there is no beam, and the sky's light is that of a sun on it.
            beam, above = (dni[k], altitude[k]) if altitude[k] > 0.0 else (0.0, 0.0)
            rows.writerow([k, *(f"{value:.4f}" for value in (azimuth[k], above, beam, dhi[k]))])


def ours(heliotile, archive, series, surfaces, folder):
    """Surface -> part -> W/m2 by step, asked of an archive under EnergyPlus's suns and irradiances, by its paths of the light."""
    asked = folder / "conditions.csv"
    conditions(series, asked)
    direct, reflected = (by_sky(heliotile, archive, asked, len(series.times), surfaces, folder, sky) for sky in SKIES)
    return {name: {**reflected[name], "sky_direct": parts["sky_direct"]} for name, parts in direct.items()}


def by_sky(heliotile, archive, asked, steps, surfaces, folder, sky):
    """The same under one sky."""
    table = folder / f"light-{sky}.csv"
    options = ["--by", "surface", "--paths", "none", "--sky", sky, "--columns", ",".join(NAMES.values()), "--quiet"]
    subprocess.run([heliotile, "replay", archive, "--conditions", asked, "-o", table, *options], check=True)
    found = {name.upper(): {part: np.zeros(steps) for part in NAMES.values()} for name in surfaces}
    with open(table, newline="") as file:
        for row in csv.DictReader(file):
            light = found.get(row["surface"].upper())
            if light is not None:
                for part, values in light.items():
                    values[int(row["condition"])] = float(row[part])
    return found
