"""A city model as rasters. In: CityJSON with roofs and a terrain, the width of a cell. Out: DSM and DEM as GeoTIFF, sampled at the middles of cells.
Needs numpy, rasterio and shapely."""
import json
import sys

import numpy as np
import rasterio
from rasterio.features import geometry_mask
from rasterio.transform import from_origin
from rasterio.windows import Window
from shapely.geometry import Polygon


def faces(model):
    """Rings of positions of each face, and whether it is terrain."""
    transform = model.get("transform", {"scale": [1, 1, 1], "translate": [0, 0, 0]})
    vertices = np.array(model["vertices"], float) * transform["scale"] + transform["translate"]

    def polygons(boundaries):
        if boundaries and isinstance(boundaries[0][0], int):
            yield [vertices[ring] for ring in boundaries]
        else:
            for inner in boundaries:
                yield from polygons(inner)

    for thing in model["CityObjects"].values():
        for geometry in thing.get("geometry", []):
            for rings in polygons(geometry["boundaries"]):
                yield rings, thing["type"] == "TINRelief"


def plane(ring):
    """Height at 0, 0 and rise eastwards and northwards; None where it stands upright."""
    middle = ring.mean(axis=0)
    after = np.roll(ring, -1, axis=0)
    normal = np.cross(ring - middle, after - middle).sum(axis=0)
    if abs(normal[2]) < 1e-3 * np.linalg.norm(normal) or not np.linalg.norm(normal):
        return None
    rise = -normal[:2] / normal[2]
    return middle[2] - rise @ middle[:2], rise


def rasterise(path, cell, crs, out):
    with open(path) as file:
        model = json.load(file)
    found = list(faces(model))
    terrain = np.concatenate([rings[0] for rings, is_terrain in found if is_terrain])
    west, south = np.floor(terrain[:, :2].min(axis=0))
    east, north = np.ceil(terrain[:, :2].max(axis=0))
    columns, rows = int((east - west) / cell), int((north - south) / cell)
    dem, top = np.full((rows, columns), -np.inf), np.full((rows, columns), -np.inf)
    for rings, is_terrain in found:
        flat = plane(rings[0])
        if flat is None:
            continue
        shape = Polygon(rings[0][:, :2], [ring[:, :2] for ring in rings[1:]])
        low, high = rings[0][:, :2].min(axis=0), rings[0][:, :2].max(axis=0)
        c0, c1 = int((low[0] - west) / cell), int(np.ceil((high[0] - west) / cell))
        r0, r1 = int((north - high[1]) / cell), int(np.ceil((north - low[1]) / cell))
        c0, r0, c1, r1 = max(c0, 0), max(r0, 0), min(c1, columns), min(r1, rows)
        if c1 <= c0 or r1 <= r0 or not shape.area:
            continue
        inside = geometry_mask([shape.buffer(0)] if not shape.is_valid else [shape], (r1 - r0, c1 - c0),
                               from_origin(west + c0 * cell, north - r0 * cell, cell, cell), invert=True)
        x = west + (np.arange(c0, c1) + 0.5) * cell
        y = north - (np.arange(r0, r1) + 0.5) * cell
        height = flat[0] + flat[1][0] * x[None, :] + flat[1][1] * y[:, None]
        grid = dem if is_terrain else top
        part = grid[r0:r1, c0:c1]
        np.copyto(part, np.maximum(part, height), where=inside)
    dsm = np.maximum(dem, top)
    for name, grid in (("dsm", dsm), ("dem", dem)):
        about = {"height": rows, "width": columns, "count": 1, "dtype": "float32", "crs": crs, "nodata": -9999.0}
        transform = from_origin(west, north, cell, cell)
        with rasterio.open(f"{out}/{name}.tif", "w", driver="GTiff", transform=transform, compress="DEFLATE", predictor=3, **about) as file:
            file.write(np.where(np.isfinite(grid), grid, -9999.0).astype("float32"), 1)


if __name__ == "__main__":
    rasterise(sys.argv[1], float(sys.argv[2]), sys.argv[3], sys.argv[4])
