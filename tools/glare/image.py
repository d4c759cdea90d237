"""The sun that panes throw at points by one reflection: a pane is a window on the mirrored sun. Every ten seconds of a year, with pvlib's sun.

    image.py write SCENE FOLDER                         site.obj, site.toml and receivers.csv
    image.py compare SCENE FOLDER latitude longitude    bits.csv and rays.csv, tables of `glare --spells`, beside the image method
"""

import csv
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pvlib

STEP_S = 10
# A rectangle: a corner and two edges.
Rectangle = tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]]


def upright(x: float, y: float, z: float, width: float, height: float) -> Rectangle:
    return (x, y, z), (width, 0.0, 0.0), (0.0, 0.0, height)


# Panes, walls, receivers with their normals.
SCENES = {
    "pane": (
        {"pane": upright(-4.0, 18.0, 3.0, 3.0, 4.0), "other": upright(0.5, 18.0, 3.0, 3.0, 4.0)},
        [upright(-30.0, 18.02, 0.0, 60.0, 12.0), upright(-2.0, 9.0, 0.0, 3.0, 3.5)],
        {"window": ((1.0, -6.0, 5.0), (0.0, 1.0, 0.0)), "garden": ((-6.0, 2.0, 1.5), (0.0, 0.0, 1.0))},
    ),
    "lake": (
        {"lake": ((-9000.0, -9000.0, 0.5), (18000.0, 0.0, 0.0), (0.0, 18000.0, 0.0))},
        [upright(-10.0, -12.0, 0.6, 20.0, 9.0)],
        {"front": ((2.0, 0.0, 5.0), (0.0, -1.0, 0.0)), "side": ((30.0, 3.0, 9.0), (0.6, -0.8, 0.0))},
    ),
    "book": (
        {"tower": upright(-10.0, 10.0, 0.0, 20.0, 15.0), "steel": ((14.0, -10.0, 0.0), (0.0, 14.0, 0.0), (0.0, 0.0, 8.0))},
        [],
        {"window": ((0.0, -5.0, 2.0), (0.0, 1.0, 0.0)), "pavement": ((0.0, 4.0, 0.01), (0.0, 0.0, 1.0))},
    ),
}


def write(scene: str, folder: Path) -> None:
    panes, walls, receivers = SCENES[scene]
    folder.mkdir(parents=True, exist_ok=True)
    ground = ((-20000.0, -20000.0, 0.0), (40000.0, 0.0, 0.0), (0.0, 40000.0, 0.0))
    lines = []
    for name, material, (corner, a, b) in [
        ("ground", "ground", ground),
        *(("walls", "wall", wall) for wall in walls),
        *((name, "pane", pane) for name, pane in panes.items()),
    ]:
        p, a, b = np.array(corner), np.array(a), np.array(b)
        lines += [f"o {name}", f"usemtl {material}", *("v {} {} {}".format(*at) for at in (p, p + a, p + a + b, p + b)), "f -4 -3 -2 -1"]
    (folder / "site.obj").write_text("\n".join(lines) + "\n", encoding="utf-8")
    materials = "[ground]\ndiffuse = 0.2\n[wall]\ndiffuse = 0.3\n[pane]\ndiffuse = 0.0\nspecular = 0.6\n"
    (folder / "site.toml").write_text(materials, encoding="utf-8")
    rows = ["receiver,x,y,z,nx,ny,nz", *(",".join(map(str, (name, *p, *n))) for name, (p, n) in receivers.items())]
    (folder / "receivers.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")


