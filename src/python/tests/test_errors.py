"""Bad input: an exception of the right class, with the program's text."""

from __future__ import annotations

import datetime
import pickle
import subprocess
from pathlib import Path

import heliotile
import numpy as np
import pandas as pd
import pytest
import xarray as xr
from conftest import DATA, DAYS, PROGRAM

SUN = {"sun_azimuth_deg": [180.0], "sun_altitude_deg": [40.0], "dni_w_m2": [800.0], "dhi_w_m2": [100.0]}


def test_missing_files_are_file_not_found(site: heliotile.Archive, tmp_path: Path) -> None:
    """3 files that are not there: FileNotFoundError and heliotile.Error, the text of the program, the file as an attribute."""
    for ask in [
        lambda: heliotile.Archive.open(tmp_path / "no.helio"),
        lambda: site.replay(tmp_path / "no.epw"),
        lambda: heliotile.Scene(tmp_path / "no.obj"),
    ]:
        with pytest.raises(FileNotFoundError, match="No such file") as found:
            ask()
        assert isinstance(found.value, heliotile.MissingFileError) and found.value.file.parent == tmp_path
    done = subprocess.run([PROGRAM, "replay", site.path, "--weather", tmp_path / "no.epw"], capture_output=True, text=True)
    with pytest.raises(heliotile.Error) as found:
        site.replay(tmp_path / "no.epw")
    assert done.returncode == 2 and str(found.value) in done.stderr


def test_a_file_that_is_no_archive_is_refused(tmp_path: Path) -> None:
    """A file that is no archive is refused by name; a changed byte of one is a CorruptError that names the block."""
    (tmp_path / "text.helio").write_text("not an archive, but long enough to be looked at" * 100)
    with pytest.raises(heliotile.Error, match=r"text\.helio"):
        heliotile.Archive.open(tmp_path / "text.helio")


def test_a_changed_byte_is_found(site: heliotile.Archive, tmp_path: Path) -> None:
    """One changed byte at 60 places: wherever a year's sums come from it, a CorruptError with the block and its offset; else the same sums."""
    whole, expected, damaged = Path(site.path).read_bytes(), site.replay(DAYS, every="total")["total"], 0
    for at in range(4096, len(whole), len(whole) // 60):
        broken = bytearray(whole)
        broken[at] ^= 0x40
        (tmp_path / "broken.helio").write_bytes(broken)
        try:
            assert (heliotile.Archive.open(tmp_path / "broken.helio").replay(DAYS, every="total")["total"] == expected).all()
        except heliotile.CorruptError as error:
            damaged += 1
            assert error.block and error.offset is not None and error.offset <= at and "is damaged" in str(error)
    assert damaged >= 3


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"dni_w_m2": [np.nan]}, "conditions, line 2: column `dni_w_m2` holds `nan`"),
        ({"sun_altitude_deg": [91.0]}, "column `sun_altitude_deg` holds `91.0`"),
        ({"dhi_w_m2": [1.0, 2.0]}, "columns have different numbers of rows"),
        ({"dhi_w_m2": [[1.0, 2.0]]}, r"column `dhi_w_m2` has the shape \(1, 2\)"),
        ({"dhi_w_m2": None}, "column `dhi_w_m2` has the shape"),
    ],
)
def test_wrong_conditions_name_their_column(site: heliotile.Archive, change: dict, text: str) -> None:
    """5 wrong tables of conditions, each with the column that is wrong."""
    with pytest.raises(heliotile.InputError, match=text) as found:
        site.query({**SUN, **change})
    assert "to fix" in str(found.value) and isinstance(found.value, ValueError)


def test_missing_columns_are_named(site: heliotile.Archive) -> None:
    """A column that is missing is named, with those that are needed."""
    with pytest.raises(heliotile.InputError, match="column `dni_w_m2` is missing from the header") as found:
        site.query({name: values for name, values in SUN.items() if name != "dni_w_m2"})
    assert (found.value.problem, found.value.column) == ("no-column", "dni_w_m2")
    with pytest.raises(heliotile.InputError, match="give a path, a DataFrame or a mapping"):
        site.query([1, 2, 3])


def frame(**columns: object) -> pd.DataFrame:
    return pd.DataFrame(columns, index=pd.date_range("2021-06-20", periods=24, freq="h"))


