"""Six planes in a courtyard beside measurements. In: the folder of the rasters, the weather and the measurements of Kronenhuset (2005-10-07; Lindberg,
Holmer and Thorsson 2008, as SOLWEIG's tests have them), the program. Out: bias and RMSE of shortwave on each plane, for scenes of more
and more of the rasters. Needs numpy, pandas and rasterio."""
import csv
import json
import math
import subprocess
import sys
from datetime import datetime, timedelta, timezone
from pathlib import Path

import numpy as np
import pandas
import rasterio

#: Azimuths of the planes, or where they look; the instruments stand turned by -15 degrees from north.
TURN = -15.0
PLANES = {"Kdown": "up", "Kup": "down", "Kn": 0.0, "Ke": 90.0, "Ks": 180.0, "Kw": 270.0}
#: Instruments stand so high above the ground, metres.
HEIGHT = 1.1
#: In the hour up to this the edge of a shadow crosses the instruments.
SHADOW_EDGE = 15
#: SOLWEIG's albedos for this place.
MATERIALS = "[WallSurface]\ndiffuse = 0.2\n[RoofSurface]\ndiffuse = 0.18\n"
#: Suns an hour.
STEPS = 12
ZONE = timezone(timedelta(hours=1))
LATITUDE, LONGITUDE = 57.709, 11.963


def sun(when):
    """Azimuth and altitude in degrees (Spencer 1971 for declination and equation of time, good to 0.1 degrees)."""
    day = when.astimezone(timezone.utc)
    hour = day.hour + day.minute / 60 + day.second / 3600
    g = 2 * math.pi * (day.timetuple().tm_yday - 1 + (hour - 12) / 24) / 365
    declination = (0.006918 - 0.399912 * math.cos(g) + 0.070257 * math.sin(g) - 0.006758 * math.cos(2 * g) + 0.000907 * math.sin(2 * g)
                   - 0.002697 * math.cos(3 * g) + 0.00148 * math.sin(3 * g))
    minutes = 229.18 * (0.000075 + 0.001868 * math.cos(g) - 0.032077 * math.sin(g) - 0.014615 * math.cos(2 * g) - 0.040849 * math.sin(2 * g))
    angle = math.radians(15 * (hour - 12) + LONGITUDE + minutes / 4)
    lat = math.radians(LATITUDE)
    east = -math.cos(declination) * math.sin(angle)
    north = math.cos(lat) * math.sin(declination) - math.sin(lat) * math.cos(declination) * math.cos(angle)
    up = math.sin(lat) * math.sin(declination) + math.cos(lat) * math.cos(declination) * math.cos(angle)
    return math.degrees(math.atan2(east, north)) % 360, math.degrees(math.asin(up))


def write_receivers(folder, out, planes):
    x, y = json.loads((folder / "poi.geojson").read_text())["geometry"]["coordinates"]
    with rasterio.open(folder / "DEM_KR.tif") as dem:
        z = float(next(dem.sample([(x, y)]))[0]) + HEIGHT
    with open(out, "w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["receiver", "x", "y", "z", "nx", "ny", "nz"])
        for name, azimuth in planes.items():
            normal = {"up": [0, 0, 1], "down": [0, 0, -1]}.get(azimuth)
            if normal is None:
                turned = math.radians(azimuth + TURN)
                normal = [math.sin(turned), math.cos(turned), 0]
            rows.writerow([name, x, y, z, *normal])


def write_conditions(folder, out):
    """Hours of the weather are labelled by their start, those of the measurements by their end."""
    met = pandas.read_csv(folder / "MetFile_Prepared.txt", sep=r"\s+").rename(columns=lambda name: name.strip("%"))
    with open(out, "w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["condition", "sun_azimuth_deg", "sun_altitude_deg", "dni_w_m2", "dhi_w_m2"])
        for _, row in met[met.Kdn > 0].iterrows():
            start = datetime(2005, 1, 1, tzinfo=ZONE) + timedelta(days=int(row.id) - 1, hours=int(row.it))
            for step in range(STEPS):
                azimuth, altitude = sun(start + timedelta(hours=(step + 0.5) / STEPS))
                if altitude > 0:
                    rows.writerow([f"{int(row.it) + 1}_{step}", azimuth, altitude, row.Kdir, row.Kdiff])


def main(folder, program, out):
    folder, out = Path(folder).resolve(), Path(out)
    out.mkdir(parents=True, exist_ok=True)
    write_receivers(folder, out / "receivers.csv", PLANES)
    write_conditions(folder, out / "conditions.csv")
    measured = pandas.read_csv(folder / "measurements_kr.csv").set_index("hour")
    dsm, dem = ["--dsm", folder / "DSM_KR.tif"], ["--dem", folder / "DEM_KR.tif"]
    canopy, cover = ["--canopy", folder / "CDSM_KR.asc"], ["--landcover", folder / "landcover_KR.tif"]
    scenes = {"terrain": [folder / "DSM_KR.tif"], "dsm": dsm, "dsm, dem": dsm + dem, "dsm, dem, cover": dsm + dem + cover,
              "dsm, dem, canopy": dsm + dem + canopy, "all": dsm + dem + canopy + cover}
    (out / "materials.toml").write_text(MATERIALS)
    tables = {"all hours": [], "without the edge of a shadow": []}
    for name, scene in scenes.items():
        archive = out / (name.replace(", ", "_") + ".helio")
        say = ["--quality", "fine", "--crs", "3007"] + (["--materials", out / "materials.toml"] if name != "terrain" else [])
        subprocess.run([program, "build", *scene, "-r", out / "receivers.csv", "-o", archive, "--fresh", *say], check=True, capture_output=True)
        asked = subprocess.run([program, "replay", archive, "--conditions", out / "conditions.csv"], check=True, capture_output=True, text=True)
        (out / "query.csv").write_text(asked.stdout)
        found = pandas.read_csv(out / "query.csv")
        found["hour"] = found.condition.str.split("_").str[0].astype(int)
        hourly = found.groupby(["hour", "receiver"]).total.sum().unstack() / STEPS
        both = hourly.index.intersection(measured.index)
        off = hourly.loc[both, list(PLANES)] - measured.loc[both, list(PLANES)]
        off.to_csv(out / (archive.stem + ".off.csv"), float_format="%.1f")
        for hours, rows in tables.items():
            kept = off.drop(SHADOW_EDGE) if hours == "without the edge of a shadow" else off
            rows.append([name, *(f"{kept[plane].mean():+.1f} / {np.sqrt((kept[plane] ** 2).mean()):.1f}" for plane in PLANES)])
    for hours, rows in tables.items():
        print(f"bias / RMSE, W/m2, {hours}")
        print(pandas.DataFrame(rows, columns=["scene", *PLANES]).to_string(index=False))


if __name__ == "__main__":
    main(*sys.argv[1:4])
