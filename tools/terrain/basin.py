"""Sky view of the Lakes Basin: heliotile, the raster that its authors made in QGIS, and a scan of the horizon for the worst pixels."""

import argparse
import csv
import subprocess
import time
from pathlib import Path

import numpy as np
import tifffile

ROOT = Path(__file__).resolve().parents[2]
DATA = ROOT / "tests/data/terrain"
OUT = ROOT / "target/terrain"
STEP, WEST, NORTH = 50.0, 320_000.0, 4_166_650.0
RIM = 2
OFFSET = 0.05


def receivers(height):
    """A receiver at every sample but the rim, on the slope by central differences."""
    south, east = np.gradient(height, STEP)
    rows, columns = height.shape
    path = OUT / "receivers.csv"
    with path.open("w") as file:
        file.write("receiver,x,y,z,nx,ny,nz\n")
        for row in range(RIM, rows - RIM):
            for column in range(RIM, columns - RIM):
                normal = np.array([-east[row, column], south[row, column], 1.0])
                normal /= np.linalg.norm(normal)
                x, y = WEST + STEP * column, NORTH - STEP * row
                z = height[row, column] + OFFSET
                file.write(f"{row}_{column},{x},{y},{z:.4f},{normal[0]:.7f},{normal[1]:.7f},{normal[2]:.7f}\n")
    return path


def ours(height):
    """Sky view factors by heliotile, nan at the rim."""
    program, site = ROOT / "target/release/heliotile", OUT / "basin.helio"
    start = time.time()
    subprocess.run(
        [program, "build", DATA / "lakes_basin.tif", "-r", receivers(height), "-o", site, "--effects", "none"],
        check=True, stdout=subprocess.DEVNULL,
    )
    built = time.time()
    subprocess.run([program, "export", site, "--view-factors", "-o", OUT / "views.csv"], check=True, stdout=subprocess.DEVNULL)
    print(f"heliotile: build {built - start:.1f} s, {site.stat().st_size / 1e6:.1f} MB, quality standard")
    view = np.full(height.shape, np.nan)
    with (OUT / "views.csv").open() as file:
        for row in csv.DictReader(file):
            view[tuple(int(part) for part in row["receiver"].split("_"))] = float(row["sky_view"])
    return view


def scanned(height, pixels, directions):
    """Sky view of slopes from horizons (Dozier and Frew 1990, eq. 7b), heights bilinear between samples."""
    south, east = np.gradient(height, STEP)
    rows, columns = height.shape
    found = []
    distances = np.concatenate([np.arange(0.02, 4.0, 0.02), np.arange(4.0, 240.0, 0.25)])
    for row, column in pixels:
        slope = np.arctan(np.hypot(east[row, column], south[row, column]))
        aspect = np.arctan2(-east[row, column], south[row, column])
        azimuth = 2 * np.pi * np.arange(directions) / directions
        r = row - np.outer(np.cos(azimuth), distances)
        c = column + np.outer(np.sin(azimuth), distances)
        inside = (r >= 0) & (r <= rows - 1) & (c >= 0) & (c <= columns - 1)
        r0 = np.clip(np.floor(r).astype(int), 0, rows - 2)
        c0 = np.clip(np.floor(c).astype(int), 0, columns - 2)
        a, b = r - r0, c - c0
        z = (height[r0, c0] * (1 - a) * (1 - b) + height[r0 + 1, c0] * a * (1 - b)
             + height[r0, c0 + 1] * (1 - a) * b + height[r0 + 1, c0 + 1] * a * b)
        rise = np.where(inside, (z - height[row, column] - OFFSET) / (distances * STEP), -np.inf)
        horizon = np.maximum(np.arctan(rise.max(axis=1)), 0.0)
        # The slope itself hides what lies behind its plane.
        own = np.arctan(-np.tan(slope) * np.cos(azimuth - aspect))
        zenith = np.pi / 2 - np.maximum(horizon, np.maximum(own, 0.0))
        sector = (np.cos(slope) * np.sin(zenith) ** 2
                  + np.sin(slope) * np.cos(azimuth - aspect) * (zenith - np.sin(zenith) * np.cos(zenith)))
        found.append(sector.mean())
    return np.array(found)


def say(name, difference):
    size = np.abs(difference)
    print(f"  {name:34} mean {difference.mean():+.4f}, 95 % within {np.quantile(size, 0.95):.4f}, worst {size.max():.4f}")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--pixels", type=int, default=60)
    pixels = parser.parse_args().pixels
    OUT.mkdir(parents=True, exist_ok=True)
    height = tifffile.imread(DATA / "lakes_basin.tif").astype(float)
    theirs = tifffile.imread(DATA / "lakes_basin_sky_view.tif").astype(float)
    view = ours(height)
    known = ~np.isnan(view)
    difference = view - theirs
    print(f"{known.sum()} pixels:")
    say("heliotile - raster", difference[known])
    order = np.argsort(np.where(known, np.abs(difference), -1.0), axis=None)
    worst = [np.unravel_index(i, height.shape) for i in order[-pixels:]]
    some = [np.unravel_index(i, height.shape) for i in np.flatnonzero(known)[:: known.sum() // pixels][:pixels]]
    for name, chosen in ((f"{pixels} pixels that differ most", worst), (f"{pixels} pixels evenly chosen", some)):
        place = tuple(np.transpose(chosen))
        fine, coarse = scanned(height, chosen, 1440), scanned(height, chosen, 8)
        print(f"{name}, against a scan of the horizon in 1,440 directions:")
        say("heliotile - scan", view[place] - fine)
        say("raster - scan", theirs[place] - fine)
        say("scan in 8 directions - raster", coarse - theirs[place])
        nearer = np.abs(view[place] - fine) < np.abs(theirs[place] - fine)
        print(f"  heliotile is nearer to the scan at {nearer.sum()} of {len(chosen)}")


main()
