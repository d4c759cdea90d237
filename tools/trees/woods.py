#!/usr/bin/env python3
"""What is seen of the sky below made woods: an open wood of broadleaved trees and a dense one of conifers, drawn at random, with 24 places on the floor
each. The judge follows 12,960 directions through the ellipsoids and cones themselves (the program has hulls of triangles); prints bias and RMSE of the
sky view, of the gap fractions by ring and of the leaf area index, and the bias of crowns whose two walls let 17 % through each, as hulls with a
transmittance do.

    tools/trees/woods.py [FOLDER]     scratch folder, default target/woods

Takes half a minute on two cores, with the program built for release; needs NumPy. HELIOTILE=PROGRAM takes another one.
"""
import csv
import os
import subprocess
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent.parent
PROGRAM = os.environ.get("HELIOTILE", ROOT / "target/release/heliotile")
SIDE, PLACES, WALL = 60.0, 24, 0.17
RINGS = [(7, 12.2), (23, 12.2), (38, 11.8), (53, 13.2), (68, 13.2)]
WEIGHTS = [0.041, 0.131, 0.201, 0.290, 0.337]
#: Name, seed, trees, heights, widths over heights, share of the trunk, leaf area density, leaves.
WOODS = [("open, broadleaved", 11, 60, (8, 16), (0.4, 0.6), 0.3, 0.5, "broadleaved"), ("dense, conifers", 12, 220, (10, 24), (0.2, 0.35), 0.15, 0.8, "needleleaved")]


def through_ellipsoid(origin, ways, middle, radii):
    """Returns where rays enter and leave an ellipsoid; they meet nothing where the first is not below the second."""
    o, d = (origin - middle) / radii, ways / radii
    a, b, c = (d * d).sum(1), d @ o, o @ o - 1
    root = np.sqrt(np.maximum(b * b - a * c, 0))
    miss = b * b < a * c
    return np.where(miss, np.inf, (-b - root) / a), np.where(miss, np.inf, (-b + root) / a)


def through_cone(origin, ways, foot, radius, height):
    """Returns where rays enter and leave an upright cone."""
    apex = foot + np.array([0, 0, height])
    k = (radius / height) ** 2
    o = origin - apex
    a = ways[:, 0] ** 2 + ways[:, 1] ** 2 - k * ways[:, 2] ** 2
    b = ways[:, 0] * o[0] + ways[:, 1] * o[1] - k * ways[:, 2] * o[2]
    c = o[0] ** 2 + o[1] ** 2 - k * o[2] ** 2
    root = np.sqrt(np.maximum(b * b - a * c, 0))
    far = 1e9
    with np.errstate(divide="ignore", invalid="ignore"):
        crossings = np.stack([np.where(b * b < a * c, far, (-b + sign * root) / a) for sign in (-1, 1)] + [(foot[2] - origin[2]) / ways[:, 2]])
    points = origin[:, None, None] + ways.T[:, None, :] * crossings[None]
    inside_sides = np.stack([(foot[2] - 1e-9 <= points[2, i]) & (points[2, i] <= apex[2] + 1e-9) for i in (0, 1)])
    inside_base = ((points[0, 2] - foot[0]) ** 2 + (points[1, 2] - foot[1]) ** 2) <= radius**2
    valid = np.vstack([inside_sides, inside_base[None]]) & np.isfinite(crossings)
    enter = np.where(valid, crossings, np.inf).min(0)
    leave = np.where(valid, crossings, -np.inf).max(0)
    return np.where(valid.sum(0) < 2, np.inf, enter), np.where(valid.sum(0) < 2, np.inf, leave)


def seen(origin, ways, trees, density, leaves):
    """Returns the light left along each ray, and that left by crowns of two walls each. Leaves in several crowns count once."""
    spans = []
    for x, y, height, width, base in trees:
        foot = np.array([x, y, base])
        if leaves == "broadleaved":
            half = 0.5 * (height - base)
            spans.append(through_ellipsoid(origin, ways, foot + [0, 0, half], np.array([width / 2, width / 2, half])))
        else:
            spans.append(through_cone(origin, ways, foot, width / 2, height - base))
    enter, leave = (np.stack([span[i] for span in spans]) for i in (0, 1))
    hit = np.isfinite(enter) & (leave > 0)
    enter, leave = np.where(hit, np.maximum(enter, 0), np.inf), np.where(hit, leave, np.inf)
    order = np.argsort(enter, axis=0)
    enter, leave = np.take_along_axis(enter, order, 0), np.take_along_axis(leave, order, 0)
    length, reached = np.zeros(len(ways)), np.zeros(len(ways))
    for a, b in zip(enter, leave):
        there = np.isfinite(a)
        length[there] += np.maximum(b[there] - np.maximum(a[there], reached[there]), 0)
        reached[there] = np.maximum(reached[there], b[there])
    return np.exp(-0.5 * density * length), (WALL * WALL) ** hit.sum(0)


