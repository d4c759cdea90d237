"""The paper's experiment. In: the dense block, EnergyPlus, heliotile. Out: Table 1 (seconds of each part with 256 and 1,024 rays
a receiver and as builds come, beside EnergyPlus's own) and Fig. 7 (hours of a day at five surfaces): CSV, Markdown, SVG."""

import json
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

DAY = (5, 18)
SURFACES = ("east 4 south window 1", "east 4 east window 1", "west 4 north window 1", "west 4 west window 1", "east 7 top")
UPDATE_DAYS = 20
STEPS = 4
SHORT, LONGER = 7, 7 + UPDATE_DAYS  # days of runs with one update of the shadows and with two
UPDATES_A_YEAR = 19


def settings(side):
    """Options of a build with side x side rays a map, and 256 a map of what is seen, as in the paper."""
    values = {"sky_base": side, "sky_fine": side, "hit": side, "probe": 16}
    return [word for name, value in values.items() for word in ("--set", f"{name}={value}")]


# The paper's rays a receiver, and what a build takes if nothing is asked for.
BUILDS = {"256 rays": settings(16), "1024 rays": settings(32), "standard": []}


def experiment(folder):
    """Runs all of it; the exit code."""
    case = block.case()
    print(
        f"{len(case.model['Shading:Site:Detailed'])} shading polygons, {len(case.model['Zone'])} zones, "
        f"{len(parts.exposed(case.model))} surfaces in the sun",
        flush=True,
    )
    here, table = folder / "dense", study.Table()
    # Loads: every hour has its own shadows. The steps' series are those of Fig. 7.
    own = compared(case, here, table, "Timestep")
    # Seconds: EnergyPlus as it comes, with shadows every 20 days; a week, and as much longer as the next update takes.
    columns = {}
    for days in (SHORT, LONGER):
        long = block.case((block.WEEK[0], models.after(block.WEEK[0], days)), STEPS, UPDATE_DAYS)
        none_s, own_s = (run.user_s for run in study.baselines(long, folder / f"dense-{days}"))
        columns[days] = {"without": {"EnergyPlus": none_s}, "its own": {"EnergyPlus": own_s}}
    for build in BUILDS:
        short = block.case(block.WEEK, STEPS, UPDATE_DAYS)
        parts.outputs(short.model)
        columns[SHORT][build] = injected(short, folder / f"dense-{SHORT}", build)[1]
    table_1(here, columns)
    figure_7(here, here / "standard" / "heliotile" / "site.helio", own)
    return table.end(here)


def compared(case, folder, table, frequency):
    """EnergyPlus without reflections and injected, beside its own; the series of its own."""
    none, own = study.baselines(case, folder, frequency)
    series, areas = own.series(), models.window_areas(case.model)
    table.add(case.name, "none", compare.deviation(series, none.series(), areas), none.user_s)
    for build in BUILDS:
        run, seconds = injected(case, folder, build)
        found = compare.deviation(series, run.series(), areas)
        table.add(case.name, build, found, sum(seconds.values()), {"cooling": case.bound})
    print(f"{'':<26}EnergyPlus {none.user_s:.1f} s without reflections, {own.user_s:.1f} s with its own")
    return series


def injected(case, folder, build):
    """An injected run, and the seconds of each part of the way to it."""
    folder /= build.replace(" ", "-")
    folder.mkdir(parents=True, exist_ok=True)
    source, out = folder / "given.epJSON", folder / "heliotile"
    source.write_text(json.dumps(case.model))
    shutil.rmtree(out, ignore_errors=True)
    command = [study.HELIOTILE, "energyplus", source, "--physics", "energyplus", "-o", out, "--quiet"]
    made = runs.seconds([*command, *BUILDS[build]])
    # The same steps one by one, to share those seconds out.
    read = runs.seconds([study.HELIOTILE, "receivers", source, "-o", folder / "receivers.csv", "--quiet"])
    inputs = [source, "-r", out / "receivers.csv", "-o", folder / "site.helio", "--fresh", "--quiet"]
    built = runs.seconds([study.HELIOTILE, "build", *inputs, *BUILDS[build]]) - read
    run = runs.run(out / "model.epJSON", case.weather, folder / "run")
    rays = min(built, made - read)
    return run, {"scene": read, "rays": rays, "tables and model": made - read - rays, "EnergyPlus": run.user_s}


def table_1(folder, columns):
    """Writes Table 1: seconds of a week by part, and of the year that runs with one update of the shadows and with two make."""
    week, longer = columns[SHORT], columns[LONGER]
    names = ("scene", "rays", "tables and model", "EnergyPlus")
    rows = [[name, *(f"{column.get(name, 0.0):.1f}" for column in week.values())] for name in names]
    sums = [sum(column.values()) for column in week.values()]
    rows.append(["a week", *(f"{total:.1f}" for total in sums)])
    rows.append(["faster than its own", *(f"{sums[1] / total:.1f}" for total in sums)])
    # What is injected costs no update: those of its runs are the shadows of a run without reflections.
    update = {run: longer[run]["EnergyPlus"] - week[run]["EnergyPlus"] for run in longer}
    every = [update.get(run, update["without"]) for run in week]
    years = [total + (UPDATES_A_YEAR - 1) * more for total, more in zip(sums, every)]
    rows.append(["a year, extrapolated", *(f"{total:.0f}" for total in years)])
    rows.append(["faster than its own", *(f"{years[1] / total:.1f}" for total in years)])
    head = ["CPU seconds", *week]
    study.write(folder / "table1.csv", head, rows)
    lines = ["| " + " | ".join(row) + " |" for row in (head, ["---"] * len(head), *rows)]
    (folder / "table1.md").write_text("\n".join(lines) + "\n")
    print("\n".join(lines))


def figure_7(folder, archive, series):
    """Writes Fig. 7: hourly means of a day of what EnergyPlus reports and of what the archive has, under EnergyPlus's suns."""
    lights = light.ours(study.HELIOTILE, archive, series, SURFACES, folder)
    at = np.array([time[1:3] == DAY for time in series.times])
    hours = np.array([time[3] for time in series.times])[at]
    rows, pictures = [], {}
    for surface in SURFACES:
        for part, theirs in light.own(series, surface).items():
            ours = lights[surface.upper()][part]
            means = [[values[at][hours == hour].mean() for hour in range(1, 25)] for values in (ours, theirs)]
            pictures.setdefault(surface, {})[part] = means
            rows += [[surface, hour - 0.5, part, *(f"{column[hour - 1]:.3f}" for column in means)] for hour in range(1, 25)]
    study.write(folder / "fig7.csv", ["surface", "hour", "light", "heliotile_w_m2", "energyplus_w_m2"], rows)
    curves.draw(pictures, folder / "fig7.svg")
