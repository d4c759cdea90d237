"""Draws a site from above, receivers coloured by annual irradiation: site-picture.py SCENE.obj RECEIVERS.csv YEAR.csv OUT.png

Needs matplotlib. The picture in src/book/building.md is made by it from the output of tools/first-site.
"""

import csv
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.collections import PolyCollection

scene, receivers, year, out = sys.argv[1:5]
vertices, faces, material = [], [], ""
for line in open(scene):
    word = line.split()
    if not word:
        continue
    if word[0] == "v":
        vertices.append(tuple(map(float, word[1:4])))
    elif word[0] == "usemtl":
        material = word[1]
    elif word[0] == "f" and material != "wall":
        corners = [vertices[int(w.split("/")[0]) - 1] for w in word[1:]]
        faces.append((sum(c[2] for c in corners), [c[:2] for c in corners], "#d9d4c7" if material == "terrain" else "#b9b9b9"))
faces.sort(key=lambda f: f[0])
place = {row["receiver"]: (float(row["x"]), float(row["y"])) for row in csv.DictReader(open(receivers))}
total = {row["receiver"]: float(row["total_kwh_m2"]) for row in csv.DictReader(open(year))}
names = [name for name in place if name in total]

figure, axes = plt.subplots(figsize=(6.4, 5.2), dpi=110)
axes.add_collection(PolyCollection([f[1] for f in faces], facecolors=[f[2] for f in faces], edgecolors="white", linewidths=0.2))
dots = axes.scatter(
    [place[n][0] for n in names], [place[n][1] for n in names], c=[total[n] for n in names],
    cmap="inferno", s=36, edgecolors="black", linewidths=0.5, zorder=3,
)
figure.colorbar(dots, label="annual irradiation, kWh/m$^2$")
axes.set_aspect("equal")
axes.autoscale_view()
axes.set_xlabel("x, m")
axes.set_ylabel("y, m")
axes.ticklabel_format(useOffset=False)
axes.tick_params(labelsize=7)
figure.tight_layout()
figure.savefig(out)
