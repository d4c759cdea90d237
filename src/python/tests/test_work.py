"""Long work: threads go on, Ctrl-C and exceptions of callbacks stop it, progress is told."""

from __future__ import annotations

import _thread
import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import heliotile
import numpy as np
import pandas as pd
import pytest
from conftest import DATA, DAYS, YEAR, program


def test_ten_threads_get_equal_answers(site: heliotile.Archive, conditions: Path) -> None:
    """10 threads ask one archive at once, 5 times each: 50 equal answers."""
    expected = site.query(conditions)["total"]
    with ThreadPoolExecutor(10) as pool:
        found = list(pool.map(lambda _: site.query(conditions)["total"], range(50)))
    assert len(found) == 50 and all((values == expected).all() for values in found)


def test_other_threads_go_on(block: heliotile.Archive) -> None:
    """While a year of 1,228 receivers is replayed, another thread counts more than 50 times a second."""
    ticks, working = 0, threading.Event()

    def count() -> None:
        nonlocal ticks
        while not working.is_set():
            ticks += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    start = time.perf_counter()
    thread.start()
    block.replay(YEAR, columns=["total"])
    seconds = time.perf_counter() - start
    working.set()
    thread.join()
    assert ticks > 50 * seconds, f"{ticks} in {seconds} s"


def test_a_build_reports_its_stages(scene: heliotile.Scene, tmp_path: Path) -> None:
    """A build tells of its stages, each of which ends with all of its items."""
    told: dict[str, list[tuple[int, int | None]]] = {}
    heliotile.build(
        scene,
        DATA / "hague" / "receivers.csv",
        tmp_path / "site.helio",
        progress=lambda stage, done, items: told.setdefault(stage, []).append((done, items)),
    )
    assert "receivers" in told and told["receivers"][-1][0] <= 78 and len(told) >= 2


#: More columns than usual: longer work.
SPLIT = ["total", "sun_reflected_ground", "sun_reflected_obstruction", "sky_reflected_ground", "sky_reflected_obstruction"]


@pytest.fixture(autouse=True)
def ctrl_c_is_heard() -> Iterator[None]:
    """Python's own handler of Ctrl-C, which it leaves out where a shell has started the tests in the background."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


class Interrupted:
    """Sends Ctrl-C to this process from another thread, once work has gone on."""

    def __init__(self) -> None:
        self.went_on, self.sent = threading.Event(), 0.0
        self.thread = threading.Thread(target=self.interrupt, daemon=True)
        self.thread.start()

    def interrupt(self) -> None:
        if not self.went_on.wait(60):
            return
        self.sent = time.perf_counter()
        os.kill(os.getpid(), signal.SIGINT)

    def __call__(self, stage: str, done: int, items: int | None) -> None:
        self.went_on.set()


def test_ctrl_c_stops_a_replay(block: heliotile.Archive) -> None:
    """Ctrl-C during a year of hours, 60 suns in each, is a KeyboardInterrupt with some of 20 tiles undone; the archive works afterwards."""
    before = heliotile._heliotile.tiles_computed()
    interrupted = Interrupted()
    with pytest.raises(KeyboardInterrupt):
        block.replay(YEAR, steps=60, columns=SPLIT, progress=interrupted)
    interrupted.thread.join()
    assert heliotile._heliotile.tiles_computed() - before < 20
    assert (block.replay(DAYS, every="total")["total"] > 0).any()


def test_ctrl_c_stops_a_build(scene: heliotile.Scene, tmp_path: Path) -> None:
    """Ctrl-C during a build leaves no archive; the same call goes on and gives the bytes of a build that nobody stopped."""
    receivers, path = DATA / "hague" / "receivers.csv", tmp_path / "site.helio"
    interrupted = Interrupted()
    with pytest.raises(KeyboardInterrupt):
        heliotile.build(scene, receivers, path, quality="fine", checkpoint=0, progress=interrupted)
    interrupted.thread.join()
    assert not path.exists() and (tmp_path / "site.helio.partial").is_file()
    with pytest.raises(heliotile.IncompleteError, match="fresh to discard it"):
        heliotile.build(scene, receivers, path, quality="draft")
    went_on = heliotile.build(scene, receivers, path, quality="fine")
    whole = heliotile.build(scene, receivers, tmp_path / "whole.helio", quality="fine")
    assert path.read_bytes() == (tmp_path / "whole.helio").read_bytes() and went_on.root == whole.root


def test_a_callback_that_raises_stops_the_work(block: heliotile.Archive) -> None:
    """What progress raises is raised by the replay, which stops."""

    def refuse(stage: str, done: int, items: int | None) -> None:
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        block.replay(YEAR, progress=refuse)


def test_ctrl_c_does_not_stop_other_threads(site: heliotile.Archive) -> None:
    """Signals are the main thread's: a replay in another thread is done all the same while Ctrl-C comes."""
    with ThreadPoolExecutor(1) as pool:
        future = pool.submit(site.replay, DAYS)
        with pytest.raises(KeyboardInterrupt):
            _thread.interrupt_main()
            time.sleep(5)
        assert future.result().shape == (78, 72)


