"""Hours of `heliotile pv` through pvlib: watts and kilowatt hours of a module. In: hourly.csv, a point. Out: a sentence."""

import sys

import pandas as pd
from pvlib import pvsystem, temperature

hours = pd.read_csv(sys.argv[1])
hours = hours[hours["point"] == sys.argv[2]]
hours.index = pd.to_datetime(hours["time"], utc=True)
step_h = (hours.index[1] - hours.index[0]) / pd.Timedelta("1h")
cell = temperature.sapm_cell(hours["poa_global"], temp_air=20, wind_speed=1, a=-3.47, b=-0.0594, deltaT=3)
watts = pvsystem.pvwatts_dc(hours["poa_global"], cell, pdc0=400, gamma_pdc=-0.004)
print(f"{sys.argv[2]}: at most {watts.max():.0f} W, {watts.sum() * step_h / 1000:.0f} kWh in a year")
