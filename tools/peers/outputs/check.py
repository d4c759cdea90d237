"""Maps beside the CSV of the same replay, as programs of others read them. In: an archive, its receivers, its city model. Out: a table of
seconds, memory and bytes, a line for each check; exit code 1 if one fails."""
import argparse
import json
import os
import subprocess
import sys
import time
import warnings
from pathlib import Path

import geopandas as gpd
import numpy as np
import pandas as pd
import pyproj
import pyvista
import shapely
import trimesh

from duck import check_duckdb

ROOT = Path(__file__).resolve().parents[3]
PROGRAM = Path(os.environ.get("HELIOTILE", ROOT / "target/release/heliotile"))
WEATHER = ROOT / "tests/data/weather/golden_tmy3.epw"
WORK = ROOT / "target/peers/outputs"
COMPONENTS = ["sun_direct", "sky_direct", "sun_reflected", "sky_reflected", "sun_mirrored", "sky_mirrored", "total"]
# CSV has six digits; a map has 32-bit floats, and sums of twelve months that were each rounded in the CSV.
SHARE = 2e-5
METRES = 0.01
# Hours have three decimals in the CSV, W/m2.
HOURLY = 6e-4
failures = []


def check(what, ok, found):
    print(f"{'ok  ' if ok else 'FAIL'} {what}: {found}")
    if not ok:
        failures.append(what)


