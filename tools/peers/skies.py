"""Open surfaces under gendaymtx's skies, beside sums over the same matrices. In: an EPW file. Out: a table, and with --cut files of the tests.

The sums know nothing of heliotile: borders of Reinhart's patches and their order are those of gendaymtx's manual, cosines are averaged over
24 x 24 points of equal solid angle in each patch.
"""
import argparse
import csv
import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pyradiance

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = Path(os.environ.get("HELIOTILE", ROOT / "target/release/heliotile"))
WORK = ROOT / "target/peers/skies"
RADIANCE = Path(pyradiance.__file__).parent / "bin"
HOURS = 500
# Tilt and azimuth: flat and four tilts.
SURFACES = [(0, 0), (30, 180), (60, 90), (90, 270), (90, 0)]
# Weights of red, green and blue in Radiance's luminance.
LUMINANCE = [0.265, 0.670, 0.065]
# Hours of the cut: month, day, hour, DNI, DHI.
CUT = [(3, 21, 8.5, 350, 110), (3, 21, 9.5, 500, 90), (3, 21, 10.5, 820, 120), (3, 21, 11.5, 200, 160), (3, 21, 12.5, 0, 180),
       (3, 21, 13.5, 600, 140), (3, 21, 14.5, 450, 100), (3, 21, 15.5, 300, 70)]
HEAD = "place skies\nlatitude 52\nlongitude -5\ntime_zone -15\nsite_elevation 0\nweather_data_file_units 1\n"


def bands(factor):
    """Lower and upper altitude and number of patches of each row."""
    counts = [n * factor for n in (30, 30, 24, 24, 18, 12, 6) for _ in range(factor)]
    height = math.pi / 2 / (len(counts) + 0.5)
    return [(k * height, (k + 1) * height, n) for k, n in enumerate(counts)] + [(len(counts) * height, math.pi / 2, 1)]


def coefficients(factor, tilt_deg, azimuth_deg, points=24):
    """Cosine-weighted solid angle of each patch before an open surface, sr."""
    tilt, azimuth = math.radians(tilt_deg), math.radians(azimuth_deg)
    normal = [math.sin(tilt) * math.sin(azimuth), math.sin(tilt) * math.cos(azimuth), math.cos(tilt)]
    found = []
    for low, high, count in bands(factor):
        z = math.sin(low) + (math.sin(high) - math.sin(low)) * (np.arange(points) + 0.5) / points
        level = np.sqrt(1 - z * z)
        sr = 2 * math.pi * (math.sin(high) - math.sin(low)) / count
        across = points if count > 1 else 720
        for patch in range(count):
            turn = 2 * math.pi * (patch - 0.5 + (np.arange(across) + 0.5) / across) / count
            cosine = normal[0] * np.outer(level, np.sin(turn)) + normal[1] * np.outer(level, np.cos(turn)) + normal[2] * z[:, None]
            found.append(np.maximum(cosine, 0).mean() * sr)
    return np.array(found)


def gendaymtx(wea, factor, flags):
    """The matrix of a weather file."""
    return subprocess.run([RADIANCE / "gendaymtx", "-m", str(factor), "-s", "-O1", *flags, wea], check=True, capture_output=True).stdout


def radiances(matrix):
    """`[patch][hour]` without the ground."""
    head, body = matrix.split(b"\n\n", 1)
    of = dict(line.split("=", 1) for line in head.decode().splitlines() if "=" in line)
    cells = np.frombuffer(body, "<f4") if of["FORMAT"] == "float" else np.array(body.split(), float)
    return (cells.reshape(int(of["NROWS"]), int(of["NCOLS"]), 3) @ LUMINANCE)[1:]


def irradiances(matrix, factor, hours=slice(None)):
    """`[hour][surface]`, W/m2."""
    light = radiances(matrix)[:, hours]
    return np.array([coefficients(factor, *surface) @ light for surface in SURFACES]).T


