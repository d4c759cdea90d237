"""Partial shade of cells: what `pv` says it takes, beside circuits of one-diode cells (Bishop 1988, pvlib's `singlediode.bishop88`) with a bypass
diode of 0.5 V at each substring, on the same light of each cell, hour by hour. Three clear days of sheds.py, arrays of 2 rows of 6 modules. The last
column has the weather in steps of 5 minutes: shadows move within an hour."""

import numpy as np
import pandas as pd
import pvlib

import ours
import sheds

# Cells across and up, width and height of a module, half-cut, modules in series.
WIRINGS = (((6, 10), (1.0, 1.7), False, 1), ((10, 6), (1.7, 1.0), False, 1), ((6, 20), (1.0, 1.7), True, 1), ((6, 20), (1.0, 1.7), True, 12))
# What shades the rows, their pitch over the height of a module, and a box: its corners from the place of the front row's lower right corner, and height.
SITES = (("rows close to each other", 1.15, None), ("a mast in front", 3.0, ((-2.7, -1.2), (-2.55, -1.05), 5.0)),
         ("a wall in the east", 3.0, ((1.5, -4.0), (1.7, 9.0), 4.0)))
TILT, SUBSTRINGS = 30.0, 3
# A cell: thermal voltage of the diode, current of light and of saturation, shunt and series resistance.
DIODE_V, LIGHT_A, SATURATION_A, SHUNT, SERIES, BYPASS_V = 0.027, 9.5, 1e-10, 10.0, 0.005, 0.5
AMPERES = np.linspace(0.0, 12.0, 1201)


def box(corners, x, y, start=4):
    (x0, y0), (x1, y1), z = corners
    x0, x1, y0, y1 = x + x0, x + x1, y + y0, y + y1
    points = [(x, y, h) for h in (0.0, z) for x, y in ((x0, y0), (x1, y0), (x1, y1), (x0, y1))]
    faces = ((4, 3, 2, 1), (5, 6, 7, 8), (1, 2, 6, 5), (2, 3, 7, 6), (3, 4, 8, 7), (4, 1, 5, 8))
    return "".join(f"v {x} {y} {h}\n" for x, y, h in points) + "usemtl wall\n" + "".join(
        f"f {' '.join(str(start + i) for i in face)}\n" for face in faces)


def weather(path, minutes):
    """Writes the clear days, and returns the beam's transmittance of the cover in each step, weighted by the light of 12 suns in each."""
    days = [pd.date_range(f"{day}T{min(of):02}:00+01:00", f"{day}T{max(of) + 1:02}:00+01:00", freq=f"{minutes}min", inclusive="left")
            for day, of in sheds.DAYS.items()]
    times = days[0].append(days[1]).append(days[2])
    sky = sheds.place().get_clearsky(times + pd.Timedelta(minutes=minutes / 2), "ineichen", linke_turbidity=3.0)
    frame = pd.DataFrame({"dni": sky["dni"].to_numpy().round(1), "dhi": sky["dhi"].to_numpy().round(1), "temp_air": 25.0, "wind_speed": 1.0},
                         index=times.map(lambda time: time.isoformat(timespec="minutes")))
    frame.to_csv(path, index_label="time")
    light, passed = np.zeros(len(times)), np.zeros(len(times))
    for step in range(12):
        sun = sheds.place().get_solarposition(times + pd.Timedelta(minutes=minutes * (step + 0.5) / 12))
        aoi = pvlib.irradiance.aoi(TILT, 180.0, sun["zenith"], sun["azimuth"]).to_numpy()
        cos = np.maximum(np.cos(np.radians(aoi)), 0.0) * (sun["zenith"].to_numpy() < 90.0)
        light, passed = light + cos, passed + cos * np.nan_to_num(pvlib.iam.physical(aoi))
    return np.where(light > 0.0, passed / np.maximum(light, 1e-9), 1.0)


def volts(light):
    """Voltage of a cell at AMPERES."""
    v = np.concatenate([np.linspace(-60.0, 0.0, 400), np.linspace(0.002, 0.72, 800)])
    amperes, voltage, _ = pvlib.singlediode.bishop88(v, LIGHT_A * light / 1000.0, SATURATION_A, SERIES, SHUNT, DIODE_V, breakdown_voltage=-100.0)
    return np.interp(AMPERES, amperes[::-1], voltage[::-1])


