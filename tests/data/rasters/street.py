"""A street of 60 x 60 m as lidar rasters of 1 m, for the book and the tests of rasters that become a city.
In: nothing. Out: street_dsm.tif, street_dem.tif, street_canopy.tif and street_landcover.tif beside this file. Needs rasterio 1.4.4 and numpy.
Four houses stand along a street that is turned by 20 degrees and rises by 1 m: two with gabled roofs of 35 degrees, one flat of 12 m, one of two
heights; a lawn with three trees, a car of 1.5 m. Heights have a noise of 0.05 m."""
import os

import numpy as np
import rasterio
from rasterio.transform import from_origin

os.chdir(os.path.dirname(os.path.abspath(__file__)))
SIZE = 60
row, column = np.mgrid[0:SIZE, 0:SIZE]
x, y = column + 0.5 - 30, 30 - (row + 0.5)
turn = np.radians(20)
u, v = x * np.cos(turn) + y * np.sin(turn), y * np.cos(turn) - x * np.sin(turn)
noise = np.random.default_rng(5).normal(0, 0.05, (SIZE, SIZE))
dem = 80 + (u + 30) / 60
dsm, cover, canopy = dem + noise, np.where(np.abs(v) < 5, 1, 5), np.zeros((SIZE, SIZE))


def house(west, east, south, north, eaves, pitch=0.0):
    inside = (u > west) & (u < east) & (v > south) & (v < north)
    half = 0.5 * (north - south)
    base = 80 + (0.5 * (west + east) + 30) / 60
    roof = base + eaves + np.tan(np.radians(pitch)) * (half - np.abs(v - 0.5 * (south + north)))
    dsm[inside], cover[inside] = (roof + noise)[inside], 2


house(-20, -8, 7, 16, 6, 35)
house(-2, 12, 7, 17, 12)
house(-20, -4, -17, -7, 5, 35)
house(2, 10, -17, -7, 9)
house(10, 18, -17, -7, 4)
car = (np.abs(u - 2) < 2.2) & (np.abs(v + 3) < 1)
dsm[car] += 1.5
for at_u, at_v, radius, height in ((16, 12, 3, 8), (20, 8, 2.5, 6), (-1, -13, 2, 5)):
    off = np.hypot(u - at_u, v - at_v) / radius
    crown = np.where(off < 1, height * (0.75 + 0.25 * np.sqrt(np.maximum(1 - off**2, 0))), 0)
    canopy = np.maximum(canopy, np.where(cover == 5, crown, 0))


def write(name, values, dtype, scale=None, **options):
    about = {"height": SIZE, "width": SIZE, "count": 1, "dtype": dtype, "crs": "EPSG:25832", **options}
    with rasterio.open(name, "w", driver="GTiff", transform=from_origin(500_000, 5_700_060, 1, 1), **about) as out:
        out.write(np.round(values / (scale or 1)).astype(dtype) if scale else values.astype(dtype), 1)
        if scale:
            out.scales = (scale,)


write("street_dsm.tif", dsm, "int16", scale=0.01, compress="DEFLATE", predictor=2)
write("street_dem.tif", dem, "float32", compress="ZSTD", predictor=3, nodata=-9999)
write("street_canopy.tif", canopy, "uint8", scale=0.1, compress="LZW")
write("street_landcover.tif", cover, "uint8", compress="DEFLATE", nodata=255)
