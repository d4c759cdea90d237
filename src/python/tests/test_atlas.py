"""Regions in parts: one of Python's own, Dask's workers, the program that a wheel has."""

from __future__ import annotations

import os
import pickle
import random
import re
import signal
import subprocess
import sys
import threading
import time
import urllib.request
from pathlib import Path

import dask
import heliotile
from heliotile._heliotile import tiles_computed
import heliotile.dask
import numpy as np
import pandas as pd
import psutil
import pytest
from conftest import DATA, DAYS, program
from distributed import Client, LocalCluster
from moto.server import ThreadedMotoServer

CITY = DATA / "cityjson" / "hague.city.json"


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> pd.Series:
    """Sums of three days of the block as one archive, by receiver."""
    folder = tmp_path_factory.mktemp("whole")
    program("receivers", CITY, "--spacing", "4m", "-o", folder / "r.csv")
    program("build", CITY, "-r", folder / "r.csv", "--quality", "draft", "-o", folder / "site.helio")
    rows = heliotile.Archive.open(folder / "site.helio").replay(DAYS, every="total").to_pandas()
    return rows.set_index(rows.receiver.astype(str)).total_kwh_m2.sort_index()


def cut(folder: Path, size: str = "30m") -> heliotile.Atlas:
    """The block in parts with a halo as wide as it."""
    program("atlas", "partition", CITY, "--spacing", "4m", "--quality", "draft", "--sample", "0", "--part-size", size, "-o", folder / "atlas")
    return heliotile.Atlas.open(folder / "atlas")


def test_parts_give_the_sums_of_one_archive(tmp_path: Path, whole: pd.Series) -> None:
    """Four parts built one by one give the 425 sums of one archive to the bit; a box opens one part, and an atlas pickles by its path."""
    atlas = cut(tmp_path, "45m")
    parts = atlas.parts()
    assert [part.state for part in parts] == ["missing"] * 4
    with pytest.raises(heliotile.InputError, match="4 of its parts are not built"):
        list(atlas.archives())
    for part in parts:
        assert atlas.build(part.name, threads=1).state == "built"
    again = pickle.loads(pickle.dumps(atlas))
    rows = again.replay(DAYS, every="total").to_pandas()
    found = rows.set_index(rows.receiver.astype(str)).total_kwh_m2.sort_index()
    assert len(found) == 425 and found.index.equals(whole.index)
    np.testing.assert_array_equal(found.to_numpy(), whole.to_numpy())
    (x0, y0), (x1, y1) = parts[0].low, parts[0].high
    assert [part.name for part, _ in atlas.archives((x0 + 1, y0 + 1, x1 - 1, y1 - 1))] == [parts[0].name]
    with pytest.raises(heliotile.Error, match="no part `nowhere`"):
        atlas.build("nowhere")


def test_a_dataset_has_a_chunk_for_each_part(tmp_path: Path, whole: pd.Series) -> None:
    """One Dataset of four parts has 425 receivers with their parts, a chunk each; nothing is computed to open it, and its sums are the archive's."""
    atlas = cut(tmp_path, "45m")
    for part in atlas.parts():
        atlas.build(part.name)
    before = tiles_computed()
    data = atlas.to_xarray(DAYS, every="total", columns=["total"])
    assert tiles_computed() == before
    assert data.sizes["receiver"] == 425 and len(data.total.chunksizes["receiver"]) == 4
    found = data.total.isel(time=0).to_series().sort_index()
    np.testing.assert_array_equal(found.to_numpy(), whole.to_numpy())
    assert set(data.part.values) == {part.name for part in atlas.parts()}


