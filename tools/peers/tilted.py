"""Open tilted surfaces, direct light and sky, beside pvlib. In: EPW files. Out: a table, and with --cut hours for the tests."""
import argparse
import csv
import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pvlib

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = Path(os.environ.get("HELIOTILE", ROOT / "target/release/heliotile"))
WORK = ROOT / "target/peers/tilted"
# A query's light outside the atmosphere; pvlib takes the same.
E0_W_M2 = 1367.0
ALBEDO = 0.2
# Tilt and azimuth: flat, three tilts each eight ways, a flat roof, an overhang, and what looks down.
SURFACES = [(0, 0)] + [(t, a) for t in (30, 60, 90) for a in range(0, 360, 45)] + [(10, 180), (120, 180), (180, 0)]
# Those that the cut for the tests holds.
CUT = [(0, 0), (30, 180), (60, 90), (90, 0), (90, 180), (90, 270), (120, 180)]


def hours(epw):
    """Rows with light whose middle has a sun above the horizon: azimuth and altitude by pvlib's SPA, without refraction."""
    with open(epw, newline="") as file:
        rows = list(csv.reader(file))
    latitude, longitude, zone_h, elevation_m = (float(v) for v in rows[0][6:10])
    rows = [row for row in rows[8:] if len(row) > 15 and (row[1], row[2]) != ("2", "29")]
    start = [f"{int(r[0])}-{int(r[1]):02}-{int(r[2]):02}" for r in rows]
    middle_h = np.array([int(r[3]) - 0.5 - zone_h for r in rows])
    times = pd.DatetimeIndex(pd.to_datetime(start) + pd.to_timedelta(middle_h, "h")).tz_localize("UTC")
    position = pvlib.solarposition.spa_python(times, latitude, longitude, elevation_m)
    table = pd.DataFrame({
        "condition": [f"{i:04}" for i in range(len(rows))],
        "sun_azimuth_deg": position["azimuth"].to_numpy().round(5),
        "sun_altitude_deg": position["elevation"].to_numpy().round(5),
        "dni_w_m2": [float(r[14]) for r in rows],
        "dhi_w_m2": [float(r[15]) for r in rows],
    })
    lit = (table.sun_altitude_deg > 0) & (table.dni_w_m2 + table.dhi_w_m2 > 0)
    return table[lit].reset_index(drop=True)


def by_pvlib(table):
    """`[hour][surface]`: sun, sky, and light of an endless ground."""
    zenith = 90 - table.sun_altitude_deg
    ghi = table.dni_w_m2 * np.cos(np.radians(zenith)) + table.dhi_w_m2
    found = [pvlib.irradiance.get_total_irradiance(
        tilt, azimuth, zenith, table.sun_azimuth_deg, table.dni_w_m2, ghi, table.dhi_w_m2, dni_extra=E0_W_M2, albedo=ALBEDO,
        model="perez") for tilt, azimuth in SURFACES]
    return [np.array([f[name].fillna(0) for f in found]).T for name in ("poa_direct", "poa_sky_diffuse", "poa_ground_diffuse")]


def archives():
    """Archives of the surfaces over nothing, and over endless ground."""
    WORK.mkdir(parents=True, exist_ok=True)
    (WORK / "far.obj").write_text("v 0 0 -9\nv 0.01 0 -9\nv 0 0.01 -9\nusemtl far\nf 1 2 3\n")
    with open(WORK / "receivers.csv", "w") as out:
        out.write("receiver,x,y,z,nx,ny,nz\n")
        for i, (tilt, azimuth) in enumerate(SURFACES):
            t, a = math.radians(tilt), math.radians(azimuth)
            normal = (math.sin(t) * math.sin(a), math.sin(t) * math.cos(a), math.cos(t))
            out.write(f"{i:02},{3 * i},0,0," + ",".join(f"{n:.12f}" for n in normal) + "\n")
    names = {}
    for name, ground in (("open", ""), ("ground", f"[endless_ground]\ndiffuse = {ALBEDO}\nelevation = -9.5\n")):
        (WORK / f"{name}.toml").write_text(f"[far]\ndiffuse = 0.0\nclass = \"obstruction\"\n{ground}")
        names[name] = WORK / f"{name}.helio"
        names[name].unlink(missing_ok=True)
        run("build", WORK / "far.obj", "-m", WORK / f"{name}.toml", "-r", WORK / "receivers.csv", "-o", names[name],
            *([] if ground else ["--no-ground"]))
    return names


