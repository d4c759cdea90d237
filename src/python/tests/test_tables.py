"""Tables: weather from DataFrames, results for pandas, Polars, DuckDB and Arrow."""

from __future__ import annotations

from datetime import timedelta
from decimal import Decimal
from pathlib import Path

import heliotile
import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pytest
from conftest import DAYS, program


@pytest.fixture(scope="module")
def frame() -> pd.DataFrame:
    """Two days of hours at +01:00, with a sun that goes up and down."""
    index = pd.date_range("2021-06-20", periods=48, freq="h", tz="Etc/GMT-1")
    up = np.clip(np.sin((index.hour - 5) / 16 * np.pi), 0, None)
    return pd.DataFrame({"ghi": 750 * up, "dni": 700 * up, "dhi": 750 * up - 700 * up * up * 0.87 + 30 * (up > 0)}, index=index)


PLACE = dict(latitude=52.08, longitude=4.3)


def test_a_frame_is_read_like_its_csv_file(site: heliotile.Archive, frame: pd.DataFrame, tmp_path: Path) -> None:
    """A DataFrame gives the values of its CSV file in the program, to the bit."""
    written = frame.copy()
    written.insert(0, "time", [stamp.isoformat() for stamp in frame.index])
    written.to_csv(tmp_path / "weather.csv", index=False)
    program("replay", site.path, "--weather", tmp_path / "weather.csv", "--latitude", 52.08, "--longitude", 4.3, "-o", tmp_path / "out.npy")
    results = site.replay(heliotile.Weather(frame, **PLACE))
    found = np.stack([results[column] for column in results.columns], axis=2)
    assert found.tobytes() == np.load(tmp_path / "out.npy").tobytes() and results["total"].max() > 100
    assert results.time_utc is not None and (results.time_utc == frame.index.tz_convert("UTC").tz_localize(None).to_numpy().astype("datetime64[s]")).all()
    mapping = {"time": written["time"].to_numpy(), **{name: frame[name].to_numpy() for name in frame}}
    assert (site.replay(heliotile.Weather(mapping, **PLACE))["total"] == results["total"]).all()


def test_types_of_columns_do_not_matter(site: heliotile.Archive) -> None:
    """Numbers as objects, text and Decimal, with None and NA for what is missing, are those of floats, to the bit; so are tables of Polars and Arrow
    with a zone, in UTC or in the zone's own clock, and pvlib's pair of table and metadata. A cell that is no number is an error of its line."""
    index = pd.date_range("2021-06-20", periods=48, freq="h", tz="Europe/Amsterdam")
    frame = pd.DataFrame({"dni": np.linspace(0, 700, 48), "dhi": 100.0, "temp_air": 15.0}, index=index)
    expected = site.replay(heliotile.Weather(frame, **PLACE))
    objects = frame.assign(dni=frame.dni.astype(object), dhi=frame.dhi.map(lambda value: Decimal(repr(value))), temp_air=[None, pd.NA] * 24)
    texts = frame.assign(dni=frame.dni.map(repr), dhi=frame.dhi.map(repr).astype("string"))
    timed = frame.reset_index(names="time")
    for table in (
        objects,
        texts,
        timed,
        pl.from_pandas(timed),
        pl.from_pandas(timed).with_columns(pl.col("time").dt.convert_time_zone("UTC")),
        pa.Table.from_pandas(timed),
    ):
        results = site.replay(heliotile.Weather(table, **PLACE))
        assert (results.time_utc == expected.time_utc).all() and (results["total"] == expected["total"]).all(), type(table)
    assert (site.replay((frame, {"latitude": 52.08, "longitude": 4.3, "TZ": 1}))["total"] == expected["total"]).all()
    # A clock on a wall, by the name of its zone; of Arrow with a fixed offset; nanoseconds without a zone; moments as objects.
    wall = frame.tz_localize(None)
    fixed = pa.table({"time": pa.array(frame.index.tz_convert("UTC").tz_localize(None)).cast(pa.timestamp("us", "+02:00")), "dni": frame.dni, "dhi": frame.dhi, "temp_air": frame.temp_air})
    plain = {"time": frame.index.tz_convert("Etc/GMT-1").tz_localize(None).to_numpy().astype("datetime64[ns]"), **{name: frame[name].to_numpy() for name in frame}}
    moments = timed.assign(time=np.array([stamp.to_pydatetime() for stamp in frame.index], dtype=object))
    for weather in (
        heliotile.Weather(wall, time_zone="Europe/Amsterdam", **PLACE),
        heliotile.Weather(fixed, **PLACE),
        heliotile.Weather(plain, time_zone="+01:00", **PLACE),
        heliotile.Weather(moments, **PLACE),
    ):
        results = site.replay(weather)
        assert (results.time_utc == expected.time_utc).all() and (results["total"] == expected["total"]).all()
    noted = frame.assign(note="a\rb")
    assert (site.replay(heliotile.Weather(noted, **PLACE))["total"] == expected["total"]).all()
    istanbul = pd.DataFrame({"dni": 500.0, "dhi": 80.0}, index=pd.date_range("2019-06-20", periods=24, freq="h"))
    assert site.replay(heliotile.Weather(istanbul, time_zone="Europe/Istanbul", **PLACE)).utc_offset == timedelta(hours=3)
    with pytest.raises(heliotile.InputError, match="the clock of `Europe/Amsterdam` shows an hour of the index twice"):
        autumn = pd.DataFrame({"dni": 1.0, "dhi": 1.0}, index=pd.date_range("2021-10-31", periods=24, freq="h"))
        heliotile.Weather(autumn, time_zone="Europe/Amsterdam", **PLACE)
    with pytest.raises(heliotile.InputError, match="weather, line 5: column `dni` holds `many`"):
        site.replay(heliotile.Weather(frame.assign(dni=["many" if row == 3 else 500.0 for row in range(48)]), **PLACE))
    conditions = pa.table({"sun_azimuth_deg": [180.0], "sun_altitude_deg": [40.0], "dni_w_m2": [800.0], "dhi_w_m2": [90.0]})
    assert (site.query(conditions)["total"] == site.query(conditions.to_pandas())["total"]).all()


