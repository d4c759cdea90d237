"""Writes the models of tools/screenshots into a folder: a mirror tower and houses at a lake, and a house with a gable roof in a snowy basin
(heights of tests/data/terrain/lakes_basin.tif are given here; the raster itself is read by heliotile)."""
import pathlib
import sys


class Obj:
    def __init__(self):
        self.lines, self.count = [], 0

    def face(self, material, *corners):
        self.lines.append(f"usemtl {material}")
        self.lines += [f"v {x:g} {y:g} {z:g}" for x, y, z in corners]
        self.lines.append("f " + " ".join(str(self.count + 1 + i) for i in range(len(corners))))
        self.count += len(corners)

    def box(self, name, low, high, wall, roof):
        (a, b, c), (x, y, z) = low, high
        self.lines.append(f"o {name}")
        self.face(wall, (a, b, c), (x, b, c), (x, b, z), (a, b, z))
        self.face(wall, (x, b, c), (x, y, c), (x, y, z), (x, b, z))
        self.face(wall, (x, y, c), (a, y, c), (a, y, z), (x, y, z))
        self.face(wall, (a, y, c), (a, b, c), (a, b, z), (a, y, z))
        self.face(roof, (a, b, z), (x, b, z), (x, y, z), (a, y, z))

    def write(self, path):
        path.write_text("\n".join(self.lines) + "\n")


def lake(folder):
    site = Obj()
    site.face("lake", (-120, -150, 0), (120, -150, 0), (120, -25, 0), (-120, -25, 0))
    site.face("promenade", (-120, -25, 0), (120, -25, 0), (120, 90, 0), (-120, 90, 0))
    site.box("tower", (-12, 45, 0), (12, 65, 60), "tower", "roof")
    for i, x in enumerate((-70, -42, -14, 14, 42)):
        site.box(f"house_{i + 1}", (x, -8, 0), (x + 22, 6, 9 + 3 * (i % 2)), "wall", "roof")
    site.write(folder / "lake.obj")
    (folder / "lake.toml").write_text(
        '[lake]\ndiffuse = 0.03\nglass = "single"\nclass = "ground"\n\n[promenade]\ndiffuse = 0.25\nclass = "ground"\n\n'
        '[tower]\ndiffuse = 0.02\nglass = "double"\n\n[wall]\ndiffuse = 0.5\n\n[roof]\ndiffuse = 0.15\n')


def alps(folder, terrain):
    site = Obj()
    # Heights around the house are 2,433 m within a metre.
    x, y, z = 325_200.0, 4_165_550.0, 2_431.0
    a, b, c, d, e, f = x - 7, y - 5, z, x + 7, y + 5, z + 6.5
    ridge = z + 10.5
    site.lines.append("o house")
    site.face("wall", (a, b, c), (d, b, c), (d, b, f), (a, b, f))
    site.face("wall", (d, e, c), (a, e, c), (a, e, f), (d, e, f))
    site.face("wall", (d, b, c), (d, e, c), (d, e, f), (d, y, ridge), (d, b, f))
    site.face("wall", (a, e, c), (a, b, c), (a, b, f), (a, y, ridge), (a, e, f))
    site.face("roof", (a, b, f), (d, b, f), (d, y, ridge), (a, y, ridge))
    site.face("roof", (d, e, f), (a, e, f), (a, y, ridge), (d, y, ridge))
    site.write(folder / "house.obj")
    (folder / "alps.toml").write_text(
        '[terrain]\ndiffuse = 0.7\nclass = "ground"\ngroup = "snow"\n\n[wall]\ndiffuse = 0.4\n\n[roof]\ndiffuse = 0.2\n')
    (folder / "site.toml").write_text(f'[[scene]]\nfile = "house.obj"\n\n[[scene]]\nfile = "{terrain}"\n')


if __name__ == "__main__":
    folder = pathlib.Path(sys.argv[1])
    for name in ("lake", "alps"):
        (folder / name).mkdir(parents=True, exist_ok=True)
    lake(folder / "lake")
    alps(folder / "alps", pathlib.Path("tests/data/terrain/lakes_basin.tif").resolve())
