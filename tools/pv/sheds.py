"""Bifacial rows under a sun: heliotile's middle row beside pvlib's `bifacial.infinite_sheds`, hour by hour: rows without end, black modules, an even
sky, ground that rows shade. infinite_sheds lights the ground by its mean; a third column resolves where the shade lies, by the view factors of rows.py."""

import numpy as np
import pandas as pd
import pvlib

import ours
import rows

SLOPE, WIDE, LATITUDE = rows.SLOPE, rows.WIDE, 40.0
# Tilt, azimuth, pitch, height of a row's middle, albedo.
CASES = ((20, 180, 5.0, 1.5, 0.2), (30, 180, 4.0, 1.0, 0.5), (60, 90, 6.0, 1.5, 0.2))
DAYS = {"2019-03-21": range(7, 18), "2019-06-21": range(6, 19), "2019-12-21": range(8, 16)}
STEPS = 12
PARTS = ("poa_front", "poa_front_direct", "poa_front_diffuse", "poa_back", "poa_back_direct", "poa_back_diffuse")


def place():
    return pvlib.location.Location(LATITUDE, 15.0, "Etc/GMT-1", 0)


def weather(path):
    """Hours of clear days, whose three columns fit together."""
    hours = pd.DatetimeIndex([f"{day}T{hour:02}:00+01:00" for day, of_day in DAYS.items() for hour in of_day])
    middle = hours + pd.Timedelta("30min")
    sky = place().get_clearsky(middle, "ineichen", linke_turbidity=3.0)
    cos = np.cos(np.radians(place().get_solarposition(middle)["zenith"].to_numpy()))
    dni, dhi = sky["dni"].to_numpy().round(1), sky["dhi"].to_numpy().round(1)
    frame = pd.DataFrame({"ghi": dhi + dni * cos, "dni": dni, "dhi": dhi}, index=hours.map(lambda time: time.isoformat(timespec="minutes")))
    frame.round(3).to_csv(path, index_label="time")
    return hours, frame


def by_pvlib(case, hours, frame):
    """Means over the hours: as many positions of the sun as heliotile takes."""
    tilt, azimuth, pitch, height, albedo = case
    sums = []
    for step in range(STEPS):
        times = hours + pd.Timedelta(minutes=60 * (step + 0.5) / STEPS)
        sun = place().get_solarposition(times)
        zenith = sun["zenith"].to_numpy()
        dni, dhi = frame["dni"].to_numpy(), frame["dhi"].to_numpy()
        found = pvlib.bifacial.infinite_sheds.get_irradiance(
            tilt, azimuth, zenith, sun["azimuth"].to_numpy(), SLOPE / pitch, height, pitch, dhi + dni * np.cos(np.radians(zenith)), dhi, dni, albedo,
            model="isotropic", bifaciality=0.8)
        sums.append(np.array([np.asarray(found[part], dtype=float) for part in PARTS]))
    return np.mean(sums, axis=0)


def shares(tilt, pitch, height, bins=400, samples=200, angles=20000, count=60):
    """What the middle row of a cut sees: ends of the row, shares of the sky of front and rear, those of each strip of the ground, the sky of each strip."""
    of_rows = rows.strips(tilt, pitch, height - 0.5 * SLOPE * np.sin(np.radians(tilt)), count)
    ys = (np.arange(bins) + 0.5) / bins * pitch
    of_sky = np.array([rows.ground_light(y, of_rows, angles) for y in ys])
    (y0, z0), (y1, z1) = of_rows[count]
    sky, ground = [], []
    for normal in (np.radians(90 + tilt), np.radians(270 + tilt)):
        open_, seen = 0.0, np.zeros(bins)
        for share in (np.arange(samples) + 0.5) / samples:
            y, z = y0 + share * (y1 - y0), z0 + share * (z1 - z0)
            phi, weight, met = rows.sky_share(y, z, normal, of_rows, skip=count, angles=angles)
            open_ += weight[(phi < np.pi) & ~met].sum() / samples
            down = (phi >= np.pi) & ~met
            place_ = (y + z / np.tan(2 * np.pi - phi[down])) % pitch
            np.add.at(seen, np.minimum((place_ / pitch * bins).astype(int), bins - 1), weight[down] / samples)
        sky.append(open_)
        ground.append(seen)
    return np.array(((y0, z0), (y1, z1))), np.array(sky), np.array(ground), of_sky