def heliotile(words):
    """Runs the program; seconds and MB of memory."""
    before = time.monotonic()
    done = subprocess.run(["/usr/bin/time", "-f", "%M", PROGRAM, *map(str, words)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return time.monotonic() - before, int(done.stderr.splitlines()[-1]) / 1000, done.stderr


def replay(archive, output, *rest):
    return heliotile(["replay", archive, "--weather", WEATHER, "-o", output, *rest])


def rings(geometry):
    """Rings of a polygon or a multipolygon, [corner][x, y, z], the last corner left out."""
    parts = geometry.geoms if geometry.geom_type == "MultiPolygon" else [geometry]
    return [np.array(ring.coords)[:-1] for part in parts for ring in [part.exterior, *part.interiors]]


def area_m2(geometry):
    parts = geometry.geoms if geometry.geom_type == "MultiPolygon" else [geometry]
    total = 0.0
    for part in parts:
        across = np.zeros(3)
        for ring in [part.exterior, *part.interiors]:
            corners = np.array(ring.coords)
            corners = corners - corners[0]
            across += np.cross(corners[:-1], corners[1:]).sum(axis=0)
        total += np.linalg.norm(across) / 2
    return total


def off(found, expected):
    """Largest difference as a share, small numbers absolutely."""
    found, expected = np.asarray(found, float), np.asarray(expected, float)
    assert found.shape == expected.shape
    return np.nanmax(np.abs(found - expected) / np.maximum(np.abs(expected), 1.0)) if len(found) else 0.0


def yearly(csv, place, months):
    """Values of the CSV, one row a place, as a map has them."""
    table = pd.read_csv(csv, dtype={"time": str, place: str})
    sums = [f"{name}_kwh_m2" for name in COMPONENTS]
    wide = table.groupby(place)[sums].sum()
    if months:
        wide = wide.join(table.pivot(index=place, columns="time", values="total_kwh_m2").add_prefix("total_").add_suffix("_kwh_m2"))
    facts = [name for name in ["area_m2", "tilt_deg", "azimuth_deg"] if name in table]
    return wide.join(table.groupby(place)[facts].first())


def compare(label, frame, expected, place):
    frame = frame.set_index(place)
    check(f"{label}: places", len(frame) == len(expected) and frame.index.is_unique, len(frame))
    frame = frame.loc[expected.index]
    worst = max((off(frame[name], expected[name]), name) for name in expected.columns)
    check(f"{label}: {len(expected.columns)} columns against the CSV", worst[0] < SHARE, f"{worst[0]:.1e} ({worst[1]})")


def patches(receivers):
    """Corners of each receiver's patch, from the table that the archive was built from: receiver -> [corner][x, y, z]."""
    table = pd.read_csv(receivers, dtype=str, keep_default_na=False)
    found = {}
    for row in table.itertuples():
        at = np.array([float(row.x), float(row.y), float(row.z)])
        corners = [[int(mm) for mm in corner.split()] for ring in row.patch.split("|") for corner in ring.split(";")]
        found[row.receiver] = at + np.array(corners) / 1000
    return found


def farthest(frame, at):
    """Farthest that a corner on the map lies from the same corner of the patch, metres."""
    return max(np.abs(np.concatenate(rings(shape)) - at[name]).max() for name, shape in zip(frame["receiver"], frame.geometry))


def faces(model):
    """Outer rings of the faces of a city model: (object, face) -> [corner][x, y, z]."""
    city = json.loads(Path(model).read_text())
    vertices = np.array(city["vertices"]) * city["transform"]["scale"] + city["transform"]["translate"]
    found = {}

    def walk(name, at, place):
        if isinstance(at[0][0], int):
            found[name, place] = vertices[at[0]]
        else:
            for i, part in enumerate(at):
                walk(name, part, f"{place}[{i}]")

    for name, thing in city["CityObjects"].items():
        for i, geometry in enumerate(thing.get("geometry", [])):
            if geometry["type"] != "GeometryInstance":
                walk(name, geometry["boundaries"], f"geometry[{i}].boundaries")
    return found


def against_model(frame, receivers, model):
    """Bounds of outlines against those of the model's faces, where all of the face has receivers."""
    table = pd.read_csv(receivers, dtype=str, keep_default_na=False).drop_duplicates("surface").set_index("surface")
    of_model, worst, count = faces(model), 0.0, 0
    for name, shape, area in zip(frame["surface"], frame.geometry, frame["area_m2"]):
        row = table.loc[name]
        ring = of_model.get((row["object"], row["face"]))
        if ring is None:
            continue
        across = np.cross(ring - ring[0], np.roll(ring, -1, axis=0) - ring[0]).sum(axis=0)
        corners = np.concatenate(rings(shape))
        if abs(np.linalg.norm(across) / 2 / area - 1) < 1e-3:
            count += 1
            worst = max(worst, np.abs(corners.min(0) - ring.min(0)).max(), np.abs(corners.max(0) - ring.max(0)).max())
    return worst, count


def degrees_off(plane, degrees):
    """Metres between corners in degrees and what PROJ makes of those in RD New, by its best operation without grids."""
    to = pyproj.Transformer.from_crs(plane.crs, 4326, always_xy=True)
    there = degrees.set_index("receiver").geometry.loc[plane["receiver"]]
    here, there = (np.concatenate([ring for shape in shapes for ring in rings(shape)]) for shapes in [plane.geometry, there])
    x, y = to.transform(here[:, 0], here[:, 1])
    return np.abs(pyproj.Geod(ellps="WGS84").inv(x, y, there[:, 0], there[:, 1])[2]).max()


def properties(glb):
    """JSON of a .glb, and its property table, decoded by EXT_structural_metadata 1.0."""
    data = glb.read_bytes()
    length = int.from_bytes(data[12:16], "little")
    head, binary = json.loads(data[20:20 + length]), data[28 + length:]
    metadata = head["extensions"]["EXT_structural_metadata"]
    table = metadata["propertyTables"][0]
    kinds = metadata["schema"]["classes"][table["class"]]["properties"]

    def view(number):
        at = head["bufferViews"][number]
        return binary[at["byteOffset"]:at["byteOffset"] + at["byteLength"]]

    columns = {}
    for name, where in table["properties"].items():
        if kinds[name]["type"] == "STRING":
            ends = np.frombuffer(view(where["stringOffsets"]), "<u4")
            text = view(where["values"])
            columns[name] = [text[a:b].decode() for a, b in zip(ends, ends[1:])]
        else:
            values = np.frombuffer(view(where["values"]), "<f4").astype(float)
            columns[name] = np.where(values == np.float32(kinds[name]["noData"]), np.nan, values)
    return head, pd.DataFrame(columns)


def check_glb(label, glb, expected, place, at):
    report = json.loads(subprocess.run(["node", ROOT / "tools/peers/outputs/validate.mjs", glb], check=True, capture_output=True, cwd=ROOT).stdout)
    issues = report["issues"]
    codes = sorted({message["code"] for message in issues["messages"]})
    check(f"{label}: glTF validator", issues["numErrors"] == 0, f"{issues['numErrors']} errors, {issues['numWarnings']} warnings, {codes}")
    head, table = properties(glb)
    compare(f"{label}: property table", table, expected, place)
    scene = trimesh.load(glb, process=False)
    mesh = next(geometry for name, geometry in scene.geometry.items() if "_TOTAL_KWH_M2" in geometry.vertex_attributes)
    node = next(node for node in scene.graph.nodes_geometry if scene.graph[node][1] == mesh.metadata.get("name", "map") or "map" in node)
    ids = np.asarray(mesh.vertex_attributes["_FEATURE_ID_0"]).ravel().astype(int)
    totals = np.asarray(mesh.vertex_attributes["_TOTAL_KWH_M2"]).ravel()
    check(f"{label}: totals of vertices in trimesh", off(totals, table["total_kwh_m2"].to_numpy()[ids]) == 0, f"{len(totals)} vertices")
    extras = head["asset"]["extras"]
    turned = trimesh.transform_points(mesh.vertices, scene.graph[node][0])
    corners = np.column_stack([turned[:, 0], -turned[:, 2], turned[:, 1]]) + extras["origin_m"]
    area = np.bincount(ids[mesh.faces[:, 0]], mesh.area_faces, len(table))
    of_table = table["area_m2"].to_numpy()
    check(f"{label}: areas of triangles", abs(area.sum() / of_table.sum() - 1) < 1e-3, f"{area.sum():.2f} of {of_table.sum():.2f} m2")
    if at:
        first = np.flatnonzero(np.diff(ids, prepend=-1))
        worst = max(np.abs(corners[a:a + len(at[name])] - at[name]).max() for a, name in zip(first, table["receiver"]))
        check(f"{label}: corners against patches", worst <= METRES + 1.1e-3, f"{worst * 1000:.1f} mm, of which 10 mm are stated as raised_m")
    colours = np.asarray(mesh.visual.vertex_attributes["color"])[:, :3].astype(float)
    order = np.argsort(totals)
    check(f"{label}: colours grow with totals", colours[order[-1]].sum() > colours[order[0]].sum(), f"{len(np.unique(colours, axis=0))} colours")


def check_vtu(label, vtu, expected, place, at):
    grid = pyvista.read(vtu)
    frame = pd.DataFrame({name: np.asarray(grid.cell_data[name]) for name in grid.cell_data.keys() if name != "place"})
    rows = frame.groupby(np.asarray(grid.cell_data["place"])).first()
    compare(label, rows, expected, place)
    size = grid.compute_cell_sizes(length=False, volume=False)["Area"]
    total = rows["area_m2"].sum()
    check(f"{label}: areas of cells", abs(size.sum() / total - 1) < 1e-3, f"{size.sum():.2f} of {total:.2f} m2")
    if at:
        # Points stand in the order of places.
        worst = np.abs(np.asarray(grid.points) - np.concatenate([at[name] for name in rows[place]])).max()
        check(f"{label}: corners against patches", worst <= METRES, f"{worst * 1000:.3f} mm")


def check_series(archive, folder):
    pvd, csv = folder / "day.pvd", folder / "day.csv"
    seconds, _, _ = replay(archive, pvd, "--every", "hour", "--from", "06-21", "--to", "06-21", "--by", "surface")
    replay(archive, csv, "--every", "hour", "--from", "06-21", "--to", "06-21", "--by", "surface")
    table = pd.read_csv(csv)
    reader = pyvista.PVDReader(pvd)
    worst = 0.0
    for step, (_, rows) in enumerate(table.groupby("time", sort=False)):
        reader.set_active_time_point(step)
        grid = reader.read()[0]
        place, surface = np.asarray(grid.cell_data["place"]), np.asarray(grid.cell_data["surface"])
        first = np.unique(place, return_index=True)[1]
        rows = rows.set_index("surface").loc[surface[first]]
        worst = max([worst, *(off(grid.cell_data[f"{name}_w_m2"][first], rows[name]) for name in COMPONENTS)])
    times = reader.time_values
    check("pvd: a day of hours", len(times) == 24 and times[-1] == 23.0 and worst < HOURLY, f"{len(times)} hours, {worst:.1e}, {seconds:.1f} s")


def main():
    warnings.simplefilter("ignore")
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("--archive", type=Path)
    words.add_argument("--receivers", type=Path)
    words.add_argument("--model", type=Path)
    words.add_argument("--folder", type=Path, default=WORK / "files", help="folder for the maps; existing maps are kept")
    args = words.parse_args()
    folder = args.folder
    folder.mkdir(parents=True, exist_ok=True)
    archive, receivers = args.archive, args.receivers
    model = args.model or ROOT / "tests/data/cityjson/hague.city.json"
    if not archive:
        site = WORK / "hague.sun"
        maps = "glb,fgb,geojson,geoparquet,vtu"
        heliotile(["run", model, "--weather", WEATHER, "--error", "5%", "--crs", "7415", "--map", maps, "--replace", "-o", site])
        archive, receivers = site / "site.helio", site / "receivers.csv"
    at = patches(receivers) if receivers else {}
    print(f"{'file':24} {'seconds':>8} {'MB':>6} {'bytes':>12}")
    months = ["--every", "month", "--by", "surface"]
    total = ["--every", "total"]
    files = {}
    for stem, how in [("surfaces", months), ("receivers", total)]:
        for ending in ["csv", "fgb", "parquet", "geojson", "glb", "vtu"]:
            path = folder / f"{stem}.{ending}"
            if args.archive and path.exists():
                seconds, memory = np.nan, np.nan
            else:
                seconds, memory, _ = replay(archive, path, *how, *(["--geo"] if ending == "parquet" else []))
            print(f"{path.name:24} {seconds:8.1f} {memory:6.0f} {path.stat().st_size:12}")
            files[stem, ending] = path
    for stem, place in [("surfaces", "surface"), ("receivers", "receiver")]:
        expected = yearly(files[stem, "csv"], place, stem == "surfaces")
        here = at if stem == "receivers" else {}
        frames = {}
        for ending, epsg in [("fgb", 28992), ("parquet", 28992), ("geojson", 4326)]:
            path = files[stem, ending]
            frame = gpd.read_parquet(path) if ending == "parquet" else gpd.read_file(path, engine="pyogrio")
            frames[ending] = frame
            check(f"{path.name}: EPSG in geopandas", frame.crs.to_epsg() == epsg, frame.crs.to_epsg())
            compare(path.name, frame, expected, place)
        frame = frames["parquet"]
        drawn = frame.geometry.map(area_m2)
        check(f"{stem}.parquet: areas of polygons", abs(drawn.sum() / frame["area_m2"].sum() - 1) < 1e-3, f"{drawn.sum():.2f} of {frame['area_m2'].sum():.2f} m2")
        large = frame["area_m2"] > 5
        worst = np.abs(drawn / frame["area_m2"] - 1)[large].max()
        if stem == "surfaces":
            check("surfaces.parquet: area of each outline above 5 m2", worst < 2e-3, f"{worst:.2%}, {shapely.get_num_geometries(frame.geometry.values).sum()} polygons of {len(frame)} surfaces")
            worst, count = against_model(frame, receivers, model)
            check("surfaces.parquet: bounds against the city model", worst <= METRES and count > 0, f"{worst * 1000:.1f} mm, {count} faces")
        else:
            for ending in ["fgb", "parquet"]:
                worst = farthest(frames[ending], at)
                check(f"receivers.{ending}: corners against patches", worst <= 1e-6, f"{worst:.1e} m")
            worst = degrees_off(frames["parquet"], frames["geojson"])
            check("receivers.geojson: corners against PROJ", worst <= METRES, f"{worst * 1000:.2f} mm")
            inside = gpd.read_parquet(files[stem, "parquet"], bbox=tuple(frame.geometry.iloc[0].bounds))
            check("receivers.parquet: read by box", 0 < len(inside) <= len(frame), f"{len(inside)} of {len(frame)} rows")
        check_glb(f"{stem}.glb", files[stem, "glb"], expected, place, here)
        check_vtu(f"{stem}.vtu", files[stem, "vtu"], expected, place, here)
    check_series(archive, folder)
    check_duckdb(check, replay, archive, files, folder, SHARE, HOURLY)
    if not args.archive:
        # What `run` wrote is what `replay` writes.
        for ending in ["glb", "fgb", "geojson", "parquet", "vtu"]:
            annual = WORK / "hague.sun/golden_tmy3" / f"annual.{ending}"
            same = annual.stat().st_size / files["receivers", ending].stat().st_size
            check(f"annual.{ending} of run", 0.95 < same < 1.05, f"{annual.stat().st_size} bytes")
        annual = gpd.read_parquet(WORK / "hague.sun/golden_tmy3/annual.parquet")
        compare("annual.parquet of run", annual, yearly(files["receivers", "csv"], "receiver", False), "receiver")
    print(f"{len(failures)} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
