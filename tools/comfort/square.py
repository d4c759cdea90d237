"""What many people cost. In: a number of people, the program, a folder to work in, weather. Out: CPU seconds, memory and size of the archive of a
square with so many people, and of a year of their hours."""
import math
import os
import resource
import shutil
import subprocess
import sys
from pathlib import Path

#: Edge of the square, and of the ground around it, metres.
SQUARE, GROUND = 400, 600


def scene(path):
    """A square with a row of houses on each of its sides, 40 m long and 12 to 30 m high."""
    with open(path, "w") as file:
        half = GROUND / 2
        file.write(f"o ground\nusemtl ground\nv {-half} {-half} 0\nv {half} {-half} 0\nv {half} {half} 0\nv {-half} {half} 0\nf 1 2 3 4\nusemtl wall\n")
        first = 5
        for side in range(4):
            for place in range(9):
                along, across = -180 + 45 * place, SQUARE / 2 + 10
                x, y = [(along, across), (across, along), (along, -across), (-across, along)][side]
                wide, deep = [(40, 15), (15, 40)][side % 2]
                high = 12 + 2 * ((place * 5 + side * 3) % 10)
                file.write(f"o house_{side}_{place}\n")
                for z in (0, high):
                    for dx, dy in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
                        file.write(f"v {x + dx * wide / 2} {y + dy * deep / 2} {z}\n")
                a = first
                for face in ((4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)):
                    file.write("f " + " ".join(str(a + corner) for corner in face) + "\n")
                first += 8


def points(path, count):
    """A grid on the square."""
    side = math.isqrt(count)
    step = (SQUARE - 20) / side
    with open(path, "w") as file:
        file.write("point,x,y,z\n")
        for i in range(side * side):
            file.write(f"p{i},{-SQUARE / 2 + 10 + step * (i % side + 0.5):.3f},{-SQUARE / 2 + 10 + step * (i // side + 0.5):.3f},1.1\n")
    return side * side, step


def timed(arguments):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(arguments, check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, after.ru_maxrss / 1024


def main(count, program, out, weather):
    out = Path(out)
    out.mkdir(parents=True, exist_ok=True)
    scene(out / "square.obj")
    (out / "m.toml").write_text("[ground]\ndiffuse = 0.2\n[wall]\ndiffuse = 0.3\n")
    people, step = points(out / "points.csv", int(count))
    place = ["--latitude", "39.74", "--longitude", "-105.18", "-m", out / "m.toml", "--points", out / "points.csv", "--folder", out / "people"]
    asked = [program, "comfort", out / "square.obj", *place, "--quality", "draft", "--replace", "-w", weather]
    # An archive of the same people would be taken again.
    shutil.rmtree(out / "people", ignore_errors=True)
    # A day of the weather: nearly all of the time is the build's.
    build_s, build_mb = timed([*asked, "--from", "07-01", "--to", "07-01", "--every", "day", "-o", out / "day.csv"])
    year_s, year_mb = timed([program, "comfort", out / "people" / "site.helio", "-w", weather, "--every", "year", "-o", out / "year.csv"])
    size = os.path.getsize(out / "people" / "site.helio")
    print(f"{people} people {step:.2f} m apart: archive {build_s:.0f} CPU s, {build_mb:.0f} MB of memory, {size / 1e6:.0f} MB "
          f"({size / people:.0f} B a person); a year of hours {year_s:.0f} CPU s, {year_mb:.0f} MB")


if __name__ == "__main__":
    main(*sys.argv[1:5])
