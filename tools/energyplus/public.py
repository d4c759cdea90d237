"""Whole public models: the 32 DOE reference buildings and ASHRAE 90.1 prototypes of the package `pyenergyplus-lbnl`.

In: names of models. Out: surfaces that get less area than EnergyPlus gives them; transmitted and absorbed sun of ten days of June beside
EnergyPlus's own reflections, by surface. Of a model only the envelope is run: what the sun does at it needs no systems.
"""

import csv
import pathlib
import re
import shutil

import numpy as np

import parts
import runs
import study

# Six of different kinds: overhangs, fins, courts, strips of windows, attics.
SIX = (
    "RefBldgSmallOfficeNew2004_Chicago",
    "RefBldgMediumOfficeNew2004_Chicago",
    "RefBldgPrimarySchoolNew2004_Chicago",
    "RefBldgFullServiceRestaurantNew2004_Chicago",
    "ASHRAE901_RetailStripmall_STD2019_Denver",
    "ASHRAE901_HotelSmall_STD2019_Denver",
)
DAYS = ((6, 10), (6, 19))
ENVELOPE = re.compile(
    r"(Version|Timestep|Building|GlobalGeometryRules|Zone|Space|Site:Location|Site:GroundReflectance.*|Wall.*|Roof.*|Floor.*|Ceiling.*"
    r"|BuildingSurface:Detailed|FenestrationSurface:Detailed|Window|GlazedDoor|Door|Shading:.*|ShadingProperty:Reflectance|Material.*"
    r"|WindowMaterial:.*|WindowProperty:FrameAndDivider|Construction.*|Schedule.*|Site:GroundTemperature:.*|SurfaceProperty:.*)",
    re.IGNORECASE,
)
ABSORBED, TRANSMITTED = parts.SUN[:2]
SUM_BOUND, WINDOW_BOUND = 1.0, 3.0


def folder_of_models():
    """Where the package keeps its models and its weather."""
    import pyenergyplus

    return pathlib.Path(pyenergyplus.__file__).parent / "data"


def objects(text):
    """Lists of fields, the class first."""
    plain = "\n".join(line.split("!")[0] for line in text.splitlines())
    return [[field.strip() for field in part.split(",")] for part in plain.split(";") if part.strip()]


def envelope(text):
    """An IDF of the envelope alone, that runs ten days with shadows of every step."""
    kept = [fields for fields in objects(text) if ENVELOPE.fullmatch(fields[0])]
    kept = [fields for fields in kept if fields[0].lower() not in ("schedule:file", "construction:internalsource")]
    for fields in kept:
        if fields[0].lower() == "building":
            fields[6] = "FullExteriorWithReflections"
    (month, day), (last_month, last_day) = DAYS
    kept += [
        ["SimulationControl", "No", "No", "No", "No", "Yes"],
        ["RunPeriod", "ten days", str(month), str(day), "", str(last_month), str(last_day), "", "", "No", "No", "No", "Yes", "Yes"],
        ["ShadowCalculation", "PolygonClipping", "Timestep"],
        ["Output:Surfaces:List", "Details"],
    ]
    kept += [["Output:Variable", "*", name, "Hourly"] for name in (ABSORBED, TRANSMITTED)]
    return ";\n".join(",".join(fields) for fields in kept) + ";\n"


def surfaces(folder):
    """Name in capitals -> class and net m2 of the surfaces in the sun, as EnergyPlus lists them."""
    found, head = {}, []
    for line in (folder / "eplusout.eio").read_text(errors="replace").splitlines():
        fields = [field.strip() for field in line.split(",")]
        if fields[0].startswith("! <HeatTransfer Surface>"):
            head = fields
        elif fields[0] == "HeatTransfer Surface" and head:
            of = dict(zip(head[1:], fields[1:]))
            if of["SunExposure"] == "SunExposed":
                net = next(value for key, value in of.items() if key.startswith("Area (Net)"))
                found[of["Surface Name"].upper()] = (of["Surface Class"], float(net))
    return found


