#!/usr/bin/env python3
"""Fig. 5 of the paper: the form factor of a wall of 10 m x 10 m straight ahead, with one ray
through each of n x n texels in three maps of the hemisphere, beside the closed form.

    tools/paper/wall.py [FOLDER] [--points N] [--rays N,...]

Prints the RMS error over distances of 1 to 50 m. Writes wall.csv into FOLDER, and wall.svg if
matplotlib is there.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path

WALL_M, RECEIVER_M = 10.0, 1.0
DISTANCES_M = range(1, 51)


def square_to_disc(u: float, v: float) -> tuple[float, float]:
    """Shirley and Chiu 1997: the point of the unit disc for one of the unit square."""
    a, b = 2 * u - 1, 2 * v - 1
    if a == 0 and b == 0:
        return 0.0, 0.0
    if abs(a) > abs(b):
        radius, angle = a, math.pi / 4 * b / a
    else:
        radius, angle = b, math.pi / 2 - math.pi / 4 * a / b
    return radius * math.cos(angle), radius * math.sin(angle)


def longitude_latitude(n: int) -> list[tuple[float, float, float, float]]:
    """Columns of equal longitude about the normal, rows of equal angle from it."""
    rays = []
    for row in range(n):
        low, middle, high = (math.pi / 2 * (row + step) / n for step in (0, 0.5, 1))
        weight = 2 / n * (math.cos(low) - math.cos(high)) * math.cos(middle)
        for column in range(n):
            longitude = 2 * math.pi * (column + 0.5) / n
            sine = math.sin(middle)
            rays.append((sine * math.cos(longitude), sine * math.sin(longitude), math.cos(middle), weight))
    return rays


def solid_angle(n: int) -> list[tuple[float, float, float, float]]:
    """Texels of equal solid angle: Shirley's and Chiu's map, lifted to the sphere."""
    rays = []
    for row in range(n):
        for column in range(n):
            x, y = square_to_disc((column + 0.5) / n, (row + 0.5) / n)
            z = 1 - x * x - y * y
            lift = math.sqrt(max(2 - x * x - y * y, 0))
            rays.append((x * lift, y * lift, z, 2 * z / (n * n)))
    return rays


def cosine(n: int) -> list[tuple[float, float, float, float]]:
    """Texels of equal solid angle times cosine (Nusselt): rays of equal weights."""
    rays = []
    for row in range(n):
        for column in range(n):
            x, y = square_to_disc((column + 0.5) / n, (row + 0.5) / n)
            rays.append((x, y, math.sqrt(max(1 - x * x - y * y, 0)), 1 / (n * n)))
    return rays


MAPS = {"longitude-latitude": longitude_latitude, "solid-angle": solid_angle, "cosine": cosine}


def traced(rays: list[tuple[float, float, float, float]], distance_m: float, at: tuple[float, float]) -> float:
    """The weights of the rays from (x, z) that meet the wall."""
    half, total = WALL_M / 2, 0.0
    for x, y, z, weight in rays:
        if z > 0 and abs(at[0] + x / z * distance_m) <= half and abs(at[1] + y / z * distance_m) <= half:
            total += weight
    return total


def analytic(distance_m: float, at: tuple[float, float]) -> float:
    """Differential element to parallel rectangle (Siegel and Howell): four corners."""

    def corner(x: float, y: float) -> float:
        p, q = math.hypot(1, x), math.hypot(1, y)
        return (x / p * math.atan(y / p) + y / q * math.atan(x / q)) / (2 * math.pi)

    sides = [(WALL_M / 2 + sign * at[axis]) / distance_m for axis in (0, 1) for sign in (1, -1)]
    return sum(corner(width, height) for width in sides[:2] for height in sides[2:])


def spread(count: int) -> list[tuple[float, float]]:
    """Points over the receiver by steps of the golden ratio; one alone is in its middle."""
    golden = (math.sqrt(5) - 1) / 2
    return [(((i + 0.5) / count - 0.5) * RECEIVER_M, ((0.5 + i * golden) % 1 - 0.5) * RECEIVER_M) for i in range(count)]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", type=Path)
    parser.add_argument("--points", type=int, default=1)
    parser.add_argument("--rays", default="256,1024,4096")
    args = parser.parse_args()
    points, numbers = spread(args.points), [int(number) for number in args.rays.split(",")]
    rows, errors = [], {}
    for name, mapping in MAPS.items():
        for number in numbers:
            rays, squares = mapping(math.isqrt(number)), 0.0
            for distance in DISTANCES_M:
                found, right = (
                    sum(values) / len(points)
                    for values in ([traced(rays, distance, at) for at in points], [analytic(distance, at) for at in points])
                )
                percent = 100 * (found / right - 1)
                squares += percent * percent
                rows.append((name, number, args.points, distance, found, right, percent))
            errors[name, number] = math.sqrt(squares / len(DISTANCES_M))
    print(f"RMS error of the form factor of a wall of 10 m x 10 m, percent, 50 distances from 1 to 50 m, {args.points} point{'s' * (args.points > 1)}:")
    print("rays   " + "".join(f"  {name:>18}" for name in MAPS))
    for number in numbers:
        print(f"{number:<7}" + "".join(f"  {errors[name, number]:>18.2f}" for name in MAPS))
    if args.folder:
        args.folder.mkdir(parents=True, exist_ok=True)
        head = "mapping,rays,points,distance_m,form_factor,analytic,error_percent\n"
        text = "".join(f"{a},{b},{c},{d},{e:.9f},{f:.9f},{g:.4f}\n" for a, b, c, d, e, f, g in rows)
        (args.folder / "wall.csv").write_text(head + text)
        draw(rows, numbers[len(numbers) // 2], args.folder / "wall.svg")


def draw(rows: list[tuple], number: int, path: Path) -> None:
    """Form factors against distance by each map, and the closed form."""
    try:
        import matplotlib.pyplot as plt
    except ImportError:
        print("wall.svg is left out: matplotlib is not there")
        return
    figure, axes = plt.subplots(figsize=(7.2, 4.4))
    for name in MAPS:
        of = [row for row in rows if row[0] == name and row[1] == number]
        axes.plot([row[3] for row in of], [row[4] for row in of], ".", label=name)
    axes.plot([row[3] for row in of], [row[5] for row in of], "k-", label="closed form")
    axes.set(xscale="log", yscale="log", xlabel="distance, m", ylabel="form factor", title=f"A wall of 10 m x 10 m, {number} rays")
    axes.legend()
    figure.savefig(path)


if __name__ == "__main__":
    main()
