"""Keyword options of all functions: those of the command line, by their names in Python."""
# Made by tools/faces from the requests. Do not edit.

from __future__ import annotations

import datetime
import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, TypeAlias, TypedDict

#: `progress(stage, done, items)` is called up to twenty times a second; `items` is None if their
#: number is unknown. An exception of it stops the work.
Progress: TypeAlias = "Callable[[str, int, int | None], object]"

#: A number, a path of a CSV file, or a value for each row of the weather, or for each month.
Follow: TypeAlias = Any

#: Ids, a table with a column `receiver`, a path of a CSV file (`pathlib.Path`), or one of
#: `{"objects": names}`, `{"surfaces": names}`, `{"bbox": (xmin, ymin, xmax, ymax)}`.
Wanted: TypeAlias = "Sequence[str] | str | os.PathLike[str] | Mapping[str, str | Sequence[str] | Sequence[float]]"

#: A path, or an address.
Place: TypeAlias = "str | os.PathLike[str]"


class SceneOptions(TypedDict, total=False):
    """Options of `Scene`."""

    materials: Place | None
    """File of reflectances (TOML), one table for each material name. They replace those of the scene files; materials without a table keep their own values, or get usual ones."""

    materials_only: bool
    """Ignore the materials of the scene files; `materials` has to describe all of them."""

    ground: bool
    """False: Add no ground to a scene that has none [default: add a plane below it; for an EnergyPlus model, as the model states]"""

    assume_version: str | None
    """Read EnergyPlus models as models of this version, whatever version they state; it decides what the fields of an IDF mean. With 25.2, `energyplus` accepts models of any version, for EnergyPlus 25.2 to run as they are."""

    height: str | float | Sequence[str | float] | None
    """Height of buildings above their base, for files of footprints: a column, or metres for all buildings, or several, of which the first with a value counts, as in HGT,9m [default: columns such as height and building:height, then storeys]"""

    storey_height: str | float | None
    """Height of a storey, for footprints that state storeys and no height [default: 3m]"""

    base: str | float | None
    """Base of buildings from footprints: a column, or metres [default: the lowest terrain below the outline, 0 without terrain]"""

    height_above: Literal["base", "sea"] | None
    """Level from which columns of heights count: the base, or the sea for absolute heights of roofs, from which the terrain below or `base` is taken [default: base]"""

    layer: str | Sequence[str] | None
    """Layer to read of a GeoPackage with several; may be given more than once [default: the layers of buildings by their names, else all]"""

    crs: str | float | None
    """Coordinate reference system of the scene's coordinates, in metres: EPSG:28992 or 28992."""

    latitude: float | None
    """Latitude of the scene, degrees, north positive; y is then true north, unless a coordinate system states otherwise."""

    longitude: float | None
    """Longitude of the scene, degrees, east positive."""

    rotate_deg: float | None
    """Angle of the model's y axis from north, degrees, clockwise as seen from above (the north axis of EnergyPlus); coordinates stay."""

    grid_north: bool
    """Count azimuths in the table of points from the y axis, in place of true north."""

    elevation: float | None
    """Height above sea level of z = 0, metres, for all files but terrain."""

    scale: float | None
    """Metres per unit of all files but terrain: 0.001 for millimetres. 0.3048 and 0.3048006 (feet) also apply to terrain whose file does not state its unit."""

    up: Literal["y", "z"] | None
    """The axis that points up in OBJ, PLY and STL files: z, with y to the north, or y, with z to the south [default: z]"""

    dsm: Place | None
    """Raster of surface heights above sea level (DSM: .tif, .asc): its steps become walls, the flat and sloping areas between them roofs; no other scene file is needed with it."""

    dem: Place | None
    """Raster of ground heights above sea level (DEM, DTM): parts of `dsm` that are at least 2 m higher are buildings, and it continues beyond `dsm` as terrain; with `canopy` and without `dsm`, ground with trees alone."""

    canopy: Place | None
    """Raster of the heights of tree crowns above the ground (CDSM), on a grid as fine as it likes: crowns become volumes of leaves of the group `trees`."""

    landcover: Place | None
    """Raster of land cover in UMEP's codes: 1 paved, 2 buildings, 5 grass, 6 bare soil, 7 water."""

    progress: Progress | None
    """Called now and then with the stage, the number of items done, and the number of all."""


class ReplayOptions(TypedDict, total=False):
    """Options of `Archive.replay`."""

    memory: int | str | None
    """Memory to work in, such as 512MiB or 2GiB. Default: `4GiB`."""

    percentiles: bool
    """Write P90, P50 and P10 in place of the years of `every` year: what is exceeded in 90, 50 and 10 % of the years of a weather file of several years."""

    receivers: Wanted | None
    """Only the receivers listed in a CSV file: ids in a column `receiver`."""

    bbox: str | Sequence[float] | None
    """Only the receivers in a box, coordinates of the scene in metres: xmin,ymin,xmax,ymax and optionally zmin,zmax; of an atlas, only parts that touch it are opened."""

    surfaces: str | Sequence[str] | None
    """Only the receivers of these surfaces."""

    objects: str | Sequence[str] | None
    """Only the receivers of these objects or buildings."""

    columns: str | Sequence[str | os.PathLike[str]] | None
    """Columns to write, in this order, such as total,sun_direct. sun_reflected and sky_reflected can be split by the kind of surface that the receiver sees, as in sun_reflected_ground and sun_reflected_obstruction; `replay` also has longwave [default: the six components and their total]"""

    bands: str | Sequence[str | os.PathLike[str]] | None
    """Further columns with light by band: some of uv, visible, par, nir, as in visible,par; or a .toml file of your own bands."""

    sky: str | os.PathLike[str] | float | None
    """Sky radiance distribution: perez (all-weather, 1993), perez1990 (tilted surfaces, as in EnergyPlus and pvlib), uniform (the same radiance everywhere), or cie:1 to cie:16 (the traditional overcast sky); or a file with a dot in its name: radiances of 145, 577 or 2305 patches as .csv, a matrix of Radiance (gendaymtx -s -O1, genskyvec), or a square equidistant photograph of the sky as .png, .hdr or .exr. Default: `perez`."""

    sky_scale: Literal["dhi", "given"] | None
    """Scale of the radiances in a file of `sky` [default: dhi for photographs, given for tables and matrices]"""

    sky_white: float | None
    """Radiance of white in a photograph of `sky`, W/m2/sr, for `sky_scale` given [default: levels of .hdr and .exr are radiances]"""

    clouds: Place | None
    """Transmittance of clouds before sun and sky, 0 to 1 by direction: a table of patches as for `sky`, or a square equidistant (fisheye) picture."""

    image_top: float | None
    """Azimuth of the top of the pictures of `sky` and `clouds`, degrees clockwise from true north; their left side is 90 degrees further clockwise [default: 0, north]"""

    patches: int | None
    """Number of sky patches: 145, 577 or 2305 [default: that for which the archive was built]"""

    bounces: str | float | None
    """Number of diffuse reflections that count: all, or 1 to 64 (1 counts the first one only). Default: `all`."""

    paths: str | Sequence[str | os.PathLike[str]] | None
    """Light paths that count besides direct sun and sky, their first diffuse reflection and the sun in mirrors: all, none (as in EnergyPlus), or some of bounces (further diffuse reflections), mirror-diffuse (diffuse light that also meets a mirror), mirror-sky (the sky in mirrors). Default: `all`."""

    reflectance: Mapping[str, Follow] | None
    """Change a diffuse reflectance: GROUP=0.6, or a material's name, `ground` or `obstruction` in place of the group; may be repeated, the last one counts."""

    schedule: Mapping[str, Follow] | None
    """Change a diffuse reflectance over time: a CSV with a column `reflectance` and a line for each condition, for each row of the weather file, or for each of 12 months; may be repeated."""

    transmittance: Mapping[str, Follow] | None
    """Change the transmittance of canopies, the share of light that each of their faces, or each metre of a volume of leaves, lets through: GROUP=0.4, or a CSV as for `schedule`, with a column `transmittance` (leaves by season); may be repeated, the last one counts."""

    leaf_area_density: Mapping[str, Follow] | None
    """Change the leaf area density of crowns that are volumes of leaves, m2/m3: GROUP=0.8, or a CSV as for `schedule`, with a column `leaf_area_density` (leaves by season); may be repeated, the last one counts."""

    latitude: float | None
    """Latitude of the weather, degrees, north positive, in place of that of the file [default if the file states none: that of the scene]"""

    longitude: float | None
    """Longitude of the weather, degrees, east positive, in place of that of the file."""

    time_zone: str | float | None
    """Time zone of the weather file's clock, in place of that of the file: hours ahead of UTC, such as +01:00, -7 or UTC, or a name, such as Europe/Amsterdam, with its summer time. If its time stamps state an offset, the zone of days and labels in results."""

    shift: str | float | None
    """Shift of the weather file's time stamps, such as 41min, -30min or 0.5h; `auto` chooses the shift under which GHI, DNI and DHI agree best, if they agree clearly better."""

    weather_stamp: Literal["start", "middle", "end"] | None
    """Position of the weather file's time stamps in their intervals; middle for values at one moment [default: as the format, the names of columns or hours 1 to 24 imply; start for plain CSV]"""

    date_order: Literal["dmy", "mdy", "ymd"] | None
    """Order of day and month in the weather file's dates of three numbers, such as 01/06/2021 [default: what the whole column shows]"""

    every: Literal["hour", "day", "month", "year", "total"] | None
    """Period of a row: means in W/m2 of hours, sums in kWh/m2 of longer periods. Default: `hour`."""

    stamp: Literal["start", "middle", "end"] | None
    """Time that labels a row of means: the start, middle or end of its interval, as 06:00, 06:30 or 07:00 for the hour from 06:00 to 07:00 (the last hour of a day ends at 00:00 of the next); sums are labelled with the start of their period. Default: `start`."""

    year: int | None
    """Year of all dates in results, such as 2019, for example for a typical year, whose months come from different ones. Sun positions stay those of the file's dates; 29 February is left out if the year has none. `before` and `end` then refer to this year."""

    start: str | datetime.date | None
    """First day that counts, such as 2019-03-01, or 03-01 of any year (for typical years and winters), or a time such as 03-01T06:00."""

    end: str | datetime.date | None
    """Last day that counts, up to its end; if it is before `before`, that day of the next year, as in `before` 11-01 `end` 02-28."""

    steps: int | None
    """Number of sun positions within each interval of the weather file, 1 to 60 [default: the number per hour for which the archive was built]"""

    snow: Literal["depth", "albedo"] | None
    """Change the reflectance of all ground by the weather file: its snow depth (`snow_reflectance` from 1 cm on) or its albedo."""

    snow_reflectance: float | None
    """Diffuse reflectance of snow. Default: `0.6`."""

    temperature: Mapping[str, Follow] | None
    """Temperature of `ground` or `obstruction` surfaces for the column `longwave`: degrees Celsius, or a CSV as for `schedule` with a column `temperature_c`; may be repeated, the last one counts [default: the weather file's dry bulb temperature]"""

    progress: Progress | None
    """Called now and then with the stage, the number of items done, and the number of all."""


