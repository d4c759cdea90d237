"""Sums of weather files as heliotile reads them, beside those of pvlib's readers.

In: the program and weather files. Out: a table, one line a file: GHI, DNI and DHI in kWh/m2 by
pvlib and by `heliotile info --weather`, and the largest difference. Exit 1 if a file that both
read differs by more than 0.1 %.

    python3 tools/peers/weathers.py target/release/heliotile FILE...

A file that pvlib reads and heliotile refuses is listed with the first line of the refusal. A sum
that pvlib's reader leaves open, because rows miss values, is not compared.
"""

from __future__ import annotations

import re
import subprocess
import sys
import warnings

import pandas as pd
import pvlib

NAMES = ("ghi", "dni", "dhi")
LIMIT = 0.001
#: Largest difference that the three printed decimals of a sum explain, kWh/m2.
PRINTED = 0.001
#: Place of files that state none: sums of stated columns do not depend on it.
SOMEWHERE = ["--latitude", "40", "--longitude", "-80"]


def readers(path: str):
    """Readers of pvlib that fit the first lines of a file, most likely first."""
    with open(path, "rb") as file:
        head = file.read(3000).decode("latin-1")
    io = pvlib.iotools
    first, *rest = head.splitlines() or [""]
    second = rest[0] if rest else ""
    if first.startswith("LOCATION"):
        yield lambda: io.read_epw(path)
    if "Date (MM/DD/YYYY)" in second and "GHI (W/m^2)" in second:
        yield lambda: io.read_tmy3(path, map_variables=True)
    if first.startswith("Source,Location ID"):
        yield lambda: io.read_nsrdb_psm4(path, map_variables=True)
        yield lambda: io.read_psm3(path, map_variables=True)
    if "latitude (decimal degrees)" in head.lower():
        yield lambda: io.read_pvgis_tmy(path, map_variables=True)
        yield lambda: io.read_pvgis_hourly(path, map_variables=True)
    if first.lstrip().startswith("{"):
        yield lambda: io.read_pvgis_tmy(path, map_variables=True)
        yield lambda: io.read_pvgis_hourly(path, map_variables=True)
    if re.search(r"\.dat$", path) and "version" in second.lower():
        yield lambda: io.read_surfrad(path, map_variables=True)
    if re.search(r"(abq|msn)\d+\.dat$", path):
        yield lambda: io.read_solrad(path)
    if re.search(r"pay0616\.dat(\.gz)?$", path):
        yield lambda: io.read_bsrn(path)
    if "cams" in path.lower() or "copernicus" in head.lower():
        yield lambda: io.read_cams(path, map_variables=True)
    if "midc" in path.lower():
        yield lambda: io.read_midc(path)
    if "solaranywhere" in path.lower():
        yield lambda: io.read_solaranywhere(path, map_variables=True)
    if re.search(r"CRN[^/]*\.txt$", path):
        yield lambda: io.read_crn(path)
    if "SRML" in path:
        yield lambda: io.read_srml(path, map_variables=True)
    if path.lower().endswith(".tm2"):
        yield lambda: io.read_tmy2(path)


def sums_by_pvlib(path: str):
    """Sums in kWh/m2 by pvlib, None where a column is absent or has gaps; None if no reader fits."""
    for read in readers(path):
        try:
            found = read()
        except Exception:  # the next reader may fit
            continue
        table = next((part for part in found if isinstance(part, pd.DataFrame)), None)
        if isinstance(found, pd.DataFrame):
            table = found
        if table is None:
            continue
        table = table.rename(columns={c: c.lower() for c in table.columns})
        table = table.rename(columns={"global horizontal [w/m^2]": "ghi", "direct normal [w/m^2]": "dni"})
        if not set(NAMES) & set(table.columns):
            continue
        hours = step_hours(table)
        return {name: total(table[name], hours) if name in table else None for name in NAMES}
    return None


def step_hours(table: pd.DataFrame) -> float:
    """Most frequent step of the index, hours."""
    return table.index.to_series().diff().mode().iloc[0].total_seconds() / 3600


def total(column: pd.Series, hours: float):
    """Sum of a column in kWh/m2; None if a value is missing."""
    values = pd.to_numeric(column, errors="coerce")
    return None if values.isna().any() else float(values.clip(lower=0).sum()) * hours / 1000


def sums_by_heliotile(program: str, path: str):
    """Sums by heliotile, or its refusal; and its warnings."""
    command = [program, "info", "--weather", path]
    done = subprocess.run(command, capture_output=True, text=True)
    if "latitude" in done.stderr and done.returncode != 0:
        done = subprocess.run(command + SOMEWHERE, capture_output=True, text=True)
    if done.returncode != 0:
        return None, done.stderr.splitlines()[0]
    cells = next(line for line in done.stdout.splitlines() if line.startswith("  all ")).split()[2:]
    return dict(zip(NAMES, (None if cell == "-" else float(cell) for cell in cells))), ""


def main(program: str, paths: list[str]) -> int:
    """Prints the table."""
    warnings.simplefilter("ignore")
    print(f"{'file':58} {'pvlib GHI DNI DHI, kWh/m2':>30} {'heliotile':>30} {'off %':>7}")
    wrong = 0
    for path in paths:
        by_pvlib, (by_heliotile, refusal) = sums_by_pvlib(path), sums_by_heliotile(program, path)
        name = path.split("/")[-1][-58:]
        show = lambda sums: " ".join("%9.3f" % v if v is not None else f"{'-':>9}" for v in sums.values())
        if by_heliotile is None:
            said = "not read" if by_pvlib is None else show(by_pvlib)
            print(f"{name:58} {said:>30} refused: {refusal.split(path + ':')[-1].strip()[:110]}")
            continue
        if by_pvlib is None:
            print(f"{name:58} {'no reader':>30} {show(by_heliotile):>30}")
            continue
        both = [(by_pvlib[n], by_heliotile[n]) for n in NAMES if by_pvlib[n] is not None and by_heliotile[n] is not None]
        beyond = [(a, max(abs(b - a) - PRINTED, 0.0)) for a, b in both]
        off = max((by / a if a > 0 else float(by > 0) for a, by in beyond), default=float("nan"))
        wrong += off > LIMIT
        print(f"{name:58} {show(by_pvlib):>30} {show(by_heliotile):>30} {100 * off:7.3f}{' <' if off > LIMIT else ''}")
    print(f"{wrong} of {len(paths)} files differ by more than {100 * LIMIT} %")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2:]))