def test_a_selection_of_an_atlas_gives_the_same_rows(tmp_path: Path) -> None:
    """Chosen by ids, by object and by a box, an atlas gives, to the bit, what it gives of these among all of its 425 receivers, as results, table,
    Dataset and Dask's rows, from the parts that hold some alone; a query and factors likewise. A name that no part knows is an error."""
    atlas = cut(tmp_path, "45m")
    for part in atlas.parts():
        atlas.build(part.name)
    every = atlas.receivers()
    ids, count = every["receiver"].tolist(), len(every["receiver"])
    assert count == 425
    all_of = dict(zip(ids, atlas.replay(DAYS, every="total", columns=["total"])["total"], strict=True))
    sun = {"sun_azimuth_deg": [180.0], "sun_altitude_deg": [40.0], "dni_w_m2": [800.0], "dhi_w_m2": [90.0]}
    by_sun = dict(zip(ids, atlas.query(sun)["total"], strict=True))
    part_of = atlas.to_xarray(DAYS, every="total", columns=["total"])["part"].values
    # One on each side of a seam, an object, and a box around one corner of a part.
    part = atlas.parts()[0]
    (x, y), _ = part.low, part.high
    box = (x, y, x + 45.0, y + 30.0)
    inside = (every["x"] >= x) & (every["x"] <= x + 45.0) & (every["y"] >= y) & (every["y"] <= y + 30.0)
    of_object = every["object"] == every["object"][7]
    for wanted, rows in (
        ([ids[-1], ids[0]], np.isin(np.arange(count), [0, count - 1])),
        ({"objects": every["object"][7]}, of_object),
        ({"bbox": box}, inside),
    ):
        names = every["receiver"][rows].tolist()
        assert 0 < len(names) < count
        results = atlas.replay(DAYS, every="total", columns=["total"], receivers=wanted)
        assert results.receivers == names
        expected = np.concatenate([all_of[name] for name in names])
        np.testing.assert_array_equal(results["total"].ravel(), expected)
        np.testing.assert_array_equal(atlas.query(sun, receivers=wanted)["total"].ravel(), np.concatenate([by_sun[name] for name in names]))
        table = atlas.receivers(wanted)
        assert all(np.array_equal(table[column], values[rows]) for column, values in every.items() if values.dtype.kind != "f")
        data = atlas.to_xarray(DAYS, every="total", columns=["total"], receivers=wanted)
        np.testing.assert_array_equal(data["receiver"], names)
        np.testing.assert_array_equal(data["part"], part_of[rows])
        np.testing.assert_array_equal(data["total"].values.ravel(), expected)
        tasks = heliotile.dask.replay(atlas, str(DAYS), every="total", columns=["total"], receivers=wanted)
        assert tasks.npartitions == len(set(part_of[rows]))
        rows_of = tasks.compute()
        assert rows_of.receiver.tolist() == names
        np.testing.assert_array_equal(rows_of.total_kwh_m2.to_numpy(), expected)
        factors, of_all = (atlas.factors(azimuth_step=90, altitude_step=45, receivers=some) for some in (wanted, None))
        assert factors.names == names and of_all.names == ids
        np.testing.assert_array_equal(factors.values["ReflFacBmToDiffSolObs"], of_all.values["ReflFacBmToDiffSolObs"][rows])
    with pytest.raises(heliotile.InputError, match="nobody"):
        atlas.replay(DAYS, receivers=["nobody"])
    with pytest.raises(heliotile.InputError, match="no part of the atlas holds"):
        atlas.replay(DAYS, receivers={"bbox": (0.0, 0.0, 1.0, 1.0)})
    with pytest.raises(heliotile.ArgumentError, match="3 numbers"):
        atlas.parts((1.0, 2.0, 3.0))


def test_parts_may_share_ids_of_receivers(tmp_path: Path) -> None:
    """Two files with an object of one name make receivers of one id in two parts: each keeps its own place, values and rows, chosen by a box, by the
    shared id, or all; and an archive in another part's place is refused by every way to ask."""
    house = "o house\nv {x} 0 0\nv {y} 0 0\nv {y} 10 0\nv {x} 10 0\nv {x} 0 5\nv {y} 0 5\nv {y} 10 5\nv {x} 10 5\nusemtl roof\nf 5 6 7 8\nusemtl wall\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n"
    for name, x in (("west", 2), ("east", 102)):
        (tmp_path / f"{name}.obj").write_text(house.format(x=x, y=x + 10))
    cut_args = ["--part-size", "50m", "--halo", "10m", "--skyline", "80", "--spacing", "4m", "--quality", "draft", "--sample", "0", "--latitude", "52", "--longitude", "4"]
    program("atlas", "partition", tmp_path / "west.obj", tmp_path / "east.obj", *cut_args, "-o", tmp_path / "atlas")
    atlas = heliotile.Atlas.open(tmp_path / "atlas")
    for part in atlas.parts():
        atlas.build(part.name)
    table = atlas.receivers()
    count = len(table["receiver"])
    assert len(set(table["receiver"])) * 2 == count
    east = atlas.replay(DAYS, every="total", receivers={"bbox": (90.0, -5.0, 120.0, 15.0)}).to_xarray()
    assert east.x.min() > 100 and east.sizes["receiver"] * 2 == count
    every = atlas.replay(DAYS, every="total")
    assert len(every.to_pandas()) == count
    shared = atlas.replay(DAYS, every="total", receivers=[table["receiver"][0]])
    assert len(shared.receivers) == 2 and (np.diff(shared.to_xarray().x) == 100).all()
    np.testing.assert_array_equal(atlas.to_xarray(DAYS, every="total")["total"], every["total"])
    first, *_, last = (Path(part.archive) for part in atlas.parts() if part.archive)
    last.write_bytes(first.read_bytes())
    for ask in (lambda: atlas.replay(DAYS), lambda: atlas.to_xarray(DAYS), lambda: heliotile.dask.replay(atlas, str(DAYS)), lambda: list(atlas.archives())):
        with pytest.raises(heliotile.InputError, match="outside the square"):
            ask()


