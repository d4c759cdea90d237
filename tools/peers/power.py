"""Energy of arrays on an open plain beside pvlib and SAM. In: the year of tests/data/weather. Out: a table; exit code 1 beyond a limit."""
import json
import os
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pandas as pd
from pvlib import iam, inverter, iotools, irradiance, location, modelchain, pvsystem, temperature
from scipy.interpolate import RegularGridInterpolator

warnings.filterwarnings("ignore")
ROOT = Path(__file__).resolve().parents[2]
PROGRAM = Path(os.environ.get("HELIOTILE", ROOT / "target/release/heliotile")).resolve()
WORK = ROOT / "target/peers/power"
WEATHER = ROOT / "tests/data/weather/golden_tmy3.epw"
SAPM = temperature.TEMPERATURE_MODEL_PARAMETERS["sapm"]
OPEN, ROOF = SAPM["open_rack_glass_polymer"], SAPM["close_mount_glass_glass"]
KWP, GAMMA, LOSSES, EFFICIENCY, RATIO, ALBEDO = 4.0, -0.0047, 14.0, 0.96, 1.1, 0.2
INVERTER = {"pdc0": 1000 * KWP / RATIO / EFFICIENCY, "eta_inv_nom": EFFICIENCY}
# Tilt, azimuth, mounting.
ARRAYS = [(35, 180, "open"), (35, 180, "roof"), (10, 90, "open"), (60, 250, "open")]


def formulas():
    """Values for the unit test."""
    for angle in (0, 50, 70, 85, 89):
        print("iam.physical", angle, repr(float(iam.physical(angle))))
    for name, parameters in (("open", OPEN), ("roof", ROOF)):
        for case in ((800, 20, 1), (1000, -5, 6)):
            print("sapm_cell", name, case, repr(float(temperature.sapm_cell(*case, **parameters))))
    print("pvwatts_dc", float(pvsystem.pvwatts_dc(700, 45, 1, -0.0035)))
    for dc in (0, 0.02, 0.1, 1, 3.9, 4.1, 5):
        print("inverter.pvwatts", dc, float(inverter.pvwatts(dc, 4 / 0.96, 0.96)))


def run_pv(scene, out, tilt, azimuth, rest=""):
    """Tables of `heliotile pv` of one module on the plain: the year's energy, its months, the hours of light."""
    WORK.mkdir(parents=True, exist_ok=True)
    (WORK / "far.obj").write_text("v 9000 9000 -9\nv 9000.01 9000 -9\nv 9000 9000.01 -9\nusemtl far\nf 1 2 3\n")
    (WORK / "far.toml").write_text(f"[far]\ndiffuse = 0\n[endless_ground]\ndiffuse = {ALBEDO}\n")
    (WORK / "points.csv").write_text(f"point,x,y,z,tilt,azimuth\np,0,0,1,{tilt},{azimuth}\n")
    command = f"{PROGRAM} pv {scene} -m far.toml -w {WEATHER} --points points.csv --sky perez1990 --kwp {KWP} --losses {LOSSES} " \
        f"--temperature-coefficient={100 * GAMMA} --replace -o {out} {rest}"
    subprocess.run(command.split(), cwd=WORK, check=True, capture_output=True)
    return [pd.read_csv(WORK / out / name) for name in ("energy.csv", "energy_months.csv", "hourly.csv")]


def site():
    data, meta = iotools.read_epw(WEATHER)
    data.index = data.index + pd.Timedelta("30min")
    return data, location.Location(meta["latitude"], meta["longitude"], altitude=meta["altitude"])


def by_chain(data, place, tilt, azimuth, thermal):
    """Yearly DC and AC energy and months of AC of ModelChain.with_pvwatts, which computes light by Perez 1990."""
    losses = dict.fromkeys(("shading", "snow", "mismatch", "wiring", "connections", "lid", "nameplate_rating", "age", "availability"), 0)
    system = pvsystem.PVSystem(
        surface_tilt=tilt, surface_azimuth=azimuth, albedo=ALBEDO, inverter_parameters=INVERTER, temperature_model_parameters=thermal,
        module_parameters={"pdc0": 1000 * KWP, "gamma_pdc": GAMMA}, losses_parameters=losses | {"soiling": LOSSES})
    chain = modelchain.ModelChain.with_pvwatts(system, place)
    chain.run_model(data[["ghi", "dni", "dhi", "temp_air", "wind_speed"]])
    dc, ac = chain.results.dc.fillna(0) / 1000, chain.results.ac.fillna(0) / 1000
    return dc.sum(), ac.sum(), ac.groupby(ac.index.month).sum().to_numpy()


