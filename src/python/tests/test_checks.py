"""What archives are worth is told as the program tells it: audits, checks, repairs, trade-offs, exports, pages."""

from __future__ import annotations

import csv
import html
import re
import struct
from typing import Any
from pathlib import Path

import heliotile
import pytest
from conftest import DATA, DAYS, ROOT, YEAR, printed, program

SCENE = [DATA / "hague" / "scene.obj", "-m", DATA / "hague" / "materials.toml"]
RECEIVERS = DATA / "hague" / "receivers.csv"


@pytest.fixture
def damaged(site: heliotile.Archive, tmp_path: Path) -> Path:
    """A copy of which a byte of `sky/0` is another one."""
    copy = tmp_path / "damaged.helio"
    copy.write_bytes(Path(site.path).read_bytes())
    with copy.open("r+b") as file:
        file.seek(copy.stat().st_size // 2)
        byte = file.read(1)
        file.seek(-1, 1)
        file.write(bytes([byte[0] ^ 0xFF]))
    return copy


def test_audit_is_the_programs(site: heliotile.Archive, scene: heliotile.Scene, tmp_path: Path) -> None:
    """Of 12 receivers the table of pairs is the program's, byte by byte, and so is what is told, but for the name of an option."""
    words = ["--samples", 12, "--paths", 256, "--weather", DAYS, "--time-zone", "+02:00"]
    said = printed("archive", "audit", site.path, *SCENE, *words, "-o", tmp_path / "program").splitlines(keepends=True)
    weather = heliotile.Weather(DAYS, time_zone="+02:00")
    report = site.audit(scene, weather=weather, samples=12, paths=256, output=tmp_path / "python")
    assert report.table.replace("build error", "build --error") == "".join(said[:-1])
    assert (tmp_path / "python" / "audit.csv").read_bytes() == (tmp_path / "program" / "audit.csv").read_bytes()
    assert sorted(path.name for path in (tmp_path / "python").iterdir()) == sorted(path.name for path in (tmp_path / "program").iterdir())
    assert (report.receivers, report.hours, report.verdict, report.stated_percent) == (12, 96, "nothing_stated", None)
    assert list(report.components)[-1] == "total" and len(report.components) == 7 and len(report.sky_views) == 3
    total = report.components["total"]
    assert total.rmse_percent.low <= total.rmse_percent.value <= total.rmse_percent.high
    assert total.rmse_percent.value == pytest.approx(100.0 * total.rmse_w_m2.value / report.mean_w_m2)
    assert total.worst is not None and total.worst.receiver in site.receivers()["receiver"]


def test_a_build_for_an_error_is_the_programs(scene: heliotile.Scene, tmp_path: Path) -> None:
    """An archive that was built for an error under the weather of another clock is the program's, byte by byte, states that error, and is audited
    under a table of 2 conditions."""
    words = ["--error", "20%", "--error-weather", DAYS, "--time-zone", "+03:00"]
    program("build", *SCENE, "-r", RECEIVERS, *words, "-o", tmp_path / "program.helio")
    weather = heliotile.Weather(DAYS, time_zone="+03:00")
    site = heliotile.build(scene, RECEIVERS, tmp_path / "python.helio", error=20, error_weather=weather)
    assert (tmp_path / "program.helio").read_bytes() == (tmp_path / "python.helio").read_bytes()
    (tmp_path / "two.csv").write_text("condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2\na,180,40,800,90\nb,90,10,300,50\n")
    report = site.audit([SCENE[0]], conditions=tmp_path / "two.csv", samples=5, paths=64)
    assert (report.hours, report.verdict) == (10, "holds") and report.stated_percent is not None
    with pytest.raises(heliotile.ArgumentError, match="conditions: does not go together with weather"):
        site.audit(scene, weather=DAYS, conditions=tmp_path / "two.csv")
    with pytest.raises(heliotile.ArgumentError, match="paths: 3 is not in 16"):
        site.audit(scene, paths=3)
    with pytest.raises(heliotile.InputError, match="not the scene of the archive"):
        site.audit(DATA / "cityjson" / "hague.city.json")


def test_verify_and_repair_are_the_programs(site: heliotile.Archive, damaged: Path, scene: heliotile.Scene, tmp_path: Path) -> None:
    """A whole archive has no problem, also below the surface; a damaged one has 1, which the program words alike, and is made whole byte by byte."""
    assert site.verify().is_good and site.verify(deep=True).problems == []
    assert site.verify().text == printed("archive", "verify", site.path)
    [found] = heliotile.verify(damaged)
    assert not found.is_good and len(found.problems) == 1 and found.text == printed("archive", "verify", damaged)
    done = heliotile.repair(damaged, scene, tmp_path / "python.helio")
    program("archive", "repair", damaged, *SCENE, "-o", tmp_path / "program.helio")
    whole = Path(site.path).read_bytes()
    assert (tmp_path / "python.helio").read_bytes() == (tmp_path / "program.helio").read_bytes() == whole
    assert done.problems == found.problems and "1 problem repaired" in done.text and done.open().root == site.root
    assert heliotile.repair(damaged, scene).archive == str(damaged) and damaged.read_bytes() == whole
    assert heliotile.repair(damaged, scene).problems == []


def test_tradeoff_is_the_programs(scene: heliotile.Scene, tmp_path: Path) -> None:
    """Errors of 8 steps on 4 receivers are the program's, digit by digit; seconds differ."""
    program("tradeoff", *SCENE, "-r", RECEIVERS, "--sample", 4, "-o", tmp_path / "program")
    found = heliotile.tradeoff(scene, RECEIVERS, tmp_path / "python", sample=4)

    def rows(name: str) -> list[dict[str, str]]:
        with (tmp_path / name / "tradeoff.csv").open() as file:
            return [{key: value for key, value in row.items() if not key.endswith("_s") and key != "frontier"} for row in csv.DictReader(file)]

    assert rows("program") == rows("python") and len(found.steps) == 8
    assert [f"{step.error_percent:.4f}" for step in found.steps] == [row["error_percent"] for row in rows("python")]
    assert found.steps[1].name == "draft" and found.steps[1].settings["sky_base"] == 64.0 and found.sources is None
    assert Path(found.page).read_text().startswith("<!DOCTYPE html>") and "rung" in found.table
    with pytest.raises(heliotile.ArgumentError, match="sample: 0 is not in 1..=4096"):
        heliotile.tradeoff(scene, RECEIVERS, tmp_path / "none", sample=0)


def pixels(png: Path) -> bytes:
    """The packed pixels of a picture, without how it was made."""
    data, at, found = png.read_bytes(), 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at : at + 8])
        found += data[at + 8 : at + 8 + length] if kind == b"IDAT" else b""
        at += 12 + length
    return found