class WriteOptions(TypedDict, total=False):
    """Options of `Archive.write`."""

    memory: int | str | None
    """Memory to work in, such as 512MiB or 2GiB. Default: `4GiB`."""

    by: Literal["receiver", "surface", "window", "object", "building", "kind"] | None
    """Grouping of rows: what each row stands for. Default: `receiver`."""

    percentiles: bool
    """Write P90, P50 and P10 in place of the years of `every` year: what is exceeded in 90, 50 and 10 % of the years of a weather file of several years."""

    positions: bool
    """Add the columns x, y, z, tilt_deg, azimuth_deg and area_m2 of each receiver to the table, which `build` can then read as its `receivers`."""

    geo: bool
    """Write .parquet as a map (GeoParquet), one row with a polygon for each receiver, surface and so on."""

    plots: Place | Sequence[Place] | None
    """Draw a picture of the results. A name that ends with .png is a map of the sums (or of one condition), from above and from the south-west; one that ends with .svg is a chart of the mean of all receivers, weighted by area: bars by component of `every` day, month or year (or of conditions), hours of the day by month of `every` hour. May be repeated; a table is then written only if `output` names one."""

    model: Place | None
    """City model (CityJSON or CityJSONSeq) on whose surfaces the receivers were placed: an `output` that ends with .city.json or .city.jsonl is this model with the sums added, and with a material theme `irradiation`."""

    honeybee: Place | None
    """Write a folder of hourly results that Honeybee and Pollination read, in place of a table, with a grid for each object (a room, a city object); `by` building, surface or kind makes other grids."""

    receivers: Wanted | None
    """Only the receivers listed in a CSV file: ids in a column `receiver`."""

    bbox: str | Sequence[float] | None
    """Only the receivers in a box, coordinates of the scene in metres: xmin,ymin,xmax,ymax and optionally zmin,zmax; of an atlas, only parts that touch it are opened."""

    surfaces: str | Sequence[str] | None
    """Only the receivers of these surfaces."""

    objects: str | Sequence[str] | None
    """Only the receivers of these objects or buildings."""

    sun: str | Sequence[float] | None
    """Azimuth (clockwise from true north) and altitude of one sun in place of weather, degrees."""

    dni: float | None
    """Direct normal irradiance of that sun, W/m2. Default: `0`."""

    dhi: float | None
    """Diffuse horizontal irradiance of the sky around it, W/m2. Default: `0`."""

    columns: str | Sequence[str | os.PathLike[str]] | None
    """Columns to write, in this order, such as total,sun_direct. sun_reflected and sky_reflected can be split by the kind of surface that the receiver sees, as in sun_reflected_ground and sun_reflected_obstruction; `replay` also has longwave [default: the six components and their total]"""

    bands: str | Sequence[str | os.PathLike[str]] | None
    """Further columns with light by band: some of uv, visible, par, nir, as in visible,par; or a .toml file of your own bands."""

    sky: str | os.PathLike[str] | float | None
    """Sky radiance distribution: perez (all-weather, 1993), perez1990 (tilted surfaces, as in EnergyPlus and pvlib), uniform (the same radiance everywhere), or cie:1 to cie:16 (the traditional overcast sky); or a file with a dot in its name: radiances of 145, 577 or 2305 patches as .csv, a matrix of Radiance (gendaymtx -s -O1, genskyvec), or a square equidistant photograph of the sky as .png, .hdr or .exr. Default: `perez`."""

    sky_scale: Literal["dhi", "given"] | None
    """Scale of the radiances in a file of `sky` [default: dhi for photographs, given for tables and matrices]"""

    sky_white: float | None
    """Radiance of white in a photograph of `sky`, W/m2/sr, for `sky_scale` given [default: levels of .hdr and .exr are radiances]"""

    clouds: Place | None
    """Transmittance of clouds before sun and sky, 0 to 1 by direction: a table of patches as for `sky`, or a square equidistant (fisheye) picture."""

    image_top: float | None
    """Azimuth of the top of the pictures of `sky` and `clouds`, degrees clockwise from true north; their left side is 90 degrees further clockwise [default: 0, north]"""

    patches: int | None
    """Number of sky patches: 145, 577 or 2305 [default: that for which the archive was built]"""

    bounces: str | float | None
    """Number of diffuse reflections that count: all, or 1 to 64 (1 counts the first one only). Default: `all`."""

    paths: str | Sequence[str | os.PathLike[str]] | None
    """Light paths that count besides direct sun and sky, their first diffuse reflection and the sun in mirrors: all, none (as in EnergyPlus), or some of bounces (further diffuse reflections), mirror-diffuse (diffuse light that also meets a mirror), mirror-sky (the sky in mirrors). Default: `all`."""

    reflectance: Mapping[str, Follow] | None
    """Change a diffuse reflectance: GROUP=0.6, or a material's name, `ground` or `obstruction` in place of the group; may be repeated, the last one counts."""

    schedule: Mapping[str, Follow] | None
    """Change a diffuse reflectance over time: a CSV with a column `reflectance` and a line for each condition, for each row of the weather file, or for each of 12 months; may be repeated."""

    transmittance: Mapping[str, Follow] | None
    """Change the transmittance of canopies, the share of light that each of their faces, or each metre of a volume of leaves, lets through: GROUP=0.4, or a CSV as for `schedule`, with a column `transmittance` (leaves by season); may be repeated, the last one counts."""

    leaf_area_density: Mapping[str, Follow] | None
    """Change the leaf area density of crowns that are volumes of leaves, m2/m3: GROUP=0.8, or a CSV as for `schedule`, with a column `leaf_area_density` (leaves by season); may be repeated, the last one counts."""

    latitude: float | None
    """Latitude of the weather, degrees, north positive, in place of that of the file [default if the file states none: that of the scene]"""

    longitude: float | None
    """Longitude of the weather, degrees, east positive, in place of that of the file."""

    time_zone: str | float | None
    """Time zone of the weather file's clock, in place of that of the file: hours ahead of UTC, such as +01:00, -7 or UTC, or a name, such as Europe/Amsterdam, with its summer time. If its time stamps state an offset, the zone of days and labels in results."""

    shift: str | float | None
    """Shift of the weather file's time stamps, such as 41min, -30min or 0.5h; `auto` chooses the shift under which GHI, DNI and DHI agree best, if they agree clearly better."""

    weather_stamp: Literal["start", "middle", "end"] | None
    """Position of the weather file's time stamps in their intervals; middle for values at one moment [default: as the format, the names of columns or hours 1 to 24 imply; start for plain CSV]"""

    date_order: Literal["dmy", "mdy", "ymd"] | None
    """Order of day and month in the weather file's dates of three numbers, such as 01/06/2021 [default: what the whole column shows]"""

    every: Literal["hour", "day", "month", "year", "total"] | None
    """Period of a row: means in W/m2 of hours, sums in kWh/m2 of longer periods. Default: `hour`."""

    stamp: Literal["start", "middle", "end"] | None
    """Time that labels a row of means: the start, middle or end of its interval, as 06:00, 06:30 or 07:00 for the hour from 06:00 to 07:00 (the last hour of a day ends at 00:00 of the next); sums are labelled with the start of their period. Default: `start`."""

    year: int | None
    """Year of all dates in results, such as 2019, for example for a typical year, whose months come from different ones. Sun positions stay those of the file's dates; 29 February is left out if the year has none. `before` and `end` then refer to this year."""

    start: str | datetime.date | None
    """First day that counts, such as 2019-03-01, or 03-01 of any year (for typical years and winters), or a time such as 03-01T06:00."""

    end: str | datetime.date | None
    """Last day that counts, up to its end; if it is before `before`, that day of the next year, as in `before` 11-01 `end` 02-28."""

    steps: int | None
    """Number of sun positions within each interval of the weather file, 1 to 60 [default: the number per hour for which the archive was built]"""

    snow: Literal["depth", "albedo"] | None
    """Change the reflectance of all ground by the weather file: its snow depth (`snow_reflectance` from 1 cm on) or its albedo."""

    snow_reflectance: float | None
    """Diffuse reflectance of snow. Default: `0.6`."""

    temperature: Mapping[str, Follow] | None
    """Temperature of `ground` or `obstruction` surfaces for the column `longwave`: degrees Celsius, or a CSV as for `schedule` with a column `temperature_c`; may be repeated, the last one counts [default: the weather file's dry bulb temperature]"""

    progress: Progress | None
    """Called now and then with the stage, the number of items done, and the number of all."""


class QueryOptions(TypedDict, total=False):
    """Options of `Archive.query`."""

    memory: int | str | None
    """Memory to work in, such as 512MiB or 2GiB. Default: `4GiB`."""

    percentiles: bool
    """Write P90, P50 and P10 in place of the years of `every` year: what is exceeded in 90, 50 and 10 % of the years of a weather file of several years."""

    receivers: Wanted | None
    """Only the receivers listed in a CSV file: ids in a column `receiver`."""

    bbox: str | Sequence[float] | None
    """Only the receivers in a box, coordinates of the scene in metres: xmin,ymin,xmax,ymax and optionally zmin,zmax; of an atlas, only parts that touch it are opened."""

    surfaces: str | Sequence[str] | None
    """Only the receivers of these surfaces."""

    objects: str | Sequence[str] | None
    """Only the receivers of these objects or buildings."""

    sun: str | Sequence[float] | None
    """Azimuth (clockwise from true north) and altitude of one sun in place of weather, degrees."""

    dni: float | None
    """Direct normal irradiance of that sun, W/m2. Default: `0`."""

    dhi: float | None
    """Diffuse horizontal irradiance of the sky around it, W/m2. Default: `0`."""

    columns: str | Sequence[str | os.PathLike[str]] | None
    """Columns to write, in this order, such as total,sun_direct. sun_reflected and sky_reflected can be split by the kind of surface that the receiver sees, as in sun_reflected_ground and sun_reflected_obstruction; `replay` also has longwave [default: the six components and their total]"""

    bands: str | Sequence[str | os.PathLike[str]] | None
    """Further columns with light by band: some of uv, visible, par, nir, as in visible,par; or a .toml file of your own bands."""

    sky: str | os.PathLike[str] | float | None
    """Sky radiance distribution: perez (all-weather, 1993), perez1990 (tilted surfaces, as in EnergyPlus and pvlib), uniform (the same radiance everywhere), or cie:1 to cie:16 (the traditional overcast sky); or a file with a dot in its name: radiances of 145, 577 or 2305 patches as .csv, a matrix of Radiance (gendaymtx -s -O1, genskyvec), or a square equidistant photograph of the sky as .png, .hdr or .exr. Default: `perez`."""

    sky_scale: Literal["dhi", "given"] | None
    """Scale of the radiances in a file of `sky` [default: dhi for photographs, given for tables and matrices]"""

    sky_white: float | None
    """Radiance of white in a photograph of `sky`, W/m2/sr, for `sky_scale` given [default: levels of .hdr and .exr are radiances]"""

    clouds: Place | None
    """Transmittance of clouds before sun and sky, 0 to 1 by direction: a table of patches as for `sky`, or a square equidistant (fisheye) picture."""

    image_top: float | None
    """Azimuth of the top of the pictures of `sky` and `clouds`, degrees clockwise from true north; their left side is 90 degrees further clockwise [default: 0, north]"""

    patches: int | None
    """Number of sky patches: 145, 577 or 2305 [default: that for which the archive was built]"""

    bounces: str | float | None
    """Number of diffuse reflections that count: all, or 1 to 64 (1 counts the first one only). Default: `all`."""

    paths: str | Sequence[str | os.PathLike[str]] | None
    """Light paths that count besides direct sun and sky, their first diffuse reflection and the sun in mirrors: all, none (as in EnergyPlus), or some of bounces (further diffuse reflections), mirror-diffuse (diffuse light that also meets a mirror), mirror-sky (the sky in mirrors). Default: `all`."""

    reflectance: Mapping[str, Follow] | None
    """Change a diffuse reflectance: GROUP=0.6, or a material's name, `ground` or `obstruction` in place of the group; may be repeated, the last one counts."""

    schedule: Mapping[str, Follow] | None
    """Change a diffuse reflectance over time: a CSV with a column `reflectance` and a line for each condition, for each row of the weather file, or for each of 12 months; may be repeated."""

    transmittance: Mapping[str, Follow] | None
    """Change the transmittance of canopies, the share of light that each of their faces, or each metre of a volume of leaves, lets through: GROUP=0.4, or a CSV as for `schedule`, with a column `transmittance` (leaves by season); may be repeated, the last one counts."""

    leaf_area_density: Mapping[str, Follow] | None
    """Change the leaf area density of crowns that are volumes of leaves, m2/m3: GROUP=0.8, or a CSV as for `schedule`, with a column `leaf_area_density` (leaves by season); may be repeated, the last one counts."""

    progress: Progress | None
    """Called now and then with the stage, the number of items done, and the number of all."""


