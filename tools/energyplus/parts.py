"""Parts of EnergyPlus 25.2 models. In: a model (a dict, as epJSON has it) and measures. Out: the model with a zone, windows,
ideal loads, shading panels or outputs more. Metres, x east, y north, z up, polygons counterclockwise from outside."""

import json

MONTHS = tuple("january february march april may june july august september october november december".split())
SIDES = ("south", "east", "north", "west")

# What the comparison needs of every run, and the parts of the incident light that only EnergyPlus's own reflections have right.
LOADS = ("Zone Air System Sensible Heating Energy", "Zone Air System Sensible Cooling Energy")
SUN = (
    "Surface Outside Face Solar Radiation Heat Gain Rate per Area",
    "Surface Window Transmitted Solar Radiation Rate",
    "Surface Window Total Glazing Layers Absorbed Solar Radiation Rate",
)
REFLECTED = tuple(
    f"Surface Outside Face Incident {name} Solar Radiation Rate per Area"
    for name in (
        "Beam To Diffuse Surface Reflected",
        "Beam To Diffuse Ground Reflected",
        "Sky Diffuse Surface Reflected",
        "Sky Diffuse Ground Reflected",
        "Beam To Beam Surface Reflected",
    )
)
DIRECT = tuple(f"Surface Outside Face Incident {name} Solar Radiation Rate per Area" for name in ("Beam", "Sky Diffuse"))
SITE = (
    "Site Direct Solar Radiation Rate per Area",
    "Site Diffuse Solar Radiation Rate per Area",
    "Site Ground Reflected Solar Radiation Rate per Area",
    "Site Solar Azimuth Angle",
    "Site Solar Altitude Angle",
)

GOLDEN = {"latitude": 39.74, "longitude": -105.18, "time_zone": -7.0, "elevation": 1829.0}


def base(location, period, steps=4, distribution="FullExterior", north_axis_deg=0.0, ground=(0.2,) * 12):
    """A model without zones. `period` is ((month, day), (month, day)), `location` the place of its weather file."""
    return {
        "Version": {"Version 1": {"version_identifier": "25.2"}},
        "Building": {
            "Study": {
                "north_axis": north_axis_deg,
                "terrain": "City",
                "solar_distribution": distribution,
                "loads_convergence_tolerance_value": 0.001,
                "temperature_convergence_tolerance_value": 0.01,
                "minimum_number_of_warmup_days": 6,
                "maximum_number_of_warmup_days": 60,
            }
        },
        "SimulationControl": {
            "Control": {"run_simulation_for_sizing_periods": "No", "run_simulation_for_weather_file_run_periods": "Yes"}
        },
        "Timestep": {"Timestep 1": {"number_of_timesteps_per_hour": steps}},
        "Site:Location": {"Site": dict(location)},
        "Site:GroundReflectance": {"Ground": {f"{m}_ground_reflectance": value for m, value in zip(MONTHS, ground)}},
        "GlobalGeometryRules": {
            "Rules": {
                "starting_vertex_position": "UpperLeftCorner",
                "vertex_entry_direction": "Counterclockwise",
                "coordinate_system": "World",
            }
        },
        "RunPeriod": {"Period": run_period(period)},
        "ShadowCalculation": {
            "Shadows": {
                "shading_calculation_method": "PolygonClipping",
                "shading_calculation_update_frequency_method": "Timestep",
                "maximum_figures_in_shadow_overlap_calculations": 50000,
            }
        },
        "ScheduleTypeLimits": {"Any": {}},
        "Schedule:Constant": {
            "Heat to": {"schedule_type_limits_name": "Any", "hourly_value": 20.0},
            "Cool to": {"schedule_type_limits_name": "Any", "hourly_value": 24.0},
            "Dual": {"schedule_type_limits_name": "Any", "hourly_value": 4.0},
            "Always": {"schedule_type_limits_name": "Any", "hourly_value": 1.0},
        },
        "Schedule:Compact": {
            "At work": {
                "schedule_type_limits_name": "Any",
                "data": [
                    {"field": field}
                    for field in ("Through: 12/31", "For: AllDays", "Until: 08:00", 0.1, "Until: 18:00", 1.0, "Until: 24:00", 0.1)
                ],
            }
        },
        "Site:GroundTemperature:BuildingSurface": {"Soil": {f"{month}_ground_temperature": 18.0 for month in MONTHS}},
        **materials(),
    }


