"""Sites that tests share, and the program that values are compared with."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import heliotile
import pytest

ROOT = Path(__file__).parents[3]
DATA = ROOT / "tests" / "data"
YEAR = DATA / "weather" / "golden_tmy3.epw"
DAYS = DATA / "weather" / "golden_3_days.epw"
#: The program of the same sources; HELIOTILE_PROGRAM may name another.
PROGRAM = Path(os.environ.get("HELIOTILE_PROGRAM", ROOT / "target" / "release" / "heliotile"))

CONDITIONS = """condition,sun_azimuth_deg,sun_altitude_deg,dni_w_m2,dhi_w_m2
noon,180,55,850,110
overcast,180,30,0,200
"""


def program(*words: object) -> None:
    """Runs the program."""
    subprocess.run([PROGRAM, "--quiet", *map(str, words)], check=True, capture_output=True, text=True)


def printed(*words: object) -> str:
    """Runs the program, which may find a problem: what it printed."""
    done = subprocess.run([PROGRAM, "--quiet", *map(str, words)], capture_output=True, text=True)
    assert done.returncode in (0, 1), done.stderr
    return done.stdout


@pytest.fixture(scope="session")
def scene() -> heliotile.Scene:
    return heliotile.Scene(DATA / "hague" / "scene.obj", materials=DATA / "hague" / "materials.toml")


@pytest.fixture(scope="session")
def site(scene: heliotile.Scene, tmp_path_factory: pytest.TempPathFactory) -> heliotile.Archive:
    """78 receivers of The Hague in 2 tiles."""
    output = tmp_path_factory.mktemp("site") / "hague.helio"
    return heliotile.build(scene, DATA / "hague" / "receivers.csv", output, quality="draft")


@pytest.fixture(scope="session")
def block(tmp_path_factory: pytest.TempPathFactory) -> heliotile.Archive:
    """README's block: 1,228 receivers in 20 tiles."""
    folder = tmp_path_factory.mktemp("block")
    city = DATA / "cityjson" / "hague.city.json"
    scene = heliotile.Scene(city)
    scene.cover(folder / "receivers.csv")
    return heliotile.build(scene, folder / "receivers.csv", folder / "site.helio", quality="draft")


@pytest.fixture(scope="session")
def conditions(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("conditions") / "conditions.csv"
    path.write_text(CONDITIONS)
    return path
