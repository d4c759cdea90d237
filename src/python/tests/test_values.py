"""Values are the program's."""

from __future__ import annotations

from pathlib import Path

import heliotile
import numpy as np
import pandas as pd
import pytest
from conftest import DATA, DAYS, PROGRAM, YEAR, program

SIX = ["sun_direct", "sky_direct", "sun_reflected", "sky_reflected", "sun_mirrored", "sky_mirrored"]


def of_program(folder: Path, command: str, site: heliotile.Archive, *words: object) -> np.ndarray:
    """[receiver][label][column], as the program writes it."""
    program(command, site.path, *words, "-o", folder / "out.npy")
    return np.load(folder / "out.npy")


def same(results: heliotile.Results, values: np.ndarray) -> None:
    found = np.stack([results[column] for column in results.columns], axis=2)
    assert found.dtype == np.float32 and found.shape == values.shape
    assert found.tobytes() == values.tobytes()


@pytest.mark.parametrize("every", ["hour", "day", "month", "year", "total"])
def test_replay_is_the_programs(site: heliotile.Archive, tmp_path: Path, every: str) -> None:
    """78 receivers, 7 columns, three days: equal to the bit for all five periods."""
    values = of_program(tmp_path, "replay", site, "--weather", DAYS, "--every", every)
    results = site.replay(DAYS, every=every)
    same(results, values)
    assert results.shape[0] == 78 and results.unit == ("W/m2" if every == "hour" else "kWh/m2")


def test_choices_are_the_programs(site: heliotile.Archive, tmp_path: Path) -> None:
    """Reflectances by value, month and row, snow, sky, bounces, columns, a span and 3 receivers: equal to the bit."""
    months = np.linspace(0.1, 0.8, 12)
    (tmp_path / "months.csv").write_text("reflectance\n" + "\n".join(map(repr, months.tolist())) + "\n")
    ids = site.receivers()["receiver"][[40, 3, 77]].tolist()
    (tmp_path / "ids.csv").write_text("receiver\n" + "\n".join(ids) + "\n")
    words = ["--weather", DAYS, "--reflectance", "wall=0.6", "--schedule", f"ground={tmp_path / 'months.csv'}", "--snow", "depth"]
    words += ["--sky", "perez1990", "--bounces", 2, "--columns", "total,sun_reflected_ground", "--receivers", tmp_path / "ids.csv"]
    values = of_program(tmp_path, "replay", site, *words, "--year", 2019, "--steps", 3)
    choices = dict(snow="depth", sky="perez1990", bounces=2, columns=["total", "sun_reflected_ground"], year=2019, steps=3)
    results = site.replay(DAYS, reflectance={"wall": 0.6, "ground": months}, receivers=ids, **choices)
    same(results, values)
    assert results.shape[0] == 3 and sorted(results.receivers) == sorted(ids)
    same(site.replay(DAYS, reflectance={"wall": 0.6, "ground": str(tmp_path / "months.csv")}, receivers=tmp_path / "ids.csv", **choices), values)


def test_own_skies_are_the_programs(site: heliotile.Archive, tmp_path: Path) -> None:
    """A matrix of Radiance as given and scaled to DHI, and clouds: equal to the bit, and not what the model gives."""
    skies = DATA / "skies"
    weather, matrix, clouds = skies / "hours.wea", skies / "m1.mtx", tmp_path / "clouds.csv"
    clouds.write_text(",".join(f"p{i}" for i in range(145)) + "\n" + ",".join(["0.5"] * 145) + "\n")
    values = of_program(tmp_path, "replay", site, "--weather", weather, "--sky", matrix)
    same(site.replay(weather, sky=matrix), values)
    assert not np.array_equal(site.replay(weather)["sky_direct"], site.replay(weather, sky=str(matrix))["sky_direct"])
    words = ["--weather", weather, "--sky", matrix, "--sky-scale", "dhi", "--clouds", clouds]
    values = of_program(tmp_path, "replay", site, *words)
    same(site.replay(weather, sky=matrix, sky_scale="dhi", clouds=clouds), values)