def test_a_killed_worker_changes_no_part(tmp_path: Path, whole: pd.Series, monkeypatch: pytest.MonkeyPatch) -> None:
    """Parts built by two workers, of which one is killed three times, are those of one machine: the same archives to the byte, 425 sums, also where
    Dask gives a part up with the first worker that is lost around it; replays of a worker with one thread run on 1 thread. No worker starts a
    process of heliotile, and stages are events of Dask."""
    alone, atlas = cut(tmp_path), cut(tmp_path / "cluster")
    monkeypatch.setattr(dask.config, "config", dask.config.merge(dask.config.config, {"distributed": {"scheduler": {"allowed-failures": 0}}}))
    for part in alone.parts():
        alone.build(part.name, threads=1)
    with LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as cluster, Client(cluster) as client:
        killed: list[int] = []

        def kill() -> None:
            chance = random.Random(7)
            while len(killed) < 3:
                time.sleep(1.0)
                pids = [nanny.pid for nanny in cluster.workers.values() if nanny.pid is not None]
                if pids:
                    os.kill(chance.choice(pids), signal.SIGKILL)
                    killed.append(1)

        children: set[str] = set()
        ended = threading.Event()

        def look() -> None:
            while not ended.wait(0.05):
                for nanny in list(cluster.workers.values()):
                    try:
                        found = psutil.Process(nanny.pid).children(recursive=True) if nanny.pid else []
                        children.update(line for line in (" ".join(child.cmdline()) for child in found) if "heliotile" in line)
                    except psutil.NoSuchProcess:
                        pass

        others = [threading.Thread(target=kill), threading.Thread(target=look)]
        for other in others:
            other.start()
        names = heliotile.dask.build(atlas, client)
        others[0].join()
        ended.set()
        others[1].join()
        events = [event for _, event in client.get_events("heliotile")]
        assert not children and {event["part"] for event in events} == set(names) and all(event["stage"] for event in events)
        rows = heliotile.dask.replay(atlas, str(DAYS), every="total", columns=["total"])
        assert rows.npartitions == len(names)
        found = rows.compute().set_index("receiver").total_kwh_m2.sort_index()
        assert set(client.run(lambda: heliotile._heliotile.use_threads(2)).values()) == {1}
    assert len(killed) == 3
    np.testing.assert_array_equal(found.to_numpy(), whole.to_numpy())
    assert sorted(names) == sorted(part.name for part in alone.parts())
    for ours, theirs in zip(alone.parts(), atlas.parts(), strict=True):
        assert ours.state == theirs.state
        if ours.archive is not None and theirs.archive is not None:
            assert Path(ours.archive).read_bytes() == Path(theirs.archive).read_bytes()


def test_workers_build_parts_in_a_store(tmp_path: Path, whole: pd.Series, monkeypatch: pytest.MonkeyPatch) -> None:
    """Four parts that two workers build where the atlas lies, in an S3 store (moto), give the 425 sums of one archive to the bit, nothing
    but their archives is there then, and the folder of the plan still holds no part; a part that is there is not built again."""
    plan = cut(tmp_path, "45m")
    server = ThreadedMotoServer(ip_address="127.0.0.1", port=0)
    server.start()
    host, port = server.get_host_and_port()
    settings = {"AWS_ACCESS_KEY_ID": "k", "AWS_SECRET_ACCESS_KEY": "s", "AWS_REGION": "us-east-1", "AWS_ENDPOINT_URL": f"http://{host}:{port}"}
    for name, value in settings.items():
        monkeypatch.setenv(name, value)
    try:
        urllib.request.urlopen(urllib.request.Request(f"http://{host}:{port}/bucket", method="PUT")).close()
        subprocess.run([sys.executable, "-m", "heliotile", "archive", "copy", plan.path, "s3://bucket/atlas"], check=True)
        atlas = heliotile.Atlas.open("s3://bucket/atlas")
        assert [part.state for part in atlas.parts()] == ["missing"] * 4
        with LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as cluster, Client(cluster) as client:
            names = heliotile.dask.build(atlas, client)
            assert heliotile.dask.build(atlas, client) == []
            rows = heliotile.dask.replay(atlas, str(DAYS), every="total", columns=["total"]).compute()
        found = rows.set_index("receiver").total_kwh_m2.sort_index()
        np.testing.assert_array_equal(found.to_numpy(), whole.to_numpy())
        with urllib.request.urlopen(f"http://{host}:{port}/bucket?list-type=2") as listed:
            keys = re.findall("<Key>([^<]*)</Key>", listed.read().decode())
        assert sorted(keys) == ["atlas/atlas.json", *(f"atlas/parts/{name}/site.helio" for name in sorted(names))]
        assert [part.state for part in plan.parts()] == ["missing"] * 4 and len(names) == 4
        assert atlas.build(names[0]).state == "built"
    finally:
        server.stop()


def test_the_wheel_runs_the_program() -> None:
    """The wheel runs the program: `python -m heliotile --version` says the package's version, and a wrong word ends with 2."""
    said = subprocess.run([sys.executable, "-m", "heliotile", "--version"], capture_output=True, text=True, check=True)
    assert said.stdout.strip() == f"heliotile {heliotile.__version__}"
    wrong = subprocess.run([sys.executable, "-m", "heliotile", "nothing"], capture_output=True, text=True, check=False)
    assert wrong.returncode == 2 and "nothing" in wrong.stderr
