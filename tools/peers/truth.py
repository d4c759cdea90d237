"""Reference by `rtrace`. In: a scene, some of its receivers, conditions. Out: `Truth`, kept in the work folder under the hash
of all that goes in.

Per condition, all with -I+, no ambient cache and no random number shared between conditions:

- direct sun, mirrored included: -ab 0, the disc as 512 small suns;
- sky, mirrored included: -ab 1, sky only;
- all: -ab 8, sky and sun. The sun is a point in it for rays from the receiver itself (-dj 0), so that its direct part, known by
  a run with -ab 0, can be taken off and the one of the whole disc be put in its place without noise."""
import hashlib
import random
from dataclasses import dataclass

import numpy as np

import programs
import sky

SMALL_SUNS = 512
EDGE_RAD = np.radians(0.4)
COMMON = ["rtrace", "-h", "-faa", "-I+", "-w", "-dt", "0", "-dc", "1", "-dj", "0", "-ds", "0", "-dr", "2", "-aa", "0",
          "-as", "0", "-lr", "12", "-lw", "1e-12", "-n", "1"]
VERSION = 1


@dataclass
class Truth:
    """W/m2, [condition][receiver]; `error` is the standard error of `total` from its batches; `near_edge`: more or less of a
    disc of 0.4 degrees around the sun is seen than its centre says."""
    total: np.ndarray
    error: np.ndarray
    sun: np.ndarray
    sky: np.ndarray
    near_edge: np.ndarray
    cpu_s: float


def sky_views(scene, folder):
    """Share of a uniform sky's horizontal irradiance that each receiver gets straight from it, mirrors included."""
    path = folder / "uniform.rad"
    path.write_text("void glow g\n0\n0\n4 1 1 1 0\n\ng source sky\n0\n0\n4 0 0 1 180\n")
    programs.run(["oconv", "scene.rad", "uniform.rad"], folder, to="uniform.oct")
    command = [*COMMON, "-ab", "1", "-ad", "4096", "uniform.oct"]
    out, _ = programs.run(command, folder, programs.lines(scene.points))
    return parsed(out) / np.pi


def parsed(out):
    return np.array([float(line.split()[0]) for line in out.split(b"\n") if line.strip()])


def sampled(octree, options, points, batches, seed, folder):
    """[batch][point]: the points in another order in each batch, for the sequence of random numbers is the same in each run."""
    draw, order = random.Random(seed), []
    for _ in range(batches):
        order.append(draw.sample(range(len(points)), len(points)))
    lead = draw.randrange(1, 50)
    rows = [points[0]] * lead + [points[i] for batch in order for i in batch]
    out, cpu = programs.run([*COMMON, *options, octree], folder, programs.lines(rows))
    values = parsed(out)[lead:].reshape(batches, len(points))
    result = np.empty_like(values)
    for b, batch in enumerate(order):
        result[b, batch] = values[b]
    return result, cpu


def one(scene, points, c, seed, divisions, batches, folder):
    """(total, error, sun, sky, near_edge, cpu) of one condition."""
    (folder / "sky.cal").write_text(sky.SKY_CAL)
    (folder / "now_sky.rad").write_text(sky.sky_text(c))
    whole = c.dni_w_m2 / sky.solid_angle(sky.SUN_RADIUS_RAD)
    (folder / "now_sun.rad").write_text(sky.sun_text(c.sun(), whole, sky.SUN_RADIUS_RAD))
    small = sky.SUN_RADIUS_RAD / 100
    for name, radius in (("disc", sky.SUN_RADIUS_RAD), ("edge", EDGE_RAD)):
        part = c.dni_w_m2 / SMALL_SUNS / sky.solid_angle(small)
        suns = [sky.sun_text(d, part, small, f"s{i}") for i, d in enumerate(sky.disc(c, radius, SMALL_SUNS))]
        (folder / f"now_{name}.rad").write_text("".join(suns))
    values, cpu = {}, 0.0
    for name, sources, options, count in (
        ("disc", ["now_disc.rad"], ["-ab", "0"], 1),
        ("edge", ["now_edge.rad"], ["-ab", "0"], 1),
        ("point", ["now_sun.rad"], ["-ab", "0"], 1),
        ("sky", ["now_sky.rad"], ["-ab", "1", "-ad", 2 * divisions], batches),
        ("all", ["now_sky.rad", "now_sun.rad"] if c.dni_w_m2 > 0 else ["now_sky.rad"], ["-ab", "8", "-ad", divisions], batches),
    ):
        if c.dni_w_m2 <= 0 and name in ("disc", "edge", "point"):
            values[name] = np.zeros((1, len(points)))
            continue
        _, used = programs.run(["oconv", "-i", "scene.oct", *sources], folder, to="now.oct")
        values[name], more = sampled("now.oct", options, points, count, f"{name}{seed}", folder)
        cpu += used + more
    disc, edge, point = (values[name][0] for name in ("disc", "edge", "point"))
    total = values["all"].mean(axis=0) - point + disc
    error = values["all"].std(axis=0, ddof=1) / np.sqrt(batches)
    near = np.abs(edge - point) > 0.003 * c.dni_w_m2
    return total, error, disc, values["sky"].mean(axis=0), near, cpu


def truth(scene, chosen, conditions, divisions, batches, folder):
    """The reference of the receivers `chosen` (indices), from the cache if it is there."""
    key = hashlib.sha256(repr((VERSION, scene.digest(), chosen, conditions, divisions, batches)).encode()).hexdigest()[:16]
    kept = folder / f"truth-{key}.npz"
    if not kept.exists():
        programs.run(["oconv", "-f", "scene.rad"], folder, to="scene.oct")
        points = [scene.points[i] for i in chosen]
        rows = []
        for i, c in enumerate(conditions):
            rows.append(one(scene, points, c, i, divisions, batches, folder))
            print(f"  truth {i + 1}/{len(conditions)} {c.name}: {rows[-1][5]:.1f} CPU-s, standard error "
                  f"{100 * rows[-1][1].mean() / rows[-1][0].mean():.2f} %", flush=True)
        total, error, sun, sky_only, near, cpu = (np.array(v) for v in zip(*rows))
        np.savez(kept, total=total, error=error, sun=sun, sky=sky_only, near_edge=near, cpu_s=cpu.sum())
    found = np.load(kept)
    return Truth(*(found[name] for name in ("total", "error", "sun", "sky", "near_edge")), float(found["cpu_s"]))
