"""Variants of a small box. In: names. Out: models that differ in one thing each, with their weather files; and any model of the
study by its name."""

import parts
from models import DAYS_FROM, GOLDEN_EPW, YEAR, YEARS, Case, after

WEEKS = ((1, 10), (1, 16)), ((7, 10), (7, 16))


def small(periods=WEEKS, steps=4, **options):
    """The box of the variants: the mirror facade is smaller, one house more stands before it."""
    model = parts.base(parts.GOLDEN, periods[0], steps, **options)
    parts.also(model, *periods[1:])
    pair, single = [(0.1, 0.43, 0.3, 0.8), (0.57, 0.9, 0.3, 0.8)], [(0.2, 0.8, 0.3, 0.8)]
    windows = {"south": pair, "east": single, "north": pair, "west": single}
    parts.zone(model, "Box", (0, 0, 10, 8), 0.0, 3.5, windows=windows, wall="Wall 40", roof=True, ground=True)
    parts.facade(model, "Tower", (-5, 20), (15, 20), 0.0, 20.0, 4, 4, 0.3, lambda i, k: 0.5)
    parts.facade(model, "West house", (-12, -4), (-12, 12), 0.0, 9.0, 4, 3, 0.45)
    return parts.outputs(model)


def daylight_saving(folder):
    model = small()
    model["RunPeriodControl:DaylightSavingTime"] = {"Summer": {"start_date": "3/12", "end_date": "11/1"}}
    return model, GOLDEN_EPW


def monthly_ground(folder):
    return small(ground=(0.5, *(0.2,) * 5, 0.12, *(0.2,) * 5)), GOLDEN_EPW


def snow(folder):
    model = small()
    model["Site:GroundReflectance:SnowModifier"] = {"Snow": {"ground_reflected_solar_modifier": 3.0}}
    weather = folder / "snow.epw"
    edited(GOLDEN_EPW, weather, lambda f: f[:30] + ["10" if f[1] == "1" and int(f[2]) < 14 else "0"] + f[31:])
    return model, weather


def leap_year(folder):
    model = small((((2, 23), (3, 1)), WEEKS[1]))
    for period, weekday in zip(model["RunPeriod"].values(), ("Friday", "Wednesday")):
        period.update(begin_year=2024, end_year=2024, day_of_week_for_start_day=weekday)
    weather = folder / "leap.epw"
    edited(GOLDEN_EPW, weather, lambda f: ["2024", *f[1:]], leap=True)
    return model, weather


def edited(source, target, change, leap=False):
    """Writes a weather file with each row's fields changed, and with a 29 February like the 28th if it is to be a leap year."""
    lines = source.read_text().splitlines()
    rows = [change(line.split(",")) for line in lines[8:]]
    if leap:
        lines[4] = lines[4].replace("SAVINGS,No", "SAVINGS,Yes", 1)
        days = [row for row in rows if row[1:3] == ["2", "28"]]
        place = rows.index(days[-1]) + 1
        rows[place:place] = [[*row[:2], "29", *row[3:]] for row in days]
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text("\n".join([*lines[:8], *(",".join(row) for row in rows)]) + "\n")


def design_days(folder):
    model = small()
    model["SimulationControl"]["Control"] = {
        "run_simulation_for_sizing_periods": "Yes",
        "run_simulation_for_weather_file_run_periods": "No",
    }
    days = (
        ("Summer", 7, "SummerDesignDay", 33.0, 15.0),
        ("Spring", 3, "Wednesday", 18.0, 12.0),
        ("Winter", 1, "Wednesday", -8.0, 10.0),
    )
    model["SizingPeriod:DesignDay"] = {
        name: {
            "month": month,
            "day_of_month": 21,
            "day_type": kind,
            "maximum_dry_bulb_temperature": high,
            "daily_dry_bulb_temperature_range": span,
            "humidity_condition_type": "WetBulb",
            "wetbulb_or_dewpoint_at_maximum_dry_bulb": high - 10.0,
            "barometric_pressure": 81000.0,
            "wind_speed": 3.0,
            "wind_direction": 180.0,
            "solar_model_indicator": "ASHRAEClearSky",
            "sky_clearness": 1.0,
        }
        for name, month, kind, high, span in days
    }
    return model, GOLDEN_EPW


