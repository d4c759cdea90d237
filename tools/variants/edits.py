#!/usr/bin/env python3
"""Five variants of a CityJSON tile: edits.py SITE.city.json FOLDER writes house, storey, tower, wall and terrain.city.json.

The house is the one nearest to the middle of all that is 6 to 15 m wide, and 6 to 14 m high.
"""

import copy
import json
import math
import sys


def main(site, folder):
    city = json.load(open(site))
    scale, shift = city["transform"]["scale"], city["transform"]["translate"]

    def place(corner):
        return [corner[k] * scale[k] + shift[k] for k in range(3)]

    def number(point):
        return [round((point[k] - shift[k]) / scale[k]) for k in range(3)]

    def corners(boundaries):
        return [boundaries] if isinstance(boundaries, int) else [c for part in boundaries for c in corners(part)]

    def moved(document, name, to):
        """All corners of an object, which no other object keeps."""
        new = {}

        def walk(boundaries):
            if not isinstance(boundaries, int):
                return [walk(part) for part in boundaries]
            if boundaries not in new:
                document["vertices"].append(number(to(place(document["vertices"][boundaries]))))
                new[boundaries] = len(document["vertices"]) - 1
            return new[boundaries]

        for geometry in document["CityObjects"][name]["geometry"]:
            geometry["boundaries"] = walk(geometry["boundaries"])

    houses = []
    for name, thing in city["CityObjects"].items():
        points = [place(city["vertices"][c]) for g in thing.get("geometry", []) for c in corners(g["boundaries"])]
        if points and thing["type"].startswith("Building"):
            houses.append((name, [min(p) for p in zip(*points)], [max(p) for p in zip(*points)]))
    middle = [sorted(low[k] for _, low, _ in houses)[len(houses) // 2] for k in range(2)]

    def fits(house):
        size = [house[2][k] - house[1][k] for k in range(3)]
        return 6 < size[0] < 15 and 6 < size[1] < 15 and 6 < size[2] < 14

    house, low, _ = min(filter(fits, houses), key=lambda h: math.dist(h[1][:2], middle))

    def save(name, edit):
        variant = copy.deepcopy(city)
        edit(variant)
        with open(f"{folder}/{name}.city.json", "w") as file:
            json.dump(variant, file)

    def tower(variant):
        first = len(variant["vertices"])
        for z in (low[2] - 1, low[2] + 100):
            for x, y in ((0, 0), (20, 0), (20, 20), (0, 20)):
                variant["vertices"].append(number([low[0] + x, low[1] + y, z]))
        faces = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
        shell = [[[first + corner for corner in face]] for face in faces]
        geometry = {"type": "Solid", "lod": "2", "boundaries": [shell]}
        variant["CityObjects"]["tower"] = {"type": "Building", "geometry": [geometry]}

    def wall(variant):
        """The first wall takes the material of the roof."""
        semantics = variant["CityObjects"][house]["geometry"][0]["semantics"]
        kinds = [surface["type"] for surface in semantics["surfaces"]]

        def paint(values):
            for i, value in enumerate(values):
                if isinstance(value, list):
                    if paint(value):
                        return True
                elif value is not None and kinds[value] == "WallSurface":
                    values[i] = kinds.index("RoofSurface")
                    return True
            return False

        paint(semantics["values"])

    def terrain(variant):
        for name, thing in city["CityObjects"].items():
            if thing["type"] == "TINRelief":
                moved(variant, name, lambda p: [p[0], p[1], p[2] - 0.2 - 0.1 * math.sin(p[0] / 50)])

    save("house", lambda v: moved(v, house, lambda p: [p[0] + 5, p[1] + 3, p[2]]))
    save("storey", lambda v: moved(v, house, lambda p: [p[0], p[1], p[2] + 3 * (p[2] > low[2] + 1)]))
    save("tower", tower)
    save("wall", wall)
    save("terrain", terrain)


main(*sys.argv[1:])