class CompareOptions(TypedDict, total=False):
    """Options of `compare`."""

    memory: int | str | None
    """Memory to work in, such as 512MiB or 2GiB. Default: `4GiB`."""

    output: Place | None
    """Table to write: .csv (with .csv-metadata.json beside it, which describes its columns), .parquet, .arrow, .feather (compressed Arrow), .npy (with .axes.json beside it), .npz, or - for CSV on standard output; also maps: .glb, .fgb, .geojson, .ply, .vtu, .pvd, .parquet with `geo`. Default: `-`."""

    by: Literal["receiver", "surface", "window", "object", "building", "kind"] | None
    """Grouping of rows: what each row stands for. Default: `receiver`."""

    positions: bool
    """Add the columns x, y, z, tilt_deg, azimuth_deg and area_m2 of each receiver to the table, which `build` can then read as its `receivers`."""

    geo: bool
    """Write .parquet as a map (GeoParquet), one row with a polygon for each receiver, surface and so on."""

    plots: Place | Sequence[Place] | None
    """Draw a picture of the results. A name that ends with .png is a map of the sums (or of one condition), from above and from the south-west; one that ends with .svg is a chart of the mean of all receivers, weighted by area: bars by component of `every` day, month or year (or of conditions), hours of the day by month of `every` hour. May be repeated; a table is then written only if `output` names one."""

    receivers: Wanted | None
    """Only the receivers listed in a CSV file: ids in a column `receiver`."""

    bbox: str | Sequence[float] | None
    """Only the receivers in a box, coordinates of the scene in metres: xmin,ymin,xmax,ymax and optionally zmin,zmax; of an atlas, only parts that touch it are opened."""

    surfaces: str | Sequence[str] | None
    """Only the receivers of these surfaces."""

    objects: str | Sequence[str] | None
    """Only the receivers of these objects or buildings."""

    conditions: Any | None
    """Table of suns and skies in place of weather, CSV: condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2; azimuths are clockwise from true north."""

    sun: str | Sequence[float] | None
    """Azimuth (clockwise from true north) and altitude of one sun in place of weather, degrees."""

    dni: float | None
    """Direct normal irradiance of that sun, W/m2. Default: `0`."""

    dhi: float | None
    """Diffuse horizontal irradiance of the sky around it, W/m2. Default: `0`."""

    columns: str | Sequence[str | os.PathLike[str]] | None
    """Columns to write, in this order, such as total,sun_direct. sun_reflected and sky_reflected can be split by the kind of surface that the receiver sees, as in sun_reflected_ground and sun_reflected_obstruction; `replay` also has longwave [default: the six components and their total]"""

    bands: str | Sequence[str | os.PathLike[str]] | None
    """Further columns with light by band: some of uv, visible, par, nir, as in visible,par; or a .toml file of your own bands."""

    sky: str | os.PathLike[str] | float | None
    """Sky radiance distribution: perez (all-weather, 1993), perez1990 (tilted surfaces, as in EnergyPlus and pvlib), uniform (the same radiance everywhere), or cie:1 to cie:16 (the traditional overcast sky); or a file with a dot in its name: radiances of 145, 577 or 2305 patches as .csv, a matrix of Radiance (gendaymtx -s -O1, genskyvec), or a square equidistant photograph of the sky as .png, .hdr or .exr. Default: `perez`."""

    sky_scale: Literal["dhi", "given"] | None
    """Scale of the radiances in a file of `sky` [default: dhi for photographs, given for tables and matrices]"""

    sky_white: float | None
    """Radiance of white in a photograph of `sky`, W/m2/sr, for `sky_scale` given [default: levels of .hdr and .exr are radiances]"""

    clouds: Place | None
    """Transmittance of clouds before sun and sky, 0 to 1 by direction: a table of patches as for `sky`, or a square equidistant (fisheye) picture."""

    image_top: float | None
    """Azimuth of the top of the pictures of `sky` and `clouds`, degrees clockwise from true north; their left side is 90 degrees further clockwise [default: 0, north]"""

    patches: int | None
    """Number of sky patches: 145, 577 or 2305 [default: that for which the archive was built]"""

    bounces: str | float | None
    """Number of diffuse reflections that count: all, or 1 to 64 (1 counts the first one only). Default: `all`."""

    paths: str | Sequence[str | os.PathLike[str]] | None
    """Light paths that count besides direct sun and sky, their first diffuse reflection and the sun in mirrors: all, none (as in EnergyPlus), or some of bounces (further diffuse reflections), mirror-diffuse (diffuse light that also meets a mirror), mirror-sky (the sky in mirrors). Default: `all`."""

    reflectance: Mapping[str, Follow] | None
    """Change a diffuse reflectance: GROUP=0.6, or a material's name, `ground` or `obstruction` in place of the group; may be repeated, the last one counts."""

    schedule: Mapping[str, Follow] | None
    """Change a diffuse reflectance over time: a CSV with a column `reflectance` and a line for each condition, for each row of the weather file, or for each of 12 months; may be repeated."""

    transmittance: Mapping[str, Follow] | None
    """Change the transmittance of canopies, the share of light that each of their faces, or each metre of a volume of leaves, lets through: GROUP=0.4, or a CSV as for `schedule`, with a column `transmittance` (leaves by season); may be repeated, the last one counts."""

    leaf_area_density: Mapping[str, Follow] | None
    """Change the leaf area density of crowns that are volumes of leaves, m2/m3: GROUP=0.8, or a CSV as for `schedule`, with a column `leaf_area_density` (leaves by season); may be repeated, the last one counts."""

    latitude: float | None
    """Latitude of the weather, degrees, north positive, in place of that of the file [default if the file states none: that of the scene]"""

    longitude: float | None
    """Longitude of the weather, degrees, east positive, in place of that of the file."""

    time_zone: str | float | None
    """Time zone of the weather file's clock, in place of that of the file: hours ahead of UTC, such as +01:00, -7 or UTC, or a name, such as Europe/Amsterdam, with its summer time. If its time stamps state an offset, the zone of days and labels in results."""

    shift: str | float | None
    """Shift of the weather file's time stamps, such as 41min, -30min or 0.5h; `auto` chooses the shift under which GHI, DNI and DHI agree best, if they agree clearly better."""

    weather_stamp: Literal["start", "middle", "end"] | None
    """Position of the weather file's time stamps in their intervals; middle for values at one moment [default: as the format, the names of columns or hours 1 to 24 imply; start for plain CSV]"""

    date_order: Literal["dmy", "mdy", "ymd"] | None
    """Order of day and month in the weather file's dates of three numbers, such as 01/06/2021 [default: what the whole column shows]"""

    every: Literal["hour", "day", "month", "year", "total"] | None
    """Period of a row: means in W/m2 of hours, sums in kWh/m2 of longer periods. Default: `total`."""

    stamp: Literal["start", "middle", "end"] | None
    """Time that labels a row of means: the start, middle or end of its interval, as 06:00, 06:30 or 07:00 for the hour from 06:00 to 07:00 (the last hour of a day ends at 00:00 of the next); sums are labelled with the start of their period. Default: `start`."""

    year: int | None
    """Year of all dates in results, such as 2019, for example for a typical year, whose months come from different ones. Sun positions stay those of the file's dates; 29 February is left out if the year has none. `before` and `end` then refer to this year."""

    start: str | datetime.date | None
    """First day that counts, such as 2019-03-01, or 03-01 of any year (for typical years and winters), or a time such as 03-01T06:00."""

    end: str | datetime.date | None
    """Last day that counts, up to its end; if it is before `before`, that day of the next year, as in `before` 11-01 `end` 02-28."""

    steps: int | None
    """Number of sun positions within each interval of the weather file, 1 to 60 [default: the number per hour for which the archive was built]"""

    snow: Literal["depth", "albedo"] | None
    """Change the reflectance of all ground by the weather file: its snow depth (`snow_reflectance` from 1 cm on) or its albedo."""

    snow_reflectance: float | None
    """Diffuse reflectance of snow. Default: `0.6`."""

    temperature: Mapping[str, Follow] | None
    """Temperature of `ground` or `obstruction` surfaces for the column `longwave`: degrees Celsius, or a CSV as for `schedule` with a column `temperature_c`; may be repeated, the last one counts [default: the weather file's dry bulb temperature]"""

    summary: Place | None
    """Table to write with a row for each AFTER: means, and how many receivers, windows and buildings lose more than 5, 10 and 20 %: .csv (with .csv-metadata.json beside it, which describes its columns), .parquet, .arrow, .feather (compressed Arrow), .npy (with .axes.json beside it), .npz, or - for CSV on standard output."""

    unmatched: Place | None
    """Table to write of the receivers that only one of the archives holds: .csv (with .csv-metadata.json beside it, which describes its columns), .parquet, .arrow, .feather (compressed Arrow), .npy (with .axes.json beside it), .npz, or - for CSV on standard output."""

    progress: Progress | None
    """Called now and then with the stage, the number of items done, and the number of all."""


class BuildingsOptions(TypedDict, total=False):
    """Options of `Archive.buildings`."""

    memory: int | str | None
    """Memory to work in, such as 512MiB or 2GiB. Default: `4GiB`."""

    faces: Place | None
    """Also write a table of roof faces; its ending chooses the format, as for `output`."""

    threshold: float | None
    """Least irradiation of a usable place on a roof, kWh/m2 over the weather file. Default: `900`."""

    min_area: float | None
    """Least area of a usable region, m2: usable places that touch one another. Default: `10`."""

    receivers: Wanted | None
    """Only the receivers listed in a CSV file: ids in a column `receiver`."""

    bbox: str | Sequence[float] | None
    """Only the receivers in a box, coordinates of the scene in metres: xmin,ymin,xmax,ymax and optionally zmin,zmax; of an atlas, only parts that touch it are opened."""

    surfaces: str | Sequence[str] | None
    """Only the receivers of these surfaces."""

    objects: str | Sequence[str] | None
    """Only the receivers of these objects or buildings."""

    sky: str | os.PathLike[str] | float | None
    """Sky radiance distribution: perez (all-weather, 1993), perez1990 (tilted surfaces, as in EnergyPlus and pvlib), uniform (the same radiance everywhere), or cie:1 to cie:16 (the traditional overcast sky); or a file with a dot in its name: radiances of 145, 577 or 2305 patches as .csv, a matrix of Radiance (gendaymtx -s -O1, genskyvec), or a square equidistant photograph of the sky as .png, .hdr or .exr. Default: `perez`."""

    sky_scale: Literal["dhi", "given"] | None
    """Scale of the radiances in a file of `sky` [default: dhi for photographs, given for tables and matrices]"""

    sky_white: float | None
    """Radiance of white in a photograph of `sky`, W/m2/sr, for `sky_scale` given [default: levels of .hdr and .exr are radiances]"""

    clouds: Place | None
    """Transmittance of clouds before sun and sky, 0 to 1 by direction: a table of patches as for `sky`, or a square equidistant (fisheye) picture."""

    image_top: float | None
    """Azimuth of the top of the pictures of `sky` and `clouds`, degrees clockwise from true north; their left side is 90 degrees further clockwise [default: 0, north]"""

    patches: int | None
    """Number of sky patches: 145, 577 or 2305 [default: that for which the archive was built]"""

    bounces: str | float | None
    """Number of diffuse reflections that count: all, or 1 to 64 (1 counts the first one only). Default: `all`."""

    paths: str | Sequence[str | os.PathLike[str]] | None
    """Light paths that count besides direct sun and sky, their first diffuse reflection and the sun in mirrors: all, none (as in EnergyPlus), or some of bounces (further diffuse reflections), mirror-diffuse (diffuse light that also meets a mirror), mirror-sky (the sky in mirrors). Default: `all`."""

    reflectance: Mapping[str, Follow] | None
    """Change a diffuse reflectance: GROUP=0.6, or a material's name, `ground` or `obstruction` in place of the group; may be repeated, the last one counts."""

    schedule: Mapping[str, Follow] | None
    """Change a diffuse reflectance over time: a CSV with a column `reflectance` and a line for each condition, for each row of the weather file, or for each of 12 months; may be repeated."""

    transmittance: Mapping[str, Follow] | None
    """Change the transmittance of canopies, the share of light that each of their faces, or each metre of a volume of leaves, lets through: GROUP=0.4, or a CSV as for `schedule`, with a column `transmittance` (leaves by season); may be repeated, the last one counts."""

    leaf_area_density: Mapping[str, Follow] | None
    """Change the leaf area density of crowns that are volumes of leaves, m2/m3: GROUP=0.8, or a CSV as for `schedule`, with a column `leaf_area_density` (leaves by season); may be repeated, the last one counts."""

    latitude: float | None
    """Latitude of the weather, degrees, north positive, in place of that of the file [default if the file states none: that of the scene]"""

    longitude: float | None
    """Longitude of the weather, degrees, east positive, in place of that of the file."""

    time_zone: str | float | None
    """Time zone of the weather file's clock, in place of that of the file: hours ahead of UTC, such as +01:00, -7 or UTC, or a name, such as Europe/Amsterdam, with its summer time. If its time stamps state an offset, the zone of days and labels in results."""

    shift: str | float | None
    """Shift of the weather file's time stamps, such as 41min, -30min or 0.5h; `auto` chooses the shift under which GHI, DNI and DHI agree best, if they agree clearly better."""

    weather_stamp: Literal["start", "middle", "end"] | None
    """Position of the weather file's time stamps in their intervals; middle for values at one moment [default: as the format, the names of columns or hours 1 to 24 imply; start for plain CSV]"""

    date_order: Literal["dmy", "mdy", "ymd"] | None
    """Order of day and month in the weather file's dates of three numbers, such as 01/06/2021 [default: what the whole column shows]"""

    start: str | datetime.date | None
    """First day that counts, such as 2019-03-01, or 03-01 of any year (for typical years and winters), or a time such as 03-01T06:00."""

    end: str | datetime.date | None
    """Last day that counts, up to its end; if it is before `before`, that day of the next year, as in `before` 11-01 `end` 02-28."""

    steps: int | None
    """Number of sun positions within each interval of the weather file, 1 to 60 [default: the number per hour for which the archive was built]"""

    snow: Literal["depth", "albedo"] | None
    """Change the reflectance of all ground by the weather file: its snow depth (`snow_reflectance` from 1 cm on) or its albedo."""

    snow_reflectance: float | None
    """Diffuse reflectance of snow. Default: `0.6`."""

    progress: Progress | None
    """Called now and then with the stage, the number of items done, and the number of all."""


