"""A made town as files of footprints, near Munich (EPSG:25832): what the tests of those formats read.

    python3 town.py FOLDER        needs geopandas, pyogrio, pyarrow

Six houses of 8 m x 12 m in a row, 9 and 10.5 m high; a block of 30 m x 30 m with a court of 10 m x 10 m and five storeys; a department store of 40 m x
30 m and 8 m, with a tower of 15 m x 15 m from 8 to 32 m; a shed without a height; all turned by 20 degrees. Roofs: 6 x 96 + 800 + 975 + 225 = 2,576 m2.
Walls: 936 + 234 + 90 of the row, 1,800 + 600 of the block, 1,120 of the store, 1,440 of the tower: 6,220 m2.
"""

import json
import sys
import zipfile
from pathlib import Path

import geopandas
from shapely.affinity import rotate, translate
from shapely.geometry import Polygon, mapping

EAST, NORTH = 691_600.0, 5_334_800.0


def rect(x0, y0, x1, y1):
    return Polygon([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])


def placed(shape):
    return translate(rotate(shape, 20, origin=(0, 0)), EAST, NORTH)


COURT = Polygon([(0, 30), (30, 30), (30, 60), (0, 60)], [[(10, 40), (20, 40), (20, 50), (10, 50)]])
# Shape; id, name, use, height, storeys, foot, year.
BUILDINGS = [
    (rect(8 * i, 0, 8 * i + 8, 12), f"row/{i + 1}", f"Lindenweg {2 * i + 1}", "terrace", [9.0, 10.5][i % 2], None, None, 1901 + i)
    for i in range(6)
] + [
    (COURT, "court", "Hofblock", "apartments", None, 5, None, 1898),
    (rect(55, 20, 95, 50), "podium", "Kaufhaus", "retail", 8.0, None, None, 1974),
    (rect(60, 25, 75, 40), "tower", "Turm", "office", 32.0, None, 8.0, 1974),
    (rect(60, 0, 70, 8), "shed", None, "shed", None, None, None, None),
]
COLUMNS = ["id", "name", "building", "height", "levels", "min_height", "year"]


def table(folder):
    rows = [dict(zip(COLUMNS, values)) for _, *values in BUILDINGS]
    frame = geopandas.GeoDataFrame(rows, geometry=[placed(shape) for shape, *_ in BUILDINGS], crs=25832)
    frame = frame.astype({"levels": "Int64", "year": "Int64"})
    frame.to_file(folder / "town.gpkg", layer="buildings", driver="GPKG", SPATIAL_INDEX="NO")
    frame.to_parquet(folder / "town.parquet")
    frame.to_crs(4326).to_file(folder / "town.geojson", driver="GeoJSON", COORDINATE_PRECISION=9)
    frame.to_file(folder / "town.shp")
    with zipfile.ZipFile(folder / "town.shp.zip", "w", zipfile.ZIP_DEFLATED) as file:
        for ending in ("shp", "shx", "dbf", "prj", "cpg"):
            file.write(folder / f"town.{ending}", f"town.{ending}")
            (folder / f"town.{ending}").unlink()


def tags(folder):
    """The same as an export of OpenStreetMap has it (osmtogeojson): texts, and the store with its tower as parts of an outline."""
    features = []
    for number, (shape, _, name, use, height, storeys, foot, year) in enumerate(BUILDINGS):
        found = {"building": use, "name": name, "height": height, "building:levels": storeys, "min_height": foot, "start_date": year}
        if name in ("Kaufhaus", "Turm"):
            found["building:part"] = found.pop("building")
        features.append((f"way/{100 + number}", shape, found))
    features.append(("way/200", rect(55, 20, 95, 50), {"building": "retail", "name": "Kaufhaus am Park", "height": "32", "operator": "Park AG"}))
    shapes = geopandas.GeoSeries([placed(shape) for _, shape, _ in features], crs=25832).to_crs(4326)
    lines = []
    for (name, _, found), shape in zip(features, shapes):
        properties = {"@id": name} | {key: str(value) for key, value in found.items() if value is not None}
        rings = [[[round(x, 7), round(y, 7)] for x, y in ring] for ring in mapping(shape)["coordinates"]]
        geometry = {"type": "Polygon", "coordinates": rings}
        lines.append(json.dumps({"type": "Feature", "id": name, "properties": properties, "geometry": geometry}))
    (folder / "osm.geojson").write_text('{"type": "FeatureCollection", "features": [\n' + ",\n".join(lines) + "\n]}\n")


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    table(folder)
    tags(folder)
