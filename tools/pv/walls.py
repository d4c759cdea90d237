"""Best turns beside a wall, by hand: under an even sky a white wall that fills the north, a mirror there, and the sun in a mirror."""

import math

import pandas as pd
import pvlib

import ours

SHARE = 0.8


def scene(out, name, material):
    """A wall of 8 km x 4 km half a metre north of the point, on black ground."""
    (out / f"{name}.obj").write_text(
        "v -4000 0.5 0\nv 4000 0.5 0\nv 4000 0.5 4000\nv -4000 0.5 4000\nusemtl wall\nf 1 2 3 4\n")
    (out / f"{name}.toml").write_text(f"[wall]\n{material}\n[endless_ground]\ndiffuse = 0\n")


def best(out, name, weather, *more):
    (out / "points.csv").write_text("point,x,y,z\np,0,0,1\n")
    seconds = ours.run(
        "pv", out / f"{name}.obj", "-m", out / f"{name}.toml", "--latitude", 50, "--longitude", 15, "-w", weather, "--points", out / "points.csv", "--search",
        "--no-hourly", "--replace", "-o", out / f"{name}.pv", *more)
    return ours.table(out / f"{name}.pv/best.csv")[0], seconds


def show(name, found, tilt, azimuth, seconds):
    print(f"{name:32} search {float(found['tilt_deg']):.2f} / {float(found['azimuth_deg']):.1f}, by hand {tilt:.2f} / {azimuth:.1f}, {seconds:.1f} s")


def main():
    out = ours.folder("walls")
    even = out / "even.csv"
    times = pd.date_range("2019-06-21 09:00", periods=6, freq="1h", tz="Etc/GMT-1")
    even.write_text("time,ghi,dni,dhi\n" + "".join(f"{t.isoformat(timespec='minutes')},100,0,100\n" for t in times))
    # Light from a lune of directions between two angles is the difference of sines: sky gives cos + sin of the normal's height, a wall that is
    # w times as bright gives w (1 - cos). The best height has tan = 1 / (1 - w).
    for name, material, bright in (
        ("black wall", "diffuse = 0", 0.0),
        ("white wall", f"diffuse = {SHARE}", SHARE / 2),
        ("mirror", f"diffuse = 0\nspecular = {SHARE}", SHARE),
    ):
        scene(out, name, material)
        found, seconds = best(out, name, even, "--sky", "uniform")
        show(f"{name}, even sky", found, 90 - math.degrees(math.atan2(1, 1 - bright)), 180, seconds)
    # The sun and its image: the best normal is their sum, the image weighed by the mirror.
    minutes = pd.date_range("2019-03-21 13:30", periods=3, freq="1min", tz="Etc/GMT-1")
    (out / "sun.csv").write_text("time,ghi,dni,dhi\n" + "".join(f"{t.isoformat(timespec='minutes')},,900,0\n" for t in minutes))
    sun = pvlib.solarposition.spa_python(minutes + pd.Timedelta("30s"), 50, 15, 0).iloc[1]
    azimuth, height = math.radians(sun["azimuth"]), math.radians(sun["elevation"])
    x, y, z = math.cos(height) * math.sin(azimuth), math.cos(height) * math.cos(azimuth), math.sin(height)
    x, y, z = x * (1 + SHARE), y * (1 - SHARE), z * (1 + SHARE)
    found, seconds = best(out, "mirror", out / "sun.csv")
    show("mirror, sun", found, math.degrees(math.atan2(math.hypot(x, y), z)), math.degrees(math.atan2(x, y)) % 360, seconds)
