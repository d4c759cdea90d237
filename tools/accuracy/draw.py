#!/usr/bin/env python3
"""Sites drawn at random, to tune settings on some and to state errors on others.

    draw.py HELIOTILE FOLDER SEED [KIND ...]    writes FOLDER/KIND-SEED/{scene.obj,materials.toml,receivers.csv} for every kind, or some

dense      terraces along streets of 8 to 15 m, four to seven storeys
suburb     houses with gable roofs, 7 to 15 m apart
towers     towers of 25 to 90 m on a square
courts     blocks around courts of 8 to 25 m with light walls
arcades    a square with walks behind pillars and bridges between its houses
slopes     houses on hills
trees      a suburb with crowns of leaves along its streets
mirrors    terraces, one house of sixteen of which is of mirrors: each mirror takes the path tracer as long as a site without

The same seed gives the same site. The receivers are 400 of those that `heliotile receivers` puts on the middle of the site: half on walls, a quarter on roofs,
a quarter on the ground.
"""
import csv
import math
import os
import random
import subprocess
import sys

from sites import Site, gable

RECEIVERS = {"wall": 200, "roof": 100, "ground": 100}


def plain(site, half, material="street"):
    site.face(material, (-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0))


def terraces(site, draw, facades):
    """Rows of houses that share walls, on both sides of parallel streets; the walls that face a street take a material of `facades`."""
    plain(site, 90)
    x = -70
    while x < 70:
        deep, street = draw.uniform(9, 14), draw.uniform(8, 15)
        y = -60
        while y < 60:
            wide, high = draw.uniform(5, 14), draw.uniform(9, 21)
            if draw.random() > 0.08:
                site.box(draw.choice(facades), "roof", (x, y, 0), (x + deep, y + wide, high))
                if draw.random() < 0.3:
                    site.box("wall", "roof", (x + 1, y + 1, high), (x + 4, y + wide - 1, high + 2.5))
            y += wide
        x += deep + street


def dense(draw):
    site = Site({"street": (0.2, "ground"), "wall": (draw.uniform(0.25, 0.45), "obstruction"), "brick": (0.2, "obstruction"), "roof": (0.2, "obstruction")})
    terraces(site, draw, ["wall", "wall", "brick"])
    return site


def mirrors(draw):
    site = Site({"street": (0.2, "ground"), "wall": (0.3, "obstruction"), "roof": (0.2, "obstruction"), "mirror": (0.05, "obstruction", draw.uniform(0.2, 0.5))})
    terraces(site, draw, ["wall"] * 15 + ["mirror"])
    return site


def houses(site, draw, trees=False):
    plain(site, 150)
    y = -60
    while y < 60:
        x = -60 + draw.uniform(0, 6)
        while x < 60:
            wide, deep, eaves = draw.uniform(7, 13), draw.uniform(7, 11), draw.uniform(2.7, 7)
            gable(site, x, y, wide, deep, eaves, eaves + draw.uniform(2, 4))
            if trees and draw.random() < 0.7:
                crown(site, (x + wide + 3, y - 4, draw.uniform(4, 7)), draw.uniform(1.5, 3), draw.uniform(2, 4))
            x += wide + draw.uniform(5, 12)
        y += 11 + draw.uniform(7, 15)


def crown(site, middle, wide, high):
    """The hull of an ellipsoid."""
    at = lambda ring, side: tuple(m + r * v for m, r, v in zip(middle, (wide, wide, high), (
        math.sin(math.pi * ring / 6) * math.cos(math.tau * side / 10), math.sin(math.pi * ring / 6) * math.sin(math.tau * side / 10), math.cos(math.pi * ring / 6))))
    for ring in range(6):
        for side in range(10):
            a, b, c, d = at(ring, side), at(ring + 1, side), at(ring + 1, side + 1), at(ring, side + 1)
            if ring < 5:
                site.face("leaves", a, b, c)
            if ring > 0:
                site.face("leaves", a, c, d)


def suburb(draw, trees=False):
    site = Site({"street": (0.2, "ground"), "wall": (draw.uniform(0.3, 0.6), "obstruction"), "tiles": (0.25, "obstruction")})
    houses(site, draw, trees)
    return site


def trees(draw):
    site = suburb(draw, True)
    site.leaves = {"leaves": 0.3}
    return site


def towers(draw):
    site = Site({"street": (0.25, "ground"), "wall": (draw.uniform(0.2, 0.5), "obstruction"), "roof": (0.2, "obstruction")})
    plain(site, 400)
    for i in range(4):
        for j in range(4):
            x, y = -75 + 42 * i + draw.uniform(-6, 6), -75 + 42 * j + draw.uniform(-6, 6)
            wide, deep, podium = draw.uniform(12, 20), draw.uniform(12, 20), draw.uniform(4, 9)
            site.box("wall", "roof", (x - 5, y - 5, 0), (x + wide + 5, y + deep + 5, podium))
            site.box("wall", "roof", (x, y, podium), (x + wide, y + deep, draw.uniform(25, 90)))
    return site


