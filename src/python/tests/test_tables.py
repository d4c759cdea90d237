"""Tables: weather from DataFrames, results for pandas, Polars, DuckDB and Arrow."""

from __future__ import annotations

from pathlib import Path

import heliotile
import numpy as np
import pandas as pd
import pytest
from conftest import DAYS, program


@pytest.fixture(scope="module")
def frame() -> pd.DataFrame:
    """Two days of hours at +01:00, with a sun that goes up and down."""
    index = pd.date_range("2021-06-20", periods=48, freq="h", tz="Etc/GMT-1")
    up = np.clip(np.sin((index.hour - 5) / 16 * np.pi), 0, None)
    return pd.DataFrame({"ghi": 750 * up, "dni": 700 * up, "dhi": 750 * up - 700 * up * up * 0.87 + 30 * (up > 0)}, index=index)


PLACE = dict(latitude=52.08, longitude=4.3)


def test_weather_of_a_frame(site: heliotile.Archive, frame: pd.DataFrame, tmp_path: Path) -> None:
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


def test_summer_time(site: heliotile.Archive) -> None:
    """A zone with summer time is told in standard time: one offset, +01:00, over the change of 28 March 2021."""
    index = pd.date_range("2021-03-27", periods=72, freq="h", tz="Europe/Amsterdam")
    frame = pd.DataFrame({"dni": 500.0, "dhi": 80.0}, index=index)
    results = site.replay(heliotile.Weather(frame, **PLACE))
    assert results.utc_offset is not None and results.utc_offset.total_seconds() == 3600
    assert results.shape[1] == 72 and (np.diff(results.time_utc) == np.timedelta64(3600, "s")).all()


def test_pandas(site: heliotile.Archive) -> None:
    """A row for each of 78 receivers and 72 hours, named as in files, with times in their zone; sums have words for typical years."""
    hours = site.replay(DAYS, columns=["total"])
    table = hours.to_pandas()
    assert list(table.columns) == ["time", "receiver", "total"] and len(table) == 78 * 72
    assert (table["total"].to_numpy().reshape(78, 72) == hours["total"]).all()
    assert str(table["time"].iloc[0].tz) == "UTC-07:00" and table["receiver"].dtype == "category"
    sums = site.replay(DAYS, every="total").to_pandas()
    assert list(sums.columns)[-1] == "total_kwh_m2" and sums["time"].unique().tolist() == ["total"]


def test_arrow_readers(site: heliotile.Archive) -> None:
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
