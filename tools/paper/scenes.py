"""Writes the scenes of the paper's pictures as OBJ, materials and receivers (see tools/paper/run).

In: a folder. Out: in it street, mountain, facade, lake and towers: NAME.obj, NAME.toml, NAME.csv. Everything is generated: no data of others.
"""

import math
import pathlib
import sys

MATERIALS = {
    "ground": "diffuse = 0.2\nclass = \"ground\"",
    "meadow": "diffuse = 0.22\nclass = \"ground\"",
    "rock": "diffuse = 0.3\nclass = \"ground\"",
    "wall": "diffuse = 0.4",
    "roof": "diffuse = 0.25",
    "concrete": "diffuse = 0.35",
    "mirror": "diffuse = 0.05\nspecular = 0.6",
    "glass": "diffuse = 0.05\nglass = \"double\"",
    "water": "diffuse = 0.06\nspecular = 0.12\nclass = \"ground\"",
}


class Scene:
    def __init__(self):
        self.vertices, self.faces = [], []

    def face(self, material, *corners):
        first = len(self.vertices) + 1
        self.vertices.extend(corners)
        self.faces.append((material, range(first, first + len(corners))))

    def block(self, x, y, width, depth, height, materials, foot=0.0):
        """A box; materials of its south, east, north and west walls and of its roof."""
        a, b, c, d = (x, y), (x + width, y), (x + width, y + depth), (x, y + depth)
        top = foot + height
        for (p, q), material in zip(((a, b), (b, c), (c, d), (d, a)), materials):
            self.face(material, (*p, foot), (*q, foot), (*q, top), (*p, top))
        self.face(materials[4], (*a, top), (*b, top), (*c, top), (*d, top))

    def facade(self, x, y, width, height, storeys, bays, solid, glazed, share=0.6):
        """A wall in the plane y that looks south, with a window in each bay of each storey."""
        high, wide = height / storeys, width / bays
        gap_x, gap_z = wide * (1 - share) / 2, high * (1 - share) / 2
        for storey in range(storeys):
            for bay in range(bays):
                x0, z0 = x + bay * wide, storey * high
                x1, z1, x2, z2 = x0 + gap_x, z0 + gap_z, x0 + wide - gap_x, z0 + high - gap_z
                at = lambda px, pz: (px, y, pz)
                self.face(glazed, at(x1, z1), at(x2, z1), at(x2, z2), at(x1, z2))
                x3, z3 = x0 + wide, z0 + high
                self.face(solid, at(x0, z0), at(x3, z0), at(x3, z1), at(x0, z1))
                self.face(solid, at(x0, z2), at(x3, z2), at(x3, z3), at(x0, z3))
                self.face(solid, at(x0, z1), at(x1, z1), at(x1, z2), at(x0, z2))
                self.face(solid, at(x2, z1), at(x3, z1), at(x3, z2), at(x2, z2))

    def write(self, folder, name, receivers):
        lines = [f"v {x:.4f} {y:.4f} {z:.4f}" for x, y, z in self.vertices]
        for material, corners in self.faces:
            lines += [f"usemtl {material}", "f " + " ".join(map(str, corners))]
        (folder / f"{name}.obj").write_text("\n".join(lines) + "\n")
        used = sorted({material for material, _ in self.faces})
        (folder / f"{name}.toml").write_text("\n\n".join(f"[{m}]\n{MATERIALS[m]}" for m in used) + "\n")
        rows = [",".join(map(str, row)) for row in receivers]
        (folder / f"{name}.csv").write_text("receiver,x,y,z,nx,ny,nz\n" + "\n".join(rows) + "\n")


def plane(scene, material, half):
    scene.face(material, (-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0))


def street(folder):
    """Two rows of houses with pitched roofs along a street of 12 m from west to east."""
    scene = Scene()
    plane(scene, "ground", 150)
    for side in (1, -1):
        for i in range(-9, 9):
            x, y, eaves, ridge = i * 8.0, side * 6.0, 8 + (i * 7 % 4), 3.0
            far = y + side * 10
            low, high = min(y, far), max(y, far)
            scene.block(x, low, 8, 10, eaves, ["wall"] * 4 + ["roof"])
            middle, top = (low + high) / 2, eaves + ridge
            scene.face("roof", (x, low, eaves), (x + 8, low, eaves), (x + 8, middle, top), (x, middle, top))
            scene.face("roof", (x + 8, high, eaves), (x, high, eaves), (x, middle, top), (x + 8, middle, top))
            for end in (x, x + 8):
                scene.face("wall", (end, low, eaves), (end, high, eaves), (end, middle, top))
    scene.write(folder, "street", [("street", 3, 0, 1.5, 0, 0, 1), ("window", 3, 5.9, 4.5, 0, -1, 0)])


