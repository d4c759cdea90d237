"""The picture of src/book/trackers.md. In: folders that `heliotile pv` wrote for trackers and for fixed rows. Out: an SVG of a clear day.
   python3 tools/pictures/trackers.py TRACKERS FIXED PICTURE"""

import csv
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "comfort"))
from chart import draw  # noqa: E402

DAY, MODULE = "2002-05-30", "field/2/2"
HOURS = (5, 20)


def hours(folder):
    """The rows of a module on the day, by the hour up to which values are means."""
    with (Path(folder) / "hourly.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if row["point"] == MODULE and row["time"].startswith(DAY)]
    return {int(row["time"][11:13]) + 1: row for row in rows if HOURS[0] < int(row["time"][11:13]) + 1 <= HOURS[1]}


def main(trackers, fixed, picture):
    found, beside = hours(trackers), hours(fixed)
    at = sorted(found)
    of = lambda rows, column: [float(rows[hour][column]) for hour in at]  # noqa: E731
    draw(picture, at, [
        ("Angle, degrees", (-60, 60), 20, of(found, "tracker_theta"), []),
        ("Front, W/m2", (0, 1200), 200, of(found, "poa_front"), of(beside, "poa_front")),
        ("Rear, W/m2", (0, 160), 40, of(found, "poa_back"), of(beside, "poa_back"))],
        f"hour of {DAY[5:]} in Golden, UTC-7; means of an hour", ("tracker", "fixed, 35 degrees south"), HOURS)


main(*sys.argv[1:])
