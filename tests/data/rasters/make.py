"""Small rasters as GDAL writes them, for the tests of the reader of GeoTIFF.
In: nothing. Out: the .tif files beside this one. Needs rasterio 1.4.4 (with GDAL 3.10.3) and numpy. The heights are 100 + column / 2 + row / 4
on cells of 10 m from 500,000 5,700,000, EPSG:25832, 40 columns and 36 rows, where a file's name does not say else."""
import os

import numpy as np
import rasterio
from rasterio.shutil import copy
from rasterio.transform import from_origin

os.chdir(os.path.dirname(os.path.abspath(__file__)))
ROWS, COLUMNS = 36, 40
row, column = np.mgrid[0:ROWS, 0:COLUMNS]
HEIGHTS = 100 + column * 0.5 + row * 0.25
MASK = np.where(column < 20, 255, 0).astype("uint8")


def write(name, bands, crs="EPSG:25832", mask=None, about=None, nodata=None, **options):
    bands = bands if bands.ndim == 3 else bands[None]
    shape = {"height": ROWS, "width": COLUMNS, "count": len(bands), "dtype": bands.dtype, "crs": crs, "nodata": nodata}
    place = from_origin(500_000, 5_700_000, 10, 10)
    with rasterio.Env(GDAL_TIFF_INTERNAL_MASK=True):
        with rasterio.open(name, "w", driver="GTiff", transform=place, **shape, **options) as out:
            out.write(bands)
            if about:
                out.scales, out.offsets, out.units = about
            if mask is not None:
                out.write_mask(mask)


tiles = {"tiled": True, "blockxsize": 16, "blockysize": 16}
write("int16_lzw_tiles.tif", (HEIGHTS * 4).astype("int16"), compress="LZW", predictor=2, **tiles)
write("uint8_lzw_tiles.tif", HEIGHTS.astype("uint8"), compress="LZW", predictor=2, **tiles)
write("float32_lzw_tiles.tif", HEIGHTS.astype("float32"), compress="LZW", predictor=3, **tiles)
write("float64_deflate.tif", HEIGHTS, compress="DEFLATE", predictor=3)
write("int32_scaled_ft.tif", (HEIGHTS * 100).astype("int32"), nodata=11_900, about=((0.01,), (5.0,), ("ft",)), compress="DEFLATE", predictor=2)
write("mask_strips.tif", HEIGHTS.astype("float32"), mask=MASK, compress="DEFLATE")
write("mask_big_endian.tif", HEIGHTS.astype("float32"), mask=MASK, ENDIANNESS="BIG", BIGTIFF="YES")
write("tmp.tif", HEIGHTS.astype("float32"), mask=MASK, compress="LZW", **tiles)
with rasterio.open("tmp.tif", "r+") as out:
    out.build_overviews([2])
copy("tmp.tif", "mask_cog.tif", driver="COG", compress="LZW", blocksize=128)
os.remove("tmp.tif")
alpha = (MASK > 0).astype("uint16") * 65_535
write("alpha_bands.tif", np.stack([(HEIGHTS * 4).astype("uint16"), alpha]), ALPHA="YES", INTERLEAVE="BAND", compress="DEFLATE")
write("alpha_pixels.tif", np.stack([HEIGHTS, MASK.astype("float64")]).astype("float32"), ALPHA="YES", compress="DEFLATE")
write("feet_heights_in_us_feet.tif", HEIGHTS.astype("float32"), crs="EPSG:2263+6360", compress="DEFLATE")
