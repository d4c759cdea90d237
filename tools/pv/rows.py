"""Bifacial rows on endless ground under an even sky: heliotile beside view factors of infinite rows."""

import math

import numpy as np

import ours

SLOPE, WIDE = 2.0, 300.0
CASES = ((30, 5.0, 1.0, 0.2), (30, 3.0, 0.5, 0.6), (90, 6.0, 0.3, 0.4), (10, 4.0, 2.0, 0.3))


def strips(tilt, pitch, clearance, count):
    """Ends of the rows in a cut from south to north: lower edge, upper edge; the rear of a module is its front."""
    dy, dz = SLOPE * math.cos(math.radians(tilt)), SLOPE * math.sin(math.radians(tilt))
    return [((k * pitch, clearance), (k * pitch + dy, clearance + dz)) for k in range(-count, count + 1)]


def sky_share(y, z, normal, rows, skip=None, angles=20000):
    """View factor of a point and a direction to what is not rows and above the horizon, and the directions to the ground that is seen: `[angle]` of
    the cut. For infinite rows the share of an angle is half the cosine off the normal."""
    phi = (np.arange(angles) + 0.5) / angles * 2 * np.pi
    weight = np.clip(np.cos(phi - normal), 0, None) * np.pi / angles
    nearest = np.full(angles, False)
    for k, ((y0, z0), (y1, z1)) in enumerate(rows):
        if k == skip:
            continue
        a, b = math.atan2(z0 - z, y0 - y), math.atan2(z1 - z, y1 - y)
        width = (b - a + np.pi) % (2 * np.pi) - np.pi
        low, width = (a, width) if width >= 0 else (b, -width)
        nearest |= (phi - low) % (2 * np.pi) < width
    return phi, weight, nearest


def ground_light(y, rows, angles=20000):
    """Share of the sky that a place of the ground sees."""
    phi, weight, met = sky_share(y, 0.0, np.pi / 2, rows, angles=angles)
    return weight[~met & (phi < np.pi)].sum()


def expected(tilt, pitch, clearance, albedo):
    """Front and rear of the middle row, sky of 1; modules are black."""
    count = 60
    rows = strips(tilt, pitch, clearance, count)
    ys = (np.arange(400) + 0.5) / 400 * pitch
    of_ground = np.array([ground_light(y, rows) for y in ys])
    (y0, z0), (y1, z1) = rows[count]
    found = []
    for normal in (math.radians(90 + tilt), math.radians(270 + tilt)):
        total = 0.0
        samples = 200
        for i in range(samples):
            share = (i + 0.5) / samples
            y, z = y0 + share * (y1 - y0), z0 + share * (z1 - z0)
            phi, weight, met = sky_share(y, z, normal, rows, skip=count)
            # A ray to the ground is met by rows that stand between only: those of the cut are found above; all rows stand above the ground.
            up = phi < np.pi
            total += weight[up & ~met].sum()
            down = ~up & ~met
            hit = y + z / np.tan(2 * np.pi - phi[down])
            total += albedo * (weight[down] * np.interp(hit % pitch, ys, of_ground, period=pitch)).sum()
        found.append(total / samples)
    return found


def front_sky(tilt, pitch):
    """The front's view of the sky by Hottel's crossed strings: the row before it and the sky close the gap."""
    beta = math.radians(tilt)
    dy, dz = SLOPE * math.cos(beta), SLOPE * math.sin(beta)
    # From the module's two edges to the upper edge of the row before it, and over to its own upper edge.
    to_upper, to_lower = pitch, math.hypot(pitch - dy, dz)
    return (SLOPE + to_upper - to_lower) / (2 * SLOPE)


def main():
    out = ours.folder("rows")
    ours.square(out / "field.obj", 200.0)
    (out / "even.csv").write_text("time,ghi,dni,dhi\n" + "".join(f"2019-06-21T{h:02}:00+01:00,700,0,700\n" for h in range(9, 15)))
    for tilt, pitch, clearance, albedo in CASES:
        (out / "field.toml").write_text(f'[grass]\ndiffuse = {albedo}\nclass = "ground"\n[endless_ground]\ndiffuse = {albedo}\n')
        deep = 32 * pitch + SLOPE
        (out / "rows.toml").write_text(
            f'[[rows]]\nname = "r"\narea = [[-150, -{deep / 2}], [150, -{deep / 2}], [150, {deep / 2}], [-150, {deep / 2}]]\ntilt = {tilt}\nazimuth = 180\n'
            f"pitch = {pitch}\nwidth = {WIDE}\nheight = {SLOPE}\nclearance = {clearance}\nthickness = 0.001\nfront = 0\nrear = 0\nsamples = 8\n")
        seconds = ours.run(
            "pv", out / "field.obj", "-m", out / "field.toml", "--latitude", 50, "--longitude", 15, "-w", out / "even.csv", "--rows", out / "rows.toml",
            "--sky", "uniform", "--no-hourly", "--replace", "--quality", "fine", "-o", out / "pv")
        table = ours.table(out / "pv/points.csv")
        names = sorted({row["point"] for row in table}, key=lambda name: int(name.split("/")[1]))
        middle = names[len(names) // 2]
        ours_ = {row["side"]: float(row["total_kwh_m2"]) / 4.2 for row in table if row["point"] == middle}
        front, rear = expected(tilt, pitch, clearance, albedo)
        print(
            f"tilt {tilt}, pitch {pitch} m, clearance {clearance} m, albedo {albedo}: front {ours_['front']:.4f}, view factors {front:.4f} ({100 * (ours_['front'] / front - 1):+.2f} %); "
            f"rear {ours_['rear']:.4f}, {rear:.4f} ({100 * (ours_['rear'] / rear - 1):+.2f} %); {len(names)} rows, {seconds:.1f} s")