class PlacesOptions(TypedDict, total=False):
    """Options of `Archive.places`."""

    memory: int | str | None
    """Memory to work in, such as 512MiB or 2GiB. Default: `4GiB`."""

    best: int | None
    """Number of places, the best first. Default: `10`."""

    module: str | Sequence[float] | None
    """Width x height of a module, metres: the width is horizontal, the height goes up the surface. Default: `1.1x1.8`."""

    on: Literal["roofs", "facades", "both"] | None
    """Surfaces to search for places. Default: `roofs`."""

    clearance: float | None
    """Height of modules above their surface, metres. Default: `0.1`."""

    receivers: Wanted | None
    """Only the receivers listed in a CSV file: ids in a column `receiver`."""

    bbox: str | Sequence[float] | None
    """Only the receivers in a box, coordinates of the scene in metres: xmin,ymin,xmax,ymax and optionally zmin,zmax; of an atlas, only parts that touch it are opened."""

    surfaces: str | Sequence[str] | None
    """Only the receivers of these surfaces."""

    objects: str | Sequence[str] | None
    """Only the receivers of these objects or buildings."""

    sky: str | os.PathLike[str] | float | None
    """Sky radiance distribution: perez (all-weather, 1993), perez1990 (tilted surfaces, as in EnergyPlus and pvlib), uniform (the same radiance everywhere), or cie:1 to cie:16 (the traditional overcast sky); or a file with a dot in its name: radiances of 145, 577 or 2305 patches as .csv, a matrix of Radiance (gendaymtx -s -O1, genskyvec), or a square equidistant photograph of the sky as .png, .hdr or .exr. Default: `perez`."""

    sky_scale: Literal["dhi", "given"] | None
    """Scale of the radiances in a file of `sky` [default: dhi for photographs, given for tables and matrices]"""

    sky_white: float | None
    """Radiance of white in a photograph of `sky`, W/m2/sr, for `sky_scale` given [default: levels of .hdr and .exr are radiances]"""

    clouds: Place | None
    """Transmittance of clouds before sun and sky, 0 to 1 by direction: a table of patches as for `sky`, or a square equidistant (fisheye) picture."""

    image_top: float | None
    """Azimuth of the top of the pictures of `sky` and `clouds`, degrees clockwise from true north; their left side is 90 degrees further clockwise [default: 0, north]"""

    patches: int | None
    """Number of sky patches: 145, 577 or 2305 [default: that for which the archive was built]"""

    bounces: str | float | None
    """Number of diffuse reflections that count: all, or 1 to 64 (1 counts the first one only). Default: `all`."""

    paths: str | Sequence[str | os.PathLike[str]] | None
    """Light paths that count besides direct sun and sky, their first diffuse reflection and the sun in mirrors: all, none (as in EnergyPlus), or some of bounces (further diffuse reflections), mirror-diffuse (diffuse light that also meets a mirror), mirror-sky (the sky in mirrors). Default: `all`."""

    reflectance: Mapping[str, Follow] | None
    """Change a diffuse reflectance: GROUP=0.6, or a material's name, `ground` or `obstruction` in place of the group; may be repeated, the last one counts."""

    schedule: Mapping[str, Follow] | None
    """Change a diffuse reflectance over time: a CSV with a column `reflectance` and a line for each condition, for each row of the weather file, or for each of 12 months; may be repeated."""

    transmittance: Mapping[str, Follow] | None
    """Change the transmittance of canopies, the share of light that each of their faces, or each metre of a volume of leaves, lets through: GROUP=0.4, or a CSV as for `schedule`, with a column `transmittance` (leaves by season); may be repeated, the last one counts."""

    leaf_area_density: Mapping[str, Follow] | None
    """Change the leaf area density of crowns that are volumes of leaves, m2/m3: GROUP=0.8, or a CSV as for `schedule`, with a column `leaf_area_density` (leaves by season); may be repeated, the last one counts."""

    latitude: float | None
    """Latitude of the weather, degrees, north positive, in place of that of the file [default if the file states none: that of the scene]"""

    longitude: float | None
    """Longitude of the weather, degrees, east positive, in place of that of the file."""

    time_zone: str | float | None
    """Time zone of the weather file's clock, in place of that of the file: hours ahead of UTC, such as +01:00, -7 or UTC, or a name, such as Europe/Amsterdam, with its summer time. If its time stamps state an offset, the zone of days and labels in results."""

    shift: str | float | None
    """Shift of the weather file's time stamps, such as 41min, -30min or 0.5h; `auto` chooses the shift under which GHI, DNI and DHI agree best, if they agree clearly better."""

    weather_stamp: Literal["start", "middle", "end"] | None
    """Position of the weather file's time stamps in their intervals; middle for values at one moment [default: as the format, the names of columns or hours 1 to 24 imply; start for plain CSV]"""

    date_order: Literal["dmy", "mdy", "ymd"] | None
    """Order of day and month in the weather file's dates of three numbers, such as 01/06/2021 [default: what the whole column shows]"""

    start: str | datetime.date | None
    """First day that counts, such as 2019-03-01, or 03-01 of any year (for typical years and winters), or a time such as 03-01T06:00."""

    end: str | datetime.date | None
    """Last day that counts, up to its end; if it is before `before`, that day of the next year, as in `before` 11-01 `end` 02-28."""

    steps: int | None
    """Number of sun positions within each interval of the weather file, 1 to 60 [default: the number per hour for which the archive was built]"""

    snow: Literal["depth", "albedo"] | None
    """Change the reflectance of all ground by the weather file: its snow depth (`snow_reflectance` from 1 cm on) or its albedo."""

    snow_reflectance: float | None
    """Diffuse reflectance of snow. Default: `0.6`."""

    progress: Progress | None
    """Called now and then with the stage, the number of items done, and the number of all."""


class ShadingOptions(TypedDict, total=False):
    """Options of `Archive.shading`."""

    memory: int | str | None
    """Memory to work in, such as 512MiB or 2GiB. Default: `4GiB`."""

    by: Literal["receiver", "surface", "window", "object", "building", "kind"] | None
    """Grouping of rows: what light is taken from. Default: `receiver`."""

    takers: Literal["building", "object", "type"] | None
    """Grouping of rows: what takes light. Default: `building`."""

    plots: Place | Sequence[Place] | None
    """Draw a picture. A name that ends with .svg is a chart: what is taken from all receivers, stacked by what takes it, for each row of `every`. One that ends with .png is what a single chosen receiver sees, in the colours of the chart. May be repeated; a table is then written only if `output` names one."""

    receivers: Wanted | None
    """Only the receivers listed in a CSV file: ids in a column `receiver`."""

    bbox: str | Sequence[float] | None
    """Only the receivers in a box, coordinates of the scene in metres: xmin,ymin,xmax,ymax and optionally zmin,zmax; of an atlas, only parts that touch it are opened."""

    surfaces: str | Sequence[str] | None
    """Only the receivers of these surfaces."""

    objects: str | Sequence[str] | None
    """Only the receivers of these objects or buildings."""

    sky: str | os.PathLike[str] | float | None
    """Sky radiance distribution: perez (all-weather, 1993), perez1990 (tilted surfaces, as in EnergyPlus and pvlib), uniform (the same radiance everywhere), or cie:1 to cie:16 (the traditional overcast sky); or a file with a dot in its name: radiances of 145, 577 or 2305 patches as .csv, a matrix of Radiance (gendaymtx -s -O1, genskyvec), or a square equidistant photograph of the sky as .png, .hdr or .exr. Default: `perez`."""

    sky_scale: Literal["dhi", "given"] | None
    """Scale of the radiances in a file of `sky` [default: dhi for photographs, given for tables and matrices]"""

    sky_white: float | None
    """Radiance of white in a photograph of `sky`, W/m2/sr, for `sky_scale` given [default: levels of .hdr and .exr are radiances]"""

    clouds: Place | None
    """Transmittance of clouds before sun and sky, 0 to 1 by direction: a table of patches as for `sky`, or a square equidistant (fisheye) picture."""

    image_top: float | None
    """Azimuth of the top of the pictures of `sky` and `clouds`, degrees clockwise from true north; their left side is 90 degrees further clockwise [default: 0, north]"""

    patches: int | None
    """Number of sky patches: 145, 577 or 2305 [default: that for which the archive was built]"""

    bounces: str | float | None
    """Number of diffuse reflections that count: all, or 1 to 64 (1 counts the first one only). Default: `all`."""

    paths: str | Sequence[str | os.PathLike[str]] | None
    """Light paths that count besides direct sun and sky, their first diffuse reflection and the sun in mirrors: all, none (as in EnergyPlus), or some of bounces (further diffuse reflections), mirror-diffuse (diffuse light that also meets a mirror), mirror-sky (the sky in mirrors). Default: `all`."""

    reflectance: Mapping[str, Follow] | None
    """Change a diffuse reflectance: GROUP=0.6, or a material's name, `ground` or `obstruction` in place of the group; may be repeated, the last one counts."""

    schedule: Mapping[str, Follow] | None
    """Change a diffuse reflectance over time: a CSV with a column `reflectance` and a line for each condition, for each row of the weather file, or for each of 12 months; may be repeated."""

    transmittance: Mapping[str, Follow] | None
    """Change the transmittance of canopies, the share of light that each of their faces, or each metre of a volume of leaves, lets through: GROUP=0.4, or a CSV as for `schedule`, with a column `transmittance` (leaves by season); may be repeated, the last one counts."""

    leaf_area_density: Mapping[str, Follow] | None
    """Change the leaf area density of crowns that are volumes of leaves, m2/m3: GROUP=0.8, or a CSV as for `schedule`, with a column `leaf_area_density` (leaves by season); may be repeated, the last one counts."""

    latitude: float | None
    """Latitude of the weather, degrees, north positive, in place of that of the file [default if the file states none: that of the scene]"""

    longitude: float | None
    """Longitude of the weather, degrees, east positive, in place of that of the file."""

    time_zone: str | float | None
    """Time zone of the weather file's clock, in place of that of the file: hours ahead of UTC, such as +01:00, -7 or UTC, or a name, such as Europe/Amsterdam, with its summer time. If its time stamps state an offset, the zone of days and labels in results."""

    shift: str | float | None
    """Shift of the weather file's time stamps, such as 41min, -30min or 0.5h; `auto` chooses the shift under which GHI, DNI and DHI agree best, if they agree clearly better."""

    weather_stamp: Literal["start", "middle", "end"] | None
    """Position of the weather file's time stamps in their intervals; middle for values at one moment [default: as the format, the names of columns or hours 1 to 24 imply; start for plain CSV]"""

    date_order: Literal["dmy", "mdy", "ymd"] | None
    """Order of day and month in the weather file's dates of three numbers, such as 01/06/2021 [default: what the whole column shows]"""

    every: Literal["hour", "day", "month", "year", "total"] | None
    """Period of a row: means in W/m2 of hours, sums in kWh/m2 of longer periods. Default: `year`."""

    stamp: Literal["start", "middle", "end"] | None
    """Time that labels a row of means: the start, middle or end of its interval, as 06:00, 06:30 or 07:00 for the hour from 06:00 to 07:00 (the last hour of a day ends at 00:00 of the next); sums are labelled with the start of their period. Default: `start`."""

    year: int | None
    """Year of all dates in results, such as 2019, for example for a typical year, whose months come from different ones. Sun positions stay those of the file's dates; 29 February is left out if the year has none. `before` and `end` then refer to this year."""

    start: str | datetime.date | None
    """First day that counts, such as 2019-03-01, or 03-01 of any year (for typical years and winters), or a time such as 03-01T06:00."""

    end: str | datetime.date | None
    """Last day that counts, up to its end; if it is before `before`, that day of the next year, as in `before` 11-01 `end` 02-28."""

    steps: int | None
    """Number of sun positions within each interval of the weather file, 1 to 60 [default: the number per hour for which the archive was built]"""

    snow: Literal["depth", "albedo"] | None
    """Change the reflectance of all ground by the weather file: its snow depth (`snow_reflectance` from 1 cm on) or its albedo."""

    snow_reflectance: float | None
    """Diffuse reflectance of snow. Default: `0.6`."""

    progress: Progress | None
    """Called now and then with the stage, the number of items done, and the number of all."""


class SunlightOptions(TypedDict, total=False):
    """Options of `Archive.sunlight`."""

    memory: int | str | None
    """Memory to work in, such as 512MiB or 2GiB. Default: `4GiB`."""

    by: Literal["receiver", "surface", "window", "object", "building", "kind"] | None
    """Grouping of rows: what each row stands for. Default: `receiver`."""

    geo: bool
    """Write .parquet as a map (GeoParquet), one row with a polygon for each receiver, surface and so on."""

    plots: Place | Sequence[Place] | None
    """Draw a picture of the results. A name that ends with .png is a map of the sums (or of one condition), from above and from the south-west; one that ends with .svg is a chart of the mean of all receivers, weighted by area: bars by component of `every` day, month or year (or of conditions), hours of the day by month of `every` hour. May be repeated; a table is then written only if `output` names one."""

    receivers: Wanted | None
    """Only the receivers listed in a CSV file: ids in a column `receiver`."""

    bbox: str | Sequence[float] | None
    """Only the receivers in a box, coordinates of the scene in metres: xmin,ymin,xmax,ymax and optionally zmin,zmax; of an atlas, only parts that touch it are opened."""

    surfaces: str | Sequence[str] | None
    """Only the receivers of these surfaces."""

    objects: str | Sequence[str] | None
    """Only the receivers of these objects or buildings."""

    year: int | None
    """Year of the dates that state none; results of other years differ by a few minutes. Default: `2017`."""

    every: Literal["hour", "day", "month", "year", "total"] | None
    """Period of a row, without `rules`: a day, or all days of a month, a year or all of them. Default: `day`."""

    rules: str | Sequence[str] | None
    """Rule to check: a name that `heliotile info --rule all` lists, or a file with rules of your own (.toml); may be repeated."""

    before: Place | None
    """Archive or atlas before a change: adds its results, the minutes that changed, and the rules that are newly broken."""

    zone: str | float | None
    """Time zone of results: hours ahead of UTC, such as +01:00, or a name such as Europe/Amsterdam, with its summer time [default: that of the weather file if one is given, else whole hours by longitude]"""

    least_altitude: float | None
    """Least altitude of the sun that counts, degrees; if a rule states one too, the higher one applies. Default: `0`."""

    lit_share: float | None
    """Share of a row's area that must be lit for a moment to count, without `rules` [default: any part of it] Default: `0`."""

    trees: Literal["ignore", "opaque", "half"] | None
    """Shade of trees and screens, which are materials with a transmittance. Default: `ignore`."""

    exact: bool
    """Refine moments at which an edge within a texel decides, by casting rays at the scene in the archive."""

    weather: Any | None
    """Weather file, such as .epw: rules of probable sunlight hours count its hours with a DNI of at least 120 W/m2, and irradiance of glare follows its DNI instead of that of a clear sky."""

    latitude: float | None
    """Latitude of the weather, degrees, north positive, in place of that of the file [default if the file states none: that of the scene]"""

    longitude: float | None
    """Longitude of the weather, degrees, east positive, in place of that of the file."""

    time_zone: str | float | None
    """Time zone of the weather file's clock, in place of that of the file: hours ahead of UTC, such as +01:00, -7 or UTC, or a name, such as Europe/Amsterdam, with its summer time. If its time stamps state an offset, the zone of days and labels in results."""

    shift: str | float | None
    """Shift of the weather file's time stamps, such as 41min, -30min or 0.5h; `auto` chooses the shift under which GHI, DNI and DHI agree best, if they agree clearly better."""

    weather_stamp: Literal["start", "middle", "end"] | None
    """Position of the weather file's time stamps in their intervals; middle for values at one moment [default: as the format, the names of columns or hours 1 to 24 imply; start for plain CSV]"""

    date_order: Literal["dmy", "mdy", "ymd"] | None
    """Order of day and month in the weather file's dates of three numbers, such as 01/06/2021 [default: what the whole column shows]"""

    progress: Progress | None
    """Called now and then with the stage, the number of items done, and the number of all."""