def relative(folder):
    """North axis 30 degrees, the zone moved and turned by 20 more, its facade a building's shade, the house a site's."""
    model = small(north_axis_deg=30.0)
    model["GlobalGeometryRules"]["Rules"]["coordinate_system"] = "Relative"
    model["Zone"]["Box"] = {"direction_of_relative_north": 20.0, "x_origin": 3.0, "y_origin": -2.0, "z_origin": 0.5}
    shades = model["Shading:Site:Detailed"]
    names = [name for name in shades if name.startswith("Tower")]
    model["Shading:Building:Detailed"] = {name: shades.pop(name) for name in names}
    return model, GOLDEN_EPW


def multipliers(folder):
    model = small()
    windows = model["FenestrationSurface:Detailed"]
    for side in ("south", "north"):
        del windows[f"Box {side} window 2"]
        windows[f"Box {side} window 1"]["multiplier"] = 2
    return model, GOLDEN_EPW


def frames(folder):
    model = small()
    model["WindowProperty:FrameAndDivider"] = {
        "Frame": {
            "frame_width": 0.06,
            "frame_outside_projection": 0.03,
            "frame_conductance": 5.0,
            "frame_solar_absorptance": 0.6,
            "divider_width": 0.04,
            "number_of_vertical_dividers": 1,
            "number_of_horizontal_dividers": 1,
            "divider_conductance": 5.0,
            "divider_solar_absorptance": 0.6,
        }
    }
    for window in model["FenestrationSurface:Detailed"].values():
        window["frame_and_divider_name"] = "Frame"
    return model, GOLDEN_EPW


def full_width(folder):
    """Windows from edge to edge of their walls."""
    model = small()
    model["FenestrationSurface:Detailed"] = {}
    for side, (start, end) in parts.edges(0, 0, 10, 8).items():
        parts.window(model, f"Box {side} window 1", f"Box {side}", start, end, 0.0, 3.5, (0.0, 1.0, 0.3, 0.75))
    return model, GOLDEN_EPW


def interior(folder):
    return small(distribution="FullInteriorAndExterior"), GOLDEN_EPW


def shades(folder):
    """Interior shades on three windows, drawn by a schedule."""
    model = small()
    model["WindowMaterial:Shade"] = {
        "Roller": {
            **{
                f"{band}_{way}": value
                for band in ("solar", "visible")
                for way, value in (("transmittance", 0.2), ("reflectance", 0.5))
            },
            "infrared_hemispherical_emissivity": 0.9,
            "infrared_transmittance": 0.0,
            "thickness": 0.003,
            "conductivity": 0.1,
        }
    }
    fields = ("Through: 12/31", "For: AllDays", "Until: 11:00", 0.0, "Until: 17:00", 1.0, "Until: 24:00", 0.0)
    model["Schedule:Compact"]["Afternoon"] = {"schedule_type_limits_name": "Any", "data": [{"field": field} for field in fields]}
    names = ("Box south window 1", "Box north window 1", "Box west window 1")
    model["WindowShadingControl"] = {
        "Roller control": {
            "zone_name": "Box",
            "shading_type": "InteriorShade",
            "shading_control_type": "OnIfScheduleAllows",
            "schedule_name": "Afternoon",
            "shading_control_is_scheduled": "Yes",
            "shading_device_material_name": "Roller",
            "fenestration_surfaces": [{"fenestration_surface_name": name} for name in names],
        }
    }
    return model, GOLDEN_EPW


VARIANTS = {
    "plain": ("the small box as it is", lambda folder: (small(), GOLDEN_EPW)),
    "daylight-saving": ("daylight saving from 12 March", daylight_saving),
    "monthly-ground": ("ground 0.5 in January, 0.12 in July", monthly_ground),
    "snow": ("ground x 3 while snow lies, four days", snow),
    "design-days": ("three clear design days", design_days),
    "hourly": ("1 time step an hour", lambda folder: (small(steps=1), GOLDEN_EPW)),
    "six-steps": ("6 time steps an hour", lambda folder: (small(steps=6), GOLDEN_EPW)),
    "relative": ("north axis 30, relative coordinates", relative),
    "multipliers": ("windows with multiplier 2", multipliers),
    "frames": ("frames and dividers", frames),
    "full-width": ("windows as wide as their walls", full_width),
    "interior": ("FullInteriorAndExterior", interior),
    "leap-year": ("February of a leap year", leap_year),
    "interior-shades": ("interior shades by schedule", shades),
}


def case(name, folder, days=None):
    """A case by its name; `days` shortens a year to so many days from 7 March."""
    if name in YEARS:
        question, made, weather = YEARS[name]
        period = YEAR if days is None else (DAYS_FROM, after(DAYS_FROM, days))
        return Case(name, made(period), weather, 0.5, question)
    question, made = VARIANTS[name]
    model, weather = made(folder)
    return Case(name, model, weather, 0.7, question)
