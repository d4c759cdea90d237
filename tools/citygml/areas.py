#!/usr/bin/env python3
"""A second reader of CityGML: buildings by gml:id and areas by kind of surface, from the standard library alone.

usage: areas.py FILE.gml [--lod N]

It shares nothing with the reader in src/scene/formats/citygml but the standard: for each feature it takes the finest level of detail (of 1 to 3),
the polygons of its thematic surfaces with their names, and those of its solids that no thematic surface holds, told apart by tilt.
Coordinates in degrees become metres by the radii of the ellipsoid at the first corner, good to 0.1 % of an area.
"""

import math
import sys
import xml.etree.ElementTree as ET

XLINK = "{http://www.w3.org/1999/xlink}href"
PARTS = {"BuildingPart", "BuildingInstallation", "TINRelief", "BridgePart", "TunnelPart"}
SURFACES = {"TrafficArea", "AuxiliaryTrafficArea", "Window", "Door"}


def local(element):
    return element.tag.rsplit("}", 1)[-1]


def gml_id(element):
    return next((value for key, value in element.attrib.items() if key.rsplit("}", 1)[-1] == "id"), None)


class Metres:
    """From numbers to metres: degrees, latitude first, about the first corner."""

    def __init__(self, system):
        self.is_degrees = any(number in system for number in ("6697", "6668", "4326", "4979", "4258"))
        self.scale = None

    def __call__(self, a, b, z):
        if not self.is_degrees:
            return a, b, z
        if self.scale is None:
            latitude = math.radians(a)
            bent = 1 - 0.00669438 * math.sin(latitude) ** 2
            north = 6378137 * (1 - 0.00669438) / bent**1.5
            east = 6378137 / math.sqrt(bent) * math.cos(latitude)
            self.scale = math.radians(east), math.radians(north), a, b
        east, north, a0, b0 = self.scale
        return (b - b0) * east, (a - a0) * north, z


def ring_vector(ring, metres):
    numbers = [float(word) for part in ring.iter() if local(part) in ("posList", "pos") for word in part.text.split()]
    corners = [metres(*numbers[i : i + 3]) for i in range(0, len(numbers) - 2, 3)]
    if len(corners) < 3:
        return 0.0, 0.0, 0.0
    x0, y0, z0 = corners[0]
    total = [0.0, 0.0, 0.0]
    for p, q in zip(corners, corners[1:] + corners[:1]):
        ax, ay, az, bx, by, bz = p[0] - x0, p[1] - y0, p[2] - z0, q[0] - x0, q[1] - y0, q[2] - z0
        total[0] += (ay * bz - az * by) / 2
        total[1] += (az * bx - ax * bz) / 2
        total[2] += (ax * by - ay * bx) / 2
    return tuple(total)


def polygon_area(polygon, metres):
    """Area less that of the holes, and the upward part of the normal of the outline."""
    area, up = 0.0, 0.0
    for side in polygon:
        vector = ring_vector(side, metres)
        length = math.sqrt(sum(part * part for part in vector))
        if local(side) == "exterior":
            area += length
            up = vector[2] / length if length else 0.0
        elif local(side) == "interior":
            area -= length
    return area, up


def lod_of(name):
    return int(name[3]) if name.startswith("lod") and name[3:4].isdigit() and "TerrainIntersection" not in name else None


def polygons(element, ids, depth=0):
    """Polygons within an element and those that it refers to."""
    target = ids.get((element.get(XLINK) or "")[1:]) if element.get(XLINK) else None
    if target is not None and depth < 9:
        yield from polygons(target, ids, depth + 1)
    if local(element) in ("Polygon", "Triangle", "PolygonPatch"):
        yield element
        return
    for child in element:
        yield from polygons(child, ids, depth)


def surfaces(element, lod, name):
    """Thematic surfaces of a feature with their geometry of a level."""
    for prop in element:
        if local(prop) in ("boundedBy", "boundary", "opening", "fillingSurface"):
            for surface in prop:
                if local(surface).endswith("Surface") or local(surface) in SURFACES:
                    yield from surfaces(surface, lod, local(surface))
        elif name and lod_of(local(prop)) == lod:
            yield name, prop


def levels(feature):
    found = {lod_of(local(prop)) for prop in feature if lod_of(local(prop)) is not None and len(prop)}
    found |= {lod_of(local(p)) for prop in feature if local(prop) in ("boundedBy", "boundary") for s in prop for p in s}
    return {level for level in found if level in (1, 2, 3)}


def read(path, asked=None):
    root = ET.parse(path).getroot()
    ids = {gml_id(element): element for element in root.iter() if gml_id(element)}
    system = next((element.get("srsName") for element in root.iter() if element.get("srsName")), "")
    metres = Metres(system)
    areas, counts, objects = {}, {}, {}

    def add(name, polygon):
        area, up = polygon_area(polygon, metres)
        if name is None:
            name = "RoofSurface" if up > 0.26 else "GroundSurface" if up < -0.26 else "WallSurface"
        areas[name] = areas.get(name, 0.0) + area
        counts[name] = counts.get(name, 0) + 1

    for feature in root.iter():
        kind = local(feature)
        if kind == "TINRelief":
            for polygon in polygons(feature, {}):
                add(kind, polygon)
        elif kind in ("Building", "BuildingPart", "BuildingInstallation"):
            found = levels(feature)
            found = {level for level in found if asked is None or level <= asked}
            if not found:
                continue
            lod, seen = max(found), set()
            for name, prop in surfaces(feature, lod, None):
                for polygon in polygons(prop, ids):
                    if id(polygon) not in seen:
                        seen.add(id(polygon))
                        add(name, polygon)
            for prop in feature:
                if lod_of(local(prop)) == lod:
                    for polygon in polygons(prop, ids):
                        if id(polygon) not in seen:
                            seen.add(id(polygon))
                            add(None, polygon)
        else:
            continue
        objects.setdefault(kind, set()).add(gml_id(feature))
    return objects, counts, areas


if __name__ == "__main__":
    lod = int(sys.argv[3]) if len(sys.argv) > 3 else None
    objects, counts, areas = read(sys.argv[1], lod)
    for kind in sorted(objects):
        print(f"{kind:24} {len(objects[kind])} objects")
    for kind in sorted(areas):
        print(f"{kind:24} {counts[kind]:6} polygons {areas[kind]:14.2f} m2")