class GlareOptions(TypedDict, total=False):
    """Options of `Archive.glare`."""

    memory: int | str | None
    """Memory to work in, such as 512MiB or 2GiB. Default: `4GiB`."""

    by: Literal["receiver", "surface", "window", "object", "building", "kind"] | None
    """Grouping of rows: what each row stands for. Default: `receiver`."""

    geo: bool
    """Write .parquet as a map (GeoParquet), one row with a polygon for each receiver, surface and so on."""

    plots: Place | Sequence[Place] | None
    """Draw a picture of the results. A name that ends with .png is a map of the sums (or of one condition), from above and from the south-west; one that ends with .svg is a chart of the mean of all receivers, weighted by area: bars by component of `every` day, month or year (or of conditions), hours of the day by month of `every` hour. May be repeated; a table is then written only if `output` names one."""

    receivers: Wanted | None
    """Only the receivers listed in a CSV file: ids in a column `receiver`."""

    bbox: str | Sequence[float] | None
    """Only the receivers in a box, coordinates of the scene in metres: xmin,ymin,xmax,ymax and optionally zmin,zmax; of an atlas, only parts that touch it are opened."""

    surfaces: str | Sequence[str] | None
    """Only the receivers of these surfaces."""

    objects: str | Sequence[str] | None
    """Only the receivers of these objects or buildings."""

    year: int | None
    """Year of the dates that state none; results of other years differ by a few minutes. Default: `2017`."""

    rules: str | Sequence[str] | None
    """Rule to check: a name that `heliotile info --rule all` lists, or a file with rules of your own (.toml); may be repeated."""

    before: Place | None
    """Archive or atlas before a change: adds its results, the minutes that changed, and the rules that are newly broken."""

    zone: str | float | None
    """Time zone of results: hours ahead of UTC, such as +01:00, or a name such as Europe/Amsterdam, with its summer time [default: that of the weather file if one is given, else whole hours by longitude]"""

    least_altitude: float | None
    """Least altitude of the sun that counts, degrees; if a rule states one too, the higher one applies. Default: `0`."""

    exact: bool
    """Refine moments at which an edge within a texel decides, by casting rays at the scene in the archive."""

    weather: Any | None
    """Weather file, such as .epw: rules of probable sunlight hours count its hours with a DNI of at least 120 W/m2, and irradiance of glare follows its DNI instead of that of a clear sky."""

    latitude: float | None
    """Latitude of the weather, degrees, north positive, in place of that of the file [default if the file states none: that of the scene]"""

    longitude: float | None
    """Longitude of the weather, degrees, east positive, in place of that of the file."""

    time_zone: str | float | None
    """Time zone of the weather file's clock, in place of that of the file: hours ahead of UTC, such as +01:00, -7 or UTC, or a name, such as Europe/Amsterdam, with its summer time. If its time stamps state an offset, the zone of days and labels in results."""

    shift: str | float | None
    """Shift of the weather file's time stamps, such as 41min, -30min or 0.5h; `auto` chooses the shift under which GHI, DNI and DHI agree best, if they agree clearly better."""

    weather_stamp: Literal["start", "middle", "end"] | None
    """Position of the weather file's time stamps in their intervals; middle for values at one moment [default: as the format, the names of columns or hours 1 to 24 imply; start for plain CSV]"""

    date_order: Literal["dmy", "mdy", "ymd"] | None
    """Order of day and month in the weather file's dates of three numbers, such as 01/06/2021 [default: what the whole column shows]"""

    every: Literal["hour", "day", "month", "year", "total"] | None
    """Period of a row, without `rules`: a day, or all days of a month, a year or all of them [default: total]"""

    least_deflection: float | None
    """Least angle between the sun and its image in a mirror that counts, degrees; if a rule states one too, the larger one applies. Default: `0`."""

    view_angle: float | None
    """Largest angle between the direction of view of a receiver, its normal, and an image of the sun in a mirror that counts, degrees: 30 for a driver; if a rule states one too, the smaller one applies. Default: `90`."""

    spells: Place | None
    """Table to write with a row for each spell, a time of unbroken reflected sun: receiver, day, start, end, pane, irradiance, angles."""

    panes: Place | None
    """Table or map to write of the panes, with the minutes in which each reflects the sun to receivers."""

    progress: Progress | None
    """Called now and then with the stage, the number of items done, and the number of all."""


class EnvelopeOptions(TypedDict, total=False):
    """Options of `Archive.envelope`."""

    memory: int | str | None
    """Memory to work in, such as 512MiB or 2GiB. Default: `4GiB`."""

    hours: float | None
    """Hours of sun that each receiver keeps on each of `dates`; one that has fewer keeps them all."""

    spacing: str | float | None
    """Distance between the nodes of the grid, metres. Default: `1m`."""

    height_limit: str | float | None
    """Greatest height above the ground. Default: `50m`."""

    mesh: Place | None
    """Mesh to write of the envelope, a closed body (.obj), which `update` adds to the archive."""

    dates: str | Sequence[str] | None
    """Days to compute, separated by commas: 03-21, 2026-03-21, 02-19..10-21 or year; with `rules`, the days for rules that state none."""

    year: int | None
    """Year of the dates that state none; results of other years differ by a few minutes. Default: `2017`."""

    rules: str | Sequence[str] | None
    """Rule to check: a name that `heliotile info --rule all` lists, or a file with rules of your own (.toml); may be repeated."""

    zone: str | float | None
    """Time zone of results: hours ahead of UTC, such as +01:00, or a name such as Europe/Amsterdam, with its summer time [default: that of the weather file if one is given, else whole hours by longitude]"""

    least_altitude: float | None
    """Least altitude of the sun that counts, degrees; if a rule states one too, the higher one applies. Default: `0`."""

    trees: Literal["ignore", "opaque", "half"] | None
    """Shade of trees and screens, which are materials with a transmittance. Default: `ignore`."""

    exact: bool
    """Refine moments at which an edge within a texel decides, by casting rays at the scene in the archive."""

    receivers: Wanted | None
    """Only the receivers listed in a CSV file: ids in a column `receiver`."""

    bbox: str | Sequence[float] | None
    """Only the receivers in a box, coordinates of the scene in metres: xmin,ymin,xmax,ymax and optionally zmin,zmax; of an atlas, only parts that touch it are opened."""

    surfaces: str | Sequence[str] | None
    """Only the receivers of these surfaces."""

    objects: str | Sequence[str] | None
    """Only the receivers of these objects or buildings."""

    progress: Progress | None
    """Called now and then with the stage, the number of items done, and the number of all."""


class FactorsOptions(TypedDict, total=False):
    """Options of `Archive.factors`."""

    memory: int | str | None
    """Memory to work in, such as 512MiB or 2GiB. Default: `4GiB`."""

    receivers: Wanted | None
    """Only the receivers listed in a CSV file: ids in a column `receiver`."""

    bbox: str | Sequence[float] | None
    """Only the receivers in a box, coordinates of the scene in metres: xmin,ymin,xmax,ymax and optionally zmin,zmax; of an atlas, only parts that touch it are opened."""

    surfaces: str | Sequence[str] | None
    """Only the receivers of these surfaces."""

    objects: str | Sequence[str] | None
    """Only the receivers of these objects or buildings."""

    output: Place | None
    """Table to write: .csv (with .csv-metadata.json beside it, which describes its columns), .parquet, .arrow, .feather (compressed Arrow), .npy (with .axes.json beside it), .npz, or - for CSV on standard output. Default: `-`."""

    by: Literal["receiver", "surface", "window", "object", "building", "kind"] | None
    """Grouping of rows: what each row stands for. Default: `receiver`."""

    azimuth_step: float | None
    """Step of the sun's azimuth, degrees, from 0 to 360: a divisor of 360. Default: `10`."""

    altitude_step: float | None
    """Step of the sun's altitude, degrees, from 0.5 to 90: a divisor of 90. Default: `5`."""

    progress: Progress | None
    """Called now and then with the stage, the number of items done, and the number of all."""


class ExtractOptions(TypedDict, total=False):
    """Options of `Archive.extract`."""

    bbox: str | Sequence[float] | None
    """Only the receivers in a box, coordinates of the scene in metres: xmin,ymin,xmax,ymax and optionally zmin,zmax; of an atlas, only parts that touch it are opened."""

    surfaces: str | Sequence[str] | None
    """Only the receivers of these surfaces."""

    objects: str | Sequence[str] | None
    """Only the receivers of these objects or buildings."""

    with_scene: bool
    """False: Leave the scene's triangles out of the new archive."""

    replay_only: bool
    """Leave out hits and cells, about two thirds of the bytes: the archive answers for weather, suns, skies and hours of sun, but not for changed reflectances, a number of bounces, bands, longwave, comfort, maps of what a receiver sees or EnergyPlus; `build` makes it whole again."""

    memory: int | str | None
    """Memory to work in, such as 512MiB or 2GiB. Default: `4GiB`."""

    progress: Progress | None
    """Called now and then with the stage, the number of items done, and the number of all."""


class ExportOptions(TypedDict, total=False):
    """Options of `Archive.export`."""

    panel: bool
    """Draw six fisheye pictures in place of one: what is seen, the light of `sun` by its paths, and their sum, on one scale."""

    sun: str | Sequence[float] | None
    """Azimuth (clockwise from true north) and altitude of a sun, degrees: an .exr gets maps of its light, a .png its position."""

    dni: float | None
    """Direct normal irradiance of that sun, W/m2. Default: `0`."""

    dhi: float | None
    """Diffuse horizontal irradiance of the sky around it, W/m2. Default: `0`."""

    sky: str | None
    """Sky radiance distribution: perez (all-weather, 1993), perez1990 (tilted surfaces, as in EnergyPlus and pvlib), uniform (the same radiance everywhere), or cie:1 to cie:16 (the traditional overcast sky). Default: `perez`."""

    patches: int | None
    """Number of sky patches: 145, 577 or 2305 [default: that for which the archive was built]"""

    bounces: str | float | None
    """Number of diffuse reflections that count: all, or 1 to 64 (1 counts the first one only). Default: `all`."""

    weather: Any | None
    """Weather file. A .png shows the sun's paths over its place (the archive's, if the file states none), with hours of the file's clock; a page of `html` shows its weather."""

    time_zone: str | float | None
    """Time zone of the weather file's clock, in place of that of the file: hours ahead of UTC, such as +01:00, -7 or UTC, or a name, such as Europe/Amsterdam, with its summer time. If its time stamps state an offset, the zone of days and labels in results."""

    latitude: float | None
    """Latitude, degrees, north positive, for which a .png shows the sun's paths; hours are mean solar time."""

    view_factors: bool
    """Export the shares of every receiver's hemisphere that are sky, ground, obstructions and nothing (they sum to 1)."""

    memory: int | str | None
    """Memory to work in, such as 512MiB or 2GiB. Default: `4GiB`."""

    progress: Progress | None
    """Called now and then with the stage, the number of items done, and the number of all."""


class AuditOptions(TypedDict, total=False):
    """Options of `Archive.audit`."""

    weather: Any | None
    """Weather file from which hours are sampled, 12 positions of the sun in each [default: suns from all sides]"""

    time_zone: str | float | None
    """Time zone of the weather file's clock, in place of that of the file: hours ahead of UTC, such as +01:00, -7 or UTC, or a name, such as Europe/Amsterdam, with its summer time. If its time stamps state an offset, the zone of days and labels in results."""

    shift: str | float | None
    """Shift of the weather file's time stamps, such as 41min, -30min or 0.5h; `auto` chooses the shift under which GHI, DNI and DHI agree best, if they agree clearly better."""

    weather_stamp: Literal["start", "middle", "end"] | None
    """Position of the weather file's time stamps in their intervals; middle for values at one moment [default: as the format, the names of columns or hours 1 to 24 imply; start for plain CSV]"""

    date_order: Literal["dmy", "mdy", "ymd"] | None
    """Order of day and month in the weather file's dates of three numbers, such as 01/06/2021 [default: what the whole column shows]"""

    conditions: Any | None
    """Table of suns and skies in place of weather, as for `replay`: condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2. If it has up to 64 rows, each receiver is checked under all of them."""

    samples: int | None
    """Number of receivers to check [default: 256, or as many as `seconds` allow]"""

    hours: int | None
    """Number of hours to check for each receiver [default: 8, or all rows of `conditions` if they are 64 or fewer]"""

    seconds: float | None
    """Time limit, seconds: no receiver is started after it."""

    paths: str | Sequence[str | os.PathLike[str]] | None
    """Number of light paths that the reference path tracer follows from each receiver. Default: `4096`."""

    seed: int | None
    """Seed of the random choice of receivers, hours and paths. Default: `1`."""

    sky: str | None
    """Sky radiance distribution: perez, uniform, or cie:1 to cie:16. Default: `perez`."""

    output: Place | None
    """Folder to write audit.csv, pictures and index.html into."""

    memory: int | str | None
    """Memory to work in, such as 512MiB or 2GiB. Default: `4GiB`."""

    progress: Progress | None
    """Called now and then with the stage, the number of items done, and the number of all."""


