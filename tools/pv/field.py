"""Best turns in an open field at three latitudes: the search, a loop of `replay` over whole degrees, and pvlib's Perez."""

import numpy as np
import pandas as pd
import pvlib

import ours

LATITUDES = (35, 52, 60)
ALBEDO = 0.2
WINDOW = 12


def weather(latitude, path):
    """A year of hours: pvlib's clear sky under clouds drawn day by day, split by Erbs; means of hours from five-minute steps."""
    times = pd.date_range("2019-01-01", "2020-01-01", freq="5min", inclusive="left", tz="Etc/GMT-1") + pd.Timedelta("150s")
    place = pvlib.location.Location(latitude, 15.0, "Etc/GMT-1", 0)
    sun = place.get_solarposition(times)
    clear = place.get_clearsky(times, "ineichen", solar_position=sun, linke_turbidity=3.0)["ghi"]
    draw = np.random.default_rng(latitude)
    days = draw.beta(1.6, 0.9, 366)
    ghi = clear * np.clip(days[times.dayofyear - 1] * draw.uniform(0.85, 1.15, len(times)), 0.08, 1.0)
    split = pvlib.irradiance.erbs(ghi, sun["zenith"], times)
    hours = pd.DataFrame({"ghi": ghi, "dni": split["dni"], "dhi": split["dhi"]}).fillna(0.0)
    hours = hours.resample("1h").mean()
    # The three fit together: DHI is what GHI has beside the sun at the middle of the hour.
    middle = place.get_solarposition(hours.index + pd.Timedelta("30min"))
    cos = np.cos(np.radians(middle["zenith"].to_numpy())).clip(0)
    hours["dni"] = np.where(cos > 0.02, hours["dni"], 0.0)
    hours["ghi"] = hours["dhi"] + hours["dni"] * cos
    hours.index = hours.index.map(lambda time: time.isoformat(timespec="minutes"))
    hours.round(3).to_csv(path, index_label="time")
    return pd.read_csv(path)


def by_pvlib(hours, latitude):
    """Best tilt and azimuth by pvlib's Perez over whole degrees, then a parabola; the sun at the middle of each hour."""
    times = pd.DatetimeIndex(hours["time"]) + pd.Timedelta("30min")
    sun = pvlib.solarposition.get_solarposition(times, latitude, 15.0, 0)
    extra = pvlib.irradiance.get_extra_radiation(times)
    zenith = sun["zenith"].to_numpy()
    mass = pvlib.atmosphere.get_relative_airmass(zenith)

    def total(tilt, azimuth):
        found = pvlib.irradiance.get_total_irradiance(
            tilt, azimuth, zenith, sun["azimuth"].to_numpy(), hours["dni"].to_numpy(), hours["ghi"].to_numpy(), hours["dhi"].to_numpy(),
            dni_extra=extra.to_numpy(), airmass=mass, albedo=ALBEDO, model="perez")
        return np.nansum(found["poa_global"]) / 1000

    tilt, azimuth = 35.0, 180.0
    for step in (8, 4, 2, 1, 0.5, 0.25, 0.1):
        around = [(total(tilt + a * step, azimuth + b * step), tilt + a * step, azimuth + b * step) for a in range(-3, 4) for b in range(-3, 4)]
        _, tilt, azimuth = max(around)
    return tilt, azimuth, total(tilt, azimuth)


def search(latitude, sky):
    """The search's row, and its seconds."""
    out = ours.folder("field")
    seconds = ours.run(
        "pv", out / "field.obj", "-m", out / "field.toml", "--latitude", latitude, "--longitude", 15, "-w", out / f"{latitude}.csv",
        "--time-zone", "+01:00", "--points", out / "points.csv", "--search", "--sky", sky, "--no-hourly", "--replace", "-o", out / f"{latitude}.pv")
    return ours.table(out / f"{latitude}.pv/best.csv")[0], seconds


def loop(latitude, sky, best):
    """All turns of whole degrees near the best as receivers of one archive, replayed: the best of them, and that of a smooth surface."""
    out = ours.folder("field")
    tilt, azimuth = round(float(best["tilt_deg"])), round(float(best["azimuth_deg"]))
    turns = [(t, a % 360) for t in range(tilt - WINDOW, tilt + WINDOW + 1) for a in range(azimuth - WINDOW, azimuth + WINDOW + 1)]
    rows = "".join(f"{t}_{a},{3 * (i % 30)},{3 * (i // 30)},1,{t},{a}\n" for i, (t, a) in enumerate(turns))
    (out / "loop.csv").write_text(f"receiver,x,y,z,tilt_deg,azimuth_deg\n{rows}")
    site = out / "loop.helio"
    site.unlink(missing_ok=True)
    seconds = ours.run("build", out / "field.obj", "-m", out / "field.toml", "--latitude", latitude, "--longitude", 15, "-r", out / "loop.csv", "-o", site)
    seconds += ours.run("replay", site, "-w", out / f"{latitude}.csv", "--time-zone", "+01:00", "--sky", sky, "--every", "total", "-o", out / "loop.total.csv")
    found = {row["receiver"]: float(row["total_kwh_m2"]) for row in ours.table(out / "loop.total.csv")}
    best = max(found, key=found.get)
    return [float(part) for part in best.split("_")], found[best], len(turns), seconds


def off(a, b):
    """Angle between two turns, degrees."""
    def normal(turn):
        tilt, azimuth = np.radians(turn)
        return np.array([np.sin(tilt) * np.sin(azimuth), np.sin(tilt) * np.cos(azimuth), np.cos(tilt)])
    return np.degrees(np.arccos(np.clip(normal(a) @ normal(b), -1, 1)))


def main():
    out = ours.folder("field")
    ours.square(out / "field.obj")
    (out / "field.toml").write_text(f'[grass]\ndiffuse = {ALBEDO}\nclass = "ground"\n[endless_ground]\ndiffuse = {ALBEDO}\n')
    (out / "points.csv").write_text("point,x,y,height,tilt,azimuth\nfield,0,0,1,,\n")
    for latitude in LATITUDES:
        hours = weather(latitude, out / f"{latitude}.csv")
        tilt, azimuth, total = by_pvlib(hours, latitude)
        print(f"latitude {latitude}: pvlib's Perez {tilt:.1f} / {azimuth:.1f}, {total:.2f} kWh/m2")
        for sky in ("perez1990", "perez"):
            best, seconds = search(latitude, sky)
            turn, sum_ = [float(best["tilt_deg"]), float(best["azimuth_deg"])], float(best["total_kwh_m2"])
            looped, most, count, taken = loop(latitude, sky, best)
            print(
                f"  {sky:10} search {turn[0]:.2f} / {turn[1]:.2f}, {sum_:.2f} kWh/m2, {seconds:.1f} s; loop of {count} turns {looped[0]:.0f} / {looped[1]:.0f}, "
                f"{most:.2f} kWh/m2, {taken:.1f} s: {off(turn, looped):.2f} degrees and {100 * (sum_ / most - 1):+.4f} % apart; "
                f"pvlib {off(turn, (tilt, azimuth)):.2f} degrees, {100 * (sum_ / total - 1):+.3f} %")