def diffuse(seen, pitch, albedo, zenith, off, dni, dhi):
    """Diffuse light of front and rear under a sun `off` the azimuth of the fronts, radians, where each place of the ground is in the sun or in shade."""
    ((y0, z0), (y1, z1)), sky, ground, of_sky = seen
    bins = len(of_sky)
    ys = (np.arange(bins) + 0.5) / bins * pitch
    # The cut's axis leads away from where fronts look; shadows fall away from the sun.
    slope = -np.cos(off) * np.tan(zenith)
    a, b = sorted((y0 - z0 * slope, y1 - z1 * slope))
    shaded = ((ys - a) % pitch < b - a) if b - a < pitch else np.full(bins, True)
    of_ground = dhi * of_sky + dni * np.cos(zenith) * ~shaded
    return dhi * sky + albedo * ground @ of_ground


def resolved(case, hours, frame):
    """The diffuse light of front and rear, hour by hour: `[side][hour]`."""
    tilt, azimuth, pitch, height, albedo = case
    seen = shares(tilt, pitch, height)
    total = np.zeros((2, len(hours)))
    for step in range(STEPS):
        sun = place().get_solarposition(hours + pd.Timedelta(minutes=60 * (step + 0.5) / STEPS))
        zenith, off = np.radians(sun["zenith"].to_numpy()), np.radians(sun["azimuth"].to_numpy() - azimuth)
        for i, (dni, dhi) in enumerate(zip(frame["dni"], frame["dhi"])):
            total[:, i] += diffuse(seen, pitch, albedo, zenith[i], off[i], dni, dhi) / STEPS
    return total


def ours_of(case, out):
    """The hours of the middle module."""
    tilt, azimuth, pitch, height, albedo = case
    (out / "field.toml").write_text(f'[grass]\ndiffuse = {albedo}\nclass = "ground"\n[endless_ground]\ndiffuse = {albedo}\n')
    half_rise = 0.5 * SLOPE * np.sin(np.radians(tilt))
    deep, wide = 32 * pitch + SLOPE, WIDE
    # Rows run across the azimuth.
    x, y = (wide / 2, deep / 2) if azimuth in (0, 180) else (deep / 2, wide / 2)
    (out / "rows.toml").write_text(
        f'[[rows]]\nname = "r"\narea = [[{-x}, {-y}], [{x}, {-y}], [{x}, {y}], [{-x}, {y}]]\ntilt = {tilt}\nazimuth = {azimuth}\npitch = {pitch}\nwidth = {WIDE}\n'
        f"height = {SLOPE}\nclearance = {height - half_rise}\nthickness = 0.001\nfront = 0\nrear = 0\nsamples = 16\n")
    seconds = ours.run(
        "pv", out / "field.obj", "-m", out / "field.toml", "--latitude", LATITUDE, "--longitude", 15, "-w", out / "days.csv", "--rows", out / "rows.toml",
        "--sky", "uniform", "--replace", "--quality", "fine", "-o", out / "pv")
    table = pd.read_csv(out / "pv/hourly.csv")
    names = sorted(set(table["point"]), key=lambda name: int(name.split("/")[1]))
    middle = table[table["point"] == names[len(names) // 2]]
    return middle[list(PARTS)].to_numpy().T, len(names), seconds


def main():
    out = ours.folder("sheds")
    ours.square(out / "field.obj", 200.0)
    hours, frame = weather(out / "days.csv")
    for case in CASES:
        tilt, azimuth, pitch, height, albedo = case
        theirs, (found, count, seconds) = by_pvlib(case, hours, frame), ours_of(case, out)
        in_place = resolved(case, hours, frame)
        print(f"tilt {tilt}, azimuth {azimuth}, pitch {pitch} m, height {height} m, albedo {albedo}: {count} rows, {len(hours)} hours, {seconds:.1f} s")
        for part, a, b in zip(PARTS, found, theirs):
            print(f"  {part:18} mean {a.mean():7.2f}, infinite_sheds {b.mean():7.2f} W/m2 ({100 * (a.mean() / b.mean() - 1):+.2f} %); hours {apart(a, b)}")
        for part, side in ((2, 0), (5, 1)):
            a, b = found[part], in_place[side]
            print(f"  {PARTS[part]:18} mean {a.mean():7.2f}, shade in its place {b.mean():7.2f} W/m2 ({100 * (a.mean() / b.mean() - 1):+.2f} %); hours {apart(a, b)}")
            print(f"  {'':18} infinite_sheds beside that: {100 * (theirs[part].mean() / b.mean() - 1):+.2f} %; hours {apart(theirs[part], b)}")


def apart(a, b):
    """How far hours are apart, W/m2."""
    return f"{abs(a - b).max():.2f} apart at most, {np.sqrt(((a - b) ** 2).mean()):.2f} RMS"
