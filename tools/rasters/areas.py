"""A city model beside itself as rasters. In: CityJSON, its coordinate system, the program, a folder, weather or nothing. Out: areas of roofs and walls
that get receivers, and with weather a year's sums, also by building and of ground, of the model and of rasters with cells of 0.5, 1 and 2 m, in percent of the model's.
Needs geopandas, numpy, pandas, rasterio and shapely."""
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pandas

from buildings import compare
from ground import compare_ground
from rasterise import rasterise

CELLS = (0.5, 1, 2)
SPACING = 4


def main(model, crs, program, out, weather=""):
    out = Path(out)
    scenes = {"model": [model]}
    for cell in CELLS:
        folder = out / str(cell)
        if not (folder / "dem.tif").exists():
            folder.mkdir(parents=True, exist_ok=True)
            rasterise(model, cell, crs, folder)
        scenes[f"{cell} m"] = ["--dsm", folder / "dsm.tif", "--dem", folder / "dem.tif"]
    table, whole = [], None
    for name, scene in scenes.items():
        receivers = out / f"{name.replace(' ', '_')}.csv"
        start = time.monotonic()
        subprocess.run([program, "receivers", *scene, "--crs", crs, "--spacing", str(SPACING), "-o", receivers], check=True, capture_output=True)
        seconds = time.monotonic() - start
        found = pandas.read_csv(receivers)
        row = found.groupby("kind").area.sum()[["roof", "wall"]]
        row["receivers"], row["surfaces"], row["seconds"] = len(found), found.surface.nunique(), round(seconds, 1)
        if weather:
            folder, found = out / f"{name.replace(' ', '_')}.sun", out / f"{name.replace(' ', '_')}.geojson"
            shutil.rmtree(folder, ignore_errors=True)
            asked = ["-w", weather, "--spacing", f"{SPACING}m", "-o", folder, "--crs", crs]
            subprocess.run([program, "run", *scene, *asked], check=True, capture_output=True)
            sums = ["--every", "year", "--by", "surface", "--columns", "total", "-w", weather, "-o", found]
            subprocess.run([program, "replay", folder / "site.helio", *sums], check=True, capture_output=True)
            for column, value in compare(out / "model.geojson", found, crs).items():
                row[column] = value
        whole = row if whole is None else whole
        share = {f"{kind}_%": round(100 * row[kind] / whole[kind], 1) for kind in ("roof", "wall")}
        table.append({"scene": name, **row.to_dict(), **share})
    print(pandas.DataFrame(table).round(2).to_string(index=False))
    if weather:
        compare_ground({name: [*scene, "--crs", crs] for name, scene in scenes.items()}, program, out, weather)


if __name__ == "__main__":
    main(*sys.argv[1:])
