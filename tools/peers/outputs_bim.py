"""City models, folders for Honeybee and tables of buildings, opened by others. In: a city model, weather. Out: a line a check; exit code 1
if one fails."""
import argparse
import csv
import json
import os
import random
import re
import shutil
import subprocess
import sys
import time
from collections import defaultdict
from pathlib import Path

import numpy as np
from honeybee_radiance_postprocess.results import AnnualIrradiance
from shapely import STRtree
from shapely.geometry import Polygon
from shapely.ops import unary_union

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = Path(os.environ.get("HELIOTILE", ROOT / "target/release/heliotile"))
WORK = ROOT / "target/peers/outputs_bim"
BIN = WORK / "cargo/bin"
THRESHOLD, LEAST_M2 = 900.0, 10.0
failures = 0


def check(what, good, detail=""):
    global failures
    failures += not good
    print(f"{'ok    ' if good else 'WRONG '} {what}{': ' if detail else ''}{detail}", flush=True)


def ours(*words):
    """Runs heliotile; gives seconds and its standard output."""
    begin = time.time()
    done = subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"heliotile {' '.join(map(str, words))}\n{done.stderr}")
    return time.time() - begin, done.stdout


def table(text):
    return list(csv.DictReader(text.splitlines()))


def strip(model):
    """Takes away what was added; objects that had no attributes have none again."""
    model.get("metadata", {}).pop("heliotile", None)
    materials = model.get("appearance", {}).get("materials", [])
    while materials and materials[-1]["name"].startswith("irradiation "):
        materials.pop()
    for item in model["CityObjects"].values():
        for key in [key for key in item.get("attributes", {}) if key.startswith("heliotile_")]:
            del item["attributes"][key]
        for shape in item.get("geometry", []):
            shape.get("material", {}).pop("irradiation", None)
            for surface in shape.get("semantics", {}).get("surfaces", []):
                for key in [key for key in surface if key.startswith("heliotile_")]:
                    del surface[key]
    return without_empty(model)


def without_empty(model):
    """Members that may hold nothing but additions go where they are empty, on both sides."""
    for item in model["CityObjects"].values():
        if item.get("attributes") == {}:
            del item["attributes"]
        for shape in item.get("geometry", []):
            if shape.get("material") == {}:
                del shape["material"]
    if model.get("appearance", {}).get("materials") == []:
        del model["appearance"]["materials"]
    for key in ("appearance", "metadata"):
        if model.get(key) == {}:
            del model[key]
    return model


def scene_hash(model, receivers):
    few = WORK / "few.csv"
    few.write_text("".join(receivers.read_text().splitlines(keepends=True)[:2]))
    ours("build", model, "-r", few, "--quality", "draft", "-o", WORK / "few.helio")
    return re.search(r"hash ([0-9a-f]{64})", ours("info", WORK / "few.helio")[1]).group(1)


def city_model(site, model, weather, receivers, year):
    out = WORK / "out.city.json"
    seconds, _ = ours("replay", site, "-w", weather, "--every", "month", "--model", model, "-o", out)
    print(f"       {out.name}: {seconds:.1f} s, {out.stat().st_size} bytes beside {model.stat().st_size}")
    known, found = json.loads(model.read_text()), json.loads(out.read_text())
    same = json.dumps(strip(json.loads(out.read_text()))) == json.dumps(without_empty(known))
    check("content is that of the input but for what was added, in its order", same)
    for file in (model, out):
        said = subprocess.run([BIN / "cjval", "-r", file], capture_output=True, text=True).stdout
        report = json.loads(said)
        check(f"cjval {report['cjval_version']} of {file.name}", report["valid"], f"valid {report['valid']}, warnings {report['has_warnings']}")
    said = subprocess.run([Path(sys.executable).parent / "cjio", out, "info"], capture_output=True, text=True)
    check("cjio reads it", said.returncode == 0 and "CityJSON version" in said.stdout)
    check("scene read again", scene_hash(out, receivers) == scene_hash(model, receivers), "the same hash of geometry")

    objects, surfaces = defaultdict(lambda: [0.0, 0.0]), defaultdict(lambda: [0.0, 0.0])
    themed = 0
    for row in table(receivers.read_text()):
        area, total = float(row["area_m2"]), year[row["receiver"]]
        numbers = [int(n) for n in re.findall(r"\d+", row["face"])]
        shape = found["CityObjects"][row["object"]]["geometry"][numbers[0]]
        value, theme = shape["semantics"]["values"], shape["material"]["irradiation"]["values"]
        for number in numbers[1:]:
            value, theme = value[number], theme[number]
        themed += found["appearance"]["materials"][theme]["name"].startswith("irradiation ")
        for sums, key in ((objects, row["object"]), (surfaces, (row["object"], numbers[0], value))):
            sums[key][0] += area
            sums[key][1] += area * total
        if row["building"] != row["object"]:
            objects[row["building"]][0] += area
            objects[row["building"]][1] += area * total
    check("colours", themed == len(year), f"{themed} receivers lie on a face with a material of the theme")
    worst = 0.0
    for name, (area, sum_kwh) in objects.items():
        own = found["CityObjects"][name]["attributes"]
        months = [own[key] for key in own if re.fullmatch(r"heliotile_total_kwh_m2_.*\d", key)]
        worst = max(worst, abs(own["heliotile_total_kwh_m2"] - sum_kwh / area), abs(sum(months) - sum_kwh / area))
    check("objects against receivers", worst < 0.02, f"{len(objects)} within {worst:.4f} kWh/m2, months too")
    worst = 0.0
    for (name, number, value), (area, sum_kwh) in surfaces.items():
        own = found["CityObjects"][name]["geometry"][number]["semantics"]["surfaces"][value]
        worst = max(worst, abs(own["heliotile_total_kwh_m2"] - sum_kwh / area))
    check("semantic surfaces against receivers", worst < 0.02, f"{len(surfaces)} within {worst:.4f} kWh/m2")