class UpdateOptions(TypedDict, total=False):
    """Options of `Archive.update`."""

    add: Place | Sequence[Place] | None
    """Add the objects of a scene file, in the coordinates of the scene; may be repeated."""

    remove: str | Sequence[str] | None
    """Remove an object or a building; may be repeated, as `move`, `height` and `material` may."""

    move: Mapping[str, Sequence[float]] | None
    """Move an object by these metres along x, y and z; its receivers go with it."""

    height: Mapping[str, str] | None
    """Raise or lower the roofs of an object, and its walls with them: by +3m or -3m, or to a height of 12m over its lowest point."""

    material: Mapping[str, object] | None
    """Give all surfaces of an object a material of the scene or of `materials`."""

    materials: Place | None
    """File of reflectances (TOML), one table for each material name. They replace those of the scene files; materials without a table keep their own values, or get usual ones."""

    materials_only: bool
    """Ignore the materials of the scene files; `materials` has to describe all of them."""

    ground: bool
    """False: Add no ground to a scene that has none [default: add a plane below it; for an EnergyPlus model, as the model states]"""

    assume_version: str | None
    """Read EnergyPlus models as models of this version, whatever version they state; it decides what the fields of an IDF mean. With 25.2, `energyplus` accepts models of any version, for EnergyPlus 25.2 to run as they are."""

    crs: str | float | None
    """Coordinate reference system of the scene's coordinates, in metres: EPSG:28992 or 28992."""

    latitude: float | None
    """Latitude of the scene, degrees, north positive; y is then true north, unless a coordinate system states otherwise."""

    longitude: float | None
    """Longitude of the scene, degrees, east positive."""

    rotate_deg: float | None
    """Angle of the model's y axis from north, degrees, clockwise as seen from above (the north axis of EnergyPlus); coordinates stay."""

    elevation: float | None
    """Height above sea level of z = 0, metres, for all files but terrain."""

    scale: float | None
    """Metres per unit of all files but terrain: 0.001 for millimetres. 0.3048 and 0.3048006 (feet) also apply to terrain whose file does not state its unit."""

    up: Literal["y", "z"] | None
    """The axis that points up in OBJ, PLY and STL files: z, with y to the north, or y, with z to the south [default: z]"""

    on: str | Sequence[str] | None
    """Surfaces of new or reshaped objects to cover with receivers, as for `receivers`."""

    spacing: str | float | None
    """Distance between the receivers on new or reshaped objects, such as 2m [default: about that of the archive's own]"""

    fresh: bool
    """Discard an interrupted update at the output path and start again. Without this option an update with the same edits is resumed."""

    memory: int | str | None
    """Memory to work in, such as 512MiB or 2GiB. Default: `4GiB`."""

    progress: Progress | None
    """Called now and then with the stage, the number of items done, and the number of all."""


class ComfortOptions(TypedDict, total=False):
    """Options of `Archive.comfort`."""

    geo: bool
    """Write .parquet as a map (GeoParquet), one row with a polygon for each receiver, surface and so on."""

    plots: Place | Sequence[Place] | None
    """Draw a picture of the results. A name that ends with .png is a map of the sums (or of one condition), from above and from the south-west; one that ends with .svg is a chart of the mean of all receivers, weighted by area: bars by component of `every` day, month or year (or of conditions), hours of the day by month of `every` hour. May be repeated; a table is then written only if `output` names one."""

    sky: str | os.PathLike[str] | float | None
    """Sky radiance distribution: perez (all-weather, 1993), perez1990 (tilted surfaces, as in EnergyPlus and pvlib), uniform (the same radiance everywhere), or cie:1 to cie:16 (the traditional overcast sky); or a file with a dot in its name: radiances of 145, 577 or 2305 patches as .csv, a matrix of Radiance (gendaymtx -s -O1, genskyvec), or a square equidistant photograph of the sky as .png, .hdr or .exr. Default: `perez`."""

    sky_scale: Literal["dhi", "given"] | None
    """Scale of the radiances in a file of `sky` [default: dhi for photographs, given for tables and matrices]"""

    sky_white: float | None
    """Radiance of white in a photograph of `sky`, W/m2/sr, for `sky_scale` given [default: levels of .hdr and .exr are radiances]"""

    clouds: Place | None
    """Transmittance of clouds before sun and sky, 0 to 1 by direction: a table of patches as for `sky`, or a square equidistant (fisheye) picture."""

    image_top: float | None
    """Azimuth of the top of the pictures of `sky` and `clouds`, degrees clockwise from true north; their left side is 90 degrees further clockwise [default: 0, north]"""

    reflectance: Mapping[str, Follow] | None
    """Change a diffuse reflectance: GROUP=0.6, or a material's name, `ground` or `obstruction` in place of the group; may be repeated, the last one counts."""

    schedule: Mapping[str, Follow] | None
    """Change a diffuse reflectance over time: a CSV with a column `reflectance` and a line for each condition, for each row of the weather file, or for each of 12 months; may be repeated."""

    transmittance: Mapping[str, Follow] | None
    """Change the transmittance of canopies, the share of light that each of their faces, or each metre of a volume of leaves, lets through: GROUP=0.4, or a CSV as for `schedule`, with a column `transmittance` (leaves by season); may be repeated, the last one counts."""

    leaf_area_density: Mapping[str, Follow] | None
    """Change the leaf area density of crowns that are volumes of leaves, m2/m3: GROUP=0.8, or a CSV as for `schedule`, with a column `leaf_area_density` (leaves by season); may be repeated, the last one counts."""

    time_zone: str | float | None
    """Time zone of the weather file's clock, in place of that of the file: hours ahead of UTC, such as +01:00, -7 or UTC, or a name, such as Europe/Amsterdam, with its summer time. If its time stamps state an offset, the zone of days and labels in results."""

    shift: str | float | None
    """Shift of the weather file's time stamps, such as 41min, -30min or 0.5h; `auto` chooses the shift under which GHI, DNI and DHI agree best, if they agree clearly better."""

    weather_stamp: Literal["start", "middle", "end"] | None
    """Position of the weather file's time stamps in their intervals; middle for values at one moment [default: as the format, the names of columns or hours 1 to 24 imply; start for plain CSV]"""

    date_order: Literal["dmy", "mdy", "ymd"] | None
    """Order of day and month in the weather file's dates of three numbers, such as 01/06/2021 [default: what the whole column shows]"""

    every: Literal["hour", "day", "month", "year", "total"] | None
    """Period of a row: means in W/m2 of hours, sums in kWh/m2 of longer periods. Default: `hour`."""

    stamp: Literal["start", "middle", "end"] | None
    """Time that labels a row of means: the start, middle or end of its interval, as 06:00, 06:30 or 07:00 for the hour from 06:00 to 07:00 (the last hour of a day ends at 00:00 of the next); sums are labelled with the start of their period. Default: `start`."""

    year: int | None
    """Year of all dates in results, such as 2019, for example for a typical year, whose months come from different ones. Sun positions stay those of the file's dates; 29 February is left out if the year has none. `before` and `end` then refer to this year."""

    start: str | datetime.date | None
    """First day that counts, such as 2019-03-01, or 03-01 of any year (for typical years and winters), or a time such as 03-01T06:00."""

    end: str | datetime.date | None
    """Last day that counts, up to its end; if it is before `before`, that day of the next year, as in `before` 11-01 `end` 02-28."""

    steps: int | None
    """Number of sun positions within each interval of the weather file, 1 to 60 [default: the number per hour for which the archive was built]"""

    snow: Literal["depth", "albedo"] | None
    """Change the reflectance of all ground by the weather file: its snow depth (`snow_reflectance` from 1 cm on) or its albedo."""

    snow_reflectance: float | None
    """Diffuse reflectance of snow. Default: `0.6`."""

    temperature: Mapping[str, Follow] | None
    """Temperature of `ground` or `obstruction` surfaces for the column `longwave`: degrees Celsius, or a CSV as for `schedule` with a column `temperature_c`; may be repeated, the last one counts [default: the weather file's dry bulb temperature]"""

    columns: Literal["air", "wind", "mrt", "utci", "pet", "shortwave", "longwave"] | Sequence[Literal["air", "wind", "mrt", "utci", "pet", "shortwave", "longwave"]] | None
    """Columns to write, in this order: some of mrt, utci, pet, air, wind, shortwave and longwave (six planes each) [default: mrt,utci,pet]"""

    above: float | Sequence[float] | None
    """Limits of the UTCI, degrees Celsius: rows of days and longer count the hours above each. Default: `26,32,38,46`."""

    posture: Literal["standing", "sitting"] | None
    """Posture of people. Default: `standing`."""

    sun_on: Literal["cylinder", "box"] | None
    """Model of the direct sun on a person. Default: `cylinder`."""

    surfaces: Literal["sol-air", "air"] | None
    """Temperature of the surfaces that `temperature` does not state. Default: `sol-air`."""

    film: float | None
    """Heat transfer coefficient between surfaces and air, radiation included, W/m2K. Default: `17`."""

    emissivity: Mapping[str, object] | None
    """Longwave emissivity of `ground` or `obstruction`; may be repeated [default: what their materials state, else ground=0.95, obstruction=0.9]"""

    absorptance: Mapping[str, object] | None
    """Share of sunlight that `ground` or `obstruction` surfaces absorb, for `surfaces` sol-air; may be repeated [default: what their materials do not reflect]"""

    wind: str | os.PathLike[str] | float | None
    """Wind speed 10 m above the ground: a factor on that of the weather file, or a CSV as for `schedule` with a column `wind_m_s`. Default: `1`."""

    memory: int | str | None
    """Memory to work in, such as 512MiB or 2GiB. Default: `4GiB`."""

    progress: Progress | None
    """Called now and then with the stage, the number of items done, and the number of all."""


class PeopleOptions(TypedDict, total=False):
    """Options of `comfort`."""

    points: Place | None
    """Positions of people, CSV with columns point,x,y and optionally z or height [default: on the ground, `spacing` apart]"""

    on: str | Sequence[str] | None
    """Kinds of surfaces, or materials, that people stand on; several with commas. Default: `ground`."""

    spacing: str | float | None
    """Distance between people, such as 2m. Default: `2m`."""

    body_height: str | float | None
    """Height of the middle of a person above the ground. Default: `1.1m`."""

    quality: Literal["draft", "standard", "fine", "reference"] | None
    """Accuracy level: a named set of settings, from fast to accurate. Default: `standard`."""

    settings: Mapping[str, object] | None
    """Change one setting of the accuracy level, such as hit=16 or sky_fine=512; `info` of an archive lists the settings; may be repeated."""

    error: str | float | None
    """Largest error to accept, the RMSE of hourly totals in percent of their mean, such as 2%: settings are tried on some of the receivers, and the cheapest that keep it are used."""

    error_weather: Any | None
    """Weather file under which the errors of `error` are estimated [default: suns from all sides]"""

    replace: bool
    """Replace results in the folder that are of another scene, points or accuracy; without this option they are an error."""

    time_zone: str | float | None
    """Time zone of the weather file's clock, in place of that of the file: hours ahead of UTC, such as +01:00, -7 or UTC, or a name, such as Europe/Amsterdam, with its summer time. If its time stamps state an offset, the zone of days and labels in results."""

    shift: str | float | None
    """Shift of the weather file's time stamps, such as 41min, -30min or 0.5h; `auto` chooses the shift under which GHI, DNI and DHI agree best, if they agree clearly better."""

    weather_stamp: Literal["start", "middle", "end"] | None
    """Position of the weather file's time stamps in their intervals; middle for values at one moment [default: as the format, the names of columns or hours 1 to 24 imply; start for plain CSV]"""

    date_order: Literal["dmy", "mdy", "ymd"] | None
    """Order of day and month in the weather file's dates of three numbers, such as 01/06/2021 [default: what the whole column shows]"""

    memory: int | str | None
    """Memory to work in, such as 512MiB or 2GiB. Default: `4GiB`."""

    progress: Progress | None
    """Called now and then with the stage, the number of items done, and the number of all."""


class CoverOptions(TypedDict, total=False):
    """Options of `Scene.cover`."""

    on: str | Sequence[str] | None
    """Surfaces to cover: roof, wall, window, ground, floor (surfaces that face down), shade, all, or names of materials; several with commas [default: roofs, walls and windows; of a building energy model also outdoor floors, and only surfaces that the sun can reach]"""

    types: str | Sequence[str] | None
    """Types of city objects to cover, such as Bridge,GenericCityObject, or all [default: buildings; all types for `on` ground and names of materials]"""

    spacing: str | float | None
    """Distance between receivers, such as 2m or 50cm. Default: `2m`."""

    per_surface: int | None
    """Number of receivers on each surface, in place of `spacing`."""

    offset: str | float | None
    """Distance of receivers from their surfaces. Default: `20mm`."""

    min_area: float | None
    """Least area of a surface that gets receivers, m2. Default: `0.1`."""

    buried: Place | None
    """Table to write of receivers that are left out because they are buried in an object or the terrain, with the same columns and `reason`."""

    along: Place | None
    """Put receivers along lines, such as roads, in place of surfaces, `spacing` apart and facing the direction of travel: a CSV file of the corners of the lines with columns x and y, and optionally z and line (a name)."""

    eye_height: str | float | None
    """Height of the receivers, the eyes of drivers, above the z of `along`, or above the ground of the scene where `along` states no z. Default: `1.2m`."""

    both_ways: bool
    """Add receivers of `along` that face backwards, for travel in both directions."""

    within: str | os.PathLike[str] | float | None
    """Put level receivers on the ground within areas, such as gardens and squares, in place of surfaces, `spacing` apart and `offset` above the ground: polygons (.geojson, .gpkg, .shp, .parquet), a CSV file of the corners of areas with columns x and y, and optionally area (a name), or a box xmin,ymin,xmax,ymax."""

    progress: Progress | None
    """Called now and then with the stage, the number of items done, and the number of all."""