def test_exports_are_the_programs(site: heliotile.Archive, tmp_path: Path) -> None:
    """View factors are the program's byte by byte, 3 pictures pixel by pixel, and values but for how they were made; 3 wrong choices are refused."""
    program("export", site.path, "--view-factors", "-o", tmp_path / "program.csv")
    site.export(tmp_path / "python.csv")
    assert (tmp_path / "program.csv").read_bytes() == (tmp_path / "python.csv").read_bytes()
    receiver = str(site.receivers()["receiver"][0])
    light = ["--sun", "180,45", "--dni", 800, "--dhi", 100]
    pictures = [
        (["--latitude", 52], {"latitude": 52}),
        (["--weather", YEAR, "--time-zone", "+02:00"], {"weather": heliotile.Weather(YEAR, time_zone="+02:00")}),
        ([*light, "--panel"], {"sun": (180, 45), "dni": 800, "dhi": 100, "panel": True}),
    ]
    for number, (words, choices) in enumerate(pictures):
        program("export", site.path, "-r", receiver, *words, "-o", tmp_path / f"program{number}.png")
        site.export(tmp_path / f"python{number}.png", receiver, **choices)
        assert pixels(tmp_path / f"program{number}.png") == pixels(tmp_path / f"python{number}.png")
    program("export", site.path, "-r", receiver, *light, "--bounces", 1, "-o", tmp_path / "program.exr")
    site.export(tmp_path / "python.exr", receiver, sun=(180, 45), dni=800, dhi=100, bounces=1)
    values = [(tmp_path / f"{name}.exr").read_bytes() for name in ("program", "python")]
    half = min(map(len, values)) // 2
    assert values[0][-half:] == values[1][-half:]
    for choices, text in [
        ({"receiver": receiver, "sun": (180, -5)}, "not above the horizon"),
        ({"receiver": receiver, "panel": True}, "panel: belongs to sun, which is not given"),
        ({"sun": (180, 45)}, "view_factors: does not go together with sun"),
    ]:
        with pytest.raises(heliotile.ArgumentError, match=text):
            site.export(tmp_path / "none.png", **choices)


