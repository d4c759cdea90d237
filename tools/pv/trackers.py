"""Single-axis trackers under a sun: heliotile's middle row beside pvlib's `tracking.singleaxis` and `bifacial.infinite_sheds`, hour by hour: rows
without end, black modules, an even sky. A third column has the shade on the ground in its place (sheds.py), by cuts 4 degrees apart."""

import os
import time

import numpy as np
import pandas as pd
import pvlib

import ours
import sheds

SLOPE, WIDE, ROWS = sheds.SLOPE, 300.0, 33
# Direction of the axes, pitch, height of the axis, albedo, backtracking.
CASES = ((180, 5.0, 1.5, 0.2, True), (180, 4.0, 2.0, 0.5, True), (155, 6.0, 1.5, 0.2, False))
# Other settings than the defaults by STEP=5 QUALITY=fine tools/pv/run trackers.
STEP_DEG, QUALITY = os.environ.get("STEP", "10"), os.environ.get("QUALITY", "standard")
# Tilts of the cuts, degrees.
STEP = 4.0
TILTS = np.arange(0.0, 60.1, STEP)


def instants(hours):
    for step in range(sheds.STEPS):
        yield sheds.place().get_solarposition(hours + pd.Timedelta(minutes=60 * (step + 0.5) / sheds.STEPS))


def angles(case, sun):
    axis, pitch, _, _, backtrack = case
    found = pvlib.tracking.singleaxis(sun["zenith"], sun["azimuth"], 0, axis, 60, backtrack, SLOPE / pitch)
    return found["tracker_theta"].to_numpy()


def by_pvlib(case, hours, frame):
    """Means over the hours, and the mean angle."""
    axis, pitch, height, albedo, _ = case
    dni, dhi = frame["dni"].to_numpy(), frame["dhi"].to_numpy()
    sums, mean = [], []
    for sun in instants(hours):
        theta, zenith = angles(case, sun), sun["zenith"].to_numpy()
        found = pvlib.bifacial.infinite_sheds.get_irradiance(
            abs(theta), (axis + np.where(theta < 0, -90, 90)) % 360, zenith, sun["azimuth"].to_numpy(), SLOPE / pitch, height, pitch,
            dhi + dni * np.cos(np.radians(zenith)), dhi, dni, albedo, model="isotropic", bifaciality=0.8)
        sums.append(np.array([np.asarray(found[part], dtype=float) for part in sheds.PARTS]))
        mean.append(theta)
    return np.mean(sums, axis=0), np.mean(mean, axis=0)


def resolved(case, hours, frame):
    axis, pitch, height, albedo, _ = case
    cuts = [sheds.shares(tilt, pitch, height, bins=200, samples=50, angles=6000, count=30) for tilt in TILTS]
    total = np.zeros((2, len(hours)))
    for sun in instants(hours):
        theta, zenith = angles(case, sun), np.radians(sun["zenith"].to_numpy())
        for i, (dni, dhi) in enumerate(zip(frame["dni"], frame["dhi"])):
            tilt = abs(theta[i])
            low = min(int(tilt / STEP), len(TILTS) - 2)
            share = tilt / STEP - low
            seen = [(1 - share) * a + share * b for a, b in zip(cuts[low], cuts[low + 1])]
            off = np.radians(sun["azimuth"].iloc[i] - (axis + (-90 if theta[i] < 0 else 90)))
            total[:, i] += sheds.diffuse(seen, pitch, albedo, zenith[i], off, dni, dhi) / sheds.STEPS
    return total


def ours_of(case, out):
    axis, pitch, height, albedo, backtrack = case
    (out / "field.toml").write_text(f'[grass]\ndiffuse = {albedo}\nclass = "ground"\n[endless_ground]\ndiffuse = {albedo}\n')
    (out / "rows.toml").write_text(
        f'[[rows]]\nname = "r"\nrows = {ROWS}\nmodules = 1\ntracker = {{ hub = {height}, step = {STEP_DEG}, axis_azimuth = {axis}, backtrack = {str(backtrack).lower()} }}\n'
        f"pitch = {pitch}\nwidth = {WIDE}\nheight = {SLOPE}\nthickness = 0.001\nfront = 0\nrear = 0\nsamples = 16\n")
    start = time.time()
    ours.run(
        "pv", out / "field.obj", "-m", out / "field.toml", "--latitude", sheds.LATITUDE, "--longitude", 15, "-w", out / "days.csv", "--rows", out / "rows.toml",
        "--sky", "uniform", "--quality", QUALITY, "--replace", "-o", out / "pv")
    table = pd.read_csv(out / "pv/hourly.csv")
    middle = table[table["point"] == f"r/{ROWS // 2 + 1}/1"]
    return middle[list(sheds.PARTS)].to_numpy().T, middle["tracker_theta"].to_numpy(), time.time() - start


def main():
    out = ours.folder("trackers")
    ours.square(out / "field.obj", 400.0)
    hours, frame = sheds.weather(out / "days.csv")
    for case in CASES:
        axis, pitch, height, albedo, backtrack = case
        (found, theta, seconds), (of_sheds, expected) = ours_of(case, out), by_pvlib(case, hours, frame)
        in_place = resolved(case, hours, frame)
        print(f"axes {axis}, pitch {pitch} m, hub {height} m, albedo {albedo}, backtracking {backtrack}: {ROWS} rows, {len(hours)} hours, {seconds:.0f} s; "
              f"angles at most {abs(theta - expected).max():.4f} degrees from pvlib's")
        for part, a, b in zip(sheds.PARTS, found, of_sheds):
            print(f"  {part:18} mean {a.mean():7.2f}, infinite_sheds {b.mean():7.2f} W/m2 ({100 * (a.mean() / max(b.mean(), 1e-9) - 1):+.2f} %); hours {sheds.apart(a, b)}")
        for part, side in ((2, 0), (5, 1)):
            a, b = found[part], in_place[side]
            print(f"  {sheds.PARTS[part]:18} mean {a.mean():7.2f}, shade in its place {b.mean():7.2f} W/m2 ({100 * (a.mean() / b.mean() - 1):+.2f} %); hours {sheds.apart(a, b)}")
