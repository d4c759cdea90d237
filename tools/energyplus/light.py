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
    "Beam To Diffuse Surface Reflected": "sun_diffuse_obstruction",
    "Beam To Diffuse Ground Reflected": "sun_diffuse_ground",
    "Sky Diffuse Surface Reflected": "sky_diffuse_obstruction",
    "Sky Diffuse Ground Reflected": "sky_diffuse_ground",
    "Beam To Beam Surface Reflected": "sun_specular",
}
LIGHT_W_M2 = 1.0


def own(series, surface):
    """Part -> W/m2 by step, as EnergyPlus reports them."""
    at = lambda name: series.values[(surface.upper(), f"Surface Outside Face Incident {name} Solar Radiation Rate per Area")]
    return {ours: at(theirs) for theirs, ours in NAMES.items()}


def conditions(series, path):
    """Writes EnergyPlus's suns and irradiances as a table for `query`, and returns the steps that are in it: those with light."""
    dni, dhi, _, azimuth, altitude = (series.site(name) for name in parts.SITE)
    steps = np.flatnonzero(dni + dhi > LIGHT_W_M2)
    with open(path, "w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["condition", "sun_azimuth_deg", "sun_altitude_deg", "dni_w_m2", "dhi_w_m2"])
        for k in steps:
            # By night and at dawn there is no beam; the sky's light then has a sun on the horizon.
            up = altitude[k] > 0.0
            rows.writerow(
                [k, f"{azimuth[k]:.4f}", f"{max(altitude[k], 0.0):.4f}", f"{dni[k] if up else 0.0:.4f}", f"{dhi[k]:.4f}"]
            )
    return steps


def ours(heliotile, archive, series, surfaces, folder, options):
    """Surface -> part -> W/m2 by step, asked of an archive."""
    table, asked = folder / "light.csv", folder / "conditions.csv"
    conditions(series, asked)
    command = [heliotile, "query", archive, "--conditions", asked, "--by", "surface", "-o", table, "--quiet"]
    subprocess.run([*command, "--columns", ",".join(NAMES.values()), *options], check=True)
    found = {name.upper(): {part: np.zeros(len(series.times)) for part in NAMES.values()} for name in surfaces}
    with open(table, newline="") as file:
        for row in csv.DictReader(file):
            light = found.get(row["surface"].upper())
            if light is not None:
                for part, values in light.items():
                    values[int(row["condition"])] = float(row[part])
    return found