def courts(draw):
    site = Site({"street": (0.25, "ground"), "wall": (draw.uniform(0.5, 0.75), "obstruction"), "roof": (0.2, "obstruction")})
    plain(site, 120)
    for i in range(3):
        for j in range(3):
            x, y, side, high = -72 + 50 * i, -72 + 50 * j, draw.uniform(8, 25), draw.uniform(9, 18)
            low, top, width = (x, y), (x + 38, y + 38), (38 - side) / 2
            for a, b in ((low, (top[0], y + width)), ((x, top[1] - width), top), ((x, y + width), (x + width, top[1] - width)),
                         ((top[0] - width, y + width), (top[0], top[1] - width))):
                site.box("wall", "roof", (*a, 0), (*b, high))
    return site


def arcades(draw):
    site = Site({"street": (0.4, "ground"), "wall": (draw.uniform(0.4, 0.6), "obstruction"), "roof": (0.2, "obstruction")})
    plain(site, 120)
    half = draw.uniform(12, 20)
    for side in (-1, 1):
        inner, high, storey = half * side, draw.uniform(10, 18), draw.uniform(3.5, 5)
        walk, outer = inner + side * draw.uniform(3, 5), inner + 16 * side
        box = lambda x0, x1, y0, y1, z0, z1: site.box("wall", "roof", (min(x0, x1), y0, z0), (max(x0, x1), y1, z1))
        box(walk, outer, -50, 50, 0, high)
        box(inner, walk, -50, 50, storey, high)
        step, y = draw.uniform(3, 5), -50.0
        while y < 49:
            box(inner, inner + 0.6 * side, y, y + 0.6, 0, storey)
            y += step
    for _ in range(3):
        y, low = draw.uniform(-45, 40), draw.uniform(4.5, 7)
        site.box("wall", "roof", (-half, y, low), (half, y + draw.uniform(2, 6), low + 3))
    return site


def slopes(draw):
    site = Site({"grass": (0.25, "ground"), "wall": (draw.uniform(0.3, 0.6), "obstruction"), "tiles": (0.25, "obstruction")})
    rise, a, b, c = draw.uniform(8, 20), draw.uniform(30, 60), draw.uniform(30, 60), draw.uniform(0, 6)
    height = lambda x, y: rise * (math.sin(x / a + c) * math.cos(y / b) + 0.4 * math.sin(x / 17 + y / 19))
    step, count = 6, 50
    at = lambda i, j: (step * (i - count / 2), step * (j - count / 2), height(step * (i - count / 2), step * (j - count / 2)))
    for i in range(count):
        for j in range(count):
            site.face("grass", at(i, j), at(i + 1, j), at(i + 1, j + 1))
            site.face("grass", at(i, j), at(i + 1, j + 1), at(i, j + 1))
    for i in range(6):
        for j in range(6):
            x, y, wide, deep = -58 + 20 * i + draw.uniform(-3, 3), -58 + 20 * j + draw.uniform(-3, 3), draw.uniform(7, 12), draw.uniform(7, 11)
            corners = [height(x + u, y + v) for u in (0, wide) for v in (0, deep)]
            site.box("wall", "tiles", (x, y, min(corners) - 2), (x + wide, y + deep, max(corners) + draw.uniform(4, 8)))
    return site


KINDS = (dense, suburb, towers, courts, arcades, slopes, trees, mirrors)


def choose(program, folder, draw):
    """Writes receivers.csv: some of the receivers that the program puts on the middle of the site."""
    scene, table = [f"{folder}/scene.obj", "-m", f"{folder}/materials.toml"], f"{folder}/receivers.csv"
    subprocess.run([program, "receivers", *scene, "--on", "wall,roof,ground", "--spacing", "2m", "-o", table, "--quiet"], check=True, stderr=subprocess.DEVNULL)
    with open(table, newline="") as text:
        rows = [row for row in csv.DictReader(text) if max(abs(float(row["x"])), abs(float(row["y"]))) < 45]
    chosen = []
    for kind, count in RECEIVERS.items():
        of = [row for row in rows if row["kind"] == kind]
        chosen += draw.sample(of, min(count, len(of)))
    with open(table, "w", newline="") as text:
        out = csv.DictWriter(text, ["receiver", "x", "y", "z", "nx", "ny", "nz"], extrasaction="ignore")
        out.writeheader()
        out.writerows(chosen)


if __name__ == "__main__":
    program, folder, seed, *names = sys.argv[1:]
    for make in KINDS:
        if not names or make.__name__ in names:
            draw = random.Random(f"{make.__name__} {seed}")
            at = f"{folder}/{make.__name__}-{seed}"
            make(draw).write(at)
            choose(program, at, draw)