def test_pages_are_the_programs(site: heliotile.Archive, tmp_path: Path) -> None:
    """A page with weather, also in a notebook, and one of two archives, is the program's byte by byte; one in place of the archive is refused."""
    program("export", site.path, "--weather", DAYS, "--html", tmp_path / "program.html")
    site.view(tmp_path / "python.html", weather=DAYS)
    assert (tmp_path / "program.html").read_bytes() == (tmp_path / "python.html").read_bytes()
    shown = re.fullmatch('<iframe srcdoc="([^"]*)" style="[^"]*height: 500px[^"]*" allowfullscreen></iframe>', site.show(500, weather=DAYS)._repr_html_())
    assert shown and html.unescape(shown[1]).encode() == (tmp_path / "program.html").read_bytes()
    program("export", site.path, "--with", site.path, "--html", tmp_path / "two.html")
    for with_ in (site, Path(site.path)):
        site.view(tmp_path / "two_python.html", with_=with_)
        assert (tmp_path / "two.html").read_bytes() == (tmp_path / "two_python.html").read_bytes()
    with pytest.raises(heliotile.InputError, match="is also an input"):
        site.view(site.path)


def test_no_result_replaces_an_input(site: heliotile.Archive, tmp_path: Path) -> None:
    """Eight calls whose output is their weather, their schedule, their list of receivers or an archive are refused, and all files keep their bytes."""
    weather, schedule, names, after = (tmp_path / name for name in ("days.epw", "ground.csv", "names.csv", "after.helio"))
    weather.write_bytes(DAYS.read_bytes())
    schedule.write_text("reflectance\n" + 12 * "0.3\n")
    names.write_text(f"receiver\n{site.receivers()['receiver'][0]}\n")
    after.write_bytes(Path(site.path).read_bytes())
    inputs = (weather, schedule, names, after)
    before = [path.read_bytes() for path in inputs]
    for call in (
        lambda: site.write(weather, weather),
        lambda: site.write(schedule, weather, reflectance={"ground": str(schedule)}),
        lambda: site.write(names, weather, receivers=names),
        lambda: site.buildings(weather, weather),
        lambda: site.places(weather, weather),
        lambda: site.shading(weather, weather),
        lambda: site.envelope(site.path, "0,0,2,2", hours=2, dates="03-21"),
        lambda: heliotile.compare(site, after, weather, summary=after),
    ):
        with pytest.raises((heliotile.ArgumentError, heliotile.InputError, heliotile.UnsupportedError), match="input|replaced|ending"):
            call()
    assert [path.read_bytes() for path in inputs] == before


