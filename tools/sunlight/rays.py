"""Minutes of sun of 1,000 receivers by another ray tracer, every ten seconds of five days, beside those of tables of `sunlight`.

In: a city model, the folder with receivers.csv, bits.csv and rays.csv, latitude, longitude. Out: shares of days within a minute.
"""

import csv
import json
import random
import sys

import mapbox_earcut
import numpy as np
import pandas as pd
import pvlib
import trimesh

DAYS = ("2017-01-21", "2017-03-21", "2017-05-05", "2017-06-21", "2017-11-10")
STEP_S = 10


def triangles(model: dict, vertices: np.ndarray) -> np.ndarray:
    """Corners of the triangles of all surfaces: polygons with holes are cut in the plane that they lie in most nearly."""
    found = []
    for city_object in model["CityObjects"].values():
        for geometry in city_object.get("geometry", []):
            solids = geometry["boundaries"]
            surfaces = [surface for shell in solids for surface in shell] if geometry["type"] == "Solid" else solids
            for rings in surfaces:
                outer = vertices[rings[0]]
                normal = np.cross(outer - outer[0], np.roll(outer, -1, axis=0) - outer[0]).sum(axis=0)
                plane = [axis for axis in range(3) if axis != np.argmax(np.abs(normal))]
                corners = np.concatenate([np.array(ring) for ring in rings])
                ends = np.cumsum([len(ring) for ring in rings]).astype(np.uint32)
                cut = mapbox_earcut.triangulate_float64(np.ascontiguousarray(vertices[corners][:, plane]), ends)
                found.extend(corners[cut].reshape(-1, 3))
    return np.array(found)


def main() -> None:
    site, folder, latitude, longitude = sys.argv[1], sys.argv[2], float(sys.argv[3]), float(sys.argv[4])
    with open(site, encoding="utf-8") as file:
        model = json.load(file)
    transform = model["transform"]
    vertices = np.array(model["vertices"]) * transform["scale"] + transform["translate"]
    # Rays have 32 bits.
    origin = vertices.mean(axis=0)
    scene = trimesh.Trimesh(vertices - origin, triangles(model, vertices - origin), process=False)
    with open(f"{folder}/receivers.csv", encoding="utf-8", newline="") as file:
        receivers = list(csv.DictReader(file))
    receivers = random.Random(7).sample(receivers, min(1000, len(receivers)))
    places = np.array([[float(row[axis]) for axis in ("x", "y", "z")] for row in receivers]) - origin
    normals = np.array([[float(row[axis]) for axis in ("nx", "ny", "nz")] for row in receivers])
    found = []
    for day in DAYS:
        start = pd.Timestamp(f"{day} 00:00", tz="Etc/GMT-1") + pd.Timedelta(seconds=STEP_S / 2)
        times = pd.date_range(start, periods=86_400 // STEP_S, freq=f"{STEP_S}s")
        suns = pvlib.solarposition.spa_python(times, latitude, longitude, altitude=0)
        azimuth, altitude = np.radians(suns["azimuth"].to_numpy()), np.radians(suns["elevation"].to_numpy())
        level = np.cos(altitude)
        directions = np.stack([level * np.sin(azimuth), level * np.cos(azimuth), np.sin(altitude)], axis=1)
        minutes = np.zeros(len(receivers))
        for sun in directions[altitude > 0.0]:
            front = np.flatnonzero(normals @ sun > 0.0)
            minutes[front] += ~scene.ray.intersects_any(places[front], np.repeat(sun[None], len(front), axis=0)) * (STEP_S / 60.0)
        found.extend((day[5:], row["receiver"], of) for row, of in zip(receivers, minutes, strict=True))
    judged = pd.DataFrame(found, columns=["date", "receiver", "judged"])
    for name, words in (("bits", "by the textures"), ("rays", "with --exact")):
        both = judged.merge(pd.read_csv(f"{folder}/{name}.csv"), on=["date", "receiver"])
        off = (both.sun_minutes - both.judged).abs()
        beyond = (off > both.uncertain_minutes + 1.0).mean()
        print(
            f"{words}: {len(both)} days, {100.0 * (off <= 1.0).mean():.1f} % within a minute, 95 % within {off.quantile(0.95):.2f}, "
            f"{100.0 * beyond:.2f} % off by a minute more than is stated, {both.uncertain_minutes.median():.2f} minutes stated in the median"
        )


if __name__ == "__main__":
    main()