def test_wrong_weather_is_refused(site: heliotile.Archive) -> None:
    """Times without a zone, no place, unknown columns, an infinite value, a wrong zone are refused; NaN is a missing value, as in files, and warned of by its line."""
    good = frame(dni=500.0, dhi=100.0)
    with pytest.raises(heliotile.InputError, match="its index has no time zone\n  to fix: .*tz_localize"):
        site.replay(good)
    with pytest.raises(heliotile.InputError, match="does not state its latitude and longitude"):
        site.replay(good.tz_localize("UTC"))
    place = dict(latitude=52.0, longitude=4.0, time_zone="+01:00")
    assert site.replay(heliotile.Weather(good, **place)).shape == (78, 24)
    with pytest.raises(heliotile.InputError, match="weather"):
        site.replay(heliotile.Weather(frame(sun=500.0, sky=100.0), **place))
    holes = good.copy()
    holes.iloc[12, 0] = np.nan
    with pytest.warns(heliotile.HeliotileWarning, match="line 14 and on: DNI or DHI of 1 hours is missing"):
        site.replay(heliotile.Weather(holes, **place))
    holes.iloc[12, 0] = np.inf
    with pytest.raises(heliotile.InputError, match="column `dni` holds `inf`"):
        site.replay(heliotile.Weather(holes, **place))
    with pytest.raises(heliotile.InputError, match="has no times"):
        site.replay({"dni": [1.0], "dhi": [1.0]})
    with pytest.raises(heliotile.ArgumentError, match="time_zone: .*\n  to fix: give hours ahead of UTC"):
        site.replay(heliotile.Weather(good, latitude=52, longitude=4, time_zone="Mars"))


@pytest.mark.parametrize(
    ("choice", "text"),
    [
        ({"every": "week"}, "every: `week` is not a known value\n  to fix: give one of hour, day, month, year, total"),
        ({"columns": ["sun"]}, "columns: .*`?sun`?"),
        ({"bands": ["visible", "red"]}, "bands: `red` is not a known band\n  to fix: give some of uv, visible, par, nir"),
        ({"bands": "own.toml"}, "No such file"),
        ({"sky": "blue"}, "sky: "),
        ({"sky": Path("no.mtx")}, "No such file"),
        ({"sky_scale": "half"}, "sky_scale: `half` is not a known value\n  to fix: give one of dhi, given"),
        ({"sky_scale": "dhi"}, "sky_scale: the sky is a model, not a file\n  to fix: give a file with sky"),
        ({"sky": "sky.hdr", "sky_white": 0.0}, "sky_white: cannot be used\n  to fix: give a number above 0"),
        ({"image_top": 45.0}, "image_top: no photograph"),
        ({"sky": "perez1990", "clouds": DATA / "skies" / "m1.mtx"}, "sky: `perez1990` adds light at the sun"),
        ({"paths": "roads"}, "paths: "),
        ({"bounces": 0}, "bounces: .*\n  to fix: give `all` or a number of reflections from 1 to 64"),
        ({"patches": 100}, "100"),
        ({"steps": 0}, "steps: 0 is not in 1..=60"),
        ({"start": "yesterday"}, "start: .*\n  to fix: give a day that exists"),
        ({"reflectance": {"ground": 1.5}}, "reflectance: a reflectance is from 0 to 1, not 1.5"),
        ({"reflectance": {"ground": [0.2, 0.3]}}, 'reflectance\\["ground"\\]'),
        ({"reflectance": {"roses": 0.5}}, "there is no group and no material `roses`"),
        ({"transmittance": {"wall": 0.5}}, "is not a canopy"),
        ({"snow": "deep"}, "snow: `deep` is not a known value"),
        ({"temperature": {"ground": 10.0}}, "no column depends on temperatures"),
        ({"receivers": ["nobody"]}, "does not hold 1 receiver: nobody"),
        ({"receivers": []}, "the list is empty"),
        ({"receivers": Path("no.csv")}, "No such file"),
    ],
)
def test_wrong_choices_are_refused_by_name(site: heliotile.Archive, choice: dict, text: str) -> None:
    """25 wrong choices, each refused with its name and what to give."""
    with pytest.raises(heliotile.Error, match=text):
        site.replay(DAYS, **choice)


