"""A year's sums of ground under a city model beside those under rasters of it. In: scenes as arguments of the program, the program, a folder, weather. Out:
bias and RMSE at points of the model's ground, and how many of these the rasters have under a roof. Needs numpy and pandas."""
import subprocess

import numpy as np
import pandas

SPACING = 14
#: Points lie so far above the model's ground, metres: above that of the rasters, too.
ABOVE = 0.5
#: Less is dark: a point under a roof, kWh/m2.
DARK = 50


def compare_ground(scenes, program, out, weather):
    receivers, sums = out / "ground.csv", {}
    asked = [program, "receivers", *scenes["model"], "--on", "ground", "--spacing", f"{SPACING}m", "-o", receivers, "--quiet"]
    subprocess.run(asked, check=True, capture_output=True)
    points = pandas.read_csv(receivers)
    points = points[points.nz > 0.8].assign(z=lambda point: point.z + ABOVE, nx=0, ny=0, nz=1)
    points[["receiver", "x", "y", "z", "nx", "ny", "nz"]].to_csv(receivers, index=False)
    for name, scene in scenes.items():
        archive, year = out / "ground.helio", out / "ground_year.csv"
        for command in (["build", *scene, "-r", receivers, "-o", archive, "--fresh", "--quality", "draft", "--quiet"],
                        ["replay", archive, "-w", weather, "--every", "year", "--columns", "total", "-o", year, "--quiet"]):
            subprocess.run([program, *command], check=True, capture_output=True)
        sums[name] = pandas.read_csv(year).set_index("receiver").total_kwh_m2
    model, rows = sums.pop("model"), []
    for name, found in sums.items():
        lit = (model > DARK) & (found > DARK)
        off, mean = (found - model)[lit], model[lit].mean()
        rows.append([name, int(lit.sum()), int((~lit).sum()), mean, 100 * off.mean() / mean, 100 * np.sqrt((off ** 2).mean()) / mean])
    print(pandas.DataFrame(rows, columns=["ground", "points", "dark", "model_kwh_m2", "bias_%", "rmse_%"]).round(2).to_string(index=False))