def name(surface):
    return f"sky_{surface[0]}_{surface[1]}"


def archive():
    """Surfaces over nothing."""
    WORK.mkdir(parents=True, exist_ok=True)
    (WORK / "far.obj").write_text("v 0 0 -9\nv 0.01 0 -9\nv 0 0.01 -9\nusemtl far\nf 1 2 3\n")
    (WORK / "far.toml").write_text("[far]\ndiffuse = 0\n")
    rows = ["receiver,x,y,z,nx,ny,nz"]
    for i, (tilt, azimuth) in enumerate(SURFACES):
        t, a = math.radians(tilt), math.radians(azimuth)
        rows.append(f"{name((tilt, azimuth))},{3 * i},0,0,{math.sin(t) * math.sin(a)},{math.sin(t) * math.cos(a)},{math.cos(t)}")
    (WORK / "receivers.csv").write_text("\n".join(rows) + "\n")
    run("build", WORK / "far.obj", "--materials", WORK / "far.toml", "--receivers", WORK / "receivers.csv", "-o", WORK / "open.helio", "--no-ground")
    return WORK / "open.helio"


def run(*arguments):
    subprocess.run([PROGRAM, *arguments], check=True, stdout=subprocess.DEVNULL)


def replayed(site, wea, matrix, patches):
    """`[hour][surface]` of sky_direct."""
    table = WORK / "out.csv"
    run("replay", site, "--weather", wea, "--sky", matrix, "--patches", str(patches), "--columns", "sky_direct", "-o", table)
    with open(table, newline="") as file:
        rows = list(csv.DictReader(file))
    columns = {name(surface): [] for surface in SURFACES}
    for row in rows:
        columns[row["receiver"]].append(float(row["sky_direct_w_m2" if "sky_direct_w_m2" in row else "sky_direct"]))
    return np.array(list(columns.values())).T