def injected(source, folder, *options):
    """The model that `heliotile energyplus` makes, and m2 by surface that get light."""
    out = folder / "heliotile"
    shutil.rmtree(out, ignore_errors=True)
    command = [study.HELIOTILE, "energyplus", source, "--physics", "energyplus", *options, "-o", out, "--quiet"]
    seconds = runs.seconds(command)
    areas = {}
    with open(out / "receivers.csv", newline="") as file:
        for row in csv.DictReader(file):
            name = row["face"].upper()
            areas[name] = areas.get(name, 0.0) + float(row["area_m2"])
    return out / "model.idf", areas, seconds


def study_of(name, data, folder, bounds):
    """One model: prints its table, returns what breaks a bound."""
    text = (data / "model" / f"{name}.idf").read_text(errors="replace")
    place = "Chicago-OHare" if name.endswith("Chicago") else "Denver-Aurora-Buckley"
    weather = next((data / "weather").glob(f"*{place}*.epw"))
    folder.mkdir(parents=True, exist_ok=True)
    source = folder / "given.idf"
    source.write_text(envelope(text))
    own = runs.run(source, weather, folder / "own")
    model, areas, _ = injected(source, folder)
    ours = runs.run(model, weather, folder / "ours")
    plain = folder / "none.idf"
    plain.write_text(source.read_text().replace("FullExteriorWithReflections", "FullExterior"))
    none = runs.run(plain, weather, folder / "none")
    known = surfaces(folder / "own")
    lost = {key: (areas.get(key, 0.0), net) for key, (_, net) in known.items() if areas.get(key, 0.0) < 0.99 * net}
    rows, broken, total_own, total_ours, total_none = [], [], 0.0, 0.0, 0.0
    series = [run.series() for run in (own, ours, none)]
    for key, (kind, net) in known.items():
        window = (key, TRANSMITTED) in series[0].values
        variable, factor = (TRANSMITTED, 1.0) if window else (ABSORBED, net)
        theirs, here, bare = (factor * float(np.sum(one.values[(key, variable)])) for one in series)
        total_own, total_ours, total_none = total_own + theirs, total_ours + here, total_none + bare
        rows.append((kind, key, window, net, *(100.0 * (value / theirs - 1.0) if theirs else 0.0 for value in (bare, here))))
    sums = [100.0 * (value / total_own - 1.0) for value in (total_none, total_ours)]
    worst = {which: max((row for row in rows if row[2] == which), key=lambda row: abs(row[5]), default=None) for which in (True, False)}
    print(f"{name}: {len(known)} surfaces in the sun, all {sums[0]:+.2f} % without reflections, {sums[1]:+.2f} % injected")
    for which, word in ((True, "transmitted"), (False, "absorbed")):
        if worst[which]:
            kind, key, _, net, bare, here = worst[which]
            print(f"    worst {word}: {here:+.2f} % {key} ({kind}, {net:.1f} m2), without {bare:+.2f} %")
    for key, (have, net) in sorted(lost.items()):
        print(f"    less area: {key} {have:.2f} of {net:.2f} m2")
    study.write(folder / "surfaces.csv", ["class", "surface", "window", "net_m2", "without_pct", "injected_pct"], rows)
    if bounds and abs(sums[1]) > SUM_BOUND:
        broken.append(f"{name}: sum {sums[1]:+.2f} %, bound {SUM_BOUND}")
    if bounds and worst[True] and abs(worst[True][5]) > WINDOW_BOUND:
        broken.append(f"{name}: window {worst[True][5]:+.2f} %, bound {WINDOW_BOUND}")
    return broken


def public(names, keep):
    """Runs the models; the exit code."""
    data = folder_of_models()
    all_names = sorted(path.stem for path in (data / "model").glob("*.idf"))
    asked = {"six": SIX, "all": all_names}.get(names) or names.split(",")
    broken = []
    for name in asked:
        broken += study_of(name, data, keep / "public" / name, name in SIX)
    for line in broken:
        print("error above its limit:", line)
    return 1 if broken else 0
