#!/usr/bin/env python3
"""Three generated sites on which the accuracy of settings is measured.

    sites.py FOLDER           writes FOLDER/{canyon,town,balconies}/{scene.obj,materials.toml,receivers.csv}
    sites.py FOLDER --hard    writes those that are hard for what cells share: lit_wall, across, court, well, mirrors, snow, sphere, arcade

canyon     a street between two rows of plain houses, 24 receivers
town       49 houses with gable roofs on a plain, 96 receivers
balconies  two light facades with balconies and a deep court, 64 receivers
lit_wall   a long light wall of 10 m that faces south, receivers 0.5 to 50 m before it on the ground
across     a long street from south to north between walls of 15 m, receivers 5 cm to 5 m from its corner
court      a court of white walls, 20 m square and 25 m deep
well       a light well, 3 m square and 18 m deep
mirrors    a street between two mirrors of 20 m
snow       hills of snow, receivers on slopes
sphere     the inside of a sphere of 40 m that is open above 60 degrees from the zenith
arcade     a walk behind pillars beside a light square
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
        self.leaves = {}  # transmittance of leaves by material

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
            for name, (diffuse, kind, *specular) in self.materials.items():
                out.write(f'[{name}]\ndiffuse = {diffuse}\nclass = "{kind}"\n')
                out.writelines(f"specular = {share}\n" for share in specular)
            out.writelines(f"[{name}]\ntransmittance = {share}\n" for name, share in self.leaves.items())
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


def lit_wall():
    site = Site({"ground": (0.2, "ground"), "wall": (0.7, "obstruction")})
    site.face("ground", (-300, -300, 0), (300, -300, 0), (300, 300, 0), (-300, 300, 0))
    site.box("wall", "wall", (-150, 0, 0), (150, 8, 10))
    for i in range(32):
        site.receiver(f"r{i}", (-40 + 2.7 * i, -0.5 * 100 ** (i / 31), 0), (0, 0, 1))
    return site


def across():
    site = Site({"street": (0.2, "ground"), "wall": (0.5, "obstruction")})
    site.face("street", (-300, -300, 0), (300, -300, 0), (300, 300, 0), (-300, 300, 0))
    site.box("wall", "wall", (-30, -200, 0), (-5, 200, 15))
    site.box("wall", "wall", (5, -200, 0), (30, 200, 15))
    for i in range(24):
        off = 0.05 * 100 ** (i / 23)
        site.receiver(f"street_{i}", (-5 + off, -60 + 5.1 * i, 0), (0, 0, 1))
        site.receiver(f"wall_{i}", (-5, -60 + 5.1 * i, off), (1, 0, 0))
    return site


def yard(side, deep, albedo):
    """A hole between walls on a plain of roofs."""
    site = Site({"floor": (albedo, "ground"), "wall": (albedo, "obstruction"), "roof": (0.2, "obstruction")})
    half = side / 2
    site.face("floor", (-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0))
    for (low, high) in (((-60, -60), (60, -half)), ((-60, half), (60, 60)), ((-60, -half), (-half, half)), ((half, -half), (60, half))):
        site.box("wall", "roof", (*low, 0), (*high, deep))
    for i in range(24):
        at = (0.06 + 0.88 * (i * 0.754877666 % 1)) * side - half
        to = (0.06 + 0.88 * (i * 0.569840291 % 1)) * side - half
        site.receiver(f"floor_{i}", (at, to, 0), (0, 0, 1))
        up = deep * (0.02 + 0.96 * (i * 0.618033989 % 1))
        place, normal = (((at, -half, up), (0, 1, 0)), ((half, at, up), (-1, 0, 0)), ((at, half, up), (0, -1, 0)), ((-half, at, up), (1, 0, 0)))[i % 4]
        site.receiver(f"wall_{i}", place, normal)
    return site


def court():
    return yard(20, 25, 0.8)


def well():
    return yard(3, 18, 0.6)


def mirrors():
    site = Site({"street": (0.2, "ground"), "wall": (0.3, "obstruction"), "glass": (0.05, "obstruction", 0.6)})
    site.face("street", (-200, -200, 0), (200, -200, 0), (200, 200, 0), (-200, 200, 0))
    site.box("glass", "wall", (-40, 8, 0), (40, 20, 20))
    site.box("glass", "wall", (-40, -20, 0), (40, -8, 20))
    for i in range(24):
        site.receiver(f"street_{i}", (-36 + 3 * i, -7.5 + 15 * (i * 0.618 % 1), 0), (0, 0, 1))
        site.receiver(f"wall_{i}", (-36 + 3 * i, 8, 0.5 + 0.8 * i), (0, -1, 0))
    return site


def snow():
    site = Site({"snow": (0.75, "ground")})
    height = lambda x, y: 25 * math.sin(x / 37) * math.cos(y / 29) + 9 * math.sin(x / 11 + y / 13)
    step, count = 5, 80
    low = -step * count / 2
    at = lambda i, j: (low + step * i, low + step * j, height(low + step * i, low + step * j))
    for i in range(count):
        for j in range(count):
            site.face("snow", at(i, j), at(i + 1, j), at(i + 1, j + 1))
            site.face("snow", at(i, j), at(i + 1, j + 1), at(i, j + 1))
    for k in range(48):
        i, j = int(20 + 40 * (k * 0.754877666 % 1)), int(20 + 40 * (k * 0.569840291 % 1))
        (x0, y0, z0), (x1, y1, z1), (x2, y2, z2) = at(i, j), at(i + 1, j), at(i + 1, j + 1)
        a, b = (x1 - x0, y1 - y0, z1 - z0), (x2 - x0, y2 - y0, z2 - z0)
        n = (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
        size = math.hypot(*n)
        site.receiver(f"r{k}", ((x0 + x1 + x2) / 3, (y0 + y1 + y2) / 3, (z0 + z1 + z2) / 3), tuple(v / size for v in n))
    return site


def sphere():
    site = Site({"inside": (0.8, "obstruction")})
    rings, sides = 24, 72
    polar = lambda ring: math.pi / 3 * (1 + 2 * ring / rings)
    at = lambda ring, side: (40 * math.sin(polar(ring)) * math.cos(math.tau * side / sides),
                             40 * math.sin(polar(ring)) * math.sin(math.tau * side / sides), 40 * math.cos(polar(ring)))
    for ring in range(rings):
        for side in range(sides):
            a, b, c, d = at(ring, side), at(ring + 1, side), at(ring + 1, side + 1), at(ring, side + 1)
            site.face("inside", a, b, d)
            if ring + 1 < rings:
                site.face("inside", b, c, d)
    for i in range(32):
        # Well within a face.
        ring, side = int(2 + (rings - 4) * (i * 0.754877666 % 1)), int(sides * (i * 0.569840291 % 1))
        a, b, d = at(ring, side), at(ring + 1, side), at(ring, side + 1)
        middle = tuple((x + y + z) / 3 for x, y, z in zip(a, b, d))
        u, v = tuple(y - x for x, y in zip(a, b)), tuple(z - x for x, z in zip(a, d))
        n = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
        size = math.hypot(*n) * (-1 if sum(x * y for x, y in zip(n, middle)) > 0 else 1)
        site.receiver(f"r{i}", middle, tuple(x / size for x in n))
    return site


def arcade():
    site = Site({"paving": (0.45, "ground"), "stone": (0.55, "obstruction"), "roof": (0.2, "obstruction")})
    site.face("paving", (-80, -80, 0), (80, -80, 0), (80, 80, 0), (-80, 80, 0))
    site.box("stone", "roof", (-40, 6, 0), (40, 18, 16))
    site.box("stone", "roof", (-40, 0, 4.5), (40, 6, 16))
    for i in range(21):
        site.box("stone", "stone", (-40 + 3.97 * i, 0, 0), (-39.4 + 3.97 * i, 0.6, 4.5))
    for i in range(24):
        x = -38 + 3.17 * i
        site.receiver(f"walk_{i}", (x, 0.8 + 5 * (i * 0.618033989 % 1), 0), (0, 0, 1))
        site.receiver(f"wall_{i}", (x, 6, 0.3 + 4 * (i * 0.754877666 % 1)), (0, -1, 0))
    return site


EASY = (canyon, town, balconies)
HARD = (lit_wall, across, court, well, mirrors, snow, sphere, arcade)

if __name__ == "__main__":
    for make in HARD if "--hard" in sys.argv else EASY:
        make().write(f"{sys.argv[1]}/{make.__name__}")
