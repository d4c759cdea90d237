"""Footprints for studies. In: a CityJSON file, or a number of houses. Out: GeoPackage or GeoJSON of outlines with heights.

    outlines.py city CITY.city.json OUT.gpkg     the ground outlines of its buildings, bases and mean heights of their roofs
    outlines.py rows COUNT OUT.geojson           so many houses in closed rows and blocks, in longitude and latitude
"""

import json
import math
import sys

import geopandas
import numpy
from shapely.geometry import Polygon
from shapely.ops import unary_union


def city(source, out):
    model = json.load(open(source))
    scale, move = model["transform"]["scale"], model["transform"]["translate"]
    points = numpy.array(model["vertices"]) * scale + move
    rows = []
    for name, found in model["CityObjects"].items():
        grounds, roofs, base = [], [], math.inf
        for geometry in found.get("geometry", []):
            shells = geometry["boundaries"] if geometry["type"] == "Solid" else [geometry["boundaries"]]
            values = geometry.get("semantics", {}).get("values") or []
            values = values if geometry["type"] == "Solid" else [values]
            kinds = [surface["type"] for surface in geometry.get("semantics", {}).get("surfaces", [])]
            for shell, numbers in zip(shells, values):
                for face, number in zip(shell, numbers):
                    kind = kinds[number] if number is not None else ""
                    rings = [points[ring] for ring in face]
                    if kind == "GroundSurface":
                        grounds.append(Polygon(rings[0][:, :2], [ring[:, :2] for ring in rings[1:]]).buffer(0))
                        base = min(base, rings[0][:, 2].min())
                    elif kind == "RoofSurface":
                        roofs.append((Polygon(rings[0][:, :2]).buffer(0).area, rings[0]))
        area = sum(a for a, _ in roofs)
        outline = unary_union(grounds)
        if area > 0 and outline.area > 0:
            height = sum(a * mean_height(ring) for a, ring in roofs) / area - base
            rows.append({"id": name, "height": round(height, 3), "ground": round(float(base), 3), "geometry": outline})
    epsg = int(model.get("metadata", {}).get("referenceSystem", "28992").rstrip("/").split("/")[-1].split(":")[-1])
    epsg = {7415: 28992}.get(epsg, epsg)
    geopandas.GeoDataFrame(rows, crs=epsg).to_file(out)
    print(f"{len(rows)} outlines, {sum(row['geometry'].area for row in rows):.0f} m2")


def mean_height(ring):
    """Mean height of a plane polygon over its area in plan."""
    if len(ring) < 3:
        return ring[:, 2].mean()
    first, weight, height = ring[0], 0.0, 0.0
    for a, b in zip(ring[1:-1], ring[2:]):
        part = (a[0] - first[0]) * (b[1] - first[1]) - (a[1] - first[1]) * (b[0] - first[0])
        weight += part
        height += part * (first[2] + a[2] + b[2]) / 3
    return height / weight if abs(weight) > 1e-9 else ring[:, 2].mean()


def rows(count, out):
    """Rows of ten houses of 6 m x 10 m back to back, streets between, around 11.58 E 48.14 N."""
    east, north = 1 / (111_320 * math.cos(math.radians(48.14))), 1 / 111_195
    side = math.ceil(math.sqrt(count / 20))
    with open(out, "w") as file:
        file.write('{"type":"FeatureCollection","features":[\n')
        for number in range(count):
            block, place = divmod(number, 20)
            row, house = divmod(place, 10)
            x0, y0 = 80.0 * (block % side) + 6 * house, 40.0 * (block // side) + 10 * row
            turn = math.radians(17)
            corners = [(x0, y0), (x0 + 6, y0), (x0 + 6, y0 + 10), (x0, y0 + 10), (x0, y0)]
            corners = [(x * math.cos(turn) - y * math.sin(turn), x * math.sin(turn) + y * math.cos(turn)) for x, y in corners]
            ring = ",".join(f"[{11.58 + x * east:.9f},{48.14 + y * north:.9f}]" for x, y in corners)
            between = ",\n" if number else ""
            file.write(
                f'{between}{{"type":"Feature","properties":{{"id":"h{number}","height":{8 + number % 3},"street":"Row {block}",'
                f'"year":{1900 + number % 100}}},"geometry":{{"type":"Polygon","coordinates":[[{ring}]]}}}}'
            )
        file.write("\n]}\n")


if __name__ == "__main__":
    work, source, out = sys.argv[1:]
    city(source, out) if work == "city" else rows(int(source), out)
