"""heliotile as a program. In: files. Out: its tables as lists of dicts."""

import csv
import os
import subprocess
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = Path(os.environ.get("HELIOTILE", ROOT / "target/release/heliotile"))
OUT = ROOT / "target/pv"


def run(*words):
    """Runs a command; gives its seconds."""
    start = time.time()
    done = subprocess.run([PROGRAM, *map(str, words), "--quiet"], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"{' '.join(map(str, words))}\n{done.stderr}")
    return time.time() - start


def table(path):
    with path.open() as file:
        return list(csv.DictReader(file))


def folder(name):
    path = OUT / name
    path.mkdir(parents=True, exist_ok=True)
    return path


def square(path, half=50.0, material="grass"):
    """A level square as OBJ."""
    corners = [(-half, -half), (half, -half), (half, half), (-half, half)]
    text = "".join(f"v {x} {y} 0\n" for x, y in corners)
    path.write_text(f"{text}usemtl {material}\nf 1 2 3 4\n")
