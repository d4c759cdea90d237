"""Scenes. In: a name and a folder (or a site's folder). Out: a `Scene`: OBJ, materials and receivers for heliotile and the
same polygons, materials and points for Radiance, written into a work folder."""
import csv
import hashlib
import math
import tomllib
from dataclasses import dataclass
from pathlib import Path

LIFT_M = 0.002  # rtrace does not lift its points off the surface that they lie on; heliotile does
STREET_DEG = 23.0  # the generated streets run this far clockwise from west-east, so that no wall is parallel to a texture


@dataclass
class Scene:
    """One scene on disk; `points` [receiver][x, y, z, nx, ny, nz] in metres, in the order of `ids`."""
    name: str
    obj: Path
    materials: Path
    receivers: Path
    rad: Path
    ids: list
    points: list

    def digest(self):
        """Names the scene's contents: geometry, materials and points as Radiance gets them."""
        return hashlib.sha256(self.rad.read_bytes() + repr(self.points).encode()).hexdigest()


def load(name, obj, materials, receivers, work):
    """A scene from the three files of `heliotile build`; writes `scene.rad` into `work`."""
    with open(receivers, newline="") as file:
        rows = list(csv.DictReader(file))
    points = []
    for row in rows:
        place = [float(row[k]) for k in ("x", "y", "z")]
        normal = [float(row[k]) for k in ("nx", "ny", "nz")]
        length = math.hypot(*normal)
        normal = [n / length for n in normal]
        points.append([p + LIFT_M * n for p, n in zip(place, normal)] + normal)
    rad = work / "scene.rad"
    rad.write_text(radiance_text(obj, tomllib.loads(Path(materials).read_text())))
    return Scene(name, obj, materials, receivers, rad, [row["receiver"] for row in rows], points)


def radiance_text(obj, materials):
    """Polygons of an OBJ file for Radiance: `plastic` without gloss (both sides reflect), `mirror` where specular."""
    out = []
    for name, table in materials.items():
        diffuse, specular = table["diffuse"], table.get("specular", 0.0)
        if specular > 0.0 and diffuse > 0.0:
            raise SystemExit(f"{name}: Radiance has no mirror with a diffuse share")
        if specular > 0.0:
            out.append(f"void mirror {name}\n0\n0\n3 {specular} {specular} {specular}\n")
        else:
            out.append(f"void plastic {name}\n0\n0\n5 {diffuse} {diffuse} {diffuse} 0 0\n")
    vertices, material, count = [], None, 0
    for line in Path(obj).read_text().splitlines():
        words = line.split()
        if not words:
            continue
        if words[0] == "v":
            vertices.append(" ".join(words[1:4]))
        elif words[0] == "usemtl":
            material = words[1]
        elif words[0] == "f":
            corners = [vertices[int(word.split("/")[0]) - 1] for word in words[1:]]
            out.append(f"{material} polygon f{count}\n0\n0\n{3 * len(corners)}\n" + "\n".join(corners) + "\n")
            count += 1
    return "\n".join(out)