def run_period(period):
    """Days from (month, day) to (month, day), from a Monday on."""
    (m0, d0), (m1, d1) = period
    return {
        "begin_month": m0,
        "begin_day_of_month": d0,
        "end_month": m1,
        "end_day_of_month": d1,
        "day_of_week_for_start_day": "Monday",
        "use_weather_file_daylight_saving_period": "No",
        "use_weather_file_holidays_and_special_days": "No",
    }


def also(model, *periods):
    """Adds further periods."""
    for k, period in enumerate(periods):
        model["RunPeriod"][f"Period {k + 2}"] = run_period(period)


def materials():
    """Walls by reflectance, a double window and the panes of glazed facades."""
    return {
        "Material": {
            "Concrete": solid(0.15, 1.3, 2200.0, 0.7),
            "Insulation": solid(0.08, 0.04, 40.0, 0.7),
            **{f"Render {p}": solid(0.02, 0.9, 1800.0, 1 - p / 100) for p in (20, 40, 60, 75)},
        },
        "WindowMaterial:Glazing": {"Clear": pane(0.775, 0.071), "Mirror": pane(0.25, 0.4)},
        "WindowMaterial:Gas": {"Air": {"gas_type": "Air", "thickness": 0.012}},
        "Construction": {
            "Slab": {"outside_layer": "Concrete"},
            "Double": {"outside_layer": "Clear", "layer_2": "Air", "layer_3": "Clear"},
            "Mirror pane": {"outside_layer": "Mirror"},
            **{
                f"Wall {p}": {"outside_layer": f"Render {p}", "layer_2": "Insulation", "layer_3": "Concrete"}
                for p in (20, 40, 60, 75)
            },
        },
    }


def solid(thickness_m, conductivity, density, absorptance):
    return {
        "roughness": "MediumRough",
        "thickness": thickness_m,
        "conductivity": conductivity,
        "density": density,
        "specific_heat": 900.0,
        "thermal_absorptance": 0.9,
        "solar_absorptance": absorptance,
        "visible_absorptance": absorptance,
    }


def pane(transmittance, reflectance):
    sides = {
        f"{face}_side_{band}_reflectance_at_normal_incidence": reflectance
        for face in ("front", "back")
        for band in ("solar", "visible")
    }
    return {
        "optical_data_type": "SpectralAverage",
        "thickness": 0.006,
        "solar_transmittance_at_normal_incidence": transmittance,
        "visible_transmittance_at_normal_incidence": transmittance,
        **sides,
    }


def corners(points):
    keys = ("vertex_x_coordinate", "vertex_y_coordinate", "vertex_z_coordinate")
    return [dict(zip(keys, (round(c, 6) for c in point))) for point in points]


def upright(start, end, low, high):
    """The rectangle over the edge from `start` to `end`, which has the outside on its right."""
    (x0, y0), (x1, y1) = start, end
    return [(x0, y0, high), (x0, y0, low), (x1, y1, low), (x1, y1, high)]


def edges(x0, y0, x1, y1):
    """The sides of a rectangle, each with the outside on its right."""
    a, b, c, d = (x0, y0), (x1, y0), (x1, y1), (x0, y1)
    return dict(zip(SIDES, ((a, b), (b, c), (c, d), (d, a))))


