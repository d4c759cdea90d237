#!/usr/bin/env python3
"""The reference path tracer beside Mitsuba 3, an independent engine: are their differences no larger than their noise?

    second_engine.py HELIOTILE FOLDER [SITE ...] [--receivers N] [--suns N] [--paths N]

FOLDER holds sites as `sites.py` and `draw.py` write them, without mirrors and leaves. Each engine gives the irradiance of the same receivers, from the
same suns (discs of 0.267 degrees) and from a uniform sky, by component, with the standard error of its own noise. A difference over both errors is z.

For each component: number of values, mean of z times the root of their number (z of the mean), RMS of z, largest |z|, difference of the means in percent.
z of the mean would be beyond 4 by chance in 1 of 16,000 such tests. The RMS of n values has a deviation of 0.7 / sqrt(n); errors of few batches raise it
to about 1.2, so its limit is 1.2 + 3 / sqrt(n). The exit code is 1 beyond either.
"""
import argparse
import csv
import math
import os
import random
import sys
import tempfile

import mitsuba as mi

from rungs import build, rows, scene_of
from targets import run

SUN_RADIUS = math.radians(0.2667)
DNI, DHI = 800.0, 200.0
BATCHES = 16
COMPONENTS = ("sun_direct", "sky_direct", "sun_reflected", "sky_reflected")