def test_the_book_names_every_command() -> None:
    """The table of the book has a line for each of the 22 commands of the help, and all that it calls exists."""
    lines = (ROOT / "src" / "book" / "python.md").read_text().splitlines()
    start = lines.index("| program | Python |") + 2
    table = [line.strip("| ").split(" | ", 1) for line in lines[start : lines.index("", start)]]
    commands = {word.split()[0] for left, _ in table for word in re.findall(r"`([^`]+)`", left) if not word.startswith("--")}
    known = {line.split()[0] for line in printed("--help").splitlines() if re.match(r"  [a-z]+  ", line)}
    assert commands == known and len(known) == 22, commands ^ known
    owners = {"site": heliotile.Archive, "Scene(files)": heliotile.Scene, 'Archive.open("site.helio")': heliotile.Archive, 'Atlas.open("atlas")': heliotile.Atlas}
    for call in (call for _, right in table for call in re.findall(r"`([^`]+)`", right) if not call.startswith("python ")):
        owner = next((owner for owner in owners if call.startswith(owner + ".")), None)
        name = re.match(r"\w+", call.removeprefix(f"{owner}."))
        assert name is not None and hasattr(owners[owner] if owner else heliotile, name.group()), call


def test_update_is_the_programs(site: heliotile.Archive, tmp_path: Path) -> None:
    """A tower is added and an object moved: the archive is the program's, byte by byte; names that nothing has are refused."""
    (tmp_path / "tower.obj").write_text(
        "o tower\nusemtl tower\n"
        + "".join(f"v {78700 + x} {457930 + y} {z}\n" for z in (2, 42) for x, y in ((0, 0), (12, 0), (12, 12), (0, 12)))
        + "f 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\nf 5 6 7 8\n"
    )
    (tmp_path / "m.toml").write_text("[tower]\ndiffuse = 0.5\n")
    words = ["--add", tmp_path / "tower.obj", "-m", tmp_path / "m.toml", "--spacing", "6m"]
    program("update", site.path, *words, "-o", tmp_path / "program.helio")
    after = site.update(tmp_path / "python.helio", add=tmp_path / "tower.obj", materials=tmp_path / "m.toml", spacing=6.0)
    assert (tmp_path / "program.helio").read_bytes() == (tmp_path / "python.helio").read_bytes()
    done = after.updated
    assert done is not None and (done.kept + len(done.buried), done.moved, done.gone) == (site.count, 0, 0)
    assert done.new > 8 and after.count == done.kept + done.new and done.rays > 0
    with pytest.raises(heliotile.ArgumentError, match="no object or building `towr`"):
        after.update(tmp_path / "no.helio", move={"towr": (1, 2, 3)})
    with pytest.raises(heliotile.ArgumentError, match="is not a height"):
        after.update(tmp_path / "no.helio", height={"tower": "tall"})


def test_sunlight_is_the_programs(site: heliotile.Archive, tmp_path: Path) -> None:
    """A table of a day and one of a rule are those of the program, and the counts are those of its rows; a wrong day says what is wrong."""
    days = site.sunlight(tmp_path / "day.csv", "03-21", zone="+01:00", by="surface", weather=YEAR)
    assert days["days"] == 1 and days["places"] == len((tmp_path / "day.csv").read_text().splitlines()) - 1
    printed("sunlight", site.path, "--dates", "03-21", "--zone", "+01:00", "--by", "surface", "-w", YEAR, "-o", tmp_path / "program.csv")
    assert (tmp_path / "day.csv").read_bytes() == (tmp_path / "program.csv").read_bytes()
    judged = site.sunlight(tmp_path / "rules.parquet", rules=["tno-light", "bre-vsc"], zone="Europe/Amsterdam", weather=YEAR)
    assert [rule["rule"] for rule in judged["rules"]] == ["tno-light", "bre-vsc"]
    assert all(rule["met"] + rule["broken"] + rule["close"] + rule["not_asked"] == site.count for rule in judged["rules"])
    with pytest.raises(heliotile.ArgumentError, match="is not a day"):
        site.sunlight(tmp_path / "x.csv", "03-32")


