"""A block of The Hague: cover it, trace it, sum a year, look at single receivers."""

# %% [markdown]
# # A block of a city
# A city model, receivers on its roofs and walls, a year of weather. Coordinates are metres, x east, y north, z up.

# %%
import tempfile
from pathlib import Path

import heliotile
import numpy as np
import pandas as pd
import xarray as xr

DATA = Path(__file__).parents[3] / "tests" / "data"
WEATHER = DATA / "weather" / "golden_tmy3.epw"
folder = tempfile.TemporaryDirectory()
here = Path(folder.name)

# %% [markdown]
# ## Trace once

# %%
scene = heliotile.Scene(DATA / "cityjson" / "hague.city.json")
print(scene.cover(here / "receivers.csv", spacing=2.0))
site = heliotile.build(scene, here / "receivers.csv", here / "site.helio")
print(site.count, "receivers in", site.tiles, "tiles")

# %% [markdown]
# ## Sums of a year, kWh/m2
# Results are float32, shape (receivers, periods); means of surfaces go by area.

# %%
months = site.replay(WEATHER, every="month", year=2019)
table = pd.DataFrame(site.receivers()).assign(total=months["total"].sum(axis=1))
for kind, of in table.groupby("kind"):
    print(f"{kind}: {np.average(of['total'], weights=of['area_m2']):.1f} kWh/m2, {of['area_m2'].sum():.1f} m2")

# %% [markdown]
# ## Hours of the best receiver
# A Dataset computes only the tile of 64 receivers that is asked for.

# %%
hours = xr.open_dataset(site.path, engine="heliotile", weather=WEATHER, year=2019, columns=["total"])
best = table.loc[table["total"].idxmax(), "receiver"]
june = hours["total"].sel(receiver=best, time="2019-06")
print(f"{best}: {june.values.sum() / 1000:.1f} kWh/m2 in June, at most {june.values.max():.0f} W/m2")
print(f"1 of {site.tiles} tiles was computed")

# %%
folder.cleanup()
