#!/usr/bin/env python3
"""What crowns of leaves cost: an avenue of 200 trees between houses, 20,000 receivers on its ground and walls, built with crowns as volumes of leaves,
as hulls whose faces scatter light, and as black hulls; prints rays, CPU seconds and bytes of the build, and CPU seconds of a year's sums.

    tools/trees/avenue.py [FOLDER]     scratch folder, default target/trees

Takes ten minutes on two cores, with the program built for release; HELIOTILE=PROGRAM takes another one.
"""
import os
import random
import re
import resource
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
PROGRAM = os.environ.get("HELIOTILE", ROOT / "target/release/heliotile")
WEATHER = ROOT / "tests/data/weather/golden_tmy3.epw"
PAIRS, STEP = 100, 10
LENGTH = PAIRS * STEP
SURFACES = '[wall]\ndiffuse = 0.3\n[roof]\ndiffuse = 0.2\n[lawn_ground]\ndiffuse = 0.2\nclass = "ground"\n'
CROWN = '["broadleaved crown"]\ngroup = "trees"\n'
CASES = {"volumes": CROWN + "leaf_area_density = 1\n", "faces that scatter": CROWN + "transmittance = 0.17\ndiffuse = 0.35\n",
         "black faces": CROWN + "transmittance = 0.17\n"}


def scene(folder):
    """Houses of 21 x 12 x 15 m on both sides of an avenue of 36 m, with trees of 12 m."""
    vertices, faces = [], []
    for i in range(LENGTH // 25):
        for low, high in ((-30, -18), (18, 30)):
            first = len(vertices)
            for z in (0, 15):
                vertices += [(25 * i + x, y, z) for x, y in ((2, low), (23, low), (23, high), (2, high))]
            sides = ((1, 2, 6, 5), (2, 3, 7, 6), (3, 4, 8, 7), (4, 1, 5, 8))
            faces += [("wall", [first + k for k in side]) for side in sides] + [("roof", [first + k for k in (5, 6, 7, 8)])]
    first = len(vertices)
    vertices += [(-100, -130, 0), (LENGTH + 100, -130, 0), (LENGTH + 100, 130, 0), (-100, 130, 0)]
    faces.append(("lawn_ground", [first + k for k in (1, 2, 3, 4)]))
    lines = ["v {} {} {}".format(*vertex) for vertex in vertices]
    lines += ["usemtl {}\nf {}".format(name, " ".join(map(str, corners))) for name, corners in faces]
    (folder / "street.obj").write_text("\n".join(lines) + "\n")
    trees = [f"{5 + STEP * i},{y},12,8" for i in range(PAIRS) for y in (-8, 8)]
    (folder / "trees.csv").write_text("x,y,height,diameter_crown\n" + "\n".join(trees) + "\n")
    draw = random.Random(1)
    rows = ["receiver,x,y,z,nx,ny,nz"]
    for k in range(10_000):
        rows.append(f"ground {k},{draw.uniform(0, LENGTH):.3f},{draw.uniform(-17, 17):.3f},0.02,0,0,1")
        side, x = draw.choice((-1, 1)), 25 * draw.randrange(LENGTH // 25) + draw.uniform(2.2, 22.8)
        rows.append(f"wall {k},{x:.3f},{17.99 * side:.3f},{draw.uniform(0.3, 14.7):.3f},0,{-side},0")
    (folder / "receivers.csv").write_text("\n".join(rows) + "\n")


def run(folder, *arguments):
    """Returns what the program prints, and its CPU seconds."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = subprocess.run([PROGRAM, *arguments], cwd=folder, check=True, capture_output=True, text=True)
    return done.stdout, resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def main():
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "target/trees"
    folder.mkdir(parents=True, exist_ok=True)
    scene(folder)
    print("| crowns | rays, millions | build, CPU s | bytes a receiver | a year's sums, CPU s |\n| --- | --- | --- | --- | --- |")
    for name, crown in CASES.items():
        (folder / "materials.toml").write_text(SURFACES + crown)
        (folder / "avenue.helio").unlink(missing_ok=True)
        said, build = run(folder, "build", "street.obj", "trees.csv", "-m", "materials.toml", "-r", "receivers.csv", "-o", "avenue.helio", "--no-scene", "-v")
        rays, size = re.search(r"([\d.]+) Mray", said)[1], re.search(r"(\d+) bytes a receiver", said)[1]
        _, replay = run(folder, "replay", "avenue.helio", "--weather", str(WEATHER), "--every", "total", "-o", "sums.csv")
        print(f"| {name} | {float(rays):.0f} | {build:.0f} | {size} | {replay:.0f} |", flush=True)


if __name__ == "__main__":
    main()
