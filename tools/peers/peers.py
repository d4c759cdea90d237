"""Radiance's annual method and heliotile beside a converged `rtrace`, on two generated scenes and a site.

    tools/peers/run [--site FOLDER] [--only SCENE] [--truth-only]

Writes target/peers/peers.csv and peers.svg. The reference is kept in target/peers; other work on the machine makes CPU seconds
longer, so leave it alone."""
import argparse
from pathlib import Path

import annual
import ours
import picture
import programs
import scenes
import sky
import table
import truth

WEATHER = programs.ROOT / "tests/data/weather/golden_tmy3.epw"
SITE = programs.ROOT / "tests/data/hague"
WORK = programs.ROOT / "target/peers"
DIVISIONS, BATCHES = 2048, 6
PATHS = 32768  # of the reference path tracer
AT_MOST, LEAST_VIEW = 40, 0.01  # receivers of a reference, and the share of the sky that each of them must see
SETTINGS = [("MF:4 -ad 10000", 4, 10000), ("MF:1 -ad 10000", 1, 10000), ("MF:1 -ad 50000", 1, 50000)]


def compare(name, make, hours):
    """All methods on one scene; prints as it goes and returns the rows."""
    folder = WORK / name
    folder.mkdir(parents=True, exist_ok=True)
    scene, conditions = make(folder), sky.conditions(WEATHER, *hours)
    sky.write_conditions(conditions, folder / "conditions.csv")
    views = truth.sky_views(scene, folder)
    seeing = [i for i, view in enumerate(views) if view >= LEAST_VIEW]
    chosen = [seeing[k * len(seeing) // min(AT_MOST, len(seeing))] for k in range(min(AT_MOST, len(seeing)))]
    known = truth.truth(scene, chosen, conditions, DIVISIONS, BATCHES, folder)
    mean = known.total.mean()
    print(f"{name}: {len(scene.ids)} receivers, {len(seeing)} see 1 % of the sky or more; {len(chosen)} of them under "
          f"{len(conditions)} conditions: mean total {mean:.1f} W/m2, standard error {100 * known.error.mean() / mean:.3f} %, "
          f"{100 * known.near_edge.mean():.1f} % of the rows near an edge, {known.cpu_s:.0f} CPU-s", flush=True)
    return scene, conditions, chosen, known, folder


def methods(scene, conditions, chosen, known, folder):
    """Rows of the table for one scene, and lines on heliotile's parts."""
    count, rows, notes = len(scene.ids), [], []
    for step in ours.LADDER:
        found = ours.ours(scene, step, folder / "conditions.csv", WEATHER, folder)
        costs = found.build_s, 0.0, found.year_s, count
        rows.append(table.row(scene.name, f"heliotile {step}", found.total()[:, chosen], known, *costs))
        named = {part: getattr(found, part)[:, chosen] for part in ("sun", "sky", "reflected")}
        asked = f"; build + query {found.build_s + found.query_s:.2f} CPU-s"
        notes.append(table.parts(scene.name, f"heliotile {step}", named, known) + asked)
        print(table.line(rows[-1]), flush=True)
    for title, mf, divisions in SETTINGS:
        found = annual.annual(scene, conditions, mf, divisions, WEATHER, folder)
        costs = found.trace_s, found.suns_s, found.year_s, count
        rows.append(table.row(scene.name, f"Radiance {title}", found.total[:, chosen], known, *costs))
        print(table.line(rows[-1]), flush=True)
    return rows, notes


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--site", type=Path, default=SITE, help="folder with scene.obj, materials.toml, receivers.csv")
    parser.add_argument("--only", help="one scene: canyon, mirror or site")
    parser.add_argument("--truth-only", action="store_true", help="stop when the `rtrace` reference is computed")
    parser.add_argument("--reference-only", action="store_true", help="stop when the reference path tracer of `audit` was compared with `rtrace`")
    arguments = parser.parse_args()
    cases = {"canyon": (scenes.canyon, (3, 3, 2)), "mirror": (scenes.mirror, (3, 3, 2)),
             "site": (lambda work: scenes.site(arguments.site, work), (3, 2, 1))}
    rows, notes = [], []
    for case, (make, hours) in cases.items():
        if arguments.only not in (None, case):
            continue
        name = arguments.site.resolve().name if case == "site" else case
        everything = compare(name, make, hours)
        if arguments.truth_only:
            continue
        scene, _, chosen, known, folder = everything
        total, error = ours.tracer(scene, folder / "conditions.csv", PATHS, folder)
        reference = table.reference(name, total[:, chosen], error[:, chosen], known)
        print(reference, flush=True)
        if arguments.reference_only:
            continue
        print(table.HEAD)
        more, remarks = methods(*everything)
        rows, notes = rows + more, [*notes, *remarks, reference]
    if rows:
        print("\n".join([table.HEAD, *(table.line(r) for r in rows), "", *notes]))
        table.write(rows, WORK / "peers.csv")
        picture.draw(rows, WORK / "peers.svg")
        print(f"in {WORK}: peers.csv, peers.svg")


main()