@pytest.mark.parametrize(
    ("choice", "text"),
    [
        ({"reflectance": 0.3}, "reflectance: `0.3` is not a mapping"),
        ({"reflectance": {"ground": None}}, "reflectance\\['ground'\\]: is None"),
        ({"reflectance": {"ground": object()}}, "is not a number"),
        ({"bounces": -1}, "bounces: "),
        ({"year": "soon"}, "year: soon is not in 1..=2999"),
        ({"start": 5}, "start: `5` is not a day"),
        ({"start": pd.Timestamp("2019-03-21", tz="UTC")}, "start: .* has a time zone"),
        ({"receivers": {"bbox": None}}, "receivers: `bbox` is `None`"),
        ({"receivers": [["a", "b"]]}, "receivers: has the shape"),
        ({"sky": 5}, "sky: "),
        ({"memory": "1"}, "memory: there is no unit\n  to fix: give a number and MiB"),
        ({"receivers": np.array([True, False])}, "receivers: is a mask"),
        ({"receivers": pd.DataFrame({"id": ["a"]})}, "receivers: has no column `receiver`, but id"),
    ],
)
def test_wrong_types_are_refused_by_name(site: heliotile.Archive, choice: dict, text: str) -> None:
    """13 choices of the wrong type, each an error of heliotile with its name and what to give."""
    with pytest.raises(heliotile.Error, match=text) as found:
        site.replay(DAYS, **choice)
    assert "to fix: " in str(found.value)


def test_dates_and_numpy_numbers_are_accepted(site: heliotile.Archive, scene: heliotile.Scene, tmp_path: Path) -> None:
    """Dates, text and NumPy's numbers are taken where they mean something: 13 ways, the same values; results say what columns they have."""
    usual = site.replay(DAYS, year=2019, start="2019-03-21", bounces=2)
    first = str(site.receivers()["receiver"][0])
    for choice in (
        {"year": "2019"},
        {"year": np.int64(2019)},
        {"year": 2019.0, "start": datetime.date(2019, 3, 21)},
        {"start": pd.Timestamp("2019-03-21")},
        {"start": np.datetime64("2019-03-21")},
        {"bounces": np.int32(2)},
    ):
        again = site.replay(DAYS, **({"year": 2019, "start": "2019-03-21", "bounces": 2} | choice))
        np.testing.assert_array_equal(again["total"], usual["total"])
    for one in (first, np.array([first]), xr.DataArray([first]), pd.DataFrame({"receiver": [first]}), {first}, {first: 1}.keys(), iter([first])):
        assert site.query(SUN, receivers=one).receivers == [first]
    assert "total" in usual and list(usual) == usual.columns == list(dict(usual)) and "sun" not in usual
    with pytest.raises(TypeError, match="do not pickle: send to_pandas"):
        pickle.dumps(usual)
    assert heliotile.Scene(DATA / "hague" / "scene.obj", crs="EPSG:28992").place == heliotile.Scene(DATA / "hague" / "scene.obj", crs=28992).place
    # A table of receivers goes back as it came, areas that nobody knows among them.
    table = pd.DataFrame(site.receivers()).drop(columns=["sky_view", "ground_view", "obstruction_view"]).head(3)
    table.loc[table.index[0], "area_m2"] = np.nan
    built = heliotile.build(DATA / "hague" / "scene.obj", table, tmp_path / "three.helio", quality="draft")
    assert np.isnan(built.receivers()["area_m2"]).sum() == 1 and built.count == 3


def test_outputs_replace_no_other_kind_of_file(scene: heliotile.Scene, site: heliotile.Archive, tmp_path: Path) -> None:
    """A table does not replace an archive, and an archive is not called a table or written to an address: 4 refusals, and the archive stays."""
    mine = tmp_path / "site.helio"
    mine.write_bytes(Path(site.path).read_bytes())
    receivers = DATA / "hague" / "receivers.csv"
    for output in (mine, tmp_path / "r.parquet"):
        with pytest.raises(heliotile.InputError, match="does not end with .csv"):
            scene.cover(output)
    with pytest.raises(heliotile.InputError, match="does not end with .helio"):
        heliotile.build(scene, receivers, tmp_path / "site.csv")
    with pytest.raises(heliotile.InputError, match="only `archive copy` writes"):
        heliotile.build(scene, receivers, "s3://bucket/site.helio")
    assert mine.read_bytes() == Path(site.path).read_bytes() and list(tmp_path.iterdir()) == [mine]


