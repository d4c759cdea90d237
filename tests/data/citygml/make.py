#!/usr/bin/env python3
"""Writes small.gml: a hamlet in CityGML 2.0, EPSG:25832, to standard output. Standard library alone.

Eight buildings (six gabled houses of LoD 2, one of which refers to its surfaces from a solid, a house with a part of its own, a hall of LoD 1),
terrain as a TIN, and three trees that stand for one template.
"""

X0, Y0, Z0 = 565_000.0, 5_935_000.0, 12.0


def ground(x, y):
    return Z0 + 0.02 * x + 0.01 * y


def ring(corners):
    numbers = " ".join(f"{X0 + x:.3f} {Y0 + y:.3f} {z:.3f}" for x, y, z in corners + corners[:1])
    return f"<gml:LinearRing><gml:posList>{numbers}</gml:posList></gml:LinearRing>"


def polygon(corners, name=None, holes=()):
    inner = "".join(f"<gml:interior>{ring(hole)}</gml:interior>" for hole in holes)
    gml_id = f' gml:id="{name}"' if name else ""
    return f"<gml:Polygon{gml_id}><gml:exterior>{ring(corners)}</gml:exterior>{inner}</gml:Polygon>"


def member(surface):
    return f"<gml:surfaceMember>{surface}</gml:surfaceMember>"


def surface(kind, corners, name, opening=None):
    # Holes turn the other way than their outline.
    holes = [opening[::-1]] if opening else []
    text = f'<bldg:boundedBy><bldg:{kind} gml:id="{name}">'
    if opening:
        window = member(polygon(opening))
        text += f'<bldg:opening><bldg:Window gml:id="{name}_w"><bldg:lod3MultiSurface><gml:MultiSurface>{window}</gml:MultiSurface></bldg:lod3MultiSurface></bldg:Window></bldg:opening>'
    lod = 3 if opening else 2
    text += f"<bldg:lod{lod}MultiSurface><gml:MultiSurface>{member(polygon(corners, name + '_p', holes))}</gml:MultiSurface></bldg:lod{lod}MultiSurface>"
    return text + f"</bldg:{kind}></bldg:boundedBy>"


def box(x, y, width, depth, height, base):
    a, b, c, d = (x, y), (x + width, y), (x + width, y + depth), (x, y + depth)
    low, high = [(*p, base) for p in (a, b, c, d)], [(*p, base + height) for p in (a, b, c, d)]
    faces = [low[::-1], high]
    faces += [[low[i], low[(i + 1) % 4], high[(i + 1) % 4], high[i]] for i in range(4)]
    return faces


def solid(lod, faces):
    members = "".join(member(polygon(face)) for face in faces)
    return f"<bldg:lod{lod}Solid><gml:Solid><gml:exterior><gml:CompositeSurface>{members}</gml:CompositeSurface></gml:exterior></gml:Solid></bldg:lod{lod}Solid>"


def gabled(name, x, y, width, depth, eaves, ridge, base):
    """Thematic surfaces of a house whose ridge runs along y."""
    m, e, r = x + width / 2, base + eaves, base + ridge
    low = [(x, y, base), (x + width, y, base), (x + width, y + depth, base), (x, y + depth, base)]
    sides = [
        ("GroundSurface", low[::-1]),
        ("WallSurface", [low[0], low[1], (x + width, y, e), (m, y, r), (x, y, e)]),
        ("WallSurface", [low[2], low[3], (x, y + depth, e), (m, y + depth, r), (x + width, y + depth, e)]),
        ("WallSurface", [low[1], low[2], (x + width, y + depth, e), (x + width, y, e)]),
        ("WallSurface", [low[3], low[0], (x, y, e), (x, y + depth, e)]),
        ("RoofSurface", [(x, y, e), (m, y, r), (m, y + depth, r), (x, y + depth, e)]),
        ("RoofSurface", [(m, y, r), (x + width, y, e), (x + width, y + depth, e), (m, y + depth, r)]),
    ]
    return [(kind, corners, f"{name}_{number}") for number, (kind, corners) in enumerate(sides)]


def attributes(function, height, storeys, year):
    return (
        f'<gen:stringAttribute name="owner"><gen:value>municipality</gen:value></gen:stringAttribute><bldg:function>{function}</bldg:function>'
        f"<bldg:yearOfConstruction>{year}</bldg:yearOfConstruction><bldg:roofType>1030</bldg:roofType>"
        f'<bldg:measuredHeight uom="m">{height}</bldg:measuredHeight><bldg:storeysAboveGround>{storeys}</bldg:storeysAboveGround>'
    )


def building(name, content):
    return f'<core:cityObjectMember>\n<bldg:Building gml:id="{name}"><gml:name>{name.replace("_", " ")}</gml:name>{content}</bldg:Building>\n</core:cityObjectMember>\n'


def terrain():
    triangles = []
    for i in range(4):
        for j in range(4):
            x, y = -20 + 40 * i, -20 + 30 * j
            a, b, c, d = [(px, py, ground(px, py)) for px, py in ((x, y), (x + 40, y), (x + 40, y + 30), (x, y + 30))]
            triangles += [[a, b, c], [a, c, d]]
    patches = "\n".join(f"<gml:Triangle><gml:exterior>{ring(triangle)}</gml:exterior></gml:Triangle>" for triangle in triangles)
    return (
        '<core:cityObjectMember>\n<dem:ReliefFeature gml:id="relief"><dem:lod>2</dem:lod><dem:reliefComponent><dem:TINRelief gml:id="terrain"><dem:lod>2</dem:lod>'
        f"<dem:tin><gml:TriangulatedSurface><gml:trianglePatches>\n{patches}\n</gml:trianglePatches></gml:TriangulatedSurface></dem:tin></dem:TINRelief>"
        "</dem:reliefComponent></dem:ReliefFeature>\n</core:cityObjectMember>\n"
    )


