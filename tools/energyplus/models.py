"""Models of the study. In: a period. Out: models for EnergyPlus 25.2: a box before a mirror facade, an L-shaped block between
neighbours, the medium office in a street.

The office is the DOE's reference building as LBNL-ETA/frads has it at 824f717d8d (tests/Resources, BSD-like): zones, surfaces,
materials, gains and thermostats unchanged, without its air systems, plant, tariffs and reports."""

import gzip
import json
import math
import pathlib
from dataclasses import dataclass

import parts
from runs import PAYLOAD, ROOT

GOLDEN_EPW = ROOT / "tests" / "data" / "weather" / "golden_tmy3.epw"
CHICAGO_EPW = PAYLOAD / "WeatherData" / "USA_IL_Chicago-OHare.Intl.AP.725300_TMY3.epw"
OFFICE = pathlib.Path(__file__).with_name("office.epJSON.gz")

YEAR = ((1, 1), (12, 31))
DAYS_FROM = (3, 7)
BAND = [(0.06, 0.47, 0.22, 0.85), (0.53, 0.94, 0.22, 0.85)]
WIDE = [(0.1, 0.9, 0.22, 0.85)]


@dataclass
class Case:
    """A model without reflections, its weather file, and the bound of its loads in percent of EnergyPlus's own."""

    name: str
    model: dict
    weather: object
    bound: float
    question: str


def half(share):
    """Glazed share of every second panel of a facade."""
    return lambda i, k: share if (i + k) % 2 == 0 else 0.0


def box(period=YEAR, steps=4):
    """One zone of 10 m x 8 m; a mirror facade across the street to the north, dark houses to the west and east."""
    model = parts.base(parts.GOLDEN, period, steps)
    windows = {"south": BAND, "east": WIDE, "north": BAND, "west": WIDE}
    parts.zone(model, "Box", (0, 0, 10, 8), 0.0, 3.5, windows=windows, wall="Wall 40", roof=True, ground=True)
    parts.facade(model, "Tower", (-10, 22), (20, 22), 0.0, 40.0, 6, 8, 0.3, lambda i, k: 0.7)
    parts.facade(model, "West house", (-14, -8), (-14, 16), 0.0, 9.0, 6, 3, 0.2)
    parts.facade(model, "East house", (24, 16), (24, -8), 0.0, 12.0, 6, 3, 0.45)
    return parts.outputs(model)


def ell(period=YEAR, steps=4):
    """Six zones on two floors round a court that is open to north and east, between neighbours of reflectance 0.1 to 0.6."""
    model = parts.base(parts.GOLDEN, period, steps)
    shares = [(0.06, 0.47, 0.25, 0.85), (0.53, 0.94, 0.25, 0.85)]
    windows = {side: shares for side in parts.SIDES}
    # Floor plans, and the sides where the next zone stands.
    plans = {
        "south": ((9, 0, 24, 9), ("west",)),
        "corner": ((0, 0, 9, 9), ("east", "north")),
        "west": ((0, 9, 9, 27), ("south",)),
    }
    for floor in range(2):
        low, high, roof, ground = 3.2 * floor, 3.2 * floor + 3.2, floor == 1, floor == 0
        for name, (plan, inside) in plans.items():
            parts.zone(model, f"{name} {floor + 1}", plan, low, high, inside, windows, "Wall 60", roof, ground)
    neighbours = (
        ("Dark", (-30, 0, -12, 24), 16.0, "east", 0.1, 0.0),
        ("Grey", (0, -34, 24, -14), 10.0, "north", 0.35, 0.0),
        ("Bright", (36, 2, 54, 26), 20.0, "west", 0.6, 0.2),
    )
    for name, plan, height, side, diffuse, glazed in neighbours:
        start, end = parts.edges(*plan)[side]
        parts.facade(model, f"{name} face", start, end, 0.0, height, 5, 4, diffuse, lambda i, k, share=glazed: share)
        for other in parts.SIDES:
            if other != side:
                parts.facade(model, f"{name} {other}", *parts.edges(*plan)[other], 0.0, height, 1, 1, diffuse)
    return parts.outputs(model)


