#!/usr/bin/env python3
"""A generated city: 2,500 buildings on a plain of 1.7 x 1.7 km, and receivers on their walls and roofs.

    site.py FOLDER RECEIVERS    writes FOLDER/city.obj, city.toml and receivers.csv
"""
import random
import sys

BUILDINGS = 50
STREET_M = 30.0


def facet(obj, at, a, b, cells):
    """A parallelogram cut into cells x cells quads."""
    for i in range(cells):
        for j in range(cells):
            corner = lambda s, t: [at[k] + a[k] * (i + s) / cells + b[k] * (j + t) / cells for k in range(3)]
            for s, t in ((0, 0), (1, 0), (1, 1), (0, 1)):
                obj.write("v %.4f %.4f %.4f\n" % tuple(corner(s, t)))
            obj.write("f -4 -3 -2 -1\n")


def main(folder, receivers):
    random.seed(2)
    per_facet = max(1, round(receivers / (BUILDINGS**2 * 5)))
    columns = max(1, round(per_facet**0.5))
    written = 0
    with open(f"{folder}/city.obj", "w") as obj, open(f"{folder}/receivers.csv", "w") as csv:
        csv.write("receiver,x,y,z,nx,ny,nz\n")
        obj.write("usemtl ground\n")
        facet(obj, (-100, -100, 0), (1700, 0, 0), (0, 1700, 0), 30)
        for number in range(BUILDINGS**2):
            x, y = number % BUILDINGS * STREET_M, number // BUILDINGS * STREET_M
            w, d, h = 10 + 12 * random.random(), 10 + 12 * random.random(), 6 + 30 * random.random() ** 2
            walls = [((x, y, 0), (w, 0, 0), (0, -1, 0)), ((x + w, y, 0), (0, d, 0), (1, 0, 0)),
                     ((x + w, y + d, 0), (-w, 0, 0), (0, 1, 0)), ((x, y + d, 0), (0, -d, 0), (-1, 0, 0))]
            facets = [("wall", at, a, (0, 0, h), n) for at, a, n in walls]
            facets.append(("roof", (x, y, h), (w, 0, 0), (0, d, 0), (0, 0, 1)))
            for side, (material, at, a, b, n) in enumerate(facets):
                obj.write(f"usemtl {material}\n")
                facet(obj, at, a, b, 3 + number % 2)
                rows = -(-per_facet // columns)
                for k in range(per_facet):
                    if written == receivers:
                        break
                    s, t = (k % columns + 0.5) / columns, (k // columns + 0.5) / rows
                    p = [at[i] + a[i] * s + b[i] * t + n[i] * 0.02 for i in range(3)]
                    csv.write("b%d_%d_%d,%.3f,%.3f,%.3f,%d,%d,%d\n" % (number, side, k, *p, *n))
                    written += 1
    with open(f"{folder}/city.toml", "w") as toml:
        toml.write('[ground]\ndiffuse = 0.2\nclass = "ground"\n[wall]\ndiffuse = 0.4\n[roof]\ndiffuse = 0.2\n')
    print(f"{written} receivers")


main(sys.argv[1], int(sys.argv[2]))