def test_queries_have_no_longwave(site: heliotile.Archive) -> None:
    """What conditions say nothing of is refused; in a replay it is a column, 200 to 500 W/m2."""
    with pytest.raises(heliotile.UnsupportedError, match="longwave"):
        site.query(SUN, columns=["longwave"])
    values = site.replay(DAYS, columns=["longwave"], temperature={"ground": 10.0})["longwave"]
    assert 100 < values.min() < values.max() < 600


def test_wrong_builds_leave_nothing_behind(scene: heliotile.Scene, site: heliotile.Archive, tmp_path: Path) -> None:
    """6 wrong builds; nothing is left behind, and a file that is no archive stays as it was."""
    receivers = DATA / "hague" / "receivers.csv"
    out = tmp_path / "site.helio"
    for change, text in [
        ({"quality": "best"}, "quality: `best` is not a known value"),
        ({"error": 99}, "error: `99` is not a possible largest error"),
        ({"settings": {"hit": 3}}, "hit"),
        ({"effects": "magic"}, "effects: "),
        ({"checkpoint": -1}, "checkpoint: "),
    ]:
        with pytest.raises(heliotile.Error, match=text):
            heliotile.build(scene, receivers, out, **change)
    wrong = {name: values[:2] for name, values in site.receivers().items() if name in ("receiver", "x", "y", "z", "nx", "ny", "nz")}
    with pytest.raises(heliotile.InputError, match="line 3.*`x`"):
        heliotile.build(scene, {**wrong, "x": np.array([1.0, np.nan])}, out)
    assert list(tmp_path.iterdir()) == []
    out.write_text("mine")
    with pytest.raises(heliotile.InputError, match="exists and is not an archive"):
        heliotile.build(scene, receivers, out)
    assert out.read_text() == "mine"


def test_wrong_places_of_scenes_are_refused() -> None:
    """One coordinate without the other, and a system in degrees, are refused."""
    scene = DATA / "hague" / "scene.obj"
    with pytest.raises(heliotile.ArgumentError, match="latitude: belongs to longitude, which is not given"):
        heliotile.Scene(scene, latitude=52)
    with pytest.raises(heliotile.ArgumentError, match="degrees"):
        heliotile.Scene(scene, crs=4326)


def test_unknown_columns_and_receivers_are_refused(site: heliotile.Archive) -> None:
    """Without weather there is nothing to replay; an unknown column, receiver and row are KeyErrors and IndexErrors that say what there is."""
    with pytest.raises(TypeError, match="give weather"):
        xr.open_dataset(site.path, engine="heliotile")
    results = site.replay(DAYS, columns=["total"], every="day")
    with pytest.raises(KeyError, match="no column `sun`; the columns are total"):
        results["sun"]
    with pytest.raises(heliotile.ArgumentError, match="pvlib needs the hours"):
        results.to_pvlib(0)
    hours = site.replay(DAYS, columns=["total"])
    with pytest.raises(heliotile.ArgumentError, match="`sun_direct` is missing"):
        hours.to_pvlib(0)
    with pytest.raises(KeyError, match="no receiver `nobody`"):
        hours.to_pvlib("nobody")


def test_unknown_selections_are_refused(site: heliotile.Archive) -> None:
    """6 ways to name receivers that are none: each an error with what to do."""
    for receivers, text in [
        (["nobody"], "does not hold 1 receiver: nobody"),
        ([], "the list is empty"),
        ({"objects": ["nobody"]}, "holds no receivers of 1 object: nobody"),
        ({"bbox": (0.0, 0.0, 1.0)}, "3 numbers, not 4 or 6"),
        ({"bbox": (0.0, 0.0, 1.0, 1.0)}, "holds none of the receivers"),
        ({"zone": ["a"]}, "is not a selection of receivers"),
    ]:
        with pytest.raises(heliotile.Error, match=text) as found:
            site.query(SUN, receivers=receivers)
        assert "to fix" in str(found.value)
