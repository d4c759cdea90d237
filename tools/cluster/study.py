"""Parts of a tile on a cluster of this machine, beside one archive of all and beside one process that builds all parts: values, bytes after
kills, threads, seconds. `tools/cluster/run` starts it."""

import argparse
import json
import logging
import pathlib
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

import heliotile
import heliotile.dask
import numpy as np
from distributed import Client, LocalCluster
from watch import Children, Killer, cpu_seconds

HERE = pathlib.Path(__file__).resolve().parents[2]
BLOCK = HERE / "tests/data/cityjson/hague.city.json"
WEATHER = HERE / "tests/data/weather/golden_tmy3.epw"
#: Cores of the cluster: workers of one thread each.
WORKERS = 2

off = []


def check(holds, what):
    """Remembers what is off."""
    print(f"{'ok   ' if holds else 'OFF  '} {what}", flush=True)
    if not holds:
        off.append(what)


def program(*words):
    """Runs the program of the wheel. Wall and CPU seconds."""
    before, started = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    done = subprocess.run([sys.executable, "-m", "heliotile", *map(str, words)], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"heliotile {' '.join(map(str, words))}: {done.stderr}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
    return time.perf_counter() - started, cpu


def on_cluster(cluster, work):
    """What work gives, wall and CPU seconds."""
    before, started = cpu_seconds(cluster), time.perf_counter()
    found = work()
    return found, (time.perf_counter() - started, cpu_seconds(cluster) - before)


def components(rows):
    """A DataFrame of receivers by component, kWh/m2, sorted by receiver."""
    rows = rows.assign(receiver=rows["receiver"].astype(str)).set_index("receiver").sort_index()
    return rows[[name for name in rows if name.endswith("kwh_m2")]]


def archives(atlas):
    """Bytes of each archive of an atlas, by part."""
    return {part.name: pathlib.Path(part.archive).read_bytes() for part in atlas.parts() if part.archive is not None}


class Study:
    """A tile: as one archive, and cut."""

    def __init__(self, args, folder):
        self.args, self.folder = args, folder
        self.crs = ["--crs", args.crs] if args.crs else []
        self.whole, self.plan = folder / "whole.helio", folder / "plan"
        how = ["--spacing", args.spacing, *self.crs, "--quality", args.quality]
        cut = ["--part-size", args.part_size, "--halo", args.halo]
        seconds = program("atlas", "partition", args.scene, *how, *cut, "-o", self.plan)
        self.seams = json.loads((self.plan / "atlas.json").read_text())["seams"]
        self.parts = len(heliotile.Atlas.open(self.plan).parts())
        print(f"{self.parts} parts of {args.part_size}, planned in {seconds[0]:.1f} s", flush=True)
        check(self.parts >= 9, f"{self.parts} parts, 9 wanted at least")

    def atlas(self, name):
        """The plan in another folder, nothing built."""
        shutil.rmtree(self.folder / name, ignore_errors=True)
        shutil.copytree(self.plan, self.folder / name)
        return heliotile.Atlas.open(self.folder / name)

    def build_whole(self):
        """As one archive: receivers and build, on all cores of the cluster."""
        scene, threads = [self.args.scene, *self.crs], ["--threads", WORKERS]
        receivers = self.folder / "receivers.csv"
        self.whole.unlink(missing_ok=True)
        cover = program("receivers", *scene, "--spacing", self.args.spacing, "-o", receivers, *threads)
        build = program("build", *scene, "-r", receivers, "--quality", self.args.quality, "-o", self.whole, *threads)
        return tuple(a + b for a, b in zip(cover, build, strict=True))

    def equality(self, cluster, client):
        """Values of the parts beside those of the one archive; the cluster's archives beside one process's."""
        self.build_whole()
        alone, shared = self.atlas("alone"), self.atlas("cluster")
        program("build", alone.path, "--part", "all", "--threads", WORKERS)
        with Children(cluster) as children:
            names, (wall, cpu) = on_cluster(cluster, lambda: heliotile.dask.build(shared, client))
        check(len(names) == self.parts, f"{len(names)} of {self.parts} parts built by the cluster")
        check(archives(alone) == archives(shared), "archives of the cluster and of one process: the same bytes")
        check(not children.found, f"{len(children.found)} processes of heliotile below the workers")
        print(f"      {cpu / wall:.2f} cores busy on the whole")
        replayed = heliotile.dask.replay(shared, str(WEATHER), every="total").compute()
        threads = set(client.run(lambda: heliotile._heliotile.use_threads(WORKERS)).values())
        check(threads == {1}, f"replays run on {', '.join(map(str, sorted(threads)))} threads a worker")
        found = components(replayed)
        truth = components(heliotile.Archive.open(self.whole).replay(WEATHER, every="total").to_pandas())
        check(found.index.equals(truth.index), f"receivers: {len(truth)} in one archive, {len(found)} in {self.parts} parts")
        both = found.index.intersection(truth.index)
        mean = float(truth["total_kwh_m2"].mean())
        print("| component | mean, kWh/m2 | RMSE, % of mean total | largest difference, kWh/m2 |")
        print("| --- | --- | --- | --- |")
        for name in truth:
            apart = (found.loc[both, name] - truth.loc[both, name]).to_numpy(dtype=float)
            rmse = 100 * float(np.sqrt(np.mean(apart**2))) / mean
            print(f"| {name.removesuffix('_kwh_m2')} | {truth[name].mean():.2f} | {rmse:.4f} | {np.abs(apart).max():.2f} |")
        print(f"stated by the plan, of hours: {json.dumps(self.seams)}")
        check(rmse <= self.args.most, f"RMSE of the {name.removesuffix('_kwh_m2')}: {rmse:.4f} %, {self.args.most} % allowed")
        return wall

    def kills(self, cluster, client, wall):
        """Builds while workers are killed, until there were as many kills as wanted."""
        truth = archives(heliotile.Atlas.open(self.folder / "alone"))
        left, turn, wrong = self.args.kills, 0, []
        parts, looks = 0, 0
        while left > 0:
            turn += 1
            atlas = self.atlas("killed")

            def look(atlas=atlas):
                now = archives(atlas)
                wrong.extend(name for name, found in now.items() if found != truth[name])
                return len(now)

            every_s = self.args.every or max(0.5, wall / (left + 1))
            # Other rounds have other moments.
            with Children(cluster) as children, Killer(cluster, self.args.seed + turn, left, every_s, look) as killer:
                heliotile.dask.build(atlas, client, retries=self.args.kills)
            left -= killer.done
            parts, looks = parts + self.parts, looks + killer.looks
            check(not children.found, f"round {turn}: {len(children.found)} processes of heliotile below the workers")
            same = archives(atlas) == truth
            check(same, f"round {turn}, {killer.done} kills: all archives have the bytes of an undisturbed build")
            strays = [file.name for file in (pathlib.Path(atlas.path) / "parts").glob("*/*") if file.name not in ("receivers.csv", "site.helio", ".lock")]
            states = {part.state for part in atlas.parts()}
            folders = {file.name for file in (pathlib.Path(atlas.path) / "parts").iterdir()}
            names = {part.name for part in atlas.parts()}
            check(states <= {"built", "empty"} and folders <= names, f"round {turn}: parts are {' and '.join(sorted(states))}, {len(folders)} folders, no other part")
            print(f"      {len(strays)} other files beside them: {', '.join(sorted(set(strays))) or 'none'}")
            program("archive", "verify", atlas.path)
        check(not wrong, f"{looks} archives seen right after kills, {len(wrong)} of them not whole")
        print(f"{self.args.kills} kills while {parts} parts were built", flush=True)

    def cost(self, cluster, client):
        """Seconds of the same work in three ways, one after the other, the order turned each time."""
        took = {}

        def note(name, seconds):
            took.setdefault(name, []).append(seconds)

        def build_on_cluster():
            atlas = self.atlas("cluster")
            note(("build", "cluster"), on_cluster(cluster, lambda: heliotile.dask.build(atlas, client))[1])

        def build_alone():
            note(("build", "one process, all parts"), program("build", self.atlas("alone").path, "--part", "all", "--threads", WORKERS))

        def replay_on_cluster():
            rows = heliotile.dask.replay(self.folder / "cluster", str(WEATHER), every="total")
            note(("replay", "cluster"), on_cluster(cluster, lambda: rows.compute())[1])

        def replay_of(name, place):
            words = ["replay", place, "--weather", WEATHER, "--every", "total", "--threads", WORKERS]
            note(("replay", name), program(*words, "-o", self.folder / "sums.parquet"))

        ways = [
            [lambda: note(("build", "one archive"), self.build_whole()), build_alone, build_on_cluster],
            [
                lambda: replay_of("one archive", self.whole),
                lambda: replay_of("one process, all parts", self.folder / "alone"),
                replay_on_cluster,
            ],
        ]
        for turn in range(self.args.repeat):
            for three in ways:
                for way in range(3):
                    three[(way + turn) % 3]()
        print(f"| work, median of {self.args.repeat} | wall, s | CPU, s | cluster's wall over it, each time |")
        print("| --- | --- | --- | --- |")
        for (work, name), seconds in took.items():
            wall, cpu = (statistics.median(column) for column in zip(*seconds, strict=True))
            ratios = ", ".join(f"{c[0] / s[0]:.2f}" for c, s in zip(took[work, "cluster"], seconds, strict=True))
            print(f"| {work}, {name} | {wall:.2f} | {cpu:.2f} | {ratios} |")


def main():
    ask = argparse.ArgumentParser(description=__doc__)
    ask.add_argument("scene", type=pathlib.Path, nargs="?")
    ask.add_argument("--crs")
    ask.add_argument("--spacing", default="4m")
    ask.add_argument("--quality")
    ask.add_argument("--part-size")
    ask.add_argument("--halo", default="300m")
    ask.add_argument("--most", type=float, help="largest allowed RMSE of sums, %% of the mean total")
    ask.add_argument("--kills", type=int, default=10)
    ask.add_argument("--every", type=float, help="seconds between kills; by default they spread over one build")
    ask.add_argument("--seed", type=int, default=7)
    ask.add_argument("--repeat", type=int, default=3)
    ask.add_argument("--only", nargs="+", choices=["kills", "cost"], default=["kills", "cost"], help="parts to run after the comparison of values")
    ask.add_argument("--short", action="store_true", help="a block at draft quality in place of a tile")
    ask.add_argument("--folder", type=pathlib.Path, help="folder for the archives")
    args = ask.parse_args()
    if args.scene is None and not args.short:
        ask.error("name a model, or give --short")
    # With a halo as wide as the block its parts have the values of one archive; a tile is larger than what is around its parts.
    quality, size, most = ("draft", "25m", 0.0) if args.short else ("standard", "250m", 0.05)
    args.scene, args.quality, args.part_size = args.scene or BLOCK, args.quality or quality, args.part_size or size
    args.most = most if args.most is None else args.most
    # Lost workers are what is asked for here.
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    with tempfile.TemporaryDirectory(dir=args.folder) as name:
        study = Study(args, pathlib.Path(name))
        cluster = LocalCluster(
            n_workers=WORKERS, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=logging.CRITICAL
        )
        with cluster, Client(cluster) as client:
            client.wait_for_workers(WORKERS)
            wall = study.equality(cluster, client)
            if "kills" in args.only:
                study.kills(cluster, client, wall)
                client.wait_for_workers(WORKERS)
            if "cost" in args.only:
                study.cost(cluster, client)
    if off:
        raise SystemExit(f"{len(off)} off: {'; '.join(off)}")


if __name__ == "__main__":
    main()
