"""EnergyPlus: what a model's surroundings reflect on its surfaces, over the sun's position."""

# %% [markdown]
# # Factors for EnergyPlus
# A model that EnergyPlus reads is a scene. The five factors are those of `heliotile energyplus factors`, for ground that reflects all.

# %%
import tempfile
from pathlib import Path

import heliotile
import numpy as np

DATA = Path(__file__).parents[3] / "tests" / "data"
folder = tempfile.TemporaryDirectory()
here = Path(folder.name)

# %% [markdown]
# ## The model and receivers on it
# Its zones, shades and reflectances; receivers go on walls, roofs and windows, half a metre apart.

# %%
scene = heliotile.Scene(DATA / "energyplus" / "box.idf")
print(scene.cover(here / "receivers.csv", spacing=0.5))
site = heliotile.build(scene, here / "receivers.csv", here / "site.helio")

# %% [markdown]
# ## Factors
# Shape: surfaces, azimuths, altitudes; means over the receivers of a surface, by area.

# %%
factors = site.factors(by="surface", azimuth_step=10, altitude_step=5)
for name, values in factors.values.items():
    most = factors.names[int(values.max(axis=(1, 2)).argmax())]
    print(f"{name}: {values.shape}, mean {values.mean():.4f}, at most {values.max():.4f} on {most}")

# %% [markdown]
# ## An hour by hand
# Irradiance = DNI x (obstructions + mirrors) + DNI sin(altitude) x reflectance of the ground x ground + DHI x (...).

# %%
azimuth, altitude, dni, dhi, ground = 180.0, 45.0, 800.0, 100.0, 0.2
sun = factors.to_xarray().sel(sun_azimuth_deg=azimuth, sun_altitude_deg=altitude)
reflected = dni * (sun["ReflFacBmToDiffSolObs"] + sun["ReflFacBmToBmSolObs"]) + dhi * sun["ReflFacSkySolObs"]
reflected += ground * (dni * np.sin(np.radians(altitude)) * sun["ReflFacBmToDiffSolGnd"] + dhi * sun["ReflFacSkySolGnd"])
print(f"reflected at {altitude:.0f} degrees: {float(reflected.min()):.1f} to {float(reflected.max()):.1f} W/m2 on {len(factors.names)} surfaces")

# %% [markdown]
# As a table for others:

# %%
table = factors.to_xarray().to_dataframe().reset_index()
table.to_csv(here / "factors.csv", index=False)
print(f"{len(table)} rows: {', '.join(table.columns)}")

# %%
folder.cleanup()