def test_bands_are_the_programs(site: heliotile.Archive, tmp_path: Path) -> None:
    """Two bands and one of a file, hours and sums: equal to the bit, under their names, each with its unit."""
    own = tmp_path / "own.toml"
    own.write_text('[[band]]\nname = "half"\nsun = 0.5\nsky = 0.5\n')
    for every in ["hour", "month"]:
        words = ["--weather", DAYS, "--every", every, "--columns", "total", "--bands", f"visible,par,{own}"]
        with pytest.warns(heliotile.HeliotileWarning, match="no material has values by band"):
            results = site.replay(DAYS, every=every, columns=["total"], bands=["visible", "par", own])
        same(results, of_program(tmp_path, "replay", site, *words))
        assert results.columns == ["total", "total_visible", "illuminance", "total_par", "ppfd", "total_half"]
        assert np.allclose(results["total_half"], 0.5 * results["total"], rtol=1e-5)


def test_selections_are_the_programs(block: heliotile.Archive, tmp_path: Path) -> None:
    """A building, two surfaces and a box, of 1,228 receivers: equal to the bit to the program's, and to a list of their ids."""
    table = pd.DataFrame(block.receivers())
    first = table.iloc[0]
    surfaces = table["surface"].unique()[:2].tolist()
    box = (first.x - 3.0, first.y - 3.0, first.x + 3.0, first.y + 3.0)
    cases = [
        ({"objects": first.building}, ["--object", first.building], table.building == first.building),
        ({"surfaces": surfaces}, ["--surface", *surfaces], table.surface.isin(surfaces)),
        ({"bbox": box}, ["--bbox=" + ",".join(map(str, box))], table.x.between(*box[::2]) & table.y.between(*box[1::2])),
    ]
    for receivers, words, expected in cases:
        results = block.replay(DAYS, every="day", receivers=receivers)
        assert results.receivers == table.receiver[expected].tolist() and 0 < len(results.receivers) < 400
        same(results, of_program(tmp_path, "replay", block, "--weather", DAYS, "--every", "day", *words))


def test_query_is_the_programs(site: heliotile.Archive, conditions: Path, tmp_path: Path) -> None:
    """A table of 2 conditions as a file, a DataFrame and a mapping: equal to the bit."""
    values = of_program(tmp_path, "replay", site, "--conditions", conditions)
    table = pd.read_csv(conditions)
    for given in [conditions, table, {name: table[name].to_numpy() for name in table.columns if name != "condition"}]:
        same(site.query(given), values)
    assert site.query(table).labels == ["noon", "overcast"]


def test_arrow_is_the_programs(site: heliotile.Archive, tmp_path: Path) -> None:
    """The Arrow stream has the names, types, units and 5,616 rows of the program's .arrow file."""
    import pyarrow as pa

    program("replay", site.path, "--weather", DAYS, "-o", tmp_path / "hours.arrow")
    with pa.ipc.open_file(tmp_path / "hours.arrow") as file:
        expected = file.read_all()
    found = pa.table(site.replay(DAYS))
    assert found.schema.equals(expected.schema) and found.num_rows == expected.num_rows == 78 * 72
    assert all(a.metadata == b.metadata for a, b in zip(found.schema, expected.schema, strict=True))
    assert found.cast(found.schema).to_pandas().equals(expected.to_pandas())


def test_factors_are_the_programs(site: heliotile.Archive, tmp_path: Path) -> None:
    """5 factors of 2 surfaces and 703 suns, as f32 of the program's Parquet file."""
    program("energyplus", "factors", site.path, "--by", "surface", "-o", tmp_path / "factors.parquet")
    table = pd.read_parquet(tmp_path / "factors.parquet")
    factors = site.factors(by="surface")
    assert factors.names == sorted(table["surface"].unique()) == ["roof", "wall"]
    for name, values in factors.values.items():
        assert values.shape == (2, 37, 19)
        assert (values.reshape(-1).astype(np.float32) == table[name].to_numpy()).all()
    assert factors.to_xarray()["ReflFacBmToDiffSolGnd"].sel(surface="roof", sun_azimuth_deg=180, sun_altitude_deg=45).item() > 0