def tree(name, x, y, size):
    """A crown of eight triangles; the first tree holds the template."""
    if name == "tree_1":
        tip, foot, around = (0, 0, 8), (0, 0, 2), [(2, 0, 5), (0, 2, 5), (-2, 0, 5), (0, -2, 5)]
        faces = [[around[i], around[(i + 1) % 4], tip] for i in range(4)] + [[around[(i + 1) % 4], around[i], foot] for i in range(4)]
        plain = lambda corners: " ".join(f"{c:g}" for corner in corners + corners[:1] for c in corner)
        members = "".join(
            member(f"<gml:Polygon><gml:exterior><gml:LinearRing><gml:posList>{plain(face)}</gml:posList></gml:LinearRing></gml:exterior></gml:Polygon>")
            for face in faces
        )
        geometry = f'><gml:MultiSurface gml:id="crown">{members}</gml:MultiSurface></core:relativeGMLGeometry>'
    else:
        geometry = ' xlink:href="#crown"/>'
    return (
        f'<core:cityObjectMember>\n<veg:SolitaryVegetationObject gml:id="{name}"><veg:species>1070</veg:species><veg:height uom="m">{8 * size:g}</veg:height>'
        f"<veg:lod2ImplicitRepresentation><core:ImplicitGeometry><core:transformationMatrix>{size} 0 0 0 0 {size} 0 0 0 0 {size} 0 0 0 0 1</core:transformationMatrix>"
        f"<core:relativeGMLGeometry{geometry}<core:referencePoint><gml:Point><gml:pos>{X0 + x:.3f} {Y0 + y:.3f} {ground(x, y):.3f}</gml:pos></gml:Point>"
        "</core:referencePoint></core:ImplicitGeometry></veg:lod2ImplicitRepresentation></veg:SolitaryVegetationObject>\n</core:cityObjectMember>\n"
    )


def hamlet():
    objects = []
    for number, (x, y, width, depth) in enumerate([(0, 0, 9, 12), (20, 0, 8, 10), (40, 2, 9, 11), (0, 30, 10, 14), (22, 32, 8, 9)], 1):
        base = ground(x, y)
        parts = gabled(f"house_{number}", x, y, width, depth, 5, 8.5, base)
        content = attributes(1000, 8.5, 2, 1950 + 7 * number)
        content += solid(1, box(x, y, width, depth, 7, base))
        content += "".join(surface(kind, corners, name) for kind, corners, name in parts)
        if number == 5:
            references = "".join(f'<gml:surfaceMember xlink:href="#{name}_p"/>' for _, _, name in parts)
            content += f"<bldg:lod2Solid><gml:Solid><gml:exterior><gml:CompositeSurface>{references}</gml:CompositeSurface></gml:exterior></gml:Solid></bldg:lod2Solid>"
        objects.append(building(f"house_{number}", content))
    # A house of LoD 3 with a window in its first wall, whose hole the window fills.
    base = ground(44, 30)
    window = [(46, 30, base + 1), (48, 30, base + 1), (48, 30, base + 2.5), (46, 30, base + 2.5)]
    content = attributes(1000, 8, 2, 2004)
    for kind, corners, name in gabled("house_6", 44, 30, 8, 10, 5, 8, base):
        text = surface(kind, corners, name, window if name == "house_6_1" else None)
        content += text.replace("lod2MultiSurface", "lod3MultiSurface")
    objects.append(building("house_6", content))
    # A house with a part, each with walls of its own.
    base = ground(70, 0)
    part = "".join(surface(*side) for side in gabled("part_7", 80, 0, 6, 8, 4, 6, base))
    content = attributes(1120, 9, 2, 1898) + "".join(surface(*side) for side in gabled("house_7", 70, 0, 10, 12, 6, 9, base))
    content += f'<bldg:consistsOfBuildingPart><bldg:BuildingPart gml:id="part_7">{part}</bldg:BuildingPart></bldg:consistsOfBuildingPart>'
    objects.append(building("house_7", content))
    objects.append(building("hall_8", attributes(2100, 10, 1, 1987) + solid(1, box(70, 30, 25, 40, 10, ground(70, 30)))))
    return objects


if __name__ == "__main__":
    print('<?xml version="1.0" encoding="UTF-8"?>')
    print('<core:CityModel xmlns:core="http://www.opengis.net/citygml/2.0" xmlns:bldg="http://www.opengis.net/citygml/building/2.0"')
    print(' xmlns:dem="http://www.opengis.net/citygml/relief/2.0" xmlns:veg="http://www.opengis.net/citygml/vegetation/2.0"')
    print(' xmlns:gen="http://www.opengis.net/citygml/generics/2.0" xmlns:gml="http://www.opengis.net/gml" xmlns:xlink="http://www.w3.org/1999/xlink">')
    print("<gml:name>hamlet</gml:name>")
    low, high = (f"{X0 + x:.0f} {Y0 + y:.0f} {z:.0f}" for x, y, z in ((-20, -20, 11), (140, 100, 26)))
    print(f'<gml:boundedBy><gml:Envelope srsName="urn:ogc:def:crs,crs:EPSG::25832,crs:EPSG::7837" srsDimension="3"><gml:lowerCorner>{low}</gml:lowerCorner><gml:upperCorner>{high}</gml:upperCorner></gml:Envelope></gml:boundedBy>')
    objects = hamlet() + [terrain(), tree("tree_1", 14, 20, 1), tree("tree_2", 34, 22, 1.25), tree("tree_3", 60, 20, 0.75)]
    print("".join(objects) + "</core:CityModel>")
