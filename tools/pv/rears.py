"""Rears of endless black rows under single suns: heliotile's middle row beside a cut through infinite rows, where each place of the ground lies in the
sun or in shade. 20 suns in front of the modules, so that rears get reflected light only. REARS=reference takes another quality."""

import os

import numpy as np

import ours
import rows

SLOPE, ALBEDO, DNI, SAMPLES = rows.SLOPE, 0.3, 800.0, 16
# Tilt, cover (slope by pitch), height of a row's middle.
CASES = ((30, 0.45, 1.5), (10, 0.35, 1.5), (20, 0.38, 6.8))
# Qualities, and settings by name: `standard` as buildings have it comes first.
SETTINGS = [("standard", ("probe=16", "cell_factor=4"))] + [(quality, ()) for quality in os.environ.get("REARS", "standard fine").split()]


def suns():
    """Azimuth and altitude of suns spread over the sky in front, degrees."""
    share = (np.arange(20) + 0.5) / 20
    low, high = np.sin(np.radians((10, 70)))
    return 100.0 + 160.0 * (np.arange(20) * 0.618034 % 1.0), np.degrees(np.arcsin(low + share * (high - low)))


def expected(case, azimuth, altitude):
    """Mean light of the middle row's rear under each sun, W/m2."""
    tilt, cover, height = case
    pitch, count, bins = SLOPE / cover, 60, 4000
    of_rows = rows.strips(tilt, pitch, height - 0.5 * SLOPE * np.sin(np.radians(tilt)), count)
    ys = (np.arange(bins) + 0.5) / bins * pitch
    (y0, z0), (y1, z1) = of_rows[count]
    seen = np.zeros(bins)
    for share in (np.arange(400) + 0.5) / 400:
        y, z = y0 + share * (y1 - y0), z0 + share * (z1 - z0)
        phi, weight, met = rows.sky_share(y, z, np.radians(270 + tilt), of_rows, skip=count)
        down = (phi >= np.pi) & ~met
        place = (y + z / np.tan(2 * np.pi - phi[down])) % pitch
        np.add.at(seen, np.minimum((place / pitch * bins).astype(int), bins - 1), weight[down] / 400)
    light = []
    for off, up in zip(np.radians(azimuth - 180.0), np.radians(altitude)):
        slope = -np.cos(off) / np.tan(up)
        a, b = sorted((y0 - z0 * slope, y1 - z1 * slope))
        lit = ~((ys - a) % pitch < b - a) if b - a < pitch else np.full(bins, False)
        light.append(ALBEDO * DNI * np.sin(up) * seen @ lit)
    return np.array(light)


def found(case, azimuth, altitude, quality, settings, out):
    """The same of nine inner rows of an archive, `[row][sun]`, the seconds of `pv`, and the bytes of the archive."""
    tilt, cover, height = case
    pitch = SLOPE / cover
    x, y = rows.WIDE / 2, (32 * pitch + SLOPE) / 2
    (out / "field.toml").write_text(f'[grass]\ndiffuse = {ALBEDO}\nclass = "ground"\n[endless_ground]\ndiffuse = {ALBEDO}\n')
    (out / "rows.toml").write_text(
        f'[[rows]]\nname = "r"\narea = [[{-x}, {-y}], [{x}, {-y}], [{x}, {y}], [{-x}, {y}]]\ntilt = {tilt}\nazimuth = 180\npitch = {pitch}\nwidth = {rows.WIDE}\n'
        f"height = {SLOPE}\nclearance = {height - 0.5 * SLOPE * np.sin(np.radians(tilt))}\nthickness = 0.001\nfront = 0\nrear = 0\nsamples = {SAMPLES}\n")
    (out / "suns.csv").write_text("condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2\n" + "".join(
        f"{i},{a},{h},{DNI},0\n" for i, (a, h) in enumerate(zip(azimuth, altitude))))
    seconds = ours.run("pv", out / "field.obj", "-m", out / "field.toml", "--latitude", 40, "--longitude", 15, "-w", out / "days.csv", "--rows", out / "rows.toml",
                       "--replace", "--no-hourly", "--quality", quality, *(word for text in settings for word in ("--set", text)), "-o", out / "pv")
    archive = next((out / "pv").glob("*.helio"))
    ours.run("replay", archive, "--conditions", out / "suns.csv", "--columns", "total", "-o", out / "light.csv")
    of_rows = {}
    for row in ours.table(out / "light.csv"):
        _, number, _, side, _ = row["receiver"].split("/")
        if side == "rear":
            of_rows.setdefault(int(number), np.zeros(len(azimuth)))[int(row["condition"])] += float(row["total"]) / SAMPLES
    middle = (1 + max(of_rows)) // 2
    return np.array([of_rows[number] for number in range(middle - 4, middle + 5)]), seconds, archive.stat().st_size


def main():
    out = ours.folder("rears")
    ours.square(out / "field.obj", 200.0)
    (out / "days.csv").write_text("time,ghi,dni,dhi\n" + "".join(f"2019-06-21T{h:02}:00+01:00,700,0,700\n" for h in range(9, 15)))
    azimuth, altitude = suns()
    for case in CASES:
        right = expected(case, azimuth, altitude)
        for quality, settings in SETTINGS:
            light, seconds, size = found(case, azimuth, altitude, quality, settings, out)
            off = 100 * (light - right) / right.mean()
            sums = 100 * (light.mean(axis=1) / right.mean() - 1)
            print(f"tilt {case[0]}, cover {case[1]}, height {case[2]} m, {' '.join((quality, *settings))}: RMSE a sun {np.sqrt((off**2).mean()):.2f} %, worst {abs(off).max():.2f} %, "
                  f"bias {off.mean():+.2f} %; sums of 20 suns of {len(light)} rows from {sums.min():+.2f} to {sums.max():+.2f} %; {seconds:.1f} s, {size / 1e6:.2f} MB", flush=True)
