"""Work that writes folders and archives is the program's, file by file."""

from __future__ import annotations

import json
from pathlib import Path

import heliotile
import numpy as np
import pytest
from conftest import DATA, DAYS, YEAR, program

CITY = DATA / "cityjson" / "hague.city.json"


def rows(path: Path) -> list[str]:
    """A table without how it was made."""
    return path.read_text().splitlines()


def test_run_is_the_programs(tmp_path: Path) -> None:
    """A run in one go writes the 9 files of the program; its archive and its tables are equal byte by byte, and other inputs are refused."""
    program("run", CITY, "--weather", DAYS, "--quality", "draft", "--spacing", "6m", "--every", "month", "-o", tmp_path / "program")
    done = heliotile.run(CITY, DAYS, tmp_path / "python", quality="draft", spacing=6.0, every=["month"])
    names = sorted(path.relative_to(tmp_path / "program") for path in (tmp_path / "program").rglob("*") if path.is_file())
    assert names == sorted(path.relative_to(tmp_path / "python") for path in (tmp_path / "python").rglob("*") if path.is_file())
    for name in ["site.helio", "receivers.csv", "golden_3_days/annual.csv", "golden_3_days/months.csv"]:
        assert (tmp_path / "program" / name).read_bytes() == (tmp_path / "python" / name).read_bytes(), name
    assert "roof" in done.table and done.open().count > 100 and "golden_3_days/annual.csv" in done.files
    with pytest.raises(heliotile.InputError, match="replace"):
        heliotile.run(CITY, DAYS, tmp_path / "python", quality="draft", spacing=8.0)
    with pytest.raises(heliotile.ArgumentError, match="week"):
        heliotile.run(CITY, DAYS, tmp_path / "other", every="week")


def test_pv_is_the_programs(tmp_path: Path) -> None:
    """Two points above a meadow: the tables of the program, and its archive."""
    (tmp_path / "scene.obj").write_text("v -50 -50 0\nv 50 -50 0\nv 50 50 0\nv -50 50 0\nusemtl ground\nf 1 2 3 4\n")
    (tmp_path / "points.csv").write_text("point,x,y,z,tilt,azimuth\nsouth,0,0,2,30,180\nflat,5,0,2,0,0\n")
    scene, points = tmp_path / "scene.obj", tmp_path / "points.csv"
    program("pv", scene, "--weather", DAYS, "--points", points, "--quality", "draft", "-o", tmp_path / "program")
    done = heliotile.pv(scene, DAYS, tmp_path / "python", points=points, quality="draft")
    for name in ["points.csv", "months.csv", "hourly.csv", "site.helio"]:
        assert (tmp_path / "program" / name).read_bytes() == (tmp_path / "python" / name).read_bytes(), name
    assert "south" in done.table
    with pytest.raises(heliotile.ArgumentError, match="bifaciality: .*\n  to fix: give a share from 0 to 1") as found:
        heliotile.pv(scene, DAYS, tmp_path / "wrong", points=points, bifaciality=7)
    assert (found.value.problem, found.value.found, found.value.range) == ("out-of-range", 7.0, (0.0, 1.0))
    assert not (tmp_path / "wrong").exists()


