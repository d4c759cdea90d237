"""The ground among black rows without end: what it sees of an even sky beside pvlib's `bifacial.utils.vf_ground_sky_2d`, and its shade under suns beside
the shadows of the rows' edges, at positions across the middle pitch."""

import math

import numpy as np
from pvlib.bifacial import utils

import ours
import rows

SLOPE, WIDE = rows.SLOPE, rows.WIDE
# Tilt, pitch, clearance.
CASES = ((30, 5.0, 1.0), (20, 8.0, 2.5), (90, 10.0, 0.8))
# Azimuth and altitude of suns; rows look south.
SUNS = ((180, 60), (220, 40), (300, 20))
PLACES = 20


def by_pvlib(tilt, pitch, clearance, behind):
    """View factors of the sky at distances behind the lower edge; pvlib counts from the middle of a row."""
    half = 0.5 * SLOPE * np.array([math.cos(math.radians(tilt)), math.sin(math.radians(tilt))])
    return utils.vf_ground_sky_2d(tilt, SLOPE / pitch, (behind - half[0]) / pitch, pitch, clearance + half[1], max_rows=60)[:, 0]


def shaded(tilt, pitch, clearance, behind, sun):
    """Which distances lie in the rows' shade, and how far each is from its ends."""
    azimuth, altitude = map(math.radians, sun)
    reach = math.cos(azimuth - math.pi) / math.tan(altitude)
    ends = [[y + z * reach for y, z in row] for row in rows.strips(tilt, pitch, clearance, 60)]
    hidden = np.array([any(min(row) <= y <= max(row) for row in ends) for y in behind])
    return hidden, np.array([min(abs(end - y) for row in ends for end in row) for y in behind])


def ours_of(case, out):
    """The middle pitch, place by place: distance behind the edge, share of the open sky, light of each sun over that on level ground."""
    tilt, pitch, clearance = case
    (out / "field.toml").write_text('[grass]\ndiffuse = 0\nclass = "ground"\n[endless_ground]\ndiffuse = 0\n')
    deep, step = 33 * pitch, pitch / PLACES

    def of(name, west, east, more=""):
        area = f"[[{west}, {-deep / 2}], [{east}, {-deep / 2}], [{east}, {deep / 2}], [{west}, {deep / 2}]]"
        return (
            f'[[rows]]\nname = "{name}"\narea = {area}\ntilt = {tilt}\nazimuth = 180\npitch = {pitch}\nwidth = {east - west}\nheight = {SLOPE}\n'
            f"clearance = {clearance}\nthickness = 0.001\nfront = 0\nrear = 0\nsamples = 1\n{more}")

    # Receivers on the ground in a strip as wide as their distance only.
    text = of("west", -WIDE / 2, -step / 2) + of("middle", -step / 2, step / 2, f"ground = {step}\n") + of("east", step / 2, WIDE / 2)
    (out / "rows.toml").write_text(text)
    (out / "even.csv").write_text("time,ghi,dni,dhi\n" + "".join(f"2019-06-21T{h:02}:00+01:00,700,0,700\n" for h in range(9, 15)))
    seconds = ours.run(
        "pv", out / "field.obj", "-m", out / "field.toml", "--latitude", 50, "--longitude", 15, "-w", out / "even.csv", "--rows", out / "rows.toml",
        "--sky", "uniform", "--no-hourly", "--replace", "--quality", "fine", "-o", out / "pv")
    places = ours.table(out / "pv/ground.csv")
    middle = places[len(places) // 2 // PLACES * PLACES:][:PLACES]
    names = [row["receiver"] for row in middle]
    (out / "suns.csv").write_text(
        "condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2\n" + "".join(f"{i},{azimuth},{altitude},1000,0\n" for i, (azimuth, altitude) in enumerate(SUNS)))
    ours.run("replay", out / "pv/site.helio", "--conditions", out / "suns.csv", "--receivers", out / "pv/ground.csv", "--columns", "total", "-o", out / "lit.csv")
    lit = {(row["condition"], row["receiver"]): float(row["total"]) for row in ours.table(out / "lit.csv")}
    of_suns = [[lit[str(i), name] / 1000 / math.sin(math.radians(altitude)) for name in names] for i, (_, altitude) in enumerate(SUNS)]
    of_sky = np.array([float(row["total_kwh_m2"]) for row in middle]) / 4.2
    return np.array([float(row["behind_m"]) for row in middle]), of_sky, np.array(of_suns), len(places), seconds


def main():
    out = ours.folder("ground")
    ours.square(out / "field.obj", 300.0)
    for case in CASES:
        tilt, pitch, clearance = case
        behind, of_sky, of_suns, count, seconds = ours_of(case, out)
        theirs = by_pvlib(tilt, pitch, clearance, behind)
        off = of_sky - theirs
        print(f"tilt {tilt}, pitch {pitch} m, clearance {clearance} m: {count} places, {PLACES} a pitch, {seconds:.1f} s")
        print(f"  sky: {off.min():+.4f} to {off.max():+.4f}, RMS {np.sqrt((off ** 2).mean()):.4f}; mean {of_sky.mean():.4f}, pvlib {theirs.mean():.4f}")
        for place in range(0, PLACES, 2):
            print(f"  {behind[place]:6.3f} m: {of_sky[place]:.4f}, pvlib {theirs[place]:.4f}, {off[place]:+.4f}")
        for sun, found in zip(SUNS, of_suns):
            hidden, from_end = shaded(tilt, pitch, clearance, behind, sun)
            clear = from_end > 0.02
            wrong = ((found < 0.5) != hidden)[clear].sum()
            print(
                f"  sun {sun[0]} / {sun[1]}: {(found < 0.5).sum()} of {PLACES} places in shade, {hidden.sum()} by edges; {wrong} of {clear.sum()} wrong more than 2 cm from an end; "
                f"lit ones {found[found >= 0.5].min(initial=2):.4f} to {found[found >= 0.5].max(initial=0):.4f}")


if __name__ == "__main__":
    main()