def honeybee(site, weather, year):
    folder = WORK / "honeybee"
    shutil.rmtree(folder, ignore_errors=True)
    seconds, _ = ours("replay", site, "-w", weather, "--honeybee", folder)
    size = sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())
    print(f"       honeybee: {seconds:.1f} s, {size} bytes")
    results = AnnualIrradiance(folder)
    cumulative, grids = results.cumulative_values()
    rows = table((folder / "receivers.csv").read_text())
    place = {grid["full_id"]: number for number, grid in enumerate(grids)}
    worst = max(abs(cumulative[place[row["grid"]]][int(row["row"])] - year[row["receiver"]]) for row in rows)
    # Hours of places that are nearly dark are not quite their year: what an hour lacks below 0 counts as 0.
    check("sums by Honeybee's reader", len(rows) == len(year) and worst < 0.5,
          f"{len(rows)} receivers in {len(grids)} grids, {len(results.sun_up_hours)} hours, within {worst:.4f} kWh/m2")
    sample = random.Random(1).sample(rows, min(20, len(rows)))
    few = WORK / "sample.csv"
    few.write_text("receiver\n" + "".join(f'"{row["receiver"]}"\n' for row in sample))
    _, text = ours("replay", site, "-w", weather, "-r", few, "--columns", "total,sun_direct")
    hours = defaultdict(list)
    for row in table(text):
        hours[row["receiver"]].append((float(row["total"]), float(row["sun_direct"])))
    worst, count = 0.0, 0
    for row in sample:
        info = grids[place[row["grid"]]]
        for column, kind in enumerate(("total", "direct")):
            array = results._get_array(info, "__static_apertures__", res_type=kind)[int(row["row"])]
            whole = results.values_to_annual(results.sun_up_hours, array, results.timestep)
            known = np.array([hour[column] for hour in hours[row["receiver"]]])
            worst = max(worst, float(np.abs(whole - known).max()))
            count += len(known)
    check("hours by Honeybee's reader", worst < 0.006, f"{count} within {worst:.4f} W/m2 of the CSV, which has 6 digits")
    shutil.rmtree(folder)


def largest_region(receivers):
    """Area in m2 of the largest region of patches, by joining outlines and cutting what is thinner than 20 mm."""
    first = receivers[0]
    normal = np.array([float(first[axis]) for axis in ("nx", "ny", "nz")])
    across = np.cross([0.0, 0.0, 1.0], normal) if abs(normal[2]) < 0.999 else np.array([1.0, 0.0, 0.0])
    across /= np.linalg.norm(across)
    up = np.cross(normal, across)
    origin = np.array([float(first[axis]) for axis in "xyz"])
    shapes = []
    for row in receivers:
        place = (np.array([float(row[axis]) for axis in "xyz"]) - origin) * 1e3
        rings = [np.array([corner.split() for corner in ring.split(";")], float) + place for ring in row["patch"].split("|")]
        shapes.append(unary_union([Polygon(np.c_[ring @ across, ring @ up]).buffer(1.5) for ring in rings]))
    joined = unary_union(shapes).buffer(-9)
    parts = list(getattr(joined, "geoms", [joined]))
    tree, areas = STRtree(parts), defaultdict(float)
    for number, (shape, row) in enumerate(zip(shapes, receivers)):
        over = [(shape.intersection(parts[i]).area, int(i)) for i in tree.query(shape)]
        best = max(over, default=(0.0, -1 - number))
        areas[best[1] if best[0] > 0 else -1 - number] += float(row["area_m2"])
    return max(areas.values())