def by_functions(data, place, tilt, azimuth, thermal, hours):
    """Yearly AC energy of the light of `heliotile pv` through pvlib's functions; the sun in the middle of each hour."""
    sun = place.get_solarposition(data.index)
    aoi = irradiance.aoi(tilt, azimuth, sun.apparent_zenith, sun.azimuth).to_numpy()
    cell = temperature.sapm_cell(hours.poa_global, data.temp_air.to_numpy(), data.wind_speed.to_numpy(), **thermal)
    effective = hours.poa_direct * iam.physical(aoi) + hours.poa_diffuse
    dc = pvsystem.pvwatts_dc(effective, cell, 1000 * KWP, GAMMA) * (1 - LOSSES / 100)
    return inverter.pvwatts(dc, **INVERTER).sum() / 1000


def by_sam(tilt, azimuth, losses=None):
    """PVWatts version 5 of SAM, with losses by shade: yearly AC energy, light that passes the cover, cell temperatures."""
    import PySAM.Pvwattsv5 as pvwatts
    model = pvwatts.new()
    model.SolarResource.solar_resource_file = str(WEATHER)
    model.SystemDesign.assign({
        "system_capacity": KWP, "module_type": 0, "dc_ac_ratio": RATIO, "inv_eff": 100 * EFFICIENCY, "losses": LOSSES, "array_type": 0,
        "tilt": tilt, "azimuth": azimuth, "gcr": 0.4})
    model.Shading.assign(losses or {})
    model.execute()
    return model.Outputs.ac_annual, np.array(model.Outputs.tpoa), np.array(model.Outputs.tcell)


def chained(effective, cell):
    """Yearly AC energy of light that passes the cover and of cell temperatures."""
    dc = pvsystem.pvwatts_dc(effective, cell, 1000 * KWP, GAMMA) * (1 - LOSSES / 100)
    return np.nansum(inverter.pvwatts(dc, **INVERTER)) / 1000


# A wall 12 m high and 20 m long, 10 m to the south; and with it a slab 3 m above the module, to the east, which hides high suns and no
# low ones, as no horizon can.
WALL = "v -10 -10 0\nv 10 -10 0\nv 10 -10 12\nv -10 -10 12\nusemtl far\nf 1 2 3 4\n"
SLAB = WALL + "v 1 -6 4\nv 9 -6 4\nv 9 6 4\nv 1 6 4\nf 5 6 7 8\n"


def shade():
    """Files of shade, read by pvlib's suns and by SAM: what they leave of a year beside what `heliotile pv` finds."""
    tilt, azimuth, bad = 35, 180, []
    free_year, _, free_hours = run_pv("far.obj", "shade_open", tilt, azimuth)
    direct = free_hours.poa_direct.to_numpy()
    data, place = site()
    sun = place.get_solarposition(data.index)
    height, around = sun.apparent_elevation.to_numpy(), sun.azimuth.to_numpy()
    free, _, _ = by_sam(tilt, azimuth)
    for name, scene in (("wall", WALL), ("slab", SLAB)):
        (WORK / f"{name}.obj").write_text(scene)
        year, _, hours = run_pv(f"{name}.obj", f"shade_{name}", tilt, azimuth, "--shade")
        folder, true = WORK / f"shade_{name}/shade", hours.poa_direct.to_numpy()
        table = pd.read_csv(folder / "beam.csv").pivot(index="azimuth_deg", columns="altitude_deg", values="beam")
        beam = RegularGridInterpolator(
            (np.append(table.index, 360), table.columns), np.nan_to_num(np.vstack([table, table.iloc[:1]])))
        share = beam(np.column_stack([around, np.clip(height, 1, 89)]))
        listed = [float(one) for one in (folder / "userhorizon.txt").read_text().split(",")]
        pairs = np.loadtxt(folder / "horizon.txt")
        lists = {"userhorizon.txt": np.interp(around, np.arange(0, 361, 7.5), listed + listed[:1]),
                 "horizon.txt": np.interp(around, pairs[:, 0], pairs[:, 1])}
        print(f"{name}: the beam of a year, open {direct.sum() / 1000:.1f} kWh/m2, shaded {true.sum() / 1000:.1f}")
        for file, part in {"beam.csv": share, **{file: height > edge for file, edge in lists.items()}}.items():
            off = (direct * part).sum() / direct.sum() - true.sum() / direct.sum()
            print(f"  pvlib's suns through {file}: {(direct * part).sum() / 1000:.1f} kWh/m2, {100 * off:+.2f} % of the open beam")
            if abs(off) > 0.01 and (file == "beam.csv" or name == "wall"):
                bad.append((name, file))
        near, _, _ = by_sam(tilt, azimuth, json.loads((folder / "sam.json").read_text()))
        left = year.ac_kwh[0] / free_year.ac_kwh[0]
        print(f"  AC left: {100 * left:.2f} % here, {100 * near / free:.2f} % of SAM through sam.json")
        if abs(near / free - left) > 0.015:
            bad.append((name, "sam.json"))
    if bad:
        raise SystemExit(f"off by more than the limits: {bad}")