class BuildOptions(TypedDict, total=False):
    """Options of `build`."""

    checkpoint: int | None
    """Seconds between checkpoints: a crash loses no more work than this. Default: `30`."""

    fresh: bool
    """Discard an interrupted build at the output path and start again. Without this option a build of the same inputs is resumed, and a build of other inputs is an error."""

    share: Literal["cells", "none"] | None
    """Sharing of probes (traced samples of what the surroundings see) between receivers. Default: `cells`."""

    effects: str | None
    """Light paths to trace besides direct sun and sky: `auto` (those that can matter in the scene), `all`, `none`, or some of diffuse, bounces, mirrors, canopies, leaves. Default: `auto`."""

    negligible: str | float | None
    """Leave out light paths that add no more than this share of the sum over `weather`, in any group of receivers, such as 0.5%."""

    weather: Any | None
    """Weather file of `negligible`: light paths are left out by what they add under it; with `dry_run`, what each of them adds is printed."""

    before: Place | None
    """Archive of this scene before a change, or with `part` an atlas of it; a path or an address. Only light that the change can alter is traced; the new archive has the same bytes as without this option."""

    with_scene: bool
    """False: Leave the scene's triangles out of the archive, if they may not be passed on."""

    quality: Literal["draft", "standard", "fine", "reference"] | None
    """Accuracy level: a named set of settings, from fast to accurate. Default: `standard`."""

    settings: Mapping[str, object] | None
    """Change one setting of the accuracy level, such as hit=16 or sky_fine=512; `info` of an archive lists the settings; may be repeated."""

    error: str | float | None
    """Largest error to accept, the RMSE of hourly totals in percent of their mean, such as 2%: settings are tried on some of the receivers, and the cheapest that keep it are used."""

    error_weather: Any | None
    """Weather file under which the errors of `error` are estimated [default: suns from all sides]"""

    memory: int | str | None
    """Memory to work in, such as 512MiB or 2GiB; what does not fit goes to temporary files beside the archive. Default: `4GiB`."""

    time_zone: str | float | None
    """Time zone of the weather file's clock, in place of that of the file: hours ahead of UTC, such as +01:00, -7 or UTC, or a name, such as Europe/Amsterdam, with its summer time. If its time stamps state an offset, the zone of days and labels in results."""

    shift: str | float | None
    """Shift of the weather file's time stamps, such as 41min, -30min or 0.5h; `auto` chooses the shift under which GHI, DNI and DHI agree best, if they agree clearly better."""

    weather_stamp: Literal["start", "middle", "end"] | None
    """Position of the weather file's time stamps in their intervals; middle for values at one moment [default: as the format, the names of columns or hours 1 to 24 imply; start for plain CSV]"""

    date_order: Literal["dmy", "mdy", "ymd"] | None
    """Order of day and month in the weather file's dates of three numbers, such as 01/06/2021 [default: what the whole column shows]"""

    progress: Progress | None
    """Called now and then with the stage, the number of items done, and the number of all."""


class PlanOptions(TypedDict, total=False):
    """Options of `plan`."""

    share: Literal["cells", "none"] | None
    """Sharing of probes (traced samples of what the surroundings see) between receivers. Default: `cells`."""

    effects: str | None
    """Light paths to trace besides direct sun and sky: `auto` (those that can matter in the scene), `all`, `none`, or some of diffuse, bounces, mirrors, canopies, leaves. Default: `auto`."""

    negligible: str | float | None
    """Leave out light paths that add no more than this share of the sum over `weather`, in any group of receivers, such as 0.5%."""

    weather: Any | None
    """Weather file of `negligible`: light paths are left out by what they add under it; with `dry_run`, what each of them adds is printed."""

    quality: Literal["draft", "standard", "fine", "reference"] | None
    """Accuracy level: a named set of settings, from fast to accurate. Default: `standard`."""

    settings: Mapping[str, object] | None
    """Change one setting of the accuracy level, such as hit=16 or sky_fine=512; `info` of an archive lists the settings; may be repeated."""

    error: str | float | None
    """Largest error to accept, the RMSE of hourly totals in percent of their mean, such as 2%: settings are tried on some of the receivers, and the cheapest that keep it are used."""

    error_weather: Any | None
    """Weather file under which the errors of `error` are estimated [default: suns from all sides]"""

    memory: int | str | None
    """Memory to work in, such as 512MiB or 2GiB; what does not fit goes to temporary files beside the archive. Default: `4GiB`."""

    time_zone: str | float | None
    """Time zone of the weather file's clock, in place of that of the file: hours ahead of UTC, such as +01:00, -7 or UTC, or a name, such as Europe/Amsterdam, with its summer time. If its time stamps state an offset, the zone of days and labels in results."""

    shift: str | float | None
    """Shift of the weather file's time stamps, such as 41min, -30min or 0.5h; `auto` chooses the shift under which GHI, DNI and DHI agree best, if they agree clearly better."""

    weather_stamp: Literal["start", "middle", "end"] | None
    """Position of the weather file's time stamps in their intervals; middle for values at one moment [default: as the format, the names of columns or hours 1 to 24 imply; start for plain CSV]"""

    date_order: Literal["dmy", "mdy", "ymd"] | None
    """Order of day and month in the weather file's dates of three numbers, such as 01/06/2021 [default: what the whole column shows]"""

    progress: Progress | None
    """Called now and then with the stage, the number of items done, and the number of all."""


class RunOptions(TypedDict, total=False):
    """Options of `run`."""

    time_zone: str | float | None
    """Time zone of the weather file's clock, in place of that of the file: hours ahead of UTC, such as +01:00, -7 or UTC, or a name, such as Europe/Amsterdam, with its summer time. If its time stamps state an offset, the zone of days and labels in results."""

    shift: str | float | None
    """Shift of the weather file's time stamps, such as 41min, -30min or 0.5h; `auto` chooses the shift under which GHI, DNI and DHI agree best, if they agree clearly better."""

    weather_stamp: Literal["start", "middle", "end"] | None
    """Position of the weather file's time stamps in their intervals; middle for values at one moment [default: as the format, the names of columns or hours 1 to 24 imply; start for plain CSV]"""

    date_order: Literal["dmy", "mdy", "ymd"] | None
    """Order of day and month in the weather file's dates of three numbers, such as 01/06/2021 [default: what the whole column shows]"""

    on: str | Sequence[str] | None
    """Surfaces to cover: roof, wall, window, ground, floor (surfaces that face down), shade, all, or names of materials; several with commas [default: roofs, walls and windows; of a building energy model also outdoor floors, and only surfaces that the sun can reach]"""

    types: str | Sequence[str] | None
    """Types of city objects to cover, such as Bridge,GenericCityObject, or all [default: buildings; all types for `on` ground and names of materials]"""

    spacing: str | float | None
    """Distance between receivers, such as 2m or 50cm. Default: `2m`."""

    per_surface: int | None
    """Number of receivers on each surface, in place of `spacing`."""

    offset: str | float | None
    """Distance of receivers from their surfaces. Default: `20mm`."""

    min_area: float | None
    """Least area of a surface that gets receivers, m2. Default: `0.1`."""

    receivers: Any | None
    """Table of receivers in place of those that cover surfaces, CSV with columns receiver,x,y,z,nx,ny,nz and optionally area,surface."""

    quality: Literal["draft", "standard", "fine", "reference"] | None
    """Accuracy level: a named set of settings, from fast to accurate. Default: `standard`."""

    settings: Mapping[str, object] | None
    """Change one setting of the accuracy level, such as hit=16 or sky_fine=512; `info` of an archive lists the settings; may be repeated."""

    error: str | float | None
    """Largest error to accept, the RMSE of hourly totals in percent of their mean, such as 2%: settings are tried on some of the receivers, and the cheapest that keep it are used."""

    error_weather: Any | None
    """Weather file under which the errors of `error` are estimated [default: suns from all sides]"""

    negligible: str | float | None
    """Leave out light paths that add no more than this share of the sum over the weather file, in any group of receivers, such as 0.5%."""

    with_scene: bool
    """False: Leave the scene's triangles out of the archive, if they may not be passed on."""

    before: Place | None
    """Archive of this scene before a change, a path or an address: only light that the change can alter is traced, with the same results as without this option."""

    every: Literal["hour", "day", "month", "year", "total"] | Sequence[Literal["hour", "day", "month", "year", "total"]] | None
    """Also write a table by hour, day, month, year or total, as `replay` does: months.csv and so on; several with commas."""

    rules: str | Sequence[str] | None
    """Also check a rule of sunlight and write rules.csv: a name that `heliotile info --rule all` lists, or a file with rules of your own (.toml); may be repeated."""

    by: Literal["receiver", "surface", "window", "object", "building", "kind"] | None
    """Grouping of rows in the tables of `every` and `rules`: what each row stands for. Default: `receiver`."""

    stamp: Literal["start", "middle", "end"] | None
    """Time that labels a row of hours: the start, middle or end of its interval. Default: `start`."""

    year: int | None
    """Year of all dates in the tables of `every`, such as 2019, as for `replay`; annual sums stay as they are."""

    format: Literal["csv", "parquet", "arrow", "feather", "npy", "npz"] | None
    """Ending of the tables of `every` and `rules`, which chooses their format. Default: `csv`."""

    maps: Literal["glb", "fgb", "geojson", "geoparquet", "ply", "vtu", "cityjson"] | Sequence[Literal["glb", "fgb", "geojson", "geoparquet", "ply", "vtu", "cityjson"]] | None
    """Also write the annual sums as a map in this format, such as annual.glb beside annual.csv, or into the city model of the scene; may be repeated, or several with commas."""

    replace: bool
    """Replace results in the folder that are of another scene, spacing, accuracy or weather; without this option they are an error."""

    memory: int | str | None
    """Memory to work in, such as 512MiB or 2GiB. Default: `4GiB`."""

    progress: Progress | None
    """Called now and then with the stage, the number of items done, and the number of all."""


class PvOptions(TypedDict, total=False):
    """Options of `pv`."""

    time_zone: str | float | None
    """Time zone of the weather file's clock, in place of that of the file: hours ahead of UTC, such as +01:00, -7 or UTC, or a name, such as Europe/Amsterdam, with its summer time. If its time stamps state an offset, the zone of days and labels in results."""

    shift: str | float | None
    """Shift of the weather file's time stamps, such as 41min, -30min or 0.5h; `auto` chooses the shift under which GHI, DNI and DHI agree best, if they agree clearly better."""

    weather_stamp: Literal["start", "middle", "end"] | None
    """Position of the weather file's time stamps in their intervals; middle for values at one moment [default: as the format, the names of columns or hours 1 to 24 imply; start for plain CSV]"""

    date_order: Literal["dmy", "mdy", "ymd"] | None
    """Order of day and month in the weather file's dates of three numbers, such as 01/06/2021 [default: what the whole column shows]"""

    points: Place | None
    """Positions of modules, CSV with columns point,x,y, z or height (metres above the roof or ground below), and tilt_deg,azimuth_deg (from true north; may be left out with `search`)."""

    rows: Place | None
    """Rows of modules, TOML: each table `rows` has a name, an area, a surface or a number of rows and modules, tilt and azimuth, or `tracker = { hub = 1.5 }` of single-axis trackers, pitch, width, height; `cells = { across = 6, up = 10 }` adds what partial shade costs. Modules shade each other, reflect light to each other, and have a front and a rear. `ground = 0.5` adds receivers on the ground among the rows, 0.5 m apart, with the light that plants use. A `quality` is finer for rows than for points: the shade on the ground below them decides the light of their rears."""

    bifaciality: float | None
    """Bifaciality, the share of the light on the rear that is added to that on the front, for poa_global and the gain. Default: `0.8`."""

    kwp: float | None
    """Rated power of the array, kW at standard test conditions, in equal shares of all points or modules. A column `kwp` of points or a key `kwp` of rows states that of each instead. A column or key `string` adds sums of each string."""

    temperature_coefficient: str | float | None
    """Temperature coefficient of power, percent per K: -0.35 of today's silicon modules, -0.47 of those of 2014. Default: `-0.35`."""

    mounting: Literal["open", "roof"] | None
    """Mounting, which decides how much warmer than the air cells are. Default: `open`."""

    losses: str | float | None
    """System losses: dirt, mismatch, wiring, age. The 14 % of PVWatts contain 3 % for shade, which is traced here; without it they are 11.4 %. Default: `14%`."""

    inverter_efficiency: float | None
    """Nominal efficiency of the inverter. Default: `0.96`."""

    dc_ac_ratio: float | None
    """Ratio of the array's rated power to the inverter's. Default: `1.1`."""

    price: str | None
    """Price of a kWh, in any currency, such as 0.30EUR."""

    value: Place | None
    """Values by the hour, CSV: a row for each row of the weather file, or 12 rows, one a month. A column `X_per_kwh` (a price, carbon) gives the sum of X, a column `load_kw` the energy that the load takes at once. A column `time` is compared with the weather file."""

    search: bool
    """Find the best tilt and azimuth of every point: best.csv, search.csv and a picture of each; points without angles get the best ones."""

    tilts: str | Sequence[float] | None
    """Range of tilts for `search`, degrees, such as 10..60, or one tilt. Default: `0..90`."""

    azimuths: str | Sequence[float] | None
    """Range of azimuths for `search`, degrees clockwise from true north, such as 90..270, or 300..60 through north, or one azimuth. Default: `0..360`."""

    shade: bool
    """Write the shade of the whole array into the folder shade/: the share of the sun's beam that arrives, by azimuth and altitude, and the layouts of SAM, PVGIS, Forecast.Solar and Open-Meteo Solar Forecast."""

    sky: str | None
    """Sky radiance distribution: perez (all-weather, 1993), perez1990 (tilted surfaces, as in EnergyPlus and pvlib), uniform (the same radiance everywhere), or cie:1 to cie:16 (the traditional overcast sky). Default: `perez`."""

    format: Literal["csv", "parquet", "arrow", "feather", "npy", "npz"] | None
    """Ending of the table of hours, which chooses its format. Default: `csv`."""

    hourly: bool
    """False: Write no hourly table, sums only."""

    stamp: Literal["start", "middle", "end"] | None
    """Time that labels a row of hours: the start, middle or end of its interval. Default: `start`."""

    year: int | None
    """Year of all dates in results, such as 2019; sun positions stay those of the weather file's dates."""

    snow: Literal["depth", "albedo"] | None
    """Take the reflectance of all ground from the weather file: its snow depth (`snow_reflectance` from 1 cm on) or its albedo."""

    snow_reflectance: float | None
    """Diffuse reflectance of snow. Default: `0.6`."""

    quality: Literal["draft", "standard", "fine", "reference"] | None
    """Accuracy level: a named set of settings, from fast to accurate. Default: `standard`."""

    settings: Mapping[str, object] | None
    """Change one setting of the accuracy level, such as hit=16 or sky_fine=512; `info` of an archive lists the settings; may be repeated."""

    error: str | float | None
    """Largest error to accept, the RMSE of hourly totals in percent of their mean, such as 2%: settings are tried on some of the receivers, and the cheapest that keep it are used."""

    error_weather: Any | None
    """Weather file under which the errors of `error` are estimated [default: suns from all sides]"""

    replace: bool
    """Replace results in the folder that are of another scene, points, accuracy or weather; without this option they are an error."""

    memory: int | str | None
    """Memory to work in, such as 512MiB or 2GiB. Default: `4GiB`."""

    progress: Progress | None
    """Called now and then with the stage, the number of items done, and the number of all."""