def test_pvlib_columns_are_sums_of_components(site: heliotile.Archive) -> None:
    """poa_* of a receiver are sums of its components, to the bit, under times with their zone."""
    hours = site.replay(DAYS, stamp="middle")
    row = 10
    table = hours.to_pvlib(hours.receivers[row])
    assert list(table.columns) == ["poa_global", "poa_direct", "poa_diffuse", "poa_sky_diffuse", "poa_ground_diffuse"]
    direct = hours["sun_direct"][row] + hours["sun_mirrored"][row]
    sky = hours["sky_direct"][row] + hours["sky_mirrored"][row]
    ground = hours["sun_reflected"][row] + hours["sky_reflected"][row]
    assert (table["poa_direct"] == direct).all() and (table["poa_sky_diffuse"] == sky).all()
    assert (table["poa_global"] == direct + (sky + ground)).all() and table["poa_global"].max() > 100
    assert table.index[0].minute == 30 and table.index[0].utcoffset().total_seconds() == -7 * 3600


def test_build_is_the_programs(scene: heliotile.Scene, tmp_path: Path) -> None:
    """Receivers of a file and of a DataFrame give the program's archive, byte by byte."""
    hague = DATA / "hague"
    program("build", hague / "scene.obj", "-m", hague / "materials.toml", "-r", hague / "receivers.csv", "-o", tmp_path / "p.helio", "--quality", "draft")
    expected = (tmp_path / "p.helio").read_bytes()
    for given in [hague / "receivers.csv", pd.read_csv(hague / "receivers.csv")]:
        site = heliotile.build(scene, given, tmp_path / "site.helio", quality="draft")
        assert (tmp_path / "site.helio").read_bytes() == expected
        assert site.built is not None and site.built.bytes == len(expected) and site.built.rays > 1e6


def test_build_from_before_is_a_fresh_build(scene: heliotile.Scene, tmp_path: Path) -> None:
    """Of a scene whose walls were painted since, no ray has to be cast: the bytes are those of a build without `before`."""
    hague = DATA / "hague"
    painted = tmp_path / "painted.toml"
    painted.write_text((hague / "materials.toml").read_text().replace("diffuse = 0.3", "diffuse = 0.6"))
    after = heliotile.Scene(hague / "scene.obj", materials=painted)
    heliotile.build(scene, hague / "receivers.csv", tmp_path / "before.helio", quality="draft")
    fresh = heliotile.build(after, hague / "receivers.csv", tmp_path / "fresh.helio", quality="draft")
    known = heliotile.build(after, hague / "receivers.csv", tmp_path / "known.helio", quality="draft", before=tmp_path / "before.helio")
    assert (tmp_path / "known.helio").read_bytes() == (tmp_path / "fresh.helio").read_bytes() != (tmp_path / "before.helio").read_bytes()
    assert known.built is not None and fresh.built is not None and known.built.rays < fresh.built.rays / 20



def test_cover_is_the_programs(tmp_path: Path) -> None:
    """The table of 1,228 receivers of README's block, and one of windows and roofs at 3 m: byte by byte."""
    city = DATA / "cityjson" / "hague.city.json"
    scene = heliotile.Scene(city)
    for words, choices, start in [([], {}, "1228 receivers on 321 surfaces"), (["--on", "roof", "--spacing", "3m"], {"on": ["roof"], "spacing": 3.0}, "")]:
        program("receivers", city, *words, "-o", tmp_path / "p.csv")
        assert scene.cover(tmp_path / "own.csv", **choices).startswith(start)
        assert (tmp_path / "own.csv").read_bytes() == (tmp_path / "p.csv").read_bytes()
    with pytest.raises(heliotile.ArgumentError, match="spacing: `0` is out of range"):
        scene.cover(tmp_path / "none.csv", spacing=0)
    with pytest.raises(heliotile.ArgumentError, match="`rooves` is neither a kind of surface nor a material"):
        scene.cover(tmp_path / "none.csv", on="rooves")
    assert not (tmp_path / "none.csv").exists()