def test_forks_are_refused(site: heliotile.Archive) -> None:
    """A forked process, which has no threads to compute on, says so instead of waiting for ever."""
    with multiprocessing.get_context("fork").Pool(1) as pool:
        text = pool.apply_async(forked, (site.path,)).get(timeout=30)
    assert "was forked after" in text and "spawn" in text


def test_forks_after_a_listing_are_refused(tmp_path: Path) -> None:
    """Parts of an atlas that were listed are work, too: a process that is forked off after nothing else is refused, not left waiting. A repr tells no
    password."""
    program("atlas", "partition", DATA / "cityjson" / "hague.city.json", "--spacing", "8m", "--quality", "draft", "--sample", "0", "-o", tmp_path / "atlas")
    text = (
        "import multiprocessing, sys, heliotile\n"
        "def ask(path):\n    try: return str(heliotile.Atlas.open(path).parts())\n    except RuntimeError as error: return str(error)\n"
        "atlas = heliotile.Atlas.open(sys.argv[1])\natlas.parts()\n"
        "with multiprocessing.get_context('fork').Pool(1) as pool: print(pool.apply_async(ask, (sys.argv[1],)).get(timeout=30))\n"
        "atlas.path = 'https://me:s3cret@host/atlas?sig=s3cret'\nprint(atlas)\n"
    )
    said = subprocess.run([sys.executable, "-c", text, str(tmp_path / "atlas")], capture_output=True, text=True, check=True, timeout=60).stdout
    assert "was forked after" in said and "Atlas('https://host/atlas')" in said and "s3cret" not in said


def forked(path: str) -> str:
    try:
        return str(heliotile.Archive.open(path))
    except RuntimeError as error:
        return str(error)