def test_ground_among_rows_is_the_programs(tmp_path: Path) -> None:
    """Rows with receivers on the ground: six files of the program, two of them of the ground, and a replay of its 20 places has their sums."""
    (tmp_path / "scene.obj").write_text("v -50 -50 0\nv 50 -50 0\nv 50 50 0\nv -50 50 0\nusemtl ground\nf 1 2 3 4\n")
    lines = ['name = "a"', "area = [[0, 0], [8, 0], [8, 6], [0, 6]]", "tilt = 30", "azimuth = 180", "pitch = 3"]
    lines += ["width = 2", "height = 1", "clearance = 1", "ground = 1.5"]
    (tmp_path / "rows.toml").write_text("\n".join(["[[rows]]", *lines, ""]))
    scene, modules = tmp_path / "scene.obj", tmp_path / "rows.toml"
    program("pv", scene, "--weather", DAYS, "--rows", modules, "--quality", "draft", "-o", tmp_path / "program")
    done = heliotile.pv(scene, DAYS, tmp_path / "python", rows=modules, quality="draft")
    assert done.files == ["points.csv", "months.csv", "ground.csv", "ground_months.csv", "hourly.csv"]
    for name in [*done.files, "site.helio"]:
        assert (tmp_path / "program" / name).read_bytes() == (tmp_path / "python" / name).read_bytes(), name
    assert "ground among" in done.table
    table = rows(tmp_path / "python" / "ground.csv")
    places = [dict(zip(table[0].split(","), line.split(","), strict=True)) for line in table[1:]]
    assert len(places) == 4 * 5
    with done.open() as site:
        sums = site.replay(DAYS, every="total", bands=["par"], receivers=[place["receiver"] for place in places])
        found = dict(zip(sums.receivers, sums["ppfd"][:, 0], strict=True))
    for place in places:
        assert abs(found[place["receiver"]] - float(place["ppfd_mol_m2"])) < 0.01


def test_comfort_is_the_programs(tmp_path: Path) -> None:
    """Two people on a meadow, and 25 of a square 5 m apart: receivers and archives are the program's byte by byte, and answer; a weather file that is none is refused
    before anything is written, and so is a distance of 0 m."""
    (tmp_path / "scene.obj").write_text("v -12.5 -12.5 0\nv 12.5 -12.5 0\nv 12.5 12.5 0\nv -12.5 12.5 0\nusemtl ground\nf 1 2 3 4\n")
    (tmp_path / "points.csv").write_text("point,x,y\nhere,1,2\nthere,-5,3\n")
    scene = heliotile.Scene(tmp_path / "scene.obj", latitude=39.7, longitude=-105.2)
    for name, words, choice, count in [
        ("points", ("--points", tmp_path / "points.csv"), {"points": tmp_path / "points.csv"}, 2),
        ("square", ("--spacing", "5m", "--body-height", "1.5m"), {"spacing": 5.0, "body_height": 1.5}, 25),
    ]:
        place = ("--latitude", "39.7", "--longitude", "-105.2", "--quality", "draft", "--folder", tmp_path / f"{name}.program")
        program("comfort", tmp_path / "scene.obj", "-w", DAYS, *place, *words, "--every", "total", "-o", tmp_path / f"{name}-table.csv")
        people = heliotile.comfort(scene, tmp_path / f"{name}.python", weather=DAYS, quality="draft", **choice)
        for file in ["site.helio", "receivers.csv"]:
            assert (tmp_path / f"{name}.program" / file).read_bytes() == (tmp_path / f"{name}.python" / file).read_bytes(), (name, file)
        assert people.comfort(tmp_path / "python.csv", DAYS, every="total") == (count, 72)
        assert (tmp_path / "python.csv").read_bytes() == (tmp_path / f"{name}-table.csv").read_bytes()
    with pytest.raises(heliotile.InputError, match="scene.obj"):
        heliotile.comfort(scene, tmp_path / "none", weather=tmp_path / "scene.obj", quality="draft")
    with pytest.raises(heliotile.ArgumentError, match="spacing"):
        heliotile.comfort(scene, tmp_path / "none", spacing=0.0)
    assert not (tmp_path / "none").exists()


def test_energyplus_is_the_programs(tmp_path: Path) -> None:
    """A model gets the tables that the program gives it, byte by byte."""
    model = DATA / "energyplus" / "box.idf"
    program("energyplus", model, "--quality", "draft", "-o", tmp_path / "program")
    assert heliotile.energyplus(model, tmp_path / "python", quality="draft") == str(tmp_path / "python")
    assert (tmp_path / "program" / "model.idf").read_bytes() == (tmp_path / "python" / "model.idf").read_bytes()


