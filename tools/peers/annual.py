"""Radiance's annual method. In: a scene, conditions, a weather file. Out: totals [condition][receiver] and CPU seconds as for a
year.

    total = all x (sky + sun in patches) - straight x (sun in patches) + suns x DNI

`all` are coefficients of sky patches with -ab 8, `straight` with -ab 1, both by `rfluxmtx`; `suns` those of the suns where they
stand, by `rcontrib` with -ab 0. So the sun's direct light is exact, and its reflected light comes from patches. For the errors
the sky and sun matrices are those of the conditions, averaged over patches here; for the cost `gendaymtx` and `dctimestep` run
over the year and `rcontrib` over its suns."""
import hashlib
import math
from dataclasses import dataclass

import numpy as np

import programs
import sky

BOUNCES = 8
VERSION = 1


@dataclass
class Annual:
    """`total` W/m2 [condition][receiver]; CPU seconds of the whole scene: coefficients of the sky, of the year's suns, and its
    time steps."""
    total: np.ndarray
    trace_s: float
    suns_s: float
    year_s: float


def rows_of(mf):
    """(altitude of the lower edge, of the upper edge, patches) of each row of Reinhart's sky, radians."""
    alpha = math.radians(90 / (7 * mf + 0.5))
    counts = [mf * n for n in (30, 30, 24, 24, 18, 12, 6) for _ in range(mf)] + [1]
    return [(i * alpha, min((i + 1) * alpha, math.pi / 2), n) for i, n in enumerate(counts)]


def patches(mf):
    """Centres [patch][3], solid angles and sets of directions of the patches, in the order of `rfluxmtx`."""
    centres, angles, inside = [], [], []
    for low, high, count in rows_of(mf):
        last = count == 1
        z = math.sin(low) + (np.arange(16) + 0.5) / 16 * (math.sin(high) - math.sin(low))
        for k in range(count):
            width = 2 * math.pi / count
            spread = (np.arange(64 if last else 16) + 0.5) / (64 if last else 16) - 0.5
            inside.append(sky.grid(z, (k + spread) * width).reshape(-1, 3))
            centres.append([0, 0, 1] if last else sky.grid(np.array([math.sin((low + high) / 2)]), np.array([k * width]))[0, 0])
            angles.append((math.sin(high) - math.sin(low)) * width)
    return np.array(centres), np.array(angles), inside


def matrices(conditions, mf):
    """Sky and sun as radiances of patches, [patch][condition]; the sun goes to the four nearest as in gendaymtx."""
    centres, angles, inside = patches(mf)
    of_sky, of_sun = np.zeros((len(angles), len(conditions))), np.zeros((len(angles), len(conditions)))
    for j, c in enumerate(conditions):
        level = sky.level(c)
        of_sky[:, j] = [level * sky.relative(c, d).mean() for d in inside]
        near = centres @ c.sun()
        four = np.argsort(near)[-4:]
        weight = 1 / (1.002 - near[four])
        of_sun[four, j] = c.dni_w_m2 * weight / weight.sum() / angles[four]
    return of_sky, of_sun


def coefficients(scene, mf, bounces, divisions, name, folder):
    """Writes `name`; returns [receiver][patch] without the ground, and CPU seconds."""
    kinds = {"ground": ("h=u", -1), "sky": (f"h=r{mf}", 1)}
    text = [f"#@rfluxmtx {kind} u=+Y\nvoid glow {n}_glow\n0\n0\n4 1 1 1 0\n\n{n}_glow source {n}\n0\n0\n4 0 0 {up} 180\n"
            for n, (kind, up) in kinds.items()]
    (folder / "sources.rad").write_text("\n".join(text))
    command = ["rfluxmtx", "-I+", "-faf", "-n", "1", "-ab", bounces, "-ad", divisions, "-lw", f"{0.2 / divisions:g}",
               "-y", len(scene.points), "-", "sources.rad", "scene.rad"]
    _, cpu = programs.run(command, folder, programs.lines(scene.points), to=name)
    return programs.matrix((folder / name).read_bytes(), len(scene.points))[:, 1:], cpu


def suns(scene, sources, modifiers, folder):
    """Coefficients of real suns [receiver][sun], and CPU seconds."""
    programs.run(["oconv", "scene.rad", sources], folder, to="suns.oct")
    command = ["rcontrib", "-I+", "-faf", "-n", "1", "-ab", "0", "-lw", "1e-4", "-dc", "1", "-dt", "0", "-dj", "0", "-ds", "0",
               "-M", modifiers, "-y", len(scene.points), "suns.oct"]
    data, cpu = programs.run(command, folder, programs.lines(scene.points))
    return programs.matrix(data, len(scene.points)), cpu


def exact(scene, conditions, folder):
    """Direct sun W/m2 [condition][receiver] at the conditions, discs as points."""
    lit = [(j, c) for j, c in enumerate(conditions) if c.dni_w_m2 > 0]
    part = 1 / sky.solid_angle(sky.SUN_RADIUS_RAD)
    text = [sky.sun_text(c.sun(), part, sky.SUN_RADIUS_RAD, f"sun{j}") for j, c in lit]
    (folder / "few.rad").write_text("".join(text))
    (folder / "few.mod").write_text("".join(f"sun{j}\n" for j, _ in lit))
    found, _ = suns(scene, "few.rad", "few.mod", folder)
    out = np.zeros((len(conditions), len(scene.points)))
    for k, (j, c) in enumerate(lit):
        out[j] = found[:, k] * part * c.dni_w_m2
    return out


def year_of_suns(scene, weather, folder):
    """CPU seconds of the direct light of all suns of the year."""
    programs.run(["epw2wea", weather, "year.wea"], folder)
    programs.run(["gendaymtx", "-d", "-O1", "-of", "-D", "year.rad", "-M", "year.mod", "year.wea"], folder, to="unused.mtx")
    return suns(scene, "year.rad", "year.mod", folder)[1]


def annual(scene, conditions, mf, divisions, weather, folder):
    """Totals and costs of one setting, from the work folder if they are there."""
    key = hashlib.sha256(repr((VERSION, scene.digest(), conditions, mf, divisions)).encode()).hexdigest()[:16]
    kept = folder / f"annual-{key}.npz"
    if not kept.exists():
        found = measured(scene, conditions, mf, divisions, weather, folder)
        np.savez(kept, **vars(found))
    found = np.load(kept)
    return Annual(found["total"], *(float(found[name]) for name in ("trace_s", "suns_s", "year_s")))


def measured(scene, conditions, mf, divisions, weather, folder):
    """Runs everything."""
    sun, suns_s = exact(scene, conditions, folder), year_of_suns(scene, weather, folder)
    every, cpu_all = coefficients(scene, mf, BOUNCES, divisions, "all.mtx", folder)
    straight, cpu_straight = coefficients(scene, mf, 1, divisions, "straight.mtx", folder)
    of_sky, of_sun = matrices(conditions, mf)
    total = (every @ (of_sky + of_sun) - straight @ of_sun).T + sun
    year = 0.0
    for name, more, coefficient in (("both", [], "all.mtx"), ("sun", ["-d"], "straight.mtx")):
        command = ["gendaymtx", "-m", mf, "-g", "0", "0", "0", "-O1", "-of", *more, "year.wea"]
        year += programs.run(command, folder, to=f"{name}.smx")[1]
        year += programs.run(["dctimestep", "-of", coefficient, f"{name}.smx"], folder, to="result.mtx")[1]
        (folder / f"{name}.smx").unlink()
    (folder / "result.mtx").unlink()
    return Annual(total, cpu_all + cpu_straight, suns_s, year)