def test_pickles_keep_their_schedules(block: heliotile.Archive, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A Dataset with a schedule by a relative path has, loaded where another file has that name, the values of its own."""
    import xarray as xr

    for folder, share in (("here", 0.9), ("there", 0.1)):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "g.csv").write_text("reflectance\n" + f"{share}\n" * 72)
    monkeypatch.chdir(tmp_path / "here")
    lazy = xr.open_dataset(block.path, engine="heliotile", weather=DAYS, every="total", columns=["total"], reflectance={"ground": "g.csv"})
    # Before values are asked for, which stay in the Dataset.
    pickled = pickle.dumps(lazy)
    expected = lazy["total"].values
    monkeypatch.chdir(tmp_path / "there")
    np.testing.assert_array_equal(pickle.loads(pickled)["total"].values, expected)
    other = block.replay(DAYS, every="total", columns=["total"], reflectance={"ground": "g.csv"})["total"]
    assert expected.mean() > 1.001 * other.mean()


def test_ten_threads_read_rows_on_demand(block: heliotile.Archive) -> None:
    """10 threads index one Dataset at once: all 1,228 rows as in memory."""
    import xarray as xr

    lazy = xr.open_dataset(block.path, engine="heliotile", weather=DAYS)["total"]
    whole = block.replay(DAYS)["total"]
    with ThreadPoolExecutor(10) as pool:
        rows = list(pool.map(lambda row: lazy.isel(receiver=row).values, range(0, 1228, 13)))
    assert (np.stack(rows) == whole[::13]).all()


CITY = DATA / "cityjson" / "hague.city.json"


def people(folder: Path, columns: str = "", cells: str = "") -> Path:
    """300 points on a line, written to a folder; `columns` and their `cells` begin with a comma."""
    lines = [f"p{i},{i * 0.1},0,20{cells}" for i in range(300)]
    (folder / "points.csv").write_text("\n".join([f"point,x,y,z{columns}", *lines, ""]))
    return folder / "points.csv"


def receivers_of(block: heliotile.Archive, folder: Path) -> Path:
    """Receivers of the archive as a table."""
    table = pd.DataFrame(block.receivers())
    table.to_csv(folder / "receivers.csv", index=False)
    return folder / "receivers.csv"


def objects_of(block: heliotile.Archive) -> list[str]:
    return sorted({str(name) for name in block.receivers()["object"]})


def damaged(block: heliotile.Archive, folder: Path) -> Path:
    """The archive without the bytes of most layers, which are its last blocks."""
    whole = bytearray(Path(block.path).read_bytes())
    whole[len(whole) // 2 : -65536] = bytes(len(whole) - len(whole) // 2 - 65536)
    (folder / "damaged.helio").write_bytes(whole)
    return folder / "damaged.helio"


#: Calls that take from 0.4 s to minutes: from the archive of README's block and a scratch folder.
LONG: dict[str, Callable[[heliotile.Archive, Path, Interrupted], object]] = {
    "run": lambda block, to, told: heliotile.run(CITY, YEAR, to / "run", quality="fine", progress=told),
    "pv": lambda block, to, told: heliotile.pv(CITY, YEAR, to / "pv", points=people(to, ",tilt,azimuth", ",30,180"), quality="fine", progress=told),
    "comfort": lambda block, to, told: heliotile.comfort(CITY, to / "people", points=people(to), quality="fine", progress=told),
    "plan": lambda block, to, told: heliotile.plan(CITY, receivers_of(block, to), error=0.5, progress=told),
    "tradeoff": lambda block, to, told: heliotile.tradeoff(CITY, receivers_of(block, to), to / "tradeoff", progress=told),
    "audit": lambda block, to, told: block.audit(CITY, samples=1000, progress=told),
    "update": lambda block, to, told: block.update(to / "up.helio", height={name: "+3m" for name in objects_of(block)}, progress=told),
    "repair": lambda block, to, told: heliotile.repair(damaged(block, to), CITY, receivers=Path(block.path).parent / "receivers.csv", progress=told),
    "write": lambda block, to, told: block.write(to / "hours.csv", YEAR, steps=60, columns=SPLIT, progress=told),
    "compare": lambda block, to, told: heliotile.compare(block, block, YEAR, steps=60, columns=SPLIT, progress=told),
    "buildings": lambda block, to, told: block.buildings(to / "roofs.csv", YEAR, steps=60, progress=told),
    "places": lambda block, to, told: block.places(to / "places.csv", YEAR, steps=60, progress=told),
    "shading": lambda block, to, told: block.shading(to / "takers.csv", YEAR, steps=60, progress=told),
    "sunlight": lambda block, to, told: block.sunlight(to / "hours.csv", "year", weather=YEAR, exact=True, progress=told),
    "factors": lambda block, to, told: block.factors(azimuth_step=1, altitude_step=1, progress=told),
}


@pytest.mark.parametrize("call", LONG)
def test_ctrl_c_stops_every_long_call(block: heliotile.Archive, tmp_path: Path, call: str) -> None:
    """Ctrl-C after the first progress is a KeyboardInterrupt within 5 s, of settings finer than `fine` within 30 s, since a tile is traced to its end;
    meanwhile another thread counts more than 20 times a second."""
    ticks, done = 0, threading.Event()

    def count() -> None:
        nonlocal ticks
        while not done.is_set():
            ticks += 1
            time.sleep(0.001)

    interrupted, other = Interrupted(), threading.Thread(target=count)
    other.start()
    start = time.perf_counter()
    try:
        with pytest.raises(KeyboardInterrupt):
            # Once is 0.4 s of work for some calls, with its only progress in the last hundredth.
            for turn in range(20):
                folder = tmp_path / str(turn)
                folder.mkdir()
                LONG[call](block, folder, interrupted)
    finally:
        end = time.perf_counter()
        done.set()
        other.join()
    assert end - interrupted.sent < (30 if call == "tradeoff" else 5), f"{end - interrupted.sent} s"
    assert ticks > 20 * (end - start), f"{ticks} in {end - start} s"