def test_two_halves_make_the_archive_again(site: heliotile.Archive, tmp_path: Path) -> None:
    """Two halves of 78 receivers make the archive again: equal, and 39 receivers differ from it; bytes are the program's."""
    ids = site.receivers()["receiver"]
    with site.extract(tmp_path / "a.helio", ids[:39]) as a, site.extract(tmp_path / "b.helio", ids[39:]) as b:
        assert (a.count, b.count) == (39, 39)
    whole = heliotile.merge(tmp_path / "a.helio", tmp_path / "b.helio", tmp_path / "whole.helio")
    assert whole.count == 78 and heliotile.diff(site.path, tmp_path / "whole.helio")[0]
    same, text = heliotile.diff(site.path, tmp_path / "a.helio")
    assert not same and "39 receivers" in text
    program("archive", "merge", tmp_path / "a.helio", tmp_path / "b.helio", "-o", tmp_path / "program.helio")
    assert (tmp_path / "program.helio").read_bytes() == (tmp_path / "whole.helio").read_bytes()


def test_a_comparison_is_the_programs(site: heliotile.Archive, tmp_path: Path) -> None:
    """A part of a site holds 39 of its 78 receivers, which change by nothing: values, summary and files are the program's."""
    ids = site.receivers()["receiver"].tolist()
    part = site.extract(tmp_path / "part.helio", ids[:39])
    program("compare", site.path, part.path, "--weather", DAYS, "-o", tmp_path / "program.csv", "--summary", tmp_path / "program-s.csv")
    found = heliotile.compare(site, part, DAYS, summary=tmp_path / "s.csv")
    assert found.columns == ["before_total_kwh_m2", "after_total_kwh_m2", "change_total_kwh_m2", "change_total_percent"]
    assert found.values.shape == (39, 1, 4) and not found["change_total_kwh_m2"].any()
    assert [row.split(",")[1] for row in rows(tmp_path / "program.csv")[1:]] == found.places and set(found.places) == set(ids[:39])
    assert rows(tmp_path / "s.csv") == rows(tmp_path / "program-s.csv")
    assert found.summary[0]["only_before"] == 39 and "39 receivers in both" in found.text
    several = heliotile.compare(site.path, [part, tmp_path / "part.helio"], DAYS)
    assert len(several.summary) == 2 and several.places == []
    with pytest.raises(heliotile.ArgumentError, match="output"):
        heliotile.compare(site, [part, part], DAYS, output=tmp_path / "x.csv")


def test_regions_are_the_programs(tmp_path: Path) -> None:
    """A region of 3 parts has the plan of the program; one part is built and listed in a catalogue."""
    words = ["--part-size", "60m", "--spacing", "8m", "--quality", "draft", "--sample", 0, "--crs", 28992]
    program("atlas", "partition", CITY, *words, "-o", tmp_path / "program")
    scene = heliotile.Scene(CITY, crs=28992)
    atlas = heliotile.partition(scene, tmp_path / "python", part_size=60.0, spacing=8.0, quality="draft", sample=0)
    plans = [json.loads((tmp_path / name / "atlas.json").read_text()) for name in ("program", "python")]
    assert plans[0] == plans[1] and len(atlas.parts()) == len(plans[0]["parts"]) == 3
    built = next(part for part in map(atlas.build, [part.name for part in atlas.parts()]) if part.state == "built")
    atlas.catalogue(title="The Hague")
    assert json.loads((tmp_path / "python" / "collection.json").read_text())["title"] == "The Hague"
    assert (tmp_path / "python" / "parts" / built.name / "item.json").exists()


