#!/usr/bin/env python3
"""A generated house in hills of a given extent, and receivers on its walls and roof.

    hills.py FOLDER KILOMETRES    writes FOLDER/terrain.asc, house.obj, site.toml and receivers.csv
"""
import math
import os
import sys

STEP_M = 50.0
# Waves that make the hills: height, length, direction (m, m, degrees).
WAVES = [(400, 9000, 20), (250, 5100, 75), (120, 2300, 140), (60, 1100, 50), (25, 520, 110), (500, 31000, 160)]


def height(x, y):
    """Flat where the house stands."""
    at = sum(h * math.sin(2 * math.pi * (x * math.cos(math.radians(a)) + y * math.sin(math.radians(a))) / length)
             for h, length, a in WAVES)
    return at * min(1.0, math.hypot(x, y) / 400) + 1000


def main(folder, kilometres):
    os.makedirs(folder, exist_ok=True)
    count = round(float(kilometres) * 1000 / STEP_M)
    low = -count * STEP_M / 2
    with open(f"{folder}/terrain.asc", "w") as asc:
        asc.write(f"ncols {count}\nnrows {count}\nxllcorner {low}\nyllcorner {low}\ncellsize {STEP_M}\nnodata_value -9999\n")
        for row in range(count):
            y = low + (count - row - 0.5) * STEP_M
            asc.write(" ".join("%.1f" % height(low + (column + 0.5) * STEP_M, y) for column in range(count)) + "\n")
    base, (w, d, h) = height(0, 0), (12, 9, 6)
    walls = [((0, 0), (w, 0), (0, -1)), ((w, 0), (0, d), (1, 0)), ((w, d), (-w, 0), (0, 1)), ((0, d), (0, -d), (-1, 0))]
    with open(f"{folder}/house.obj", "w") as obj, open(f"{folder}/receivers.csv", "w") as csv:
        csv.write("receiver,x,y,z,nx,ny,nz\n")
        for side, ((x, y), (a, b), (nx, ny)) in enumerate(walls):
            corners = [(x, y, base - 2), (x + a, y + b, base - 2), (x + a, y + b, base + h), (x, y, base + h)]
            obj.write("usemtl wall\n" + "".join("v %.3f %.3f %.3f\n" % c for c in corners) + "f -4 -3 -2 -1\n")
            for i in range(5):
                for j in range(4):
                    s, z = (i + 0.5) / 5, base + (j + 0.5) / 4 * h
                    csv.write("w%d_%d_%d,%.3f,%.3f,%.3f,%d,%d,0\n" % (side, i, j, x + s * a + 0.01 * nx, y + s * b + 0.01 * ny, z, nx, ny))
        corners = [(0, 0), (w, 0), (w, d), (0, d)]
        obj.write("usemtl roof\n" + "".join("v %.3f %.3f %.3f\n" % (*c, base + h) for c in corners) + "f -4 -3 -2 -1\n")
        csv.write("roof,6,4.5,%.3f,0,0,1\n" % (base + h + 0.01))
    with open(f"{folder}/site.toml", "w") as toml:
        for name, diffuse, kind in (("terrain", 0.2, "ground"), ("wall", 0.5, "obstruction"), ("roof", 0.3, "obstruction")):
            toml.write(f'[{name}]\ndiffuse = {diffuse}\nclass = "{kind}"\n')


main(*sys.argv[1:])