def run(*arguments):
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, arguments))}: {done.stderr}")


def ours(archive, conditions, sky, columns):
    """`[column][hour][surface]`."""
    out = WORK / "out.csv"
    out.unlink(missing_ok=True)
    run("replay", archive, "-c", conditions, "--sky", sky, "--columns", ",".join(columns), "-o", out)
    table = pd.read_csv(out, dtype={"condition": str, "receiver": str})
    return [table.pivot(index="condition", columns="receiver", values=name).to_numpy() for name in columns]


def year(found, expected, least_deg=0):
    """Largest deviation of a surface's year, percent, and its name: of those tilted by 0 to 179 degrees, or from so many."""
    with np.errstate(invalid="ignore"):
        off = 100 * (found.sum(0) / expected.sum(0) - 1)
    worst = max((i for i, (tilt, _) in enumerate(SURFACES) if least_deg <= tilt < 180), key=lambda i: abs(off[i]))
    return off[worst], "{} deg to {}".format(*SURFACES[worst])


def rms(found, expected):
    return float(np.sqrt(((found - expected) ** 2).mean(0)).max())


def cut(table, sky, path):
    """Hours of all kinds: every 90th by clearness, and some of the lowest suns."""
    clear = (table.dni_w_m2 / table.dhi_w_m2.clip(lower=1e-9)).argsort()
    lit = [i for i in clear if table.dhi_w_m2[i] > 0]
    low = [i for i in table.sun_altitude_deg.argsort() if table.dhi_w_m2[i] > 0]
    rows = sorted(set(lit[::90]) | set(low[:100:10]))
    with open(path, "w") as out:
        names = ",".join(f"sky_{t}_{a}" for t, a in CUT)
        out.write(f"condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2,{names}\n")
        for i in rows:
            values = [table[name][i] for name in table.columns] + [f"{sky[i][SURFACES.index(s)]:.5f}" for s in CUT]
            out.write(",".join(map(str, values)) + "\n")


def main():
    options = argparse.ArgumentParser()
    options.add_argument("--cut", type=Path)
    options.add_argument("weather", nargs="*", type=Path)
    options = options.parse_args()
    files = options.weather or [ROOT / "tests/data/weather/golden_tmy3.epw"]
    sites, bad = archives(), False
    for place, epw in enumerate(files):
        table = hours(epw)
        sun, sky, ground = by_pvlib(table)
        if place == 0 and options.cut:
            cut(table, sky, options.cut)
        conditions = WORK / "conditions.csv"
        table.to_csv(conditions, index=False)
        expected = sun + sky
        down = [i for i, (tilt, _) in enumerate(SURFACES) if tilt == 180]
        walls = [i for i, (tilt, _) in enumerate(SURFACES) if tilt == 90]
        print(f"{epw.name}: {len(table)} hours, {len(SURFACES)} surfaces; of pvlib {pvlib.__version__}")
        for model in ("perez1990", "perez"):
            of_sun, of_sky = ours(sites["open"], conditions, model, ("sun_direct", "sky_direct"))
            total = of_sun + of_sky
            # What looks down gets nothing from either.
            nothing = np.abs(total[:, down]).max()
            off, where = year(total, expected)
            hourly = rms(total, expected)
            off_sky, where_sky = year(of_sky, sky)
            by_wall = 100 * (total[:, walls].sum(0) / expected[:, walls].sum(0) - 1)
            print(f"  {model:9} sun + sky, a year {off:+7.3f} % at worst ({where}), hours {hourly:6.2f} W/m2 RMS at worst, "
                  f"{np.abs(total - expected).max():6.2f} W/m2 at most")
            print(f"  {'':9} sky alone, a year {off_sky:+7.3f} % at worst ({where_sky}); walls, sun + sky, "
                  f"{by_wall.min():+.2f} to {by_wall.max():+.2f} %; looking down {nothing:.2g} W/m2")
            if model == "perez1990":
                bad |= not (abs(off) < 0.2 and hourly < 1.0 and nothing < 1e-3)
        parts = ours(sites["ground"], conditions, "perez1990", ("sun_reflected", "sky_reflected"))
        off, where = year(parts[0] + parts[1], ground, 30)
        print(f"  endless ground of {ALBEDO} beside pvlib's isotropic one: {off:+.3f} % of a year at worst ({where})")
    sys.exit(int(bad))


main()
