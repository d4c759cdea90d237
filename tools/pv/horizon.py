"""Horizons in a mountain basin beside a scan of the terrain's samples."""

import numpy as np
import tifffile

import ours

STEP, WEST, NORTH = 50.0, 320_000.0, 4_166_650.0
HEIGHT = 2.0
# Of UTM zone 11 in the middle of the basin: y from true north, clockwise, on a sphere.
CONVERGENCE = np.arctan(np.tan(np.radians(-118.9949 + 117.0)) * np.sin(np.radians(37.5925)))
EVERY = 9


def scan(height, row, column, facets):
    """Heights of the horizon in 360 directions, along 360 lines over the samples of the terrain: between them triangles, whose diagonals go through
    the samples of odd row and column, or bilinear."""
    rows, columns = height.shape
    azimuth = np.radians(np.arange(360.0)) - CONVERGENCE
    distances = np.concatenate([np.arange(0.01, 4.0, 0.01), np.arange(4.0, 240.0, 0.05)])
    r = row - np.outer(np.cos(azimuth), distances)
    c = column + np.outer(np.sin(azimuth), distances)
    inside = (r >= 0) & (r <= rows - 1) & (c >= 0) & (c <= columns - 1)
    r0 = np.clip(np.floor(r).astype(int), 0, rows - 2)
    c0 = np.clip(np.floor(c).astype(int), 0, columns - 2)
    a, b = r - r0, c - c0
    h00, h10, h01, h11 = height[r0, c0], height[r0 + 1, c0], height[r0, c0 + 1], height[r0 + 1, c0 + 1]
    if facets:
        down = np.where(a > b, h00 + a * (h10 - h00) + b * (h11 - h10), h00 + b * (h01 - h00) + a * (h11 - h01))
        up = np.where(a + b < 1, h00 + a * (h10 - h00) + b * (h01 - h00), h11 + (1 - a) * (h01 - h11) + (1 - b) * (h10 - h11))
        z = np.where((r0 % 2) == (c0 % 2), down, up)
    else:
        z = h00 * (1 - a) * (1 - b) + h10 * a * (1 - b) + h01 * (1 - a) * b + h11 * a * b
    rise = np.where(inside, (z - height[row, column] - HEIGHT) / (distances * STEP), 0.0)
    return np.degrees(np.arctan(np.maximum(rise.max(axis=1), 0.0)))


def main():
    out = ours.folder("horizon")
    terrain = ours.ROOT / "tests/data/terrain/lakes_basin.tif"
    height = tifffile.imread(terrain).astype(float)
    rows, columns = height.shape
    places = [(row, column) for row in range(20, rows - 20, EVERY * 2) for column in range(20, columns - 20, EVERY * 2)]
    lines = "".join(f"{r}_{c},{WEST + STEP * c},{NORTH - STEP * r},{HEIGHT},30,180\n" for r, c in places)
    (out / "points.csv").write_text(f"point,x,y,height,tilt,azimuth\n{lines}")
    (out / "weather.csv").write_text("time,ghi,dni,dhi\n" + "".join(f"2019-06-21T{h:02}:00-08:00,100,0,100\n" for h in range(9, 15)))
    seconds = ours.run(
        "pv", terrain, "-w", out / "weather.csv", "--points", out / "points.csv", "--no-hourly", "--quality", "draft",
        "--replace", "-o", out / "pv")
    found = {row: np.loadtxt(out / f"pv/horizon/{row[0]}_{row[1]}.csv") for row in places}
    print(f"{len(places)} points x 360 directions, {seconds:.1f} s; horizons up to {max(h.max() for h in found.values()):.1f} degrees")
    for name, facets in (("triangles between samples", True), ("bilinear between samples", False)):
        off = np.array([found[place] - scan(height, *place, facets) for place in places])
        size = np.abs(off)
        print(
            f"  {name}: RMS {np.sqrt((off ** 2).mean()):.4f} degrees, mean {off.mean():+.4f}, 99 % within {np.quantile(size, 0.99):.3f}, "
            f"largest {size.max():.2f}")
