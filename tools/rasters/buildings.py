"""A year's sums of a city of rasters beside those of its city model, by building. In: two maps by surface (GeoJSON), and a plane coordinate system in
metres. Out: means of roofs and walls in kWh/m2; bias and RMSE of roofs by building of the rasters, in percent."""

import warnings

import geopandas
import numpy

warnings.filterwarnings("ignore")


def compare(model, rasters, crs):
    tables = [geopandas.read_file(path).to_crs(crs) for path in (model, rasters)]
    for table in tables:
        table["kwh"] = table.area_m2 * table.total_kwh_m2
        table["geometry"] = table.geometry.force_2d().buffer(0)
    sums = [table.groupby("kind")[["kwh", "area_m2"]].sum() for table in tables]
    row = {f"{kind}_kwh_m2": sums[1].kwh[kind] / sums[1].area_m2[kind] for kind in ("roof", "wall")}
    roofs = [table[table.kind == "roof"][["object", "kwh", "area_m2", "geometry"]] for table in tables]
    # A roof of the model belongs to the building of the rasters that holds a point of it.
    points = roofs[0].assign(geometry=roofs[0].geometry.representative_point()).drop(columns="object")
    within = geopandas.sjoin(points, roofs[1][["object", "geometry"]], predicate="within")
    theirs, ours = within.groupby("object")[["kwh", "area_m2"]].sum(), roofs[1].groupby("object")[["kwh", "area_m2"]].sum()
    both = theirs.add_suffix("_model").join(ours, how="inner")
    area, means = both.area_m2_model, both.kwh_model / both.area_m2_model
    off = both.kwh / both.area_m2 - means
    mean = both.kwh_model.sum() / area.sum()
    row["buildings"] = len(both)
    row["bias_%"] = 100 * (area * off).sum() / area.sum() / mean
    row["rmse_%"] = 100 * numpy.sqrt((area * off**2).sum() / area.sum()) / mean
    return row