def directions():
    """Returns directions of the upper hemisphere with their zenith angles, and weights of a level surface that sum to 1."""
    zenith = np.radians((np.arange(72) + 0.5) * 90 / 72)
    azimuth = np.radians((np.arange(180) + 0.5) * 2)
    t, p = (grid.ravel() for grid in np.meshgrid(zenith, azimuth, indexing="ij"))
    ways = np.stack([np.sin(t) * np.sin(p), np.sin(t) * np.cos(p), np.cos(t)], axis=1)
    weight = np.sin(t) * np.cos(t)
    return ways, np.degrees(t), weight / weight.sum()


def judged(gap, zenith, weight):
    """Returns the sky view, the gap fractions by ring and the leaf area index."""
    rings = [np.average(gap[(abs(zenith - middle) < width / 2)], weights=weight[abs(zenith - middle) < width / 2]) for middle, width in RINGS]
    index = 2 * sum(-np.log(ring) * np.cos(np.radians(middle)) * by for ring, (middle, _), by in zip(rings, RINGS, WEIGHTS))
    return [weight @ gap, *rings, index]


def main():
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "target/woods"
    folder.mkdir(parents=True, exist_ok=True)
    ways, zenith, weight = directions()
    print("| wood | sky view: mean, bias, RMSE | gap fractions of five rings: largest bias, RMSE | leaf area index: mean, bias, RMSE | sky view by walls: bias |")
    print("| --- | --- | --- | --- | --- |")
    for name, seed, count, heights, shares, trunk, density, leaves in WOODS:
        draw = np.random.default_rng(seed)
        height = draw.uniform(*heights, count)
        trees = np.stack([*draw.uniform(-SIDE / 2, SIDE / 2, (2, count)), height, height * draw.uniform(*shares, count), trunk * height], axis=1).round(3)
        places = np.append(draw.uniform(-SIDE / 4, SIDE / 4, (PLACES, 2)).round(3), np.full((PLACES, 1), 0.1), axis=1)
        (folder / "floor.obj").write_text("v -90 -90 0\nv 90 -90 0\nv 90 90 0\nv -90 90 0\nusemtl floor_ground\nf 1 2 3 4\n")
        rows = "".join(f"{x},{y},{h},{w},{b},{leaves}\n" for x, y, h, w, b in trees)
        (folder / "trees.csv").write_text("x,y,height,diameter_crown,crown_base,leaf_type\n" + rows)
        (folder / "r.csv").write_text("receiver,x,y,z,nx,ny,nz\n" + "".join(f"p{i},{x},{y},{z},0,0,1\n" for i, (x, y, z) in enumerate(places)))
        crown = f'["{leaves} crown"]\ngroup = "trees"\nleaf_area_density = {density}\n'
        (folder / "m.toml").write_text('[floor_ground]\ndiffuse = 0.1\nclass = "ground"\n' + crown)
        for words in ("build floor.obj trees.csv -m m.toml -r r.csv -o w.helio --fresh".split(), "export w.helio --view-factors -o views.csv".split()):
            subprocess.run([PROGRAM, *words], cwd=folder, check=True, capture_output=True)
        found = {row["receiver"]: row for row in csv.DictReader((folder / "views.csv").open())}
        columns = ["sky_view"] + [f"gap_{middle}_deg_percent" for middle, _ in RINGS] + ["leaf_area_index"]
        ours = np.array([[float(found[f"p{i}"][column]) / (100 if "percent" in column else 1) for column in columns] for i in range(PLACES)])
        gaps = [seen(place, ways, trees, density, leaves) for place in places]
        right, walls = (np.array([judged(gap[i], zenith, weight) for gap in gaps]) for i in (0, 1))
        off = ours - right
        bias, rmse, mean = off.mean(0), np.sqrt((off**2).mean(0)), right.mean(0)
        ring = max(range(1, 6), key=lambda k: rmse[k])
        print(f"| {name} | {mean[0]:.3f}, {bias[0]:+.4f}, {rmse[0]:.4f} | {bias[1:6][abs(bias[1:6]).argmax()]:+.4f}, {rmse[ring]:.4f} | "
              f"{mean[6]:.2f}, {bias[6]:+.3f}, {rmse[6]:.3f} | {(walls - right)[:, 0].mean():+.3f} |", flush=True)


if __name__ == "__main__":
    main()
