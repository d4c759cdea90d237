"""Runs programs. In: a command, its input, a folder. Out: what it wrote and the CPU seconds (user + system) that it and all its
children took."""
import importlib.util
import os
import resource
import subprocess
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
HELIOTILE = ROOT / "target/release/heliotile"


def environment():
    """PATH and RAYPATH of the Radiance that the wheel `pyradiance` brings."""
    folder = Path(importlib.util.find_spec("pyradiance").origin).parent
    return os.environ | {"PATH": f"{folder / 'bin'}:{os.environ['PATH']}", "RAYPATH": f".:{folder / 'lib'}"}


def cpu_seconds():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def run(command, folder, stdin=None, to=None):
    """(bytes written to standard output, CPU seconds); with `to` the output goes to that file of the folder. Radiance is one
    process at a time, started without a shell."""
    before = cpu_seconds()
    words = [str(word) for word in command]
    out = open(Path(folder) / to, "wb") if to else subprocess.PIPE
    done = subprocess.run(words, cwd=folder, env=environment(), input=stdin, stdout=out, stderr=subprocess.PIPE)
    if to:
        out.close()
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(words)}: {done.stderr.decode()[-2000:]}")
    return done.stdout, cpu_seconds() - before


def lines(points):
    """Points and normals as `rtrace` reads them."""
    return "".join(" ".join(f"{v:.9g}" for v in p) + "\n" for p in points).encode()


def matrix(data, rows):
    """First channel of a Radiance matrix of floats with a header, [rows][columns]."""
    body = data[data.index(b"\n\n") + 2:]
    return np.frombuffer(body, dtype="<f4").reshape(rows, -1, 3)[..., 0].astype(float)