def office(period=YEAR, steps=4):
    """The reference medium office of Chicago with ideal loads in place of its air system, between two rows of houses."""
    model = json.loads(gzip.decompress(OFFICE.read_bytes()))
    plain = parts.base(next(iter(model["Site:Location"].values())), period, steps)
    for name in ("Version", "SimulationControl", "Timestep", "Site:GroundReflectance", "RunPeriod", "ShadowCalculation"):
        model[name] = plain[name]
    for building in model["Building"].values():
        building.update(solar_distribution="FullExterior", maximum_number_of_warmup_days=60)
    model["WindowMaterial:Glazing"] = {"Mirror": parts.pane(0.25, 0.4)}
    model["Construction"]["Mirror pane"] = {"outside_layer": "Mirror"}
    controls = list(model["ZoneControl:Thermostat"].values())
    setpoints, model["ThermostatSetpoint:DualSetpoint"], model["ZoneControl:Thermostat"] = (
        model["ThermostatSetpoint:DualSetpoint"],
        {},
        {},
    )
    for control in controls:
        asked = setpoints[control["control_1_name"]]
        heat, cool = (asked[f"{way}_setpoint_temperature_schedule_name"] for way in ("heating", "cooling"))
        parts.ideal_loads(model, control["zone_or_zonelist_name"], heat, cool, control["control_type_schedule_name"])
    for person in model["People"].values():
        for field in [
            f for f in person if f.startswith(("thermal_comfort", "clothing", "air_velocity", "work_eff", "mean_radiant"))
        ]:
            del person[field]
    for lights in model["Lights"].values():
        # Without an air system no return air takes their heat away.
        lights["return_air_fraction"] = 0.0
    rows = (("South house", -18.0, "north", (14.0, 22.0, 9.0), 0.3), ("North house", 51.0, "south", (17.0, 9.0, 22.0), 0.0))
    for name, front, side, heights, glazed in rows:
        for k, (height, diffuse) in enumerate(zip(heights, (0.2, 0.5, 0.35))):
            x0, x1 = -18.0 + 30.0 * k, 8.0 + 30.0 * k
            plan = (x0, front - 16.0, x1, front) if side == "north" else (x0, front, x1, front + 16.0)
            parts.facade(model, f"{name} {k + 1} face", *parts.edges(*plan)[side], 0.0, height, 5, 3, diffuse, half(glazed))
            for flank in ("west", "east"):
                parts.facade(model, f"{name} {k + 1} {flank}", *parts.edges(*plan)[flank], 0.0, height, 1, 1, diffuse)
    return parts.outputs(model)


YEARS = {
    "box": ("box before a mirror facade", box, GOLDEN_EPW),
    "l": ("L-shaped block between neighbours", ell, GOLDEN_EPW),
    "office": ("medium office in a street", office, CHICAGO_EPW),
}


def after(start, days):
    """The last (month, day) of so many days from `start` in a common year."""
    lengths = (31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31)
    month, day = start
    day += days - 1
    while day > lengths[month - 1]:
        day -= lengths[month - 1]
        month = month % 12 + 1
    return month, day


def window_areas(model):
    """Key in capitals -> m2 of each window, its multiplier included."""
    areas = {}
    for name, window in model["FenestrationSurface:Detailed"].items():
        points = [
            [window[f"vertex_{k}_{axis}_coordinate"] for axis in "xyz"] for k in range(1, int(window["number_of_vertices"]) + 1)
        ]
        total = [0.0] * 3
        for a, b in zip(points, points[1:] + points[:1]):
            total = [
                t + u for t, u in zip(total, (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]))
            ]
        areas[name.upper()] = math.hypot(*total) / 2 * window.get("multiplier", 1)
    return areas
