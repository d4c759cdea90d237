#!/usr/bin/env python3
"""A generated city of a given extent, and receivers on the walls and roofs in its middle, the same for every extent.

    city.py FOLDER KILOMETRES    writes FOLDER/site.obj, site.toml and receivers.csv
"""
import os
import random
import sys

PITCH_M = 20.0  # from building to building: 2,500 a square kilometre, 25,000 triangles
MIDDLE = 9  # so many buildings to each side of the middle have receivers


def building(column, row):
    """Lower corner and size, whatever the extent of the city."""
    numbers = random.Random(f"{column} {row}")
    size = [7 + 7 * numbers.random(), 7 + 7 * numbers.random(), 4 + 16 * numbers.random() ** 2]
    return [column * PITCH_M, row * PITCH_M, 0.0], size


def sides(low, size):
    """Material, corner, two edges and normal of walls and roof."""
    (x, y, z), (w, d, h) = low, size
    up = (0, 0, h)
    return [("wall", (x, y, z), (w, 0, 0), up, (0, -1, 0)), ("wall", (x + w, y, z), (0, d, 0), up, (1, 0, 0)),
            ("wall", (x + w, y + d, z), (-w, 0, 0), up, (0, 1, 0)), ("wall", (x, y + d, z), (0, -d, 0), up, (-1, 0, 0)),
            ("roof", (x, y, h), (w, 0, 0), (0, d, 0), (0, 0, 1))]


def quad(obj, at, a, b):
    for s, t in ((0, 0), (1, 0), (1, 1), (0, 1)):
        obj.write("v %.3f %.3f %.3f\n" % tuple(at[k] + a[k] * s + b[k] * t for k in range(3)))
    obj.write("f -4 -3 -2 -1\n")


def main(folder, kilometres):
    os.makedirs(folder, exist_ok=True)
    half = round(float(kilometres) * 500 / PITCH_M)
    with open(f"{folder}/site.obj", "w") as obj, open(f"{folder}/receivers.csv", "w") as csv:
        csv.write("receiver,x,y,z,nx,ny,nz\n")
        obj.write("usemtl ground\n")
        for column in range(-half, half, 10):
            for row in range(-half, half, 10):
                quad(obj, (column * PITCH_M, row * PITCH_M, 0), (10 * PITCH_M, 0, 0), (0, 10 * PITCH_M, 0))
        for column in range(-half, half):
            for row in range(-half, half):
                for side, (material, at, a, b, normal) in enumerate(sides(*building(column, row))):
                    obj.write(f"usemtl {material}\n")
                    quad(obj, at, a, b)
                    if -MIDDLE <= min(column, row) and max(column, row) < MIDDLE:
                        place = [at[k] + 0.37 * a[k] + 0.41 * b[k] + 0.01 * normal[k] for k in range(3)]
                        csv.write("r%d_%d_%d," % (column, row, side) + ",".join("%.4f" % v for v in place) + ",%d,%d,%d\n" % normal)
    with open(f"{folder}/site.toml", "w") as toml:
        for name, diffuse, kind in (("ground", 0.2, "ground"), ("wall", 0.4, "obstruction"), ("roof", 0.2, "obstruction")):
            toml.write(f'[{name}]\ndiffuse = {diffuse}\nclass = "{kind}"\n')


main(*sys.argv[1:])