def distance(rectangle: Rectangle, origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """How far rays go until they meet a rectangle; infinite where they do not."""
    corner, a, b = (np.array(part) for part in rectangle)
    normal = np.cross(a, b)
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (normal @ (corner - origins).T) / (directions @ normal)
        at = origins + t[:, None] * directions - corner
    met = t > 1e-6
    for edge in (a, b):
        along = at @ edge
        met &= (along >= 0.0) & (along <= edge @ edge)
    return np.where(met, t, np.inf)


def thrown(pane: Rectangle, others: list[Rectangle], origin: np.ndarray, normal: np.ndarray, suns: np.ndarray) -> np.ndarray:
    """Whether a pane throws each sun at a point."""
    corner, a, b = (np.array(part) for part in pane)
    across = np.cross(a, b) / np.linalg.norm(np.cross(a, b))
    images = suns - 2.0 * (suns @ across)[:, None] * across
    origins = np.broadcast_to(origin, suns.shape)
    t = distance(pane, origins, images)
    lit = np.isfinite(t) & (suns[:, 2] > 0.0) & (images @ normal > 0.0)
    lit &= (suns @ across) * (across @ (origin - corner)) > 0.0
    points = origin + np.where(lit, t, 0.0)[:, None] * images
    for other in others:
        lit &= (distance(other, origins, images) >= t) & ~np.isfinite(distance(other, points, suns))
    return lit


def compare(scene: str, folder: Path, latitude: float, longitude: float) -> None:
    panes, walls, receivers = SCENES[scene]
    start = pd.Timestamp("2017-01-01 00:00", tz="Etc/GMT-1")
    times = pd.date_range(start, periods=365 * 86_400 // STEP_S, freq=f"{STEP_S}s")
    position = pvlib.solarposition.get_solarposition(times, latitude, longitude, method="nrel_numpy")
    azimuth, altitude = np.radians(position["azimuth"].to_numpy()), np.radians(position["elevation"].to_numpy())
    level = np.cos(altitude)
    suns = np.stack([level * np.sin(azimuth), level * np.cos(azimuth), np.sin(altitude)], axis=1)
    a_day = 86_400 // STEP_S
    for table in ("bits", "rays"):
        with open(folder / f"{table}.csv", encoding="utf-8", newline="") as file:
            found = [row for row in csv.DictReader(file) if row["mirrors"] == "1"]
        errors, minutes, missed, wrong, spells = [], [0.0, 0.0], 0, 0, 0
        for name, (place, normal) in receivers.items():
            for pane in panes:
                others = [other for other_name, other in panes.items() if other_name != pane] + walls
                lit = thrown(panes[pane], others, np.array(place), np.array(normal), suns).reshape(365, a_day)
                own: dict[int, list[tuple[float, float]]] = {}
                for row in found:
                    if row["receiver"] == name and row["pane"] == pane:
                        day = pd.Timestamp(f"2017-{row['date']}").day_of_year - 1
                        ends = (pd.Timedelta(row[end]).total_seconds() / 60.0 for end in ("start", "end"))
                        own.setdefault(day, []).append(tuple(ends))
                minutes[0] += sum(end - start for day in own.values() for start, end in day)
                minutes[1] += float(lit.sum()) * STEP_S / 60.0
                for day in range(365):
                    edges = np.flatnonzero(np.diff(np.concatenate([[0], lit[day].astype(int), [0]])))
                    for first, last in edges.reshape(-1, 2):
                        # Between the last look without and the first with.
                        start_min, end_min = (first - 0.5) * STEP_S / 60.0, (last - 0.5) * STEP_S / 60.0
                        if end_min - start_min < 1.0:
                            continue
                        spells += 1
                        near = [one for one in own.get(day, []) if one[0] < end_min + 1.0 and one[1] > start_min - 1.0]
                        if not near:
                            missed += 1
                            continue
                        errors += [min(abs(one[0] - start_min) for one in near), min(abs(one[1] - end_min) for one in near)]
                wrong += sum(not lit[day, max(0, int((s - 1.0) * 6)) : int((e + 1.0) * 6) + 1].any() for day, own_day in own.items() for s, e in own_day)
        off = np.array(errors)
        print(
            f"{scene}, {table}: {spells} spells of a minute or more; starts and ends within a minute {100 * (off <= 1.0).mean():.2f} %, "
            f"95 % within {np.quantile(off, 0.95):.2f} minutes, {off.max():.2f} at most; {missed} missed, {wrong} where that pane throws none; "
            f"minutes of the year {minutes[0]:.0f} of {minutes[1]:.0f}"
        )


if __name__ == "__main__":
    if sys.argv[1] == "write":
        write(sys.argv[2], Path(sys.argv[3]))
    else:
        compare(sys.argv[2], Path(sys.argv[3]), float(sys.argv[4]), float(sys.argv[5]))
