"""A region in parts: cut, built and replayed by Dask's workers, opened as one lazy Dataset."""

# %% [markdown]
# # Parts on a cluster
# A plan says which squares a region is cut into; any machine that has the plan and the scene files can build a part.

# %%
import subprocess
import sys
import tempfile
from pathlib import Path

import heliotile
import heliotile.dask
from distributed import Client, LocalCluster

DATA = Path(__file__).parents[3] / "tests" / "data"
WEATHER = DATA / "weather" / "golden_3_days.epw"


def main(here: Path) -> None:
    """Workers are processes that read this file again, so that what it does stands in a function."""
    # %% [markdown]
    # ## Cut
    # The wheel has the program. Workers see this folder and the model under the same paths.

    # %%
    cut = ["--spacing", "4m", "--quality", "draft", "--part-size", "45m", "--sample", "0"]
    words = ["atlas", "partition", DATA / "cityjson" / "hague.city.json", "--crs", "EPSG:28992", *cut, "-o", here / "atlas"]
    subprocess.run([sys.executable, "-m", "heliotile", *map(str, words)], check=True, capture_output=True)
    atlas = heliotile.Atlas.open(here / "atlas")
    print(atlas)

    # %% [markdown]
    # ## Build
    # A process for each part; a worker has as many of them as it has threads. One that is lost is begun again elsewhere.

    # %%
    cluster = LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0")
    with cluster, Client(cluster) as client:
        print(f"{len(heliotile.dask.build(atlas, client))} parts built: {[part.state for part in atlas.parts()]}")

        # %% [markdown]
        # ## Sums as a table
        # A Dask DataFrame, a partition for each part: nothing is replayed before it is computed.

        # %%
        sums = heliotile.dask.replay(atlas, str(WEATHER), every="total", columns=["total"])
        best = sums.nlargest(3, "total_kwh_m2").compute()
        print(best[["receiver", "total_kwh_m2"]].to_string(index=False))

        # %% [markdown]
        # ## Hours as one Dataset
        # A chunk for each part; workers replay those that values are asked of.

        # %%
        hours = atlas.to_xarray(WEATHER, columns=["total"])
        noon = hours["total"].isel(time=12)
        print(f"{dict(hours.sizes)}, {len(noon.chunksizes['receiver'])} chunks; mean of an hour {float(noon.mean()):.1f} W/m2")

    # %% [markdown]
    # ## A box
    # The atlas is asked like one archive; parts that the box does not touch stay closed.

    # %%
    x, y = atlas.parts()[0].low
    box = (x + 1, y + 1, x + 20, y + 20)
    results = atlas.replay(WEATHER, receivers={"bbox": box}, every="total", columns=["total"])
    print(f"{len(results.receivers)} receivers, at most {results['total'].max():.2f} kWh/m2")


# %%
if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        main(Path(folder))