def buildings(site, weather, receivers, year):
    tables = [WORK / "buildings.csv", WORK / "faces.csv"]
    seconds, _ = ours("buildings", site, "-w", weather, "--threshold", THRESHOLD, "--min-area", LEAST_M2, "--faces", tables[1], "-o", tables[0])
    found, faces = (table(file.read_text()) for file in tables)
    print(f"       buildings: {seconds:.1f} s, {len(found)} buildings, {len(faces)} roof faces")
    sums, above = defaultdict(lambda: [0.0, 0.0]), defaultdict(list)
    for row in table(receivers.read_text()):
        area, total = float(row["area_m2"]), year[row["receiver"]]
        part = {"roof": "roof", "wall": "facade", "window": "facade"}.get(row["kind"])
        if part is None:
            continue
        for key in [(row["building"], part)] + [(row["building"], row["surface"])] * (part == "roof"):
            sums[key][0] += area
            sums[key][1] += area * total
        if part == "roof" and total >= THRESHOLD:
            sums[row["building"], "above"][0] += area
            above[row["building"], row["surface"]].append(row)
    worst = 0.0
    for row in found:
        for part in ("roof", "facade"):
            area, kwh = sums[row["building"], part]
            sides = sum(float(row[f"{part}_{side}_kwh"]) for side in ("flat", "north", "east", "south", "west") if f"{part}_{side}_kwh" in row)
            for own, other in ((float(row[f"{part}_area_m2"]), area), (float(row[f"{part}_kwh"]), kwh), (sides, kwh)):
                worst = max(worst, abs(own - other) / max(other, 1.0))
        worst = max(worst, abs(float(row["above_threshold_m2"]) - sums[row["building"], "above"][0]))
    check("buildings against receivers", worst < 1e-3, f"{len(found)}: areas and sums by orientation within {worst:.1e}")
    worst = max(abs(float(row["total_kwh"]) - sums[row["building"], row["face"]][1]) / max(float(row["total_kwh"]), 100.0) for row in faces)
    check("roof faces against receivers", worst < 1e-4, f"{len(faces)} within {worst:.1e}")
    other = 0
    for row in faces:
        here = above.get((row["building"], row["face"]))
        known = largest_region(here) if here else 0.0
        if abs(float(row["largest_region_m2"]) - known) > 0.02 + 1e-3 * known:
            other += 1
            print(f"       {row['face']}: largest region {row['largest_region_m2']}, by shapely {known:.3f}")
    check("largest regions against shapely", other <= len(faces) // 500, f"{len(faces) - other} of {len(faces)} faces")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--model", type=Path, default=ROOT / "tests/data/cityjson/hague.city.json")
    parser.add_argument("--folder", type=Path)
    parser.add_argument("--weather", type=Path, default=ROOT / "tests/data/weather/golden_tmy3.epw")
    args = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    folder = args.folder or WORK / "site.sun"
    if not (folder / "site.helio").exists():
        ours("run", args.model, "--weather", args.weather, "-o", folder)
    site, receivers = folder / "site.helio", folder / "receivers.csv"
    _, text = ours("replay", site, "-w", args.weather, "--every", "total", "--columns", "total")
    year = {row["receiver"]: float(row["total_kwh_m2"]) for row in table(text)}
    # Of places that are nearly dark, months are not quite the year: what a month lacks below 0 counts as 0.
    months = defaultdict(float)
    for row in table(ours("replay", site, "-w", args.weather, "--every", "month", "--columns", "total")[1]):
        months[row["receiver"]] += float(row["total_kwh_m2"])
    city_model(site, args.model, args.weather, receivers, months)
    buildings(site, args.weather, receivers, year)
    honeybee(site, args.weather, year)
    sys.exit(failures > 0)


if __name__ == "__main__":
    main()