def test_summer_time_becomes_standard_time(site: heliotile.Archive) -> None:
    """A zone with summer time is told in standard time: one offset, +01:00, over the change of 28 March 2021, and in June alone. Two days of its clock are two days."""
    june = pd.DataFrame({"dni": 500.0, "dhi": 80.0}, index=pd.date_range("2021-06-20", periods=24, freq="h", tz="Europe/Amsterdam"))
    assert site.replay(heliotile.Weather(june, **PLACE)).utc_offset == timedelta(hours=1)
    two_days = pd.DataFrame({"dni": 500.0, "dhi": 80.0}, index=pd.date_range("2021-06-01", periods=48, freq="h", tz="Europe/Amsterdam"))
    assert site.replay(heliotile.Weather(two_days, **PLACE), every="day").shape[1] == 2
    index = pd.date_range("2021-03-27", periods=72, freq="h", tz="Europe/Amsterdam")
    frame = pd.DataFrame({"dni": 500.0, "dhi": 80.0}, index=index)
    results = site.replay(heliotile.Weather(frame, **PLACE))
    assert results.utc_offset is not None and results.utc_offset.total_seconds() == 3600
    assert results.shape[1] == 72 and (np.diff(results.time_utc) == np.timedelta64(3600, "s")).all()


def test_pandas_has_a_row_for_each_hour(site: heliotile.Archive) -> None:
    """A row for each of 78 receivers and 72 hours, named as in files, with times in their zone; sums have words for typical years."""
    hours = site.replay(DAYS, columns=["total"])
    table = hours.to_pandas()
    assert list(table.columns) == ["time", "receiver", "total"] and len(table) == 78 * 72
    assert (table["total"].to_numpy().reshape(78, 72) == hours["total"]).all()
    assert str(table["time"].iloc[0].tz) == "UTC-07:00" and table["receiver"].dtype == "category"
    sums = site.replay(DAYS, every="total").to_pandas()
    assert list(sums.columns)[-1] == "total_kwh_m2" and sums["time"].unique().tolist() == ["total"]