def test_files_are_the_programs(block: heliotile.Archive, conditions: Path, tmp_path: Path) -> None:
    """Tables, a map, a chart and a cadastre: values of the program's files."""
    for name, every in [("hours.parquet", "hour"), ("months.csv", "month"), ("map.fgb", "total"), ("map.ply", "total")]:
        program("replay", block.path, "--weather", DAYS, "--every", every, "-o", tmp_path / f"program-{name}")
        block.write(tmp_path / name, DAYS, every=every)
        assert (tmp_path / name).stat().st_size > 1000
    assert rows(tmp_path / "months.csv") == rows(tmp_path / "program-months.csv")
    block.write(tmp_path / "noon.csv", conditions=conditions, plots=[tmp_path / "noon.svg"])
    assert "<svg" in (tmp_path / "noon.svg").read_text()
    program("replay", block.path, "--conditions", conditions, "-o", tmp_path / "program-noon.csv")
    assert rows(tmp_path / "noon.csv") == rows(tmp_path / "program-noon.csv")
    program("buildings", block.path, "--weather", YEAR, "-o", tmp_path / "program-b.csv", "--faces", tmp_path / "program-f.csv")
    buildings, faces = block.buildings(tmp_path / "b.csv", YEAR, faces=tmp_path / "f.csv")
    assert rows(tmp_path / "b.csv") == rows(tmp_path / "program-b.csv") and rows(tmp_path / "f.csv") == rows(tmp_path / "program-f.csv")
    assert len(rows(tmp_path / "b.csv")) == buildings + 1 and faces > buildings
    program("places", block.path, "--weather", YEAR, "--best", 5, "-o", tmp_path / "program-p.csv")
    assert block.places(tmp_path / "p.csv", YEAR, best=5)[0] == 5
    assert rows(tmp_path / "p.csv") == rows(tmp_path / "program-p.csv")
    program("shading", block.path, "--weather", YEAR, "--by", "surface", "-o", tmp_path / "program-s.csv")
    assert "takes most" in block.shading(tmp_path / "s.csv", YEAR, by="surface", plots=[tmp_path / "s.svg"])
    assert rows(tmp_path / "s.csv") == rows(tmp_path / "program-s.csv") and "<svg" in (tmp_path / "s.svg").read_text()
    with pytest.raises(heliotile.ArgumentError, match="weather, conditions"):
        block.write(tmp_path / "none.csv")


def test_an_envelope_is_that_of_the_program(tmp_path: Path) -> None:
    """The envelope of a court of 5 x 5 m among the walls of README's block has the program's heights and vertices, and more than 20 of 500 walls limit it."""
    scene = heliotile.Scene(DATA / "cityjson" / "hague.city.json", crs=28992)
    scene.cover(tmp_path / "walls.csv", on="wall")
    site = heliotile.build(scene, tmp_path / "walls.csv", tmp_path / "site.helio", quality="draft")
    asked = ["--within", "78736,457954,78741,457959", "--hours", 1, "--dates", "03-21"]
    program("envelope", site.path, *asked, "--mesh", tmp_path / "program.obj", "-o", tmp_path / "program.csv")
    found = site.envelope(tmp_path / "e.csv", asked[1], hours=1, dates="03-21", mesh=tmp_path / "e.obj")
    assert rows(tmp_path / "e.csv") == rows(tmp_path / "program.csv") and round(found["plot_m2"], 6) == 25 and found["volume_m3"] > 0
    assert found["places"] > 500 and found["bound"] > 20, found
    vertices = [[line for line in (tmp_path / name).read_text().splitlines() if line.startswith("v ")] for name in ("e.obj", "program.obj")]
    assert vertices[0] == vertices[1]


def test_footprints_give_their_attributes_back(tmp_path: Path) -> None:
    """A town of footprints in degrees has 9 buildings, whose years come back as whole numbers in GeoParquet, as DuckDB reads it."""
    import duckdb

    town = DATA / "footprints" / "town.geojson"
    scene = heliotile.Scene(town, height=["height", "levels"], storey_height=3.0)
    assert scene.place == (pytest.approx(48.138, abs=0.01), pytest.approx(11.576, abs=0.01))
    assert any("UTM zone of its middle" in note for note in scene.notes)
    done = heliotile.run(scene, DAYS, tmp_path / "out", quality="draft", spacing=6.0)
    done.open().write(tmp_path / "map.parquet", DAYS, every="total", by="building", geo=True)
    years = duckdb.sql(f"select building, year, typeof(year) from '{tmp_path}/map.parquet' order by building").fetchall()
    assert len(years) == 9 and ("tower", 1974, "BIGINT") in years
    with pytest.raises(heliotile.ArgumentError, match="storey_height"):
        heliotile.Scene(town, storey_height=300.0)