def meshes(at, scratch):
    """The faces of scene.obj by material, as Mitsuba's shapes of matt surfaces."""
    import tomllib
    with open(f"{at}/materials.toml", "rb") as text:
        materials = tomllib.load(text)
    vertices, faces, name = [], {}, None
    with open(f"{at}/scene.obj") as text:
        for line in text:
            kind, *rest = line.split()
            if kind == "v":
                vertices.append(line)
            elif kind == "usemtl":
                name = rest[0]
            elif kind == "f":
                faces.setdefault(name, []).append(line)
    shapes = {}
    for name, lines in faces.items():
        material = materials[name]
        if "specular" in material or "transmittance" in material:
            sys.exit(f"{at}: {name} is no matt surface")
        with open(f"{scratch}/{name}.obj", "w") as out:
            out.writelines(vertices + lines)
        matt = {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": material["diffuse"]}}}
        shapes[name] = {"type": "obj", "filename": f"{scratch}/{name}.obj", "face_normals": True, "bsdf": matt}
    return shapes


def to_sun(azimuth_deg, altitude_deg):
    azimuth, altitude = math.radians(azimuth_deg), math.radians(altitude_deg)
    return mi.ScalarVector3f(math.sin(azimuth) * math.cos(altitude), math.cos(azimuth) * math.cos(altitude), math.sin(altitude))


def in_disc(middle, radius, turn):
    """A direction at some share of the radius of the sun's disc."""
    side = mi.ScalarVector3f(middle.y, -middle.x, 0)
    side = side / math.hypot(side.x, side.y)
    other = mi.ScalarVector3f(middle.y * side.z - middle.z * side.y, middle.z * side.x - middle.x * side.z, middle.x * side.y - middle.y * side.x)
    off = math.tan(SUN_RADIUS) * radius
    found = middle + side * (off * math.cos(turn)) + other * (off * math.sin(turn))
    return found / math.sqrt(found.x ** 2 + found.y ** 2 + found.z ** 2)


def meter(receiver):
    """A disc of 1 mm that measures irradiance."""
    place, normal = ([float(receiver[name]) for name in names] for names in (("x", "y", "z"), ("nx", "ny", "nz")))
    up = [0, 0, 1] if abs(normal[2]) < 0.9 else [0, 1, 0]
    turned = mi.ScalarTransform4f().look_at(origin=place, target=[p + n for p, n in zip(place, normal)], up=up)
    film = {"type": "hdrfilm", "width": 1, "height": 1, "pixel_format": "rgb", "component_format": "float32", "filter": {"type": "box"}}
    return {"type": "disk", "to_world": turned @ mi.ScalarTransform4f().scale(1e-3), "sensor": {"type": "irradiancemeter", "film": film}}


def found(values):
    """Mean and its standard error."""
    mean = sum(values) / len(values)
    return mean, math.sqrt(sum((value - mean) ** 2 for value in values) / (len(values) - 1) / len(values))


def mitsuba_irradiance(at, receivers, suns, paths, draw):
    """`{(receiver, condition, component): (W/m2, standard error)}`."""
    light = {}
    with tempfile.TemporaryDirectory() as scratch:
        # No sky below the horizon, wherever the ground ends.
        below = {"type": "disk", "to_world": mi.ScalarTransform4f().translate([0, 0, -60]).scale(1e6), "bsdf": {
            "type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}}}
        shapes = meshes(at, scratch) | {"below": below} | {f"meter_{i}": meter(receiver) for i, receiver in enumerate(receivers)}
        site = lambda emitter, depth=-1, hide=False: mi.load_dict({"type": "scene", "integrator": {
            "type": "path", "max_depth": depth, "hide_emitters": hide}, "emitter": emitter, **shapes}, optimize=False)
        measure = lambda scene, i: float(mi.render(scene, sensor=i, spp=max(1, paths // BATCHES), seed=draw.randrange(1 << 30)).array[0])
        sky = {"type": "constant", "radiance": {"type": "rgb", "value": DHI / math.pi}}
        for name, scene in (("sky_direct", site(sky, 1)), ("sky_reflected", site(sky, -1, True))):
            for i, receiver in enumerate(receivers):
                value = found([measure(scene, i) for _ in range(BATCHES)])
                light |= {(receiver["receiver"], condition, name): value for condition in suns}
        for condition, sun in suns.items():
            middle = to_sun(*sun)
            measured = [[] for _ in receivers]
            for batch in range(BATCHES):
                at_sun = in_disc(middle, math.sqrt((batch + draw.random()) / BATCHES), math.tau * draw.random())
                scene = site({"type": "directional", "direction": [-at_sun.x, -at_sun.y, -at_sun.z], "irradiance": {"type": "rgb", "value": DNI}})
                for i in range(len(receivers)):
                    measured[i].append(measure(scene, i))
            for receiver, values in zip(receivers, measured):
                light[receiver["receiver"], condition, "sun_reflected"] = found(values)
                place, normal = ([float(receiver[name]) for name in names] for names in (("x", "y", "z"), ("nx", "ny", "nz")))
                place = [p + 1e-4 * n for p, n in zip(place, normal)]  # off the meter
                shown = [in_disc(middle, math.sqrt((k + 0.5) / 256), 2.399963 * k) for k in range(256)]
                open_ = [max(0.0, sum(n * d for n, d in zip(normal, to))) * (not scene.ray_test(mi.Ray3f(mi.ScalarPoint3f(place), to))) for to in shown]
                light[receiver["receiver"], condition, "sun_direct"] = DNI * sum(open_) / 256, DNI / 256
    return light


def main(args):
    mi.set_variant("scalar_rgb")
    mi.set_log_level(mi.LogLevel.Error)
    draw, failed = random.Random(5), False
    print(f"{'site':<14}{'component':<16}{'values':>7}{'mean W/m2':>11}{'z of mean':>11}{'RMS z':>7}{'max |z|':>9}{'difference %':>14}")
    for site in args.sites or sorted(os.listdir(args.folder)):
        at = f"{args.folder}/{site}"
        suns = {str(i): (draw.uniform(0, 360), draw.uniform(8, 70)) for i in range(args.suns)}
        with tempfile.TemporaryDirectory() as scratch:
            with open(f"{scratch}/suns.csv", "w") as out:
                out.write("condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2\n")
                out.writelines(f"{name},{azimuth:.9f},{altitude:.9f},{DNI},{DHI}\n" for name, (azimuth, altitude) in suns.items())
            build(args.program, at, f"{scratch}/site.helio", "draft")
            run(args.program, "archive", "audit", f"{scratch}/site.helio", *scene_of(at), "--conditions", f"{scratch}/suns.csv", "--sky", "uniform",
                "--samples", str(args.receivers), "--paths", str(args.paths), "--seed", "3", "-o", f"{scratch}/audit")
            reference = rows(f"{scratch}/audit/audit.csv")
        chosen = {row["receiver"] for row in reference}
        receivers = [row for row in rows(f"{at}/receivers.csv") if row["receiver"] in chosen]
        mitsuba_light = mitsuba_irradiance(at, receivers, suns, args.paths, draw)
        for name in COMPONENTS:
            pairs = [(float(row[f"{name}_reference_w_m2"]), float(row[f"{name}_standard_error_w_m2"]), *mitsuba_light[row["receiver"], row["condition"], name])
                     for row in reference]
            # Light of the sky is the same for all suns.
            pairs = pairs if name.startswith("sun") else list({row["receiver"]: pair for row, pair in zip(reference, pairs)}.values())
            z = [(a - b) / math.hypot(s, t, 1e-3) for a, s, b, t in pairs]
            of_mean, rms = sum(z) / math.sqrt(len(z)), math.sqrt(sum(v * v for v in z) / len(z))
            mean = sum(pair[2] for pair in pairs) / len(pairs)
            off = sum(pair[0] - pair[2] for pair in pairs) / len(pairs) / mean * 100 if mean else 0.0
            failed |= abs(of_mean) > 4 or rms > 1.2 + 3 / math.sqrt(len(z))
            print(f"{site:<14}{name:<16}{len(z):>7}{mean:>11.2f}{of_mean:>+11.2f}{rms:>7.2f}{max(map(abs, z)):>9.2f}{off:>+14.3f}", flush=True)
    sys.exit(failed)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("folder")
    parser.add_argument("sites", nargs="*")
    parser.add_argument("--receivers", type=int, default=24)
    parser.add_argument("--suns", type=int, default=8)
    parser.add_argument("--paths", type=int, default=65536)
    main(parser.parse_args())