class EnergyplusOptions(TypedDict, total=False):
    """Options of `energyplus`."""

    scene: Place | Sequence[Place] | None
    """Scene files of the surroundings: CityJSON, terrain, meshes, site.toml; in the coordinates of the model, unless `at` is given."""

    at: str | Sequence[float] | None
    """Position of the model's origin in the coordinates of `scene`, metres: east,north or east,north,up. The model is turned so that its true north is that of their coordinate system."""

    crs: str | float | None
    """Coordinate reference system of `scene`, in place of the one that its files state: EPSG:28992 or 28992."""

    delete_surroundings: bool
    """Remove the shading objects of the surroundings from the model. Their effect on direct and diffuse light becomes a time series for `weather`, and EnergyPlus computes no shadows of them."""

    weather: Any | None
    """Weather file for `run` and `delete_surroundings`."""

    physics: Literal["full", "energyplus"] | None
    """Reflected light that the model gets. Default: `full`."""

    run: bool
    """Run EnergyPlus three times (without reflections, with its own, with the injected light) and compare the results in the report."""

    energyplus: str | os.PathLike[str] | None
    """Folder of EnergyPlus 25.2 [default: that of `energyplus` on the search path]"""

    spacing: str | float | None
    """Distance between receivers on the model's surfaces, such as 1m or 50cm; with `delete_surroundings` the default is 50cm, as shadows depend on it. Default: `1m`."""

    materials: Place | None
    """File of reflectances (TOML), one table for each material name. They replace those of the scene files; materials without a table keep their own values, or get usual ones."""

    materials_only: bool
    """Ignore the materials of the scene files; `materials` has to describe all of them."""

    ground: bool
    """False: Add no ground to a scene that has none [default: add a plane below it; for an EnergyPlus model, as the model states]"""

    assume_version: str | None
    """Read EnergyPlus models as models of this version, whatever version they state; it decides what the fields of an IDF mean. With 25.2, `energyplus` accepts models of any version, for EnergyPlus 25.2 to run as they are."""

    height: str | float | Sequence[str | float] | None
    """Height of buildings above their base, for files of footprints: a column, or metres for all buildings, or several, of which the first with a value counts, as in HGT,9m [default: columns such as height and building:height, then storeys]"""

    storey_height: str | float | None
    """Height of a storey, for footprints that state storeys and no height [default: 3m]"""

    base: str | float | None
    """Base of buildings from footprints: a column, or metres [default: the lowest terrain below the outline, 0 without terrain]"""

    height_above: Literal["base", "sea"] | None
    """Level from which columns of heights count: the base, or the sea for absolute heights of roofs, from which the terrain below or `base` is taken [default: base]"""

    layer: str | Sequence[str] | None
    """Layer to read of a GeoPackage with several; may be given more than once [default: the layers of buildings by their names, else all]"""

    quality: Literal["draft", "standard", "fine", "reference"] | None
    """Accuracy level: a named set of settings, from fast to accurate. Default: `standard`."""

    settings: Mapping[str, object] | None
    """Change one setting of the accuracy level, such as hit=16 or sky_fine=512; `info` of an archive lists the settings; may be repeated."""

    error: str | float | None
    """Largest error to accept, the RMSE of hourly totals in percent of their mean, such as 2%: settings are tried on some of the receivers, and the cheapest that keep it are used."""

    error_weather: Any | None
    """Weather file under which the errors of `error` are estimated [default: suns from all sides]"""

    replace: bool
    """Replace results in the folder that are of another model, scene, spacing or accuracy; without this option they are an error."""

    memory: int | str | None
    """Memory to work in, such as 512MiB or 2GiB. Default: `4GiB`."""

    progress: Progress | None
    """Called now and then with the stage, the number of items done, and the number of all."""


class PartitionOptions(TypedDict, total=False):
    """Options of `partition`."""

    part_size: str | float | None
    """Side of a square part; its corners lie at multiples of this length in the scene's coordinates. Default: `500m`."""

    halo: str | float | None
    """Width of the zone around a part in which all objects count. Default: `300m`."""

    skyline: float | None
    """Angle above the horizon, degrees: objects beyond the halo count only if they rise higher than this, as seen from the part. Default: `5`."""

    on: str | Sequence[str] | None
    """Surfaces to cover: roof, wall, window, ground, floor (surfaces that face down), shade, all, or names of materials; several with commas [default: roofs, walls and windows; of a building energy model also outdoor floors, and only surfaces that the sun can reach]"""

    types: str | Sequence[str] | None
    """Types of city objects to cover, such as Bridge,GenericCityObject, or all [default: buildings; all types for `on` ground and names of materials]"""

    spacing: str | float | None
    """Distance between receivers, such as 2m or 50cm. Default: `2m`."""

    per_surface: int | None
    """Number of receivers on each surface, in place of `spacing`."""

    offset: str | float | None
    """Distance of receivers from their surfaces. Default: `20mm`."""

    min_area: float | None
    """Least area of a surface that gets receivers, m2. Default: `0.1`."""

    quality: Literal["draft", "standard", "fine", "reference"] | None
    """Accuracy level: a named set of settings, from fast to accurate. Default: `standard`."""

    settings: Mapping[str, object] | None
    """Change one setting of the accuracy level, such as hit=16 or sky_fine=512; `info` of an archive lists the settings; may be repeated."""

    with_scene: bool
    """False: Leave the scene's triangles out of the archives, if they may not be passed on."""

    replace: bool
    """Replace the plan of an atlas that has no built parts."""

    sample: int | None
    """Number of receivers that are also traced with three times the halo, to estimate the error due to the halo; 0 for no estimate. Default: `256`."""

    memory: int | str | None
    """Memory to work in, such as 512MiB or 2GiB. Default: `4GiB`."""

    progress: Progress | None
    """Called now and then with the stage, the number of items done, and the number of all."""


class TradeoffOptions(TypedDict, total=False):
    """Options of `tradeoff`."""

    sample: int | None
    """Number of receivers to try settings on, spread over the site. Default: `32`."""

    weather: Any | None
    """Weather file under which errors are estimated and replays are timed [default: suns from all sides]"""

    time_zone: str | float | None
    """Time zone of the weather file's clock, in place of that of the file: hours ahead of UTC, such as +01:00, -7 or UTC, or a name, such as Europe/Amsterdam, with its summer time. If its time stamps state an offset, the zone of days and labels in results."""

    shift: str | float | None
    """Shift of the weather file's time stamps, such as 41min, -30min or 0.5h; `auto` chooses the shift under which GHI, DNI and DHI agree best, if they agree clearly better."""

    weather_stamp: Literal["start", "middle", "end"] | None
    """Position of the weather file's time stamps in their intervals; middle for values at one moment [default: as the format, the names of columns or hours 1 to 24 imply; start for plain CSV]"""

    date_order: Literal["dmy", "mdy", "ymd"] | None
    """Order of day and month in the weather file's dates of three numbers, such as 01/06/2021 [default: what the whole column shows]"""

    sources: bool
    """Also try each setting alone, and write sources.csv and a picture (takes several times as long)."""

    effects: str | None
    """Light paths to trace besides direct sun and sky: `auto` (those that can matter in the scene), `all`, `none`, or some of diffuse, bounces, mirrors, canopies, leaves. Default: `auto`."""

    memory: int | str | None
    """Memory to work in, such as 512MiB or 2GiB. Default: `4GiB`."""

    progress: Progress | None
    """Called now and then with the stage, the number of items done, and the number of all."""


class RepairOptions(TypedDict, total=False):
    """Options of `repair`."""

    receivers: Any | None
    """Table of the receivers that the archive was built from; needed if the archive's own table is damaged."""

    memory: int | str | None
    """Memory to work in, such as 512MiB or 2GiB. Default: `4GiB`."""

    progress: Progress | None
    """Called now and then with the stage, the number of items done, and the number of all."""


class ReportOptions(TypedDict, total=False):
    """Options of `report`."""

    title: str | None
    """Title of the page [default: the question that the first table answers]"""

    rows: int | None
    """Most rows of each table that are shown; newly broken and broken rules come first, and the page states how many rows it leaves out. Default: `100`."""

    pictures: Place | Sequence[Place] | None
    """Picture to show, .svg or .png; may be repeated. A picture beside a table that has its name, such as a.svg beside a.csv, is shown without this option."""

    progress: Progress | None
    """Called now and then with the stage, the number of items done, and the number of all."""


class MergeOptions(TypedDict, total=False):
    """Options of `merge`."""

    memory: int | str | None
    """Memory to work in, such as 512MiB or 2GiB. Default: `4GiB`."""

    io: Literal["map", "pread"] | None
    """Way to read the archives. Default: `pread`."""

    progress: Progress | None
    """Called now and then with the stage, the number of items done, and the number of all."""


class DiffOptions(TypedDict, total=False):
    """Options of `diff`."""

    memory: int | str | None
    """Memory to work in, such as 512MiB or 2GiB. Default: `4GiB`."""

    io: Literal["map", "pread"] | None
    """Way to read the archives. Default: `pread`."""

    progress: Progress | None
    """Called now and then with the stage, the number of items done, and the number of all."""


class VerifyOptions(TypedDict, total=False):
    """Options of `verify`."""

    deep: bool
    """Also decode every layer and follow every reference between blocks."""

    io: Literal["map", "pread"] | None
    """Way to read the archive. Default: `pread`."""

    progress: Progress | None
    """Called now and then with the stage, the number of items done, and the number of all."""


class CatalogueOptions(TypedDict, total=False):
    """Options of `Atlas.catalogue`."""

    title: str | None
    """Title of the catalogue [default: the folder's name]"""

    license: str | None
    """Licence of the data of the atlas, an SPDX name such as CC-BY-4.0. Default: `other`."""

    progress: Progress | None
    """Called now and then with the stage, the number of items done, and the number of all."""


class ViewOptions(TypedDict, total=False):
    """Options of `Archive.view`."""

    with_: Place | None
    """Archive of the same site after a change: the page shows before, after and the change, under one sun, weather and camera."""

    weather: Any | None
    """Weather file whose hours and sums are shown: EPW, TMY3, SAM, PVGIS or CSV, packed with gzip or not."""

    time_zone: str | float | None
    """Time zone of the weather file's clock, in place of that of the file: hours ahead of UTC, such as +01:00, -7 or UTC, or a name, such as Europe/Amsterdam, with its summer time. If its time stamps state an offset, the zone of days and labels in results."""

    shift: str | float | None
    """Shift of the weather file's time stamps, such as 41min, -30min or 0.5h; `auto` chooses the shift under which GHI, DNI and DHI agree best, if they agree clearly better."""

    weather_stamp: Literal["start", "middle", "end"] | None
    """Position of the weather file's time stamps in their intervals; middle for values at one moment [default: as the format, the names of columns or hours 1 to 24 imply; start for plain CSV]"""

    date_order: Literal["dmy", "mdy", "ymd"] | None
    """Order of day and month in the weather file's dates of three numbers, such as 01/06/2021 [default: what the whole column shows]"""

    progress: Progress | None
    """Called now and then with the stage, the number of items done, and the number of all."""