def year(epw):
    """The year as a WEA file, and evenly spread rows with light."""
    wea = subprocess.run([RADIANCE / "epw2wea", epw], check=True, capture_output=True).stdout
    path = WORK / "year.wea"
    path.write_bytes(wea)
    rows = wea.decode().splitlines()[6:]
    lit = [i for i, row in enumerate(rows) if float(row.split()[4]) > 0]
    return path, [lit[i * len(lit) // HOURS] for i in range(HOURS)]


def cut(folder):
    """Matrices of a few hours and their sums."""
    folder.mkdir(parents=True, exist_ok=True)
    wea = folder / "hours.wea"
    wea.write_text(HEAD + "".join(f"{m} {d} {h} {dni} {dhi}\n" for m, d, h, dni, dhi in CUT))
    lines = ["matrix,hour," + ",".join(name(surface) for surface in SURFACES)]
    for file, factor, flags in (("m1.mtx", 1, []), ("m2_float.mtx", 2, ["-of"])):
        matrix = gendaymtx(wea, factor, flags)
        # The command names a folder of this machine.
        start, rest = matrix.split(b"\n", 2)[0], matrix.split(b"\n", 2)[2]
        matrix = b"\n".join([start, " ".join(["gendaymtx", "-m", str(factor), "-s", "-O1", *flags, "hours.wea"]).encode(), rest])
        (folder / file).write_bytes(matrix)
        for hour, row in enumerate(irradiances(matrix, factor)):
            lines.append(f"{file},{hour}," + ",".join(f"{value:.4f}" for value in row))
    (folder / "sums.csv").write_text("\n".join(lines) + "\n")


def points(factor, side):
    """Points of equal solid angle of each patch, and what one of them stands for, sr."""
    found = []
    for low, high, count in bands(factor):
        z = math.sin(low) + (math.sin(high) - math.sin(low)) * (np.arange(side) + 0.5) / side
        across = side if count > 1 else 6 * side
        for patch in range(count):
            turn = 2 * math.pi * (patch - 0.5 + (np.arange(across) + 0.5) / across) / count
            heights, turns = np.meshgrid(z, turn, indexing="ij")
            level = np.sqrt(1 - heights**2)
            directions = np.stack([level * np.sin(turns), level * np.cos(turns), heights], axis=-1).reshape(-1, 3)
            found.append((directions, 2 * math.pi * (math.sin(high) - math.sin(low)) / count / len(directions)))
    return found


def cie_12(directions, sun):
    """Relative radiances of the CIE standard clear sky."""
    angle = np.arccos(np.clip(directions @ sun, -1, 1))
    gradation = 1 - np.exp(-0.32 / np.maximum(directions[:, 2], 0.01))
    return gradation * (1 + 10 * (np.exp(-3 * angle) - math.exp(-1.5 * math.pi)) + 0.45 * np.cos(angle) ** 2)


def clouds():
    """What is lost where patches are dimmed by their mean: clouds with sharp edges before a clear sky, in percent of DHI."""
    surfaces = np.array([[0, 0, 1], [0, -1, 0]])
    for factor, side in ((2, 24), (4, 12)):
        random, sky = np.random.default_rng(1), points(factor, side)
        errors = []
        for trial in range(200):
            altitude = math.radians(random.uniform(15, 65))
            sun = np.array([0, -math.cos(altitude), math.sin(altitude)])
            towards = random.normal(size=3)
            edge = math.cos(math.radians(random.uniform(10, 90)))
            if trial % 2:
                towards, edge = np.cross(sun, random.normal(size=3)), 0.0
            towards /= np.linalg.norm(towards)
            exact, dimmed, dhi = np.zeros(2), np.zeros(2), 0.0
            for directions, sr in sky:
                light, through = cie_12(directions, sun), (directions @ towards < edge).astype(float)
                cosines = np.maximum(directions @ surfaces.T, 0)
                exact += sr * (light * through) @ cosines
                dimmed += sr * light.mean() * through.mean() * cosines.sum(axis=0)
                dhi += sr * light @ cosines[:, 0]
            errors.append(100 * (dimmed - exact) / dhi)
        errors = np.array(errors)
        rms, most = np.sqrt((errors**2).mean(axis=0)), np.abs(errors).max(axis=0)
        print(f"{144 * factor**2 + 1} patches: flat {rms[0]:.2f} % RMS, {most[0]:.2f} % at most; south wall {rms[1]:.2f} %, {most[1]:.2f} %")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--cut", type=Path)
    parser.add_argument("--clouds", action="store_true")
    parser.add_argument("weather", nargs="?", type=Path, default=ROOT / "tests/data/weather/golden_tmy3.epw")
    arguments = parser.parse_args()
    if arguments.cut:
        cut(arguments.cut)
        return
    if arguments.clouds:
        clouds()
        return
    site = archive()
    (wea, hours), worst = year(arguments.weather), 0.0
    print("| matrix | on patches | " + " | ".join(f"{tilt} deg to {azimuth}" for tilt, azimuth in SURFACES) + " | worst hour |")
    for factor in (1, 2, 4):
        matrix = WORK / f"m{factor}.mtx"
        matrix.write_bytes(gendaymtx(wea, factor, ["-of"]))
        expected = irradiances(matrix.read_bytes(), factor, hours)
        for patches in (145, 577, 2305):
            found = replayed(site, wea, matrix, patches)[hours]
            means = 100 * (found.mean(axis=0) / expected.mean(axis=0) - 1)
            largest = 100 * np.abs(found - expected).max() / expected.mean()
            if patches == 144 * factor**2 + 1:
                worst = max(worst, *np.abs(means))
            print(f"| MF:{factor} | {patches} | " + " | ".join(f"{mean:+.3f} %" for mean in means) + f" | {largest:.2f} % |", flush=True)
    sys.exit(worst > 0.5)


main()