class Drawing:
    """Collects polygons and receivers of a generated street and writes the three files; x along the street, y across."""

    def __init__(self):
        self.vertices, self.lines, self.receivers = [], [], []

    @staticmethod
    def turned(x, y):
        c, s = math.cos(math.radians(STREET_DEG)), math.sin(math.radians(STREET_DEG))
        return x * c + y * s, -x * s + y * c

    def polygon(self, material, corners):
        first = len(self.vertices) + 1
        for x, y, z in corners:
            self.vertices.append((*self.turned(x, y), z))
        self.lines += [f"usemtl {material}", "f " + " ".join(str(first + i) for i in range(len(corners)))]

    def box(self, x0, x1, y0, y1, height, south="wall", north="wall"):
        """A house without floor: walls counter-clockwise seen from outside, and a flat roof."""
        ring = [(x0, y0, south), (x1, y0, "wall"), (x1, y1, north), (x0, y1, "wall")]
        for (xa, ya, material), (xb, yb, _) in zip(ring, ring[1:] + ring[:1]):
            self.polygon(material, [(xa, ya, 0), (xb, yb, 0), (xb, yb, height), (xa, ya, height)])
        self.polygon("roof", [(x0, y0, height), (x1, y0, height), (x1, y1, height), (x0, y1, height)])

    def receiver(self, x, y, z, normal):
        """1 cm off the surface, along the normal."""
        n = (*self.turned(normal[0], normal[1]), normal[2])
        place = (*self.turned(x, y), z)
        self.receivers.append([p + 0.01 * k for p, k in zip(place, n)] + list(n))

    def write(self, name, materials, work):
        obj, toml, points = work / "scene.obj", work / "materials.toml", work / "receivers.csv"
        obj.write_text("".join("v %.6f %.6f %.6f\n" % v for v in self.vertices) + "\n".join(self.lines) + "\n")
        toml.write_text("".join(f"[{n}]\n" + "".join(f"{k} = {v}\n" for k, v in t.items()) for n, t in materials.items()))
        rows = [f"r{i:02}," + ",".join(f"{v:.6f}" for v in r) for i, r in enumerate(self.receivers)]
        points.write_text("receiver,x,y,z,nx,ny,nz\n" + "\n".join(rows) + "\n")
        return load(name, obj, toml, points, work)


SOUTH, NORTH, UP = (0, -1, 0), (0, 1, 0), (0, 0, 1)


def canyon(work):
    """A street 12 m wide between rows of houses of 15 m and 9 m: 11 polygons, 24 receivers."""
    d = Drawing()
    d.polygon("street", [(-60, -40, 0), (60, -40, 0), (60, 40, 0), (-60, 40, 0)])
    d.box(-30, 30, 6, 18, 15)
    d.box(-30, 30, -16, -6, 9)
    for x in (-21.3, -6.1, 4.7, 19.2):
        for z in (2.1, 11.3):
            d.receiver(x, 6, z, SOUTH)
        for z in (2.1, 6.4):
            d.receiver(x, -6, z, NORTH)
    for x, y in ((-18.3, -4.6), (-7.7, 0.4), (3.1, 4.7), (12.9, -1.3), (24.1, 2.2)):
        d.receiver(x, y, 0, UP)
    for x, y in ((-15.3, -8.1), (2.7, -11.2), (18.4, -14.3)):
        d.receiver(x, y, 9, UP)
    materials = {"street": {"diffuse": 0.2, "class": '"ground"'}, "wall": {"diffuse": 0.4}, "roof": {"diffuse": 0.3}}
    return d.write("canyon", materials, work)


def mirror(work):
    """A mirror facade (0.8) across a street from a diffuse house, another house beside it: 16 polygons, 24 receivers."""
    d = Drawing()
    d.polygon("street", [(-60, -45, 0), (60, -45, 0), (60, 45, 0), (-60, 45, 0)])
    d.box(-20, 16, 8, 20, 18, south="facade")
    d.box(-24, 24, -18, -8, 10)
    d.box(24, 34, 4, 20, 12)
    for x in (-16.2, -8.9, 1.3, 9.6, 18.7):
        for z in (2.2, 7.1):
            d.receiver(x, -8, z, NORTH)
    for i, x in enumerate((-18.8, -11.1, -3.4, 4.2, 11.7, 19.3, 27.9)):
        d.receiver(x, (-6.3, 1.2, 5.4)[i % 3], 0, UP)
    for x in (-13.1, 1.9, 14.6):
        d.receiver(x, -11.3, 10, UP)
    for x, z in ((26.2, 2.4), (29.3, 6.7), (31.8, 10.1)):
        d.receiver(x, 4, z, SOUTH)
    d.receiver(24, 11.8, 5.6, (-1, 0, 0))
    materials = {"street": {"diffuse": 0.2, "class": '"ground"'}, "wall": {"diffuse": 0.4}, "roof": {"diffuse": 0.3},
                 "facade": {"diffuse": 0.0, "specular": 0.8}}
    return d.write("mirror", materials, work)


def site(folder, work):
    """A folder with scene.obj, materials.toml and receivers.csv."""
    folder = Path(folder).resolve()
    return load(folder.name, folder / "scene.obj", folder / "materials.toml", folder / "receivers.csv", work)