def test_a_text_is_an_id(site: heliotile.Archive, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """`receivers="x"` means the receiver x, also where a file of that name lies in the folder; a path is a list of ids."""
    first, second = site.receivers()["receiver"][:2].tolist()
    monkeypatch.chdir(tmp_path)
    Path(first).write_text(f"receiver\n{second}\n")
    assert site.replay(DAYS, every="total", receivers=first).receivers == [first]
    assert site.replay(DAYS, every="total", receivers=Path(first)).receivers == [second]


def test_options_have_names(site: heliotile.Archive) -> None:
    """A keyword that is none is a TypeError that names those that there are; defaults are those of the program."""
    with pytest.raises(TypeError, match="wether.*bounces, clouds, columns"):
        site.replay(DAYS, wether=1)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match="every"):
        site.query(DAYS, every="hour")  # type: ignore[call-arg]
    assert np.array_equal(site.replay(DAYS)["total"], site.replay(DAYS, every="hour", sky="perez", paths="all")["total"])


def test_a_scene_with_y_up_is_turned(tmp_path: Path) -> None:
    """A scene with y up stands as one with z up, and its request has what was said of it."""
    (tmp_path / "z.obj").write_text("v 0 0 0\nv 4 0 0\nv 4 0 3\nv 0 0 3\nusemtl wall\nf 1 2 3 4\n")
    (tmp_path / "y.obj").write_text("v 0 0 0\nv 4 0 0\nv 4 3 0\nv 0 3 0\nusemtl wall\nf 1 2 3 4\n")
    covered = [heliotile.Scene(tmp_path / f"{up}.obj", up=up, ground=False) for up in "yz"]
    assert [scene.cover(tmp_path / "r.csv", on="wall") for scene in covered][0]
    assert [scene.options["up"] for scene in covered] == ["y", "z"]
    with pytest.raises(heliotile.ArgumentError) as refused:
        heliotile.Scene(tmp_path / "z.obj", latitude=91.0, longitude=0.0)
    assert refused.value.argument == "latitude"


def test_report_is_the_programs(tmp_path: Path) -> None:
    """A statement about a table of 78 rows holds its verdicts, its hash and the call; a table that was edited is refused."""
    table, page = tmp_path / "walls.csv", tmp_path / "statement.html"
    scene = heliotile.Scene(DATA / "hague" / "scene.obj", materials=DATA / "hague" / "materials.toml", crs=28992)
    site = heliotile.build(scene, DATA / "hague" / "receivers.csv", tmp_path / "site.helio", quality="draft")
    site.sunlight(table, rules=["tno-light"], year=2019)
    said = heliotile.report(table, page, title="Sun <here>", rows=5)
    text = page.read_text()
    assert said.startswith("1 table, 78 rows; tno-light: ") and "5 rows of 78 are shown, 73 are left out." in text
    stated = json.loads((tmp_path / "walls.csv-metadata.json").read_text())["schema:additionalProperty"]
    stated = {one["schema:name"]: one["schema:value"] for one in stated}
    for part in ["<h1>Sun &lt;here&gt;</h1>", "heliotile.Archive.sunlight", stated["heliotile.table_blake3"], stated["heliotile.archive_root"]]:
        assert part in text, part
    program("report", table, "--title", "Sun <here>", "--rows", 5, "-o", tmp_path / "other.html")
    assert (tmp_path / "other.html").read_text().split("<footer>")[0] == text.split("<footer>")[0]
    table.write_text(table.read_text().replace("broken", "met"))
    with pytest.raises(heliotile.InputError, match="was changed since heliotile wrote it"):
        heliotile.report([table], page)
