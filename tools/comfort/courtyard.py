"""A person in a courtyard beside measurements. In: the folder of the rasters, the weather and the measurements of Kronenhuset (2005-10-07; Lindberg,
Holmer and Thorsson 2008, as SOLWEIG's tests have them), the program, a folder to work in. Out: shortwave and longwave irradiance of six planes and the
mean radiant temperature beside the measured ones, by hour, as bias and RMSE and as a picture of the hours. Needs numpy, pandas and rasterio."""
import csv
import subprocess
import sys
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pandas

sys.path.append(str(Path(__file__).resolve().parent.parent / "rasters"))
from chart import draw  # noqa: E402
from gothenburg import MATERIALS, PLANES, SHADOW_EDGE, write_receivers  # noqa: E402

#: Of the book's page of comfort.
PICTURE = Path(__file__).resolve().parent.parent / "pictures" / "courtyard_day.svg"
#: The planes of a person in the order of the measured ones, by the names of their columns.
NAMES = ["up", "down", "north", "east", "south", "west"]
SIDES = [plane.removeprefix("K") for plane in PLANES]
WAYS = {
    "sol-air": [],
    "sol-air, film 25": ["--film", "25"],
    "air": ["--surfaces", "air"],
    "black, air": ["--surfaces", "air", "--emissivity", "ground=1", "--emissivity", "obstruction=1"],
}


def write_weather(folder, out):
    """Hours are labelled by their start. The day was clear: no cloud hides the sky."""
    met = pandas.read_csv(folder / "MetFile_Prepared.txt", sep=r"\s+").rename(columns=lambda name: name.strip("%"))
    with open(out, "w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["time", "ghi", "dni", "dhi", "temp_air", "relative_humidity", "wind_speed", "opaque_sky_cover"])
        for _, row in met.iterrows():
            start = datetime(2005, 1, 1) + timedelta(days=int(row.id) - 1, hours=int(row.it))
            rows.writerow([start.isoformat(), row.Kdn, row.Kdir, row.Kdiff, row.Td, row.RH, row.Wind, 0])


def radiant(measured):
    """Mean radiant temperature of a standing box from the twelve measured fluxes: the column of the file is not that of its own fluxes."""
    sides = sum(0.7 * measured[f"K{side}"] + 0.97 * measured[f"L{side}"] for side in "nesw")
    ends = sum(0.7 * measured[f"K{end}"] + 0.97 * measured[f"L{end}"] for end in ("down", "up"))
    return ((0.22 * sides + 0.06 * ends) / (0.97 * 5.670374419e-8)) ** 0.25 - 273.15


def main(folder, program, out):
    folder, out = Path(folder).resolve(), Path(out)
    out.mkdir(parents=True, exist_ok=True)
    names = ["P", *(f"P/{name}" for name in NAMES[1:])]
    write_receivers(folder, out / "receivers.csv", dict(zip(names, PLANES.values())))
    write_weather(folder, out / "weather.csv")
    measured = pandas.read_csv(folder / "measurements_kr.csv").set_index("hour")
    (out / "materials.toml").write_text(MATERIALS)
    scene = ["--dsm", folder / "DSM_KR.tif", "--dem", folder / "DEM_KR.tif", "--canopy", folder / "CDSM_KR.asc", "--landcover",
             folder / "landcover_KR.tif", "--crs", "3007", "--materials", out / "materials.toml"]
    subprocess.run([program, "build", *scene, "-r", out / "receivers.csv", "-o", out / "site.helio", "--fresh", "--quality", "fine"],
                   check=True, capture_output=True)
    summary = []
    for way, options in WAYS.items():
        hours = out / (way.replace(", ", "_").replace(" ", "_") + ".csv")
        asked = [program, "comfort", out / "site.helio", "-w", out / "weather.csv", "--weather-stamp", "start", "--time-zone", "1", "--steps", "12",
                 "--sun-on", "box", "--columns", "mrt,shortwave,longwave,utci,pet", "-o", hours, *options]
        subprocess.run(asked, check=True, capture_output=True)
        found = pandas.read_csv(hours)
        # Measurements are labelled by the end of their hour.
        found.index = found.time.str.slice(11, 13).astype(int) + 1
        found = found.loc[measured.index]
        off = pandas.DataFrame({f"{kind}{side}": found[f"{band}_{name}"] - measured[f"{kind}{side}"]
                                for kind, band in (("K", "shortwave"), ("L", "longwave"))
                                for name, side in zip(NAMES, SIDES)})
        off["Tmrt"] = found.mrt_c - radiant(measured)
        off["Tmrt column"] = found.mrt_c - measured.Tmrt
        off.to_csv(out / ("off_" + hours.name), float_format="%.1f")
        for which, kept in (("12 hours", off), ("11 hours", off.drop(SHADOW_EDGE))):
            summary.append([way, which, *(f"{kept[one].mean():+.1f} / {np.sqrt((kept[one] ** 2).mean()):.1f}" for one in off)])
        if not options:
            table = pandas.DataFrame({"Kdown": measured.Kdown, "found": found.shortwave_up, "Ldown": measured.Ldown, "found ": found.longwave_up,
                                      "Lup": measured.Lup, "found  ": found.longwave_down, "Tmrt": radiant(measured), "found   ": found.mrt_c,
                                      "UTCI": found.utci_c, "PET": found.pet_c})
            print(table.round(1).to_string())
            draw(PICTURE, measured.index, [
                ("Shortwave down, W/m2", (0, 200), 50, measured.Kdown, found.shortwave_up),
                ("Longwave down, W/m2", (280, 380), 20, measured.Ldown, found.longwave_up),
                ("Mean radiant temperature, C", (0, 50), 10, radiant(measured), found.mrt_c)],
                "hour of 2005-10-07, UTC+1; means of an hour")
            print(f"drawn: {PICTURE}")
    print("bias / RMSE, W/m2 and K")
    print(pandas.DataFrame(summary, columns=["surfaces", "of", *off.columns]).to_string(index=False))


if __name__ == "__main__":
    main(*sys.argv[1:4])