def zone(model, name, floor_plan, low, high, inside=(), windows=None, wall="Wall 40", roof=False, ground=False, gains_w=None):
    """Adds a zone over (x0, y0, x1, y1). Sides in `inside` are adiabatic, the others have the windows of `windows`: side ->
    list of (from, to, low, high), shares of the side's width and height."""
    x0, y0, x1, y1 = floor_plan
    model.setdefault("Zone", {})[name] = {}
    surfaces = model.setdefault("BuildingSurface:Detailed", {})
    for side, (start, end) in edges(*floor_plan).items():
        outdoors = side not in inside
        surfaces[f"{name} {side}"] = surface("Wall", name, wall if outdoors else "Slab", outdoors, upright(start, end, low, high))
        for k, shares in enumerate((windows or {}).get(side, []) if outdoors else []):
            window(model, f"{name} {side} window {k + 1}", f"{name} {side}", start, end, low, high, shares)
    top = [(x0, y1, high), (x0, y0, high), (x1, y0, high), (x1, y1, high)]
    surfaces[f"{name} top"] = surface("Roof" if roof else "Ceiling", name, "Wall 40" if roof else "Slab", roof, top)
    bottom = [(x, y, low) for x, y, _ in (top[3], top[2], top[1], top[0])]
    surfaces[f"{name} floor"] = surface("Floor", name, "Wall 40" if ground else "Slab", False, bottom)
    if ground:
        surfaces[f"{name} floor"]["outside_boundary_condition"] = "Ground"
    gains_w = 15.0 * (x1 - x0) * (y1 - y0) if gains_w is None else gains_w
    model.setdefault("OtherEquipment", {})[f"{name} gains"] = {
        "zone_or_zonelist_or_space_or_spacelist_name": name,
        "schedule_name": "At work",
        "design_level": gains_w,
        "fraction_radiant": 0.4,
    }
    model.setdefault("ZoneInfiltration:DesignFlowRate", {})[f"{name} air"] = {
        "zone_or_zonelist_or_space_or_spacelist_name": name,
        "schedule_name": "Always",
        "design_flow_rate_calculation_method": "AirChanges/Hour",
        "air_changes_per_hour": 0.2,
    }
    ideal_loads(model, name)


def surface(kind, name, construction, outdoors, points):
    return {
        "surface_type": kind,
        "construction_name": construction,
        "zone_name": name,
        "outside_boundary_condition": "Outdoors" if outdoors else "Adiabatic",
        "sun_exposure": "SunExposed" if outdoors else "NoSun",
        "wind_exposure": "WindExposed" if outdoors else "NoWind",
        "vertices": corners(points),
    }


def window(model, name, wall, start, end, low, high, shares, construction="Double"):
    """Adds a window over shares (from, to, low, high) of the wall over `start` to `end`."""
    left, right, sill, head = shares
    at = lambda share: tuple(a + share * (b - a) for a, b in zip(start, end))
    points = upright(at(left), at(right), low + sill * (high - low), low + head * (high - low))
    flat = {
        f"vertex_{k + 1}_{axis}_coordinate": round(value, 6)
        for k, point in enumerate(points)
        for axis, value in zip("xyz", point)
    }
    model.setdefault("FenestrationSurface:Detailed", {})[name] = {
        "surface_type": "Window",
        "construction_name": construction,
        "building_surface_name": wall,
        "number_of_vertices": 4,
        **flat,
    }


def ideal_loads(model, name, heat="Heat to", cool="Cool to", control="Dual"):
    """Adds a thermostat and an ideal load system without latent loads or outdoor air to a zone."""
    model.setdefault("ThermostatSetpoint:DualSetpoint", {})[f"{name} setpoints"] = {
        "heating_setpoint_temperature_schedule_name": heat,
        "cooling_setpoint_temperature_schedule_name": cool,
    }
    model.setdefault("ZoneControl:Thermostat", {})[f"{name} thermostat"] = {
        "zone_or_zonelist_name": name,
        "control_type_schedule_name": control,
        "control_1_object_type": "ThermostatSetpoint:DualSetpoint",
        "control_1_name": f"{name} setpoints",
    }
    model.setdefault("ZoneHVAC:IdealLoadsAirSystem", {})[f"{name} loads"] = {
        "zone_supply_air_node_name": f"{name} supply",
        "dehumidification_control_type": "None",
    }
    model.setdefault("ZoneHVAC:EquipmentList", {})[f"{name} equipment"] = {
        "equipment": [
            {
                "zone_equipment_object_type": "ZoneHVAC:IdealLoadsAirSystem",
                "zone_equipment_name": f"{name} loads",
                "zone_equipment_cooling_sequence": 1,
                "zone_equipment_heating_or_no_load_sequence": 1,
            }
        ]
    }
    model.setdefault("ZoneHVAC:EquipmentConnections", {})[f"{name} connections"] = {
        "zone_name": name,
        "zone_conditioning_equipment_list_name": f"{name} equipment",
        "zone_air_inlet_node_or_nodelist_name": f"{name} supply",
        "zone_air_node_name": f"{name} air node",
        "zone_return_air_node_or_nodelist_name": f"{name} return",
    }