def main():
    data, place = site()
    bad = []
    print("tilt azimuth mounting  AC kWh  ModelChain  off %  months %  same light %")
    for tilt, azimuth, mounting in ARRAYS:
        thermal = OPEN if mounting == "open" else ROOF
        year, months, hours = run_pv("far.obj", f"{tilt}_{azimuth}_{mounting}", tilt, azimuth, f"--mounting {mounting}")
        dc, ac, months = year.dc_kwh[0], year.ac_kwh[0], months.ac_kwh.to_numpy()
        chain_dc, chain_ac, chain_months = by_chain(data, place, tilt, azimuth, thermal)
        same = 100 * (ac / by_functions(data, place, tilt, azimuth, thermal, hours) - 1)
        off, worst = 100 * (ac / chain_ac - 1), 100 * np.abs(months / chain_months - 1).max()
        print(f"{tilt:4} {azimuth:7} {mounting:>8} {ac:7.1f} {chain_ac:11.1f} {off:6.3f} {worst:9.3f} {same:13.4f}"
              f"   DC {dc:.1f} {chain_dc:.1f} {100 * (dc / chain_dc - 1):.3f} %")
        print("     months of ModelChain:", " ".join(f"{month:.2f}" for month in chain_months))
        if abs(off) > 0.5 or abs(same) > 0.2:
            bad.append((tilt, azimuth, mounting))
    tilt, azimuth = 35, 180
    year, _, hours = run_pv("far.obj", f"{tilt}_{azimuth}_open", tilt, azimuth)
    ac = year.ac_kwh[0]
    sam, light, cell = by_sam(tilt, azimuth)
    print(f"SAM, PVWatts 5: {sam:.1f} kWh, ours {100 * (ac / sam - 1):+.3f} %")
    # What makes the difference: SAM's light and cells through pvlib's functions, then ours in place of each.
    sun = place.get_solarposition(data.index)
    aoi = irradiance.aoi(tilt, azimuth, sun.apparent_zenith, sun.azimuth).to_numpy()
    own_light = (hours.poa_direct * iam.physical(aoi) + hours.poa_diffuse).to_numpy()
    own_cell = temperature.sapm_cell(hours.poa_global, data.temp_air.to_numpy(), data.wind_speed.to_numpy(), **OPEN).to_numpy()
    both = chained(light, cell)
    print(f"  its light and cells through pvlib: {100 * (both / sam - 1):+.3f} % of SAM")
    print(f"  our light, its cells: {100 * (chained(own_light, cell) / both - 1):+.3f} %")
    print(f"  its light, our cells: {100 * (chained(light, own_cell) / both - 1):+.3f} %")
    if abs(ac / sam - 1) > 0.01:
        bad.append("SAM")
    if bad:
        raise SystemExit(f"off by more than the limits: {bad}")


if __name__ == "__main__":
    {"formulas": formulas, "shade": shade}.get("".join(sys.argv[1:]), main)()
