"""Draws the map that `heliotile run` writes, seen from the south-west or another side: map-picture.py annual.ply OUT.png [AZIMUTH]

Needs numpy and matplotlib. README's picture is made by it from the first command's map.
"""

import sys

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.collections import PolyCollection

ply, out = sys.argv[1:3]
azimuth = np.radians(float(sys.argv[3]) if len(sys.argv) > 3 else 205.0)
data = open(ply, "rb").read()
end = data.index(b"end_header\n") + 11
count = {line.split()[1]: int(line.split()[2]) for line in data[:end].decode().splitlines() if line.startswith("element")}
vertex = np.dtype([("p", "<f8", 3), ("total", "<f4"), ("rgb", "u1", 3)])
vertices = np.frombuffer(data, vertex, count["vertex"], end)
face = np.dtype([("n", "u1"), ("i", "<i4", 3)])
faces = np.frombuffer(data, face, count["face"], end + vertex.itemsize * count["vertex"])["i"]

p = vertices["p"] - vertices["p"].mean(axis=0)
# The eye stands at this azimuth, 35 degrees up.
up = np.radians(35.0)
eye = np.array([np.sin(azimuth) * np.cos(up), np.cos(azimuth) * np.cos(up), np.sin(up)])
right = np.cross([0.0, 0.0, 1.0], eye)
right /= np.linalg.norm(right)
flat = np.stack([p @ right, p @ np.cross(eye, right)], axis=1)
corners = p[faces]
normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
seen = normal @ eye > 0
faces, depth = faces[seen], corners[seen].mean(axis=1) @ eye
order = np.argsort(depth)
total = vertices["total"][faces[:, 0]]

figure, axes = plt.subplots(figsize=(7.2, 4.4), dpi=110)
shapes = PolyCollection(flat[faces[order]], array=total[order], cmap="inferno", edgecolors="face", linewidths=0.3)
shapes.set_clim(0, vertices["total"].max())
axes.add_collection(shapes)
figure.colorbar(shapes, label="annual irradiation, kWh/m$^2$", shrink=0.8)
axes.set_aspect("equal")
axes.autoscale_view()
axes.axis("off")
figure.tight_layout()
figure.savefig(out)