def shade(model, name, points, diffuse, glazed=0.0, kind="Shading:Site:Detailed"):
    """Adds a shading polygon, a share of it mirroring glass."""
    model.setdefault(kind, {})[name] = {"number_of_vertices": len(points), "vertices": corners(points)}
    reflectance = {
        "shading_surface_name": name,
        "diffuse_solar_reflectance_of_unglazed_part_of_shading_surface": diffuse,
        "diffuse_visible_reflectance_of_unglazed_part_of_shading_surface": diffuse,
        "fraction_of_shading_surface_that_is_glazed": glazed,
    }
    if glazed:
        reflectance["glazing_construction_name"] = "Mirror pane"
    model.setdefault("ShadingProperty:Reflectance", {})[f"{name} reflectance"] = reflectance


def facade(model, name, start, end, low, high, across, up, diffuse, glazed=lambda i, k: 0.0):
    """Adds a facade over the edge `start` to `end` (outside on its right), cut into `across` x `up` panels."""
    at = lambda share: tuple(a + share * (b - a) for a, b in zip(start, end))
    for i in range(across):
        for k in range(up):
            z0, z1 = (low + (high - low) * part / up for part in (k, k + 1))
            points = upright(at(i / across), at((i + 1) / across), z0, z1)
            shade(model, f"{name} {i + 1} {k + 1}", points, diffuse, glazed(i, k))


def block(model, name, floor_plan, height, across, up, diffuse, glazed=lambda i, k: 0.0, low=0.0):
    """Adds four facades of panels and a roof."""
    x0, y0, x1, y1 = floor_plan
    for side, (start, end) in edges(*floor_plan).items():
        facade(model, f"{name} {side}", start, end, low, height, across, up, diffuse, glazed)
    shade(model, f"{name} roof", [(x0, y1, height), (x0, y0, height), (x1, y0, height), (x1, y1, height)], diffuse)


def exposed(model):
    """Names of the surfaces and windows that the sun reaches."""
    walls = [name for name, wall in model["BuildingSurface:Detailed"].items() if wall["sun_exposure"] == "SunExposed"]
    return walls + [name for name, w in model["FenestrationSurface:Detailed"].items() if w["building_surface_name"] in walls]


def outputs(model, frequency="Hourly"):
    """Asks for what the comparison reads, in the `.eso` alone; drops constructions that nothing has."""
    asked = [("*", name) for name in (*LOADS, *SUN, *SITE)]
    asked += [(surface, name) for surface in exposed(model) for name in (*REFLECTED, *DIRECT)]
    model["Output:Variable"] = {
        f"Output {k + 1}": {"key_value": key, "variable_name": name, "reporting_frequency": frequency}
        for k, (key, name) in enumerate(asked)
    }
    used = json.dumps(
        [
            model.get(kind, {})
            for kind in (
                "BuildingSurface:Detailed",
                "FenestrationSurface:Detailed",
                "ShadingProperty:Reflectance",
                "InternalMass",
            )
        ]
    )
    model["Construction"] = {name: layers for name, layers in model["Construction"].items() if json.dumps(name) in used}
    off = ("mtr", "tabular", "audit", "space_sizing", "zone_sizing", "system_sizing", "dxf", "bnd", "rdd", "mdd", "mtd", "shd")
    model["OutputControl:Files"] = {"Files": {f"output_{name}": "No" for name in off}}
    return model