def test_an_error_is_kept(scene: heliotile.Scene, tmp_path: Path) -> None:
    """A build for 5 % states what it is off by; the settings are in the archive."""
    some = pd.read_csv(DATA / "hague" / "receivers.csv").head(40)
    site = heliotile.build(scene, some, tmp_path / "site.helio", error=5)
    assert site.built is not None and site.built.error_percent is not None and 0 < site.built.error_percent < 10
    assert site.count == 40 and int(site.settings["hit"]) >= 8


def test_receivers_have_unit_normals(site: heliotile.Archive) -> None:
    """78 receivers with unit normals, areas and surfaces, in the order of results; shares of the hemisphere are at most 1."""
    table = pd.DataFrame(site.receivers())
    assert len(table) == site.count == 78 and table["receiver"].tolist() == site.replay(DAYS, every="total").receivers
    assert np.allclose(np.hypot(np.hypot(table["nx"], table["ny"]), table["nz"]), 1, atol=1e-12)
    assert set(table["surface"]) == {"roof", "wall"} and table["area_m2"].sum() == pytest.approx(670.831 + 1575.87, abs=0.01)
    assert ((table[["sky_view", "ground_view", "obstruction_view"]].sum(axis=1)) <= 1 + 1e-6).all()
    assert {material.kind for material in site.materials()} == {"ground", "obstruction"}


def test_some_receivers_are_rows_of_the_table(block: heliotile.Archive, tmp_path: Path) -> None:
    """The table of a building and of a list of ids, and the coordinates of their Dataset, are rows of the table of 1,228 receivers in its
    order, dtypes included but for the widths of texts; names with 4-byte characters and of 300 characters come back as they were."""
    table = block.receivers()
    building = table["building"][0]
    for wanted, rows in [({"objects": building}, table["building"] == building), (table["receiver"][[900, 20]], np.isin(np.arange(1228), [20, 900]))]:
        some = block.receivers(wanted)
        assert list(some) == list(table) and 2 <= len(some["receiver"]) == rows.sum() < 1228
        for name, values in some.items():
            np.testing.assert_array_equal(values, table[name][rows])
            assert values.dtype.kind == table[name].dtype.kind and not values.flags.writeable
        data = block.replay(DAYS, every="total", columns=["total"], receivers=wanted).to_xarray()
        for name in set(table) & set(data.coords):
            np.testing.assert_array_equal(data[name].to_numpy(), some[name])
    names = ["\U0001f31e" * 3, "zo\u00eb", "a" * 300]
    (tmp_path / "r.csv").write_text("receiver,x,y,z,nx,ny,nz\n" + "".join(f"{name},{i},0,1,0,0,1\n" for i, name in enumerate(names)), encoding="utf-8")
    (tmp_path / "s.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    open_air = heliotile.build(heliotile.Scene(tmp_path / "s.obj"), tmp_path / "r.csv", tmp_path / "s.helio", quality="draft")
    assert sorted(open_air.receivers()["receiver"].tolist()) == sorted(names)


def test_a_year_is_the_programs(site: heliotile.Archive, tmp_path: Path) -> None:
    """A year of 78 receivers by month: equal to the bit, and README's 1271.4 kWh/m2 of roofs within 2 % at draft quality."""
    values = of_program(tmp_path, "replay", site, "--weather", YEAR, "--every", "month")
    with pytest.warns(heliotile.HeliotileWarning, match="come from different years"):
        results = site.replay(YEAR, every="month")
    same(results, values)
    table = site.receivers()
    roof = table["surface"] == "roof"
    mean = (results["total"].sum(axis=1) * table["area_m2"])[roof].sum() / table["area_m2"][roof].sum()
    assert mean == pytest.approx(1271.37, rel=0.02)


def test_the_program_is_there() -> None:
    """What values are compared with is the program of version 0.1.0."""
    assert PROGRAM.is_file() and heliotile.__version__ == "0.1.0"
