"""Datasets: nothing is computed before it is asked for, and then only the tile that it is in."""

from __future__ import annotations

import multiprocessing
import pickle
from pathlib import Path

import heliotile
from heliotile._heliotile import tiles_computed
import numpy as np
import pytest
import xarray as xr
from conftest import DAYS


@pytest.fixture
def dataset(block: heliotile.Archive) -> xr.Dataset:
    return xr.open_dataset(block.path, engine="heliotile", weather=DAYS)


def test_one_receiver_is_one_tile(block: heliotile.Archive, dataset: xr.Dataset) -> None:
    """Opening computes 0 of 20 tiles; a receiver with all 7 columns 1; its neighbour none more; one of the last tile 1 more."""
    assert block.tiles == 20 and dataset.sizes == {"receiver": 1228, "time": 72}
    before = tiles_computed()
    xr.open_dataset(block.path, engine="heliotile", weather=DAYS, every="day")
    assert tiles_computed() == before
    name = block.receivers()["receiver"][130]
    one = dataset.sel(receiver=name).load()
    assert tiles_computed() == before + 1
    dataset.isel(receiver=131).load()
    assert tiles_computed() == before + 1
    dataset["total"].isel(receiver=[1227, 130], time=slice(3, 9)).load()
    assert tiles_computed() == before + 2
    expected = block.replay(DAYS, receivers=[name])
    assert tiles_computed() == before + 3
    for column in expected.columns:
        assert (one[column].values == expected[column][0]).all()


def test_indexing_is_that_of_numpy(block: heliotile.Archive, dataset: xr.Dataset) -> None:
    """Numbers, slices, lists, masks and backward slices of both dimensions give what NumPy gives of all 1,228 x 72 values."""
    whole = block.replay(DAYS, columns=["total"])["total"]
    total = dataset["total"]
    assert (total.values == whole).all()
    for receivers, times in [
        (5, 7),
        (-1, -1),
        (slice(None, None, 100), 12),
        (slice(1000, 3, -77), slice(None, None, -5)),
        ([900, 2, 2, 70], slice(10, 14)),
        (7, [1, 5, 3]),
        (np.arange(1228) % 400 == 3, slice(0, 0)),
        ([], slice(None)),
    ]:
        expected = whole[receivers, :][..., times] if not isinstance(receivers, int) else whole[receivers][times]
        found = total.isel(receiver=receivers, time=times).values
        assert found.shape == expected.shape and (found == expected).all()
    some = total.isel(receiver=xr.DataArray([3, 800], dims="p"), time=xr.DataArray([1, 40], dims="p")).values
    assert (some == whole[[3, 800], [1, 40]]).all()


def test_a_dataset_states_units_and_provenance(dataset: xr.Dataset) -> None:
    """Units of CF, coordinates of the receivers, chunks of 64, provenance with the archive's root."""
    total = dataset["total"]
    assert total.attrs["units"] == "W m-2" and total.encoding["preferred_chunks"] == {"receiver": 64, "time": 72}
    assert {"x", "y", "z", "nx", "ny", "nz", "area_m2", "surface"} <= set(dataset.coords)
    assert dataset["time"].attrs["standard_name"] == "time" and dataset["x"].attrs["units"] == "m"
    assert len(dataset.attrs["heliotile.archive_root"]) == 64 and dataset.attrs["heliotile.weather"] == DAYS.name
    south = dataset["total"].where((dataset["kind"] == "roof").compute(), drop=True)
    assert south.sizes["receiver"] == 410


def test_a_tile_is_a_task_of_dask(block: heliotile.Archive) -> None:
    """With chunks a tile is a task, whose threads run at once: the mean of 1,228 x 72 values is that of all in memory."""
    lazy = xr.open_dataset(block.path, engine="heliotile", weather=DAYS, columns=["total"], chunks={})
    assert lazy["total"].data.numblocks == (20, 1)
    expected = block.replay(DAYS, columns=["total"])["total"].mean(dtype=np.float64)
    assert lazy["total"].astype(np.float64).mean().compute().item() == pytest.approx(expected, rel=1e-12)


def test_in_memory_is_the_same(block: heliotile.Archive, dataset: xr.Dataset) -> None:
    """`Results.to_xarray` of some receivers is that part of the Dataset, coordinates and all."""
    names = block.receivers()["receiver"][[10, 700]].tolist()
    eager = block.replay(DAYS, receivers=names).to_xarray()
    xr.testing.assert_equal(eager, dataset.sel(receiver=eager["receiver"].values).load())


def test_pickles_restore_archives_and_scenes(block: heliotile.Archive, scene: heliotile.Scene, dataset: xr.Dataset) -> None:
    """Archive, scene and Dataset come out of a pickle as they went in; the Dataset is small, and works in a new process."""
    again = pickle.loads(pickle.dumps(block))
    assert again.root == block.root and again.count == 1228
    assert pickle.loads(pickle.dumps(scene)).triangles == scene.triangles
    one = dataset[["total"]].isel(receiver=[64])
    packed = pickle.dumps(one)
    assert (pickle.loads(packed)["total"].values == one["total"].values).all()
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        assert pool.apply(total_of, (packed,)) == one["total"].values.sum().item()


def test_pickles_open_in_another_folder(block: heliotile.Archive, monkeypatch: pytest.MonkeyPatch) -> None:
    """What was opened by names without folders is unpickled in another folder: the same 72 hours of receiver 5."""
    path = Path(block.path)
    monkeypatch.chdir(path.parent)
    (path.parent / "days.epw").write_bytes(DAYS.read_bytes())
    lazy = xr.open_dataset(path.name, engine="heliotile", weather="days.epw")["total"].isel(receiver=5)
    packed = pickle.dumps(lazy)
    monkeypatch.chdir("/")
    found = pickle.loads(packed).values
    assert found.shape == (72,) and (found == block.replay(DAYS)["total"][5]).all()


def total_of(packed: bytes) -> float:
    return pickle.loads(packed)["total"].values.sum().item()


def test_another_archive_is_refused(scene: heliotile.Scene, site: heliotile.Archive, tmp_path) -> None:
    """A pickle of an archive that was built again with other receivers since is refused."""
    table = {name: values[:3] for name, values in site.receivers().items() if name in ("receiver", "x", "y", "z", "nx", "ny", "nz")}
    path = tmp_path / "site.helio"
    packed = pickle.dumps(heliotile.build(scene, table, path, quality="draft"))
    heliotile.build(scene, {name: values[:2] for name, values in table.items()}, path, quality="draft")
    with pytest.raises(heliotile.InputError, match="another archive than the one that was pickled"):
        pickle.loads(packed)
