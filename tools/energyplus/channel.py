"""The channel alone. In: a case. Out: a model into which EnergyPlus's own reflected light goes as series through the actuator
`View Factor To Ground`, and the CSV beside it; its loads have to be those of the run that the series are from."""

import json

import numpy as np

import parts

NAME = "reflected.csv"


def reflected(series, surfaces):
    """W/m2 [step][surface]: all light that EnergyPlus reflects onto the outside of each surface."""
    return np.stack([sum(series.values[(name.upper(), part)] for part in parts.REFLECTED) for name in surfaces], axis=1)


def injected(model, series, folder):
    """The model with its own reflected light injected, and the file that it reads. Every row is a time step of a common year."""
    steps = next(iter(model["Timestep"].values()))["number_of_timesteps_per_hour"]
    surfaces = parts.exposed(model)
    rows = np.zeros((8760 * steps, len(surfaces)))
    days = np.cumsum([0, 31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30])
    at = [
        ((days[m - 1] + d - 1) * 24 + hour - 1) * steps + round(minute * steps / 60) - 1 for _, m, d, hour, minute in series.times
    ]
    rows[at] = reflected(series, surfaces)
    file = folder / NAME
    folder.mkdir(parents=True, exist_ok=True)
    np.savetxt(file, rows, delimiter=",", fmt="%.9g", header=",".join(f"surface {k}" for k in range(len(surfaces))), comments="")
    return through_actuators(model, surfaces, file, 60 // steps), file


def through_actuators(model, surfaces, file, minutes):
    """A copy of the model with a schedule, a sensor and an actuator a surface."""
    copy = json.loads(json.dumps(model))
    ems = {
        kind: copy.setdefault(f"EnergyManagementSystem:{kind}", {})
        for kind in ("Sensor", "Actuator", "Program", "ProgramCallingManager")
    }
    ems["Sensor"]["GSR"] = sensor("Environment", "Site Ground Reflected Solar Radiation Rate per Area")
    lines, dark = ["IF GSR > 0.01"], ["ELSE"]
    schedules = copy.setdefault("Schedule:File", {})
    for k, surface in enumerate(surfaces):
        schedules[f"Light {k}"] = {
            "schedule_type_limits_name": "Any",
            "file_name": str(file),
            "column_number": k + 1,
            "rows_to_skip_at_top": 1,
            "number_of_hours_of_data": 8760,
            "column_separator": "Comma",
            "interpolate_to_timestep": "No",
            "minutes_per_item": minutes,
            "adjust_schedule_for_daylight_savings": "No",
        }
        ems["Sensor"][f"S{k}"] = sensor(f"Light {k}", "Schedule Value")
        ems["Actuator"][f"A{k}"] = {
            "actuated_component_unique_name": surface,
            "actuated_component_type": "Surface",
            "actuated_component_control_type": "View Factor To Ground",
        }
        lines.append(f"SET A{k} = S{k} / GSR")
        dark.append(f"SET A{k} = 0")
    ems["Program"]["Inject"] = {"lines": [{"program_line": line} for line in (*lines, *dark, "ENDIF")]}
    ems["ProgramCallingManager"]["Each step"] = {
        "energyplus_model_calling_point": "BeginZoneTimestepBeforeInitHeatBalance",
        "programs": [{"program_name": "Inject"}],
    }
    return copy


def sensor(key, variable):
    return {"output_variable_or_output_meter_index_key_name": key, "output_variable_or_output_meter_name": variable}