def test_four_readers_share_arrow_memory(site: heliotile.Archive) -> None:
    """pyarrow, Polars, DuckDB and pandas read the capsule: one sum of 78 x 72 values, and Arrow's memory is NumPy's."""
    import duckdb
    import polars as pl
    import pyarrow as pa

    hours = site.replay(DAYS)
    total = float(hours["total"].sum(dtype=np.float64))
    table = pa.table(hours)
    address = table["total"].chunk(0).buffers()[1].address
    assert address == hours["total"].__array_interface__["data"][0]
    assert np.shares_memory(table["total"].chunk(0).to_numpy(), hours["total"])
    assert pl.DataFrame(hours)["total"].cast(pl.Float64).sum() == pytest.approx(total, rel=1e-12)
    assert duckdb.sql("select sum(total::double), count(*) from hours").fetchall() == [(pytest.approx(total, rel=1e-12), 78 * 72)]
    assert pd.DataFrame.from_arrow(hours)["total"].astype(float).sum() == pytest.approx(total, rel=1e-12)


def test_arrays_are_views(site: heliotile.Archive) -> None:
    """A column outlives its results, is the same memory each time, and cannot be written to."""
    hours = site.replay(DAYS, columns=["total"])
    first, again = hours["total"], hours["total"]
    assert np.shares_memory(first, again) and not first.flags.writeable
    expected = first.copy()
    del hours, again
    np.zeros(10_000_000)
    assert (first == expected).all()
    with pytest.raises(ValueError, match="read-only"):
        first[0, 0] = 1


def test_thirteen_layouts_of_a_table(site: heliotile.Archive, frame: pd.DataFrame) -> None:
    """The same two days in 13 layouts of pandas, Polars, Arrow, xarray and mappings, with units in names and attributes, ends in an index or a
    column, pairs, clocks with a zone and without, give the sums of the plain frame to 0.01 %."""
    import xarray as xr

    expected = site.replay(heliotile.Weather(frame, **PLACE), every="total")["total"]
    utc, hour = frame.index.tz_convert("UTC"), pd.Timedelta("1h")
    light = {name: frame[name].to_numpy() for name in frame}
    kilowatts = pd.DataFrame({f"{name} (kW/m2)": frame[name] / 1000 for name in frame})
    stamps = [stamp.isoformat() for stamp in utc]
    dataset = xr.Dataset({name: ("time", values / 1000, {"units": "kW m-2"}) for name, values in light.items()}, coords={"time": utc.tz_localize(None).to_numpy()})
    american = frame.index.strftime("%m/%d/%Y %I:%M %p").to_numpy()
    layouts: dict[str, heliotile.Weather] = {
        "kW/m2": heliotile.Weather(kilowatts, **PLACE),
        "J/cm2": heliotile.Weather(pd.DataFrame({f"{name}_j_cm2": frame[name] * 0.36 for name in frame}), **PLACE),
        "index period_end": heliotile.Weather(frame.set_axis((frame.index + hour).rename("period_end")), **PLACE),
        "index Period End without a zone": heliotile.Weather(frame.set_axis((frame.index + hour).tz_localize(None).rename("Period End")), time_zone="+01:00", **PLACE),
        "column period_end": heliotile.Weather(frame.reset_index(drop=True).assign(period_end=utc + hour, period="PT60M"), **PLACE),
        "PeriodStart and PeriodEnd": heliotile.Weather(frame.reset_index(drop=True).assign(PeriodEnd=utc + hour, PeriodStart=utc), **PLACE),
        "mapping of text": heliotile.Weather({"period_end": [(stamp + hour).isoformat() for stamp in utc], **light}, **PLACE),
        "timestamp of text": heliotile.Weather({"timestamp": stamps, **light}, **PLACE),
        "US dates": heliotile.Weather({"time": american, **light}, time_zone="+01:00", date_order="mdy", **PLACE),
        "Polars, period_end": heliotile.Weather(pl.from_pandas(kilowatts.reset_index(drop=True).assign(period_end=utc + hour)), **PLACE),
        "Arrow, timestamp": heliotile.Weather(pa.table({"timestamp": pa.array(utc), **light}), **PLACE),
        "xarray with units": heliotile.Weather(dataset, time_zone="UTC", **PLACE),
        "parts": heliotile.Weather({"year": frame.index.year.to_numpy(), "month": frame.index.month.to_numpy(), "day": frame.index.day.to_numpy(), "hour": frame.index.hour.to_numpy() + 1, **light}, time_zone="+01:00", **PLACE),
    }
    for name, weather in layouts.items():
        assert site.replay(weather, every="total")["total"] == pytest.approx(expected, rel=1e-4), name
    assert len(layouts) == 13
    with pytest.raises(heliotile.InputError, match=r"the unit `lux` of column `ghi \(lux\)` is not known"):
        site.replay(heliotile.Weather(frame.rename(columns={"ghi": "ghi (lux)"}), **PLACE))
    with pytest.raises(heliotile.ArgumentError, match="date_order"):
        site.replay(heliotile.Weather(frame, date_order="european", **PLACE))


