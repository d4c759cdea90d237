"""Snow and leaves: one trace, other seasons."""

# %% [markdown]
# # Seasons
# A facade behind a tree, whose leaves let a share of the light through at each crossing, on ground that snow covers.

# %%
import tempfile
from pathlib import Path

import heliotile
import numpy as np

DATA = Path(__file__).parents[3] / "tests" / "data"
WEATHER = DATA / "weather" / "golden_tmy3.epw"
folder = tempfile.TemporaryDirectory()
here = Path(folder.name)


# %%
def box(name: str, low: tuple[float, float, float], high: tuple[float, float, float], first: int) -> str:
    """Six faces of an OBJ file."""
    corners = [(x, y, z) for z in (low[2], high[2]) for y in (low[1], high[1]) for x in (low[0], high[0])]
    faces = [(1, 3, 4, 2), (5, 6, 8, 7), (1, 2, 6, 5), (3, 7, 8, 4), (1, 5, 7, 3), (2, 4, 8, 6)]
    lines = [f"o {name}", f"usemtl {name}", *(f"v {x} {y} {z}" for x, y, z in corners)]
    return "\n".join([*lines, *("f " + " ".join(str(first + i - 1) for i in face) for face in faces)]) + "\n"


(here / "scene.obj").write_text(box("house", (-5, 0, 0), (5, 8, 6), 1) + box("leaves", (-2, -7, 2), (2, -3, 6), 9))
(here / "materials.toml").write_text("[house]\ndiffuse = 0.4\n\n[leaves]\ntransmittance = 0.4\n")
scene = heliotile.Scene(here / "scene.obj", materials=here / "materials.toml", latitude=39.74, longitude=-105.18)
facade = {
    "receiver": [f"floor {i}" for i in range(3)],
    "x": [0.0] * 3,
    "y": [-0.01] * 3,
    "z": [1.0, 3.0, 5.0],
    "nx": [0.0] * 3,
    "ny": [-1.0] * 3,
    "nz": [0.0] * 3,
}
site = heliotile.build(scene, facade, here / "site.helio")
print({material.name: (material.diffuse, material.transmittance) for material in site.materials()})

# %% [markdown]
# ## Three years of the same weather
# Twelve values are months; as many as the weather has rows are hours. Where the weather states its snow, `snow="depth"` follows that.

# %%
bare = np.array([0.8, 0.8, 0.7, 0.6, 0.4, 0.4, 0.4, 0.4, 0.4, 0.5, 0.7, 0.8])
seasons = {
    "leaves all year": {},
    "leaves fall": {"transmittance": {"leaves": bare}},
    "and a white winter": {"transmittance": {"leaves": bare}, "reflectance": {"ground": np.where(bare > 0.6, 0.7, 0.2)}},
}
for name, changes in seasons.items():
    months = site.replay(WEATHER, every="month", year=2019, **changes)
    january, june = months["total"][:, 0], months["total"][:, 5]
    print(f"{name}: January {january.round(1)}, June {june.round(1)} kWh/m2")

# %%
folder.cleanup()
