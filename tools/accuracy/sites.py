#!/usr/bin/env python3
"""Three generated sites on which the accuracy of settings is measured.

    sites.py FOLDER    writes FOLDER/{canyon,town,balconies}/{scene.obj,materials.toml,receivers.csv}

canyon     a street between two rows of plain houses, 24 receivers
town       49 houses with gable roofs on a plain, 96 receivers
balconies  two light facades with balconies and a deep court, 64 receivers
"""
import math
import os
import random
import sys

LIFT_M = 0.02


class Site:
    """Faces and receivers, written as the three files of a site."""

    def __init__(self, materials):
        self.materials, self.lines, self.receivers, self.vertices = materials, [], [], 0

    def face(self, material, *corners):
        self.lines.append(f"usemtl {material}")
        self.lines += ["v %.4f %.4f %.4f" % corner for corner in corners]
        self.lines.append("f " + " ".join(str(self.vertices + i + 1) for i in range(len(corners))))
        self.vertices += len(corners)

    def box(self, wall, roof, low, high):
        (x0, y0, z0), (x1, y1, z1) = low, high
        self.face(wall, (x0, y0, z0), (x1, y0, z0), (x1, y0, z1), (x0, y0, z1))
        self.face(wall, (x1, y0, z0), (x1, y1, z0), (x1, y1, z1), (x1, y0, z1))
        self.face(wall, (x1, y1, z0), (x0, y1, z0), (x0, y1, z1), (x1, y1, z1))
        self.face(wall, (x0, y1, z0), (x0, y0, z0), (x0, y0, z1), (x0, y1, z1))
        self.face(roof, (x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1))
        if z0 > 0:
            self.face(wall, (x0, y0, z0), (x0, y1, z0), (x1, y1, z0), (x1, y0, z0))

    def receiver(self, name, at, normal):
        at = [a + LIFT_M * n for a, n in zip(at, normal)]
        self.receivers.append("%s,%.4f,%.4f,%.4f,%.6f,%.6f,%.6f" % (name, *at, *normal))

    def write(self, folder):
        os.makedirs(folder, exist_ok=True)
        with open(f"{folder}/scene.obj", "w") as out:
            out.write("\n".join(self.lines) + "\n")
        with open(f"{folder}/materials.toml", "w") as out:
            for name, (diffuse, kind) in self.materials.items():
                out.write(f'[{name}]\ndiffuse = {diffuse}\nclass = "{kind}"\n')
        with open(f"{folder}/receivers.csv", "w") as out:
            out.write("receiver,x,y,z,nx,ny,nz\n" + "\n".join(self.receivers) + "\n")


def canyon():
    site = Site({"street": (0.2, "ground"), "wall": (0.35, "obstruction"), "roof": (0.2, "obstruction")})
    site.face("street", (-60, -60, 0), (60, -60, 0), (60, 60, 0), (-60, 60, 0))
    site.box("wall", "roof", (-18, -40, 0), (-7, 12, 14))
    site.box("wall", "roof", (-18, 16, 0), (-7, 40, 9))
    site.box("wall", "roof", (7, -40, 0), (18, 40, 17))
    for i in range(8):
        y = -30 + 8.4 * i
        site.receiver(f"pavement_{i}", (-5 + 1.4 * i, y, 0), (0, 0, 1))
        site.receiver(f"east_{i}", (7, y, 2 + 1.8 * i), (-1, 0, 0))
        site.receiver(f"west_{i}", (-7, -36 + 6.2 * i, 1.5 + 1.5 * i), (1, 0, 0))
    return site


def gable(site, x, y, w, d, eaves, ridge):
    """A house with its ridge along x."""
    middle = y + d / 2
    for a, b in (((x, y), (x + w, y)), ((x + w, y + d), (x, y + d))):
        site.face("wall", (*a, 0), (*b, 0), (*b, eaves), (*a, eaves))
    for a, b, at in (((x + w, y), (x + w, y + d), x + w), ((x, y + d), (x, y), x)):
        site.face("wall", (*a, 0), (*b, 0), (*b, eaves), (at, middle, ridge), (*a, eaves))
    site.face("tiles", (x, y, eaves), (x + w, y, eaves), (x + w, middle, ridge), (x, middle, ridge))
    site.face("tiles", (x + w, y + d, eaves), (x, y + d, eaves), (x, middle, ridge), (x + w, middle, ridge))


def town():
    random.seed(7)
    site = Site({"grass": (0.2, "ground"), "wall": (0.4, "obstruction"), "tiles": (0.25, "obstruction")})
    site.face("grass", (-100, -100, 0), (220, -100, 0), (220, 220, 0), (-100, 220, 0))
    count = 0
    for row in range(7):
        for column in range(7):
            x, y = 17 * column + 3 * random.random(), 19 * row + 4 * random.random()
            w, d, eaves = 8 + 5 * random.random(), 8 + 3 * random.random(), 3 + 9 * random.random() ** 2
            ridge = eaves + 2 + 2 * random.random()
            gable(site, x, y, w, d, eaves, ridge)
            s, t = 0.1 + 0.8 * random.random(), 0.1 + 0.8 * random.random()
            rise, run = ridge - eaves, d / 2
            length = math.hypot(rise, run)
            roof = ((x + s * w, y + t * run, eaves + t * rise), (0, -rise / length, run / length))
            walls = [((x + s * w, y, t * eaves), (0, -1, 0)), ((x + w, y + s * d, t * eaves), (1, 0, 0)),
                     ((x, y + s * d, t * eaves), (-1, 0, 0))]
            for at, normal in (roof, walls[count % 3]):
                if count < 96:
                    site.receiver(f"r{count}", at, normal)
                    count += 1
    return site


def balconies():
    site = Site({"yard": (0.25, "ground"), "facade": (0.6, "obstruction"), "slab": (0.45, "obstruction"), "roof": (0.15, "obstruction")})
    site.face("yard", (-70, -70, 0), (70, -70, 0), (70, 70, 0), (-70, 70, 0))
    site.box("facade", "roof", (-25, 8, 0), (25, 20, 19))
    site.box("facade", "roof", (-25, -20, 0), (-4, -8, 13))
    site.box("facade", "roof", (-25, -8, 0), (-16, 8, 13))
    site.box("facade", "roof", (4, -20, 0), (25, -8, 22))
    for storey in range(1, 6):
        for i in range(6):
            x = -22 + 8 * i
            site.box("slab", "slab", (x, 6.4, 3.0 * storey), (x + 3.6, 8, 3.0 * storey + 0.16))
            site.box("slab", "slab", (x, 6.4, 3.0 * storey + 0.16), (x + 3.6, 6.46, 3.0 * storey + 1.1))
    count = 0
    for storey in range(6):
        for i in range(6):
            x = -22.5 + 8.1 * i + 0.37 * storey
            site.receiver(f"south_{storey}_{i}", (x, 8, 3.0 * storey + 1.4), (0, -1, 0))
            count += 1
    for i in range(12):
        site.receiver(f"court_{i}", (-15 + 3.3 * i, -6.5 + 1.1 * i, 0), (0, 0, 1))
        site.receiver(f"west_{i}", (-16, -7.2 + 1.2 * i, 0.8 + i), (1, 0, 0))
    for i in range(4):
        site.receiver(f"roof_{i}", (-20 + 11 * i, 15, 19), (0, 0, 1))
    return site


if __name__ == "__main__":
    for make in (canyon, town, balconies):
        make().write(f"{sys.argv[1]}/{make.__name__}")