def test_comfort_is_the_programs(tmp_path: Path) -> None:
    """A table of months of people on a square is that of the program; an archive of roofs says that it holds no people."""
    corners = [(-30, -30), (30, -30), (30, 30), (-30, 30)]
    (tmp_path / "s.obj").write_text("".join(f"v {x} {y} 0\n" for x, y in corners) + "usemtl ground\nf 1 2 3 4\n")
    (tmp_path / "p.csv").write_text("point,x,y\nhere,1,2\nthere,-5,3\n")
    place = ("--latitude", "52", "--longitude", "5", "--folder", tmp_path / "people", "--points", tmp_path / "p.csv")
    said = ("--every", "month", "--posture", "sitting", "--emissivity", "ground=0.9", "--temperature", "ground=12.5", "--wind", "0.5")
    printed("comfort", tmp_path / "s.obj", "-w", YEAR, *place, *said, "-o", tmp_path / "program.csv")
    people = heliotile.Archive.open(tmp_path / "people" / "site.helio")
    choice: dict[str, Any] = {"posture": "sitting", "emissivity": {"ground": 0.9}, "temperature": {"ground": 12.5}, "wind": 0.5}
    assert people.comfort(tmp_path / "python.csv", YEAR, every="month", **choice) == (2, 8760)
    assert (tmp_path / "python.csv").read_bytes() == (tmp_path / "program.csv").read_bytes()
    with pytest.raises(heliotile.ArgumentError, match="film"):
        people.comfort(tmp_path / "x.csv", YEAR, film=0.0)
    with pytest.raises(TypeError, match="receivers"):
        people.comfort(tmp_path / "x.csv", YEAR, receivers="here")  # type: ignore[call-arg]


def test_glare_is_the_programs(tmp_path: Path) -> None:
    """Minutes, spells and panes of a mirror are those of the program; a site without mirrors says so."""
    square = "v -3 8 0\nv 3 8 0\nv 3 8 5\nv -3 8 5\n"
    (tmp_path / "s.obj").write_text(f"o ground\nv -90 -90 0\nv 90 -90 0\nv 90 90 0\nv -90 90 0\nusemtl ground\nf 1 2 3 4\no pane\n{square}usemtl mirror\nf 5 6 7 8\n")
    (tmp_path / "m.toml").write_text("[ground]\ndiffuse = 0.2\n[mirror]\ndiffuse = 0.0\nspecular = 0.8\n")
    (tmp_path / "r.csv").write_text("receiver,x,y,z,nx,ny,nz\na,0,0,1,0,1,0\n")
    scene = heliotile.Scene(tmp_path / "s.obj", materials=tmp_path / "m.toml", latitude=52.0, longitude=5.0)
    mirror = heliotile.build(scene, tmp_path / "r.csv", tmp_path / "s.helio")
    files = {"spells": tmp_path / "spells.csv", "panes": tmp_path / "panes.csv"}
    done = mirror.glare(tmp_path / "t.csv", zone="+01:00", plots=[tmp_path / "year.svg"], view_angle=60.0, **files)
    assert done["places"] == 1 and done["days"] == 365
    asked = ("--zone", "+01:00", "--view-angle", "60", "--spells", tmp_path / "s.csv", "--panes", tmp_path / "p.csv")
    printed("glare", mirror.path, *asked, "-o", tmp_path / "program.csv")
    for own, program in (("t.csv", "program.csv"), ("spells.csv", "s.csv"), ("panes.csv", "p.csv")):
        assert (tmp_path / own).read_bytes() == (tmp_path / program).read_bytes()
    assert "pane</text>" in (tmp_path / "year.svg").read_text()
    judged = mirror.glare(tmp_path / "lai.csv", rules="lai", zone="+01:00")
    assert [(rule["rule"], rule["broken"]) for rule in judged["rules"]] == [("lai-day", 1), ("lai-year", 1)]
    (tmp_path / "matt.toml").write_text("[ground]\ndiffuse = 0.2\n[mirror]\ndiffuse = 0.5\n")
    scene = heliotile.Scene(tmp_path / "s.obj", materials=tmp_path / "matt.toml", latitude=52.0, longitude=5.0)
    matt = heliotile.build(scene, tmp_path / "r.csv", tmp_path / "matt.helio")
    with pytest.raises(heliotile.InputError, match="no mirror and no glass"):
        matt.glare(tmp_path / "x.csv", zone="+01:00")
    with pytest.raises(heliotile.ArgumentError, match="view_angle"):
        mirror.glare(tmp_path / "x.csv", view_angle=91.0)
