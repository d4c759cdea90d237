"""The examples run."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import pytest

EXAMPLES = sorted((Path(__file__).parents[1] / "examples").glob("*.py"))


def test_there_are_five() -> None:
    """A city, parts on a cluster, PV, seasons, EnergyPlus: 5 examples."""
    assert [example.stem for example in EXAMPLES] == ["city", "cluster", "energyplus", "pv", "seasons"]


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_examples_print_a_number(example: Path, tmp_path: Path) -> None:
    """Each ends well within 60 s and prints a number."""
    start = time.perf_counter()
    done = subprocess.run([sys.executable, example], cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert any(character.isdigit() for character in done.stdout) and time.perf_counter() - start < 60
