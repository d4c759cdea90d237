"""Yearly sums of buildings from their footprints beside those of their city model. In: two maps by surface (GeoJSON). Out: a table.

    beside.py MODEL.geojson OUTLINES.geojson
"""

import json
import sys

import numpy
import pandas


def surfaces(path):
    rows = [feature["properties"] for feature in json.load(open(path))["features"]]
    table = pandas.DataFrame(rows)[["object", "building", "kind", "area_m2", "tilt_deg", "total_kwh_m2"]]
    table["kwh"] = table.area_m2 * table.total_kwh_m2
    return table


def main(model, outlines):
    model, outlines = surfaces(model), surfaces(outlines)
    pitched = model[(model.kind == "roof") & (model.tilt_deg > 10)].groupby("object").area_m2.sum()
    roofs = model[model.kind == "roof"].groupby("object").area_m2.sum()
    share = (pitched / roofs).fillna(0)
    print(f"{'':22} {'model m2':>10} {'outlines':>10} {'kWh/m2':>8} {'outlines':>9} {'bias %':>7} {'RMSE %':>7} {'objects':>8}")
    for kind in ("roof", "wall"):
        sums = [table[table.kind == kind].groupby("object")[["area_m2", "kwh"]].sum() for table in (model, outlines)]
        both = sums[0].add_suffix("_a").join(sums[1].add_suffix("_b"), how="inner")
        groups = {"all": both.index, "flat roofs": share.index[share < 0.1], "pitched roofs": share.index[share > 0.9]}
        for name, index in groups.items():
            some = both[both.index.isin(index)]
            a, b = some.kwh_a / some.area_m2_a, some.kwh_b / some.area_m2_b
            mean = some.kwh_a.sum() / some.area_m2_a.sum()
            other = some.kwh_b.sum() / some.area_m2_b.sum()
            # By the area of each building.
            rmse = numpy.sqrt((some.area_m2_a * (b - a) ** 2).sum() / some.area_m2_a.sum())
            print(
                f"{kind + ', ' + name:22} {some.area_m2_a.sum():10.0f} {some.area_m2_b.sum():10.0f} {mean:8.1f} {other:9.1f} "
                f"{100 * (other / mean - 1):7.2f} {100 * rmse / mean:7.2f} {len(some):8}"
            )


if __name__ == "__main__":
    main(*sys.argv[1:])
