"""The paper's experiment. In: the dense block, EnergyPlus, heliotile. Out: Table 1 (seconds of each part with 256 and 1,024 rays
a receiver, beside EnergyPlus's own) as CSV and Markdown; Fig. 7 (hours of a day at five surfaces) as CSV and SVG."""

import shutil

import numpy as np

import block
import compare
import curves
import light
import models
import parts
import runs
import study

RAYS = {256: 16, 1024: 32}  # Rays of a receiver's map, and the side of the texture that they fill.
DAY = (5, 18)
SURFACES = ("east 4 south window 1", "east 4 east window 1", "west 4 north window 1", "west 4 west window 1", "east 7 top")
COOLING_BOUND = 2.0
UPDATE_DAYS = 20
UPDATES_A_YEAR = 19


def settings(side):
    """Options of a build with side x side rays, and a quarter of 1,024 a map of what is seen, as in the paper."""
    values = {"sky_base": side, "sky_fine": side, "hit": side, "probe": 16}
    return [word for name, value in values.items() for word in ("--set", f"{name}={value}")]


def experiment(folder):
    """Runs all of it; the exit code."""
    case = block.case()
    print(
        f"{len(case.model['Shading:Site:Detailed'])} shading polygons, {len(case.model['Zone'])} zones, "
        f"{len(parts.exposed(case.model))} surfaces in the sun",
        flush=True,
    )
    here = folder / "dense"
    none, own = study.baselines(case, here, "Timestep")
    series, areas = own.series(), models.window_areas(case.model)
    table = study.Table()
    table.add("dense", "none", compare.deviation(series, none.series(), areas), none.user_s)
    columns = {"none": {"EnergyPlus": none.user_s}, "own": {"EnergyPlus": own.user_s}}
    for rays, side in RAYS.items():
        columns[f"{rays} rays"], found = injected(case, series, here / f"rays-{rays}", side)
        table.add("dense", f"{rays} rays", found, sum(columns[f"{rays} rays"].values()), {"cooling": COOLING_BOUND})
    years = year(folder)
    table_1(here, columns, years)
    figure_7(here, here / "rays-1024" / "heliotile" / "site.helio", series)
    return table.end(here)


def injected(case, series, folder, side):
    """Seconds of each part of the way to an injected run, and how its loads deviate."""
    folder.mkdir(parents=True, exist_ok=True)
    source, out = folder / "given.epJSON", folder / "heliotile"
    source.write_text(study.json.dumps(parts.outputs(case.model, "Timestep")))
    shutil.rmtree(out, ignore_errors=True)
    made = runs.seconds([study.HELIOTILE, "energyplus", source, "--physics", "energyplus", "-o", out, "--quiet", *settings(side)])
    # The same steps one by one, to share those seconds out.
    read = runs.seconds([study.HELIOTILE, "receivers", source, "-o", folder / "receivers.csv", "--quiet"])
    inputs = [source, "-r", out / "receivers.csv", "-o", folder / "site.helio", "--fresh", "--quiet"]
    built = runs.seconds([study.HELIOTILE, "build", *inputs, *settings(side)]) - read
    run = runs.run(out / "model.epJSON", case.weather, folder / "run")
    found = compare.deviation(series, run.series(), models.window_areas(case.model))
    return {"scene": read, "rays": built, "tables and model": made - read - built, "EnergyPlus": run.user_s}, found


def year(folder):
    """Seconds of a year by kind of run, shadows every 20 days as by default: from runs with one update and with two."""
    found = {}
    for own in (False, True):
        times = []
        for days in (20, 40):
            case = block.case(((4, 1), models.after((4, 1), days)), update=UPDATE_DAYS)
            model = runs.with_distribution(case.model, own)
            times.append(runs.run(model, case.weather, folder / f"dense-{days}" / ("own" if own else "none")).user_s)
        once, twice = times
        found["own" if own else "none"] = once + (UPDATES_A_YEAR - 1) * (twice - once)
    return found


def table_1(folder, columns, years):
    """Writes Table 1."""
    names = ("scene", "rays", "tables and model", "EnergyPlus")
    rows = [[name, *(f"{columns[run].get(name, 0.0):.1f}" for run in columns)] for name in names]
    sums = [sum(column.values()) for column in columns.values()]
    rows.append(["together", *(f"{total:.1f}" for total in sums)])
    rows.append(["times faster than EnergyPlus's own", *(f"{sums[1] / total:.1f}" for total in sums)])
    rows.append(
        ["a year, shadows every 20 days, extrapolated", *(f"{years[run]:.0f}" if run in years else "" for run in columns)]
    )
    head = ["CPU seconds", *columns]
    study.write(folder / "table1.csv", head, rows)
    lines = ["| " + " | ".join(row) + " |" for row in (head, ["---"] * len(head), *rows)]
    (folder / "table1.md").write_text("\n".join(lines) + "\n")
    print("\n".join(lines))


def figure_7(folder, archive, series):
    """Writes Fig. 7: hourly means of a day of what EnergyPlus reports and of what the archive has, under EnergyPlus's suns."""
    options = ["--paths", "first", "--bounces", "1", "--sky", "perez1990"]
    ours = light.ours(study.HELIOTILE, archive, series, SURFACES, folder, options)
    at = np.array([time[1:3] == DAY for time in series.times])
    hours = np.array([time[3] for time in series.times])[at]
    rows, pictures = [], {}
    for surface in SURFACES:
        theirs, mine = light.own(series, surface), ours[surface.upper()]
        for part in light.NAMES.values():
            means = [[values[part][at][hours == hour].mean() for hour in range(1, 25)] for values in (mine, theirs)]
            pictures.setdefault(surface, {})[part] = means
            rows += [[surface, hour - 0.5, part, *(f"{column[hour - 1]:.3f}" for column in means)] for hour in range(1, 25)]
    study.write(folder / "fig7.csv", ["surface", "hour", "light", "heliotile_w_m2", "energyplus_w_m2"], rows)
    curves.draw(pictures, folder / "fig7.svg")