def test_every_call_takes_weather_of_a_table(block: heliotile.Archive, frame: pd.DataFrame, tmp_path: Path) -> None:
    """A DataFrame gives what its CSV file gives, value by value: a run, modules, an audit, settings, a forecast, a build with an error target, a picture
    of the sun's paths and a page. Two tables of one name, and a table for EnergyPlus, which reads a file, are refused."""
    written = frame.copy()
    written.insert(0, "time", [stamp.isoformat() for stamp in frame.index])
    # Pictures show the name of a file that states no place.
    written.to_csv(tmp_path / "weather", index=False)
    (tmp_path / "scene.obj").write_text("v -50 -50 0\nv 50 -50 0\nv 50 50 0\nv -50 50 0\nusemtl ground\nf 1 2 3 4\n")
    (tmp_path / "points.csv").write_text("point,x,y,z,tilt,azimuth\nsouth,0,0,2,30,180\nflat,5,0,2,0,0\n")
    (tmp_path / "receivers.csv").write_text("receiver,x,y,z,nx,ny,nz\na,0,0,1,0,0,1\nb,1,0,1,0,-1,0\n")
    scene, receivers = heliotile.Scene(tmp_path / "scene.obj", **PLACE), tmp_path / "receivers.csv"
    zoned = heliotile.Weather(tmp_path / "weather", time_zone=1)
    found = {}
    for name, weather in [("file", zoned), ("table", frame)]:
        folder = tmp_path / name
        ran = heliotile.run(scene, weather, folder / "run", quality="draft", spacing=20.0, on=["ground"])
        modules = heliotile.pv(scene, weather, folder / "pv", points=tmp_path / "points.csv", quality="draft")
        built = heliotile.build(scene, receivers, folder / "site.helio", error=5.0, error_weather=weather, weather=weather, negligible=0.1)
        tried = heliotile.tradeoff(scene, receivers, folder / "tradeoff", weather=weather, sample=2)
        audited = built.audit(scene, weather=weather, samples=2)
        forecast = heliotile.plan(scene, receivers, weather=weather)
        built.export(folder / "paths.png", "a", weather=weather)
        built.view(folder / "page.html", weather=weather)
        assert b"weather" in (folder / "page.html").read_bytes()
        pixels = (folder / "paths.png").read_bytes().split(b"IDAT", 1)[1]
        tables = [(folder / "run" / file).read_bytes().split(b"\n", 1)[1] for file in ran.files if file.endswith("annual.csv")]
        errors = [built.built.error_percent, *((step.name, step.error_percent) for step in tried.steps)]
        light = built.replay(DAYS)["total"].tobytes()
        found[name] = [tables, modules.table.split("kWh/m2:")[1], light, errors, audited.components, forecast.text.split(" rays")[0], pixels]
    assert found["file"] == found["table"]
    with pytest.raises(heliotile.ArgumentError, match="error_weather: is another table with the name"):
        heliotile.build(scene, receivers, tmp_path / "two.helio", error=5.0, weather=frame, negligible=0.1, error_weather=frame * 0.5)
    for option in ["weather", "error_weather"]:
        with pytest.raises(heliotile.ArgumentError, match="from a file only"):
            heliotile.energyplus(tmp_path / "model.idf", tmp_path / "out", **{option: frame})