def mountain(folder):
    """A valley between ridges, as a grid of 60 m."""
    scene, n, step = Scene(), 80, 60.0

    def height(i, j):
        x, y = (i - n / 2) * step, (j - n / 2) * step
        ridges = 700 * (1 - math.exp(-((y - 150) / 900) ** 2)) * (1 + 0.25 * math.sin(x / 450) + 0.15 * math.sin(y / 210 + x / 800))
        return ridges + 40 * math.sin(x / 170) * math.cos(y / 140)

    at = lambda i, j: ((i - n / 2) * step, (j - n / 2) * step, height(i, j))
    for i in range(n):
        for j in range(n):
            material = "rock" if height(i, j) > 450 else "meadow"
            scene.face(material, at(i, j), at(i + 1, j), at(i + 1, j + 1))
            scene.face(material, at(i, j), at(i + 1, j + 1), at(i, j + 1))
    x, y, z = at(42, 42)
    scene.write(folder, "mountain", [("valley", x, y, round(z + 5, 3), 0, 0, 1)])


def facade(folder):
    """A wall that looks north at a facade of mirror glass across a street."""
    scene = Scene()
    plane(scene, "ground", 120)
    scene.block(-20, -14, 40, 14, 15, ["wall"] * 4 + ["roof"])
    scene.facade(-30, 18, 60, 32, 8, 12, "concrete", "mirror", 0.8)
    scene.block(-30, 18.01, 60, 20, 32, ["concrete"] * 4 + ["roof"])
    scene.block(-64, 10, 24, 24, 12, ["wall"] * 4 + ["roof"])
    scene.write(folder, "facade", [("north wall", 2, 0.05, 6, 0, 1, 0)])


def lake(folder):
    """A house whose south wall looks over a lake to hills."""
    scene = Scene()
    scene.face("meadow", (-400, -15, 0), (400, -15, 0), (400, 300, 0), (-400, 300, 0))
    scene.face("water", (-400, -500, -0.2), (400, -500, -0.2), (400, -15, -0.2), (-400, -15, -0.2))
    scene.block(-8, 0, 16, 10, 7, ["wall"] * 4 + ["roof"])
    for i in range(-8, 8):
        a, b = i * 50.0, (i + 1) * 50.0
        ha, hb = 40 + 25 * math.sin(a / 90), 40 + 25 * math.sin(b / 90)
        scene.face("meadow", (a, -500, -0.2), (a, -650, ha), (b, -650, hb))
        scene.face("meadow", (a, -500, -0.2), (b, -650, hb), (b, -500, -0.2))
    scene.write(folder, "lake", [("south wall", 0, -0.05, 3.5, 0, -1, 0)])


def towers(folder):
    """Two towers of 417 m and lower blocks round a square, proportions as of the World Trade Center of 1973, half of the facades glazed."""
    scene = Scene()
    plane(scene, "ground", 900)
    for x, y in ((-70, 20), (40, -60)):
        scene.facade(x, y, 63, 417, 22, 7, "concrete", "glass", 0.7)
        scene.block(x, y + 0.01, 63, 63, 417, ["concrete"] * 4 + ["roof"])
    for x, y, width, depth, height in (
        (-170, 100, 60, 40, 36), (-170, -120, 50, 130, 36), (130, 60, 45, 80, 36), (-60, 130, 90, 40, 174),
        (-20, -190, 130, 45, 30), (-300, -60, 80, 160, 120), (230, -150, 90, 260, 160), (-160, -330, 300, 70, 95),
        (-150, 260, 320, 80, 130),
    ):
        scene.block(x, y, width, depth, height, ["wall"] * 4 + ["roof"])
    scene.write(folder, "towers", [("square", 10, -95, 1.5, 0, 0, 1), ("wall", -19.0, -144.9, 15, 0, 1, 0)])


if __name__ == "__main__":
    folder = pathlib.Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for write in (street, mountain, facade, lake, towers):
        write(folder)