def bypassed(cells, is_half_cut):
    """Voltage of a substring at AMPERES; `cells` is light, `[cell along][cell beside]`. Of half-cut cells each has half the current."""
    halves = np.array_split(cells, 2) if is_half_cut else [cells]
    curves = [sum(volts(light) for light in half.flat) for half in halves]
    if is_half_cut:
        # In parallel: at each voltage the mean of the two currents, a cell's current counted as that of a whole one.
        grid = np.linspace(-1.0, curves[0].max(initial=1.0) + 20.0, 2000)
        amperes = sum(np.interp(grid, curve[::-1], AMPERES[::-1], right=0.0) for curve in curves) / 2.0
        curve = np.interp(AMPERES, amperes[::-1], grid[::-1])
    else:
        curve = curves[0]
    return np.maximum(curve, -BYPASS_V)


def judged(cells, wiring):
    """Energy of chains, and of modules with even light; `cells` is `[hour][module][up][across]`."""
    (across, up), _, is_half_cut, series = wiring
    chains, even = 0.0, 0.0
    for of_hour in cells:
        curves = []
        for module in of_hour:
            along = module if up >= across else module.T
            curves.append(sum(bypassed(part, is_half_cut) for part in np.array_split(along, SUBSTRINGS, axis=1)))
            count = across * up // (2 if is_half_cut else 1)
            even += (AMPERES * count * volts(module.mean())).max()
        for start in range(0, len(curves), series):
            chains += (AMPERES * sum(curves[start:start + series])).max()
    return chains, even


def lost(site, wiring, minutes, out, judge):
    """Percent of the energy that partial shade takes, by `pv` and, if asked, by circuits."""
    _, pitch, beside = site
    (across, up), (width, height), is_half_cut, series = wiring
    cover = weather(out / "days.csv", minutes)
    ours.square(out / "field.obj")
    with (out / "field.obj").open("a") as file:
        if beside:
            file.write(box(beside, 3 * width, -0.5 * height * (pitch + np.cos(np.radians(TILT)))))
    (out / "field.toml").write_text('[grass]\ndiffuse = 0.2\nclass = "ground"\n[wall]\ndiffuse = 0.3\n')
    (out / "rows.toml").write_text(
        f'[[rows]]\nname = "r"\nrows = 2\nmodules = 6\ntilt = {TILT}\nazimuth = 180\npitch = {pitch * height}\nwidth = {width}\nheight = {height}\nclearance = 0.5\nkwp = 0.3\n'
        f"cells = {{ across = {across}, up = {up}, half_cut = {str(is_half_cut).lower()}, series = {series} }}\n")
    ours.run("pv", out / "field.obj", "-m", out / "field.toml", "--latitude", sheds.LATITUDE, "--longitude", 15, "-w", out / "days.csv", "--rows", out / "rows.toml",
             "--bifaciality", 0, "--losses", "0%", "--temperature-coefficient=0", "--no-hourly", "--replace", "-o", out / "pv")
    row = ours.table(out / "pv/energy.csv")[0]
    found = 100.0 * float(row["mismatch_kwh"]) / (float(row["dc_kwh"]) + float(row["mismatch_kwh"]))
    if not judge:
        return found, None
    ours.run("replay", out / "pv/site.helio", "-w", out / "days.csv", "--every", "hour", "-o", out / "hours.csv")
    hours = pd.read_csv(out / "hours.csv")
    hours = hours[hours["receiver"].str.contains("/front/")]
    table = {part: hours.pivot(index="time", columns="receiver", values=part) for part in ("sun_direct", "total")}
    names = [f"r/{row}/{module}/front/{cell + 1}" for row in (1, 2) for module in range(1, 7) for cell in range(across * up)]
    sun, total = (table[part][names].to_numpy() for part in ("sun_direct", "total"))
    light = total - sun * (1.0 - cover[:, None])
    chains, even = judged(light.reshape(len(light), 12, up, across), wiring)
    return found, 100.0 * (1.0 - chains / even)


def main():
    out = ours.folder("cells")
    print("| shade | cells | in series | `pv` | circuits | steps of 5 minutes |\n| --- | --- | --- | --- | --- | --- |")
    for site in SITES:
        for wiring in WIRINGS:
            (across, up), _, is_half_cut, series = wiring
            found, right = lost(site, wiring, 60, out, True)
            fine, _ = lost(site, wiring, 5, out, False)
            cells = f"{across} x {up}{', half-cut' if is_half_cut else ''}"
            print(f"| {site[0]} | {cells} | {series} | {found:.2f} | {right:.2f} | {fine:.2f} |", flush=True)
