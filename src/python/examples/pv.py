"""Two modules beside a wall: light from heliotile, watts from pvlib's ModelChain."""

# %% [markdown]
# # Modules for pvlib
# Two modules look south, one of them with a white wall behind it and a block before it.

# %%
import tempfile
from pathlib import Path

import heliotile
from pvlib import iotools, location, modelchain, pvsystem, temperature

DATA = Path(__file__).parents[3] / "tests" / "data"
WEATHER = DATA / "weather" / "golden_tmy3.epw"
folder = tempfile.TemporaryDirectory()
here = Path(folder.name)

# %% [markdown]
# ## A scene of one's own
# A wall of 10 m x 4 m along y = 6, a block along y = -8.

# %%
(here / "scene.obj").write_text(
    """usemtl wall
v -5 6 0
v 5 6 0
v 5 6 4
v -5 6 4
f 1 2 3 4
usemtl block
v -5 -8 0
v 5 -8 0
v 5 -8 3
v -5 -8 3
f 5 6 7 8
"""
)
(here / "materials.toml").write_text("[wall]\ndiffuse = 0.8\n\n[block]\ndiffuse = 0.3\n")
scene = heliotile.Scene(here / "scene.obj", materials=here / "materials.toml", latitude=39.74, longitude=-105.18)
modules = {
    "receiver": ["between", "open"],
    "x": [0.0, 60.0],
    "y": [0.0, 0.0],
    "z": [1.0, 1.0],
    "tilt_deg": [35.0, 35.0],
    "azimuth_deg": [180.0, 180.0],
}
site = heliotile.build(scene, modules, here / "site.helio", quality="fine")

# %% [markdown]
# ## Watts
# Rows are labelled with the middle of their hour, where solar positions are taken.

# %%
hours = site.replay(WEATHER, year=2019, stamp="middle")
air, about = iotools.read_epw(WEATHER)
place = location.Location(about["latitude"], about["longitude"], tz=about["TZ"], altitude=about["altitude"])
mount = temperature.TEMPERATURE_MODEL_PARAMETERS["sapm"]["open_rack_glass_polymer"]
system = pvsystem.PVSystem(
    surface_tilt=35,
    surface_azimuth=180,
    module_parameters={"pdc0": 400, "gamma_pdc": -0.004},
    inverter_parameters={"pdc0": 400},
    temperature_model_parameters=mount,
)
chain = modelchain.ModelChain(system, place, aoi_model="no_loss", spectral_model="no_loss")
for module in hours.receivers:
    light = hours.to_pvlib(module)
    light["temp_air"], light["wind_speed"] = air["temp_air"].to_numpy(), air["wind_speed"].to_numpy()
    chain.run_model_from_poa(light)
    watts = chain.results.ac
    assert watts is not None
    print(f"{module}: {light['poa_global'].sum() / 1000:.0f} kWh/m2, {watts.sum() / 1000:.0f} kWh of 400 W")

# %%
folder.cleanup()
