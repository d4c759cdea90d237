"""Atlases as others find them: catalogues by their validators, and atlases on a web server."""

from __future__ import annotations

import functools
import json
import subprocess
import sys
import threading
from collections.abc import Iterator
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import heliotile
import numpy as np
import pystac
import pytest
import rustac
from conftest import DATA, DAYS, program

CITY = DATA / "cityjson" / "hague.city.json"


@pytest.fixture(scope="module")
def atlas(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The block in four parts, two of them built, with a catalogue."""
    folder = tmp_path_factory.mktemp("catalogue") / "atlas"
    program("atlas", "partition", CITY, "--crs", "EPSG:28992", "--spacing", "4m", "--quality", "draft", "--sample", "0", "--part-size", "45m", "-o", folder)
    for part in ("0", "3"):
        program("build", folder, "--part", part)
    program("atlas", "catalogue", folder, "--title", "A block")
    return folder


def test_validators_accept_the_catalogue(atlas: Path) -> None:
    """pystac validates the collection and 2 items against STAC 1.1, rustac reads the same 3, every link and file in them is there, and a table that
    rustac makes of the items gives both back."""
    collection = pystac.Collection.from_file(str(atlas / "collection.json"))
    items = list(collection.get_items())
    assert len(items) == 2
    for thing in (collection, *items):
        # Schemas of extensions stand on the web: what they ask for is seen below.
        thing.stac_extensions = []
        thing.validate()
        for link in thing.links:
            target = link.get_absolute_href()
            if target and not target.startswith("http"):
                assert Path(target.split("#")[0]).exists(), target
        for asset in thing.get_assets().values():
            assert Path(asset.get_absolute_href() or "").stat().st_size > 0
    values = [rustac.read_sync(str(Path(item.self_href))) for item in items]
    assert [value["id"] for value in values] == [item.id for item in items]
    assert rustac.read_sync(str(atlas / "collection.json"))["type"] == "Collection"
    for item in items:
        archive = item.assets["archive"]
        assert archive.extra_fields["file:size"] == Path(archive.get_absolute_href() or "").stat().st_size
        assert archive.extra_fields["file:checksum"].startswith("1e20") and len(archive.extra_fields["file:checksum"]) == 68
        assert item.properties["proj:code"] == "EPSG:28992" and len(item.properties["proj:bbox"]) == 4
        assert item.bbox is not None and np.allclose(item.bbox[:2], (4.30, 52.10), atol=0.03)
    program_of_rustac = Path(sys.executable).with_name("rustac")
    table = atlas / "items.parquet"
    text = json.dumps({"type": "FeatureCollection", "features": values})
    subprocess.run([program_of_rustac, "translate", "-", table], input=text, text=True, check=True, capture_output=True)
    assert {feature["id"] for feature in rustac.read_sync(str(table))["features"]} == {item.id for item in items}
    table.unlink()


class Quiet(SimpleHTTPRequestHandler):
    """A server without ranges and without a log."""

    def log_message(self, *_: object) -> None:
        """Nothing."""


@pytest.fixture()
def served(atlas: Path) -> Iterator[str]:
    """The address of the atlas on a web server."""
    with ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=str(atlas.parent))) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield f"http://127.0.0.1:{server.server_port}/atlas"
        server.shutdown()
        thread.join()


def test_an_atlas_on_a_web_server_has_the_same_sums(atlas: Path, served: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """An atlas at an address has the parts and, to the bit, the sums of its folder; parts that are not built are told, 2 of 4."""
    monkeypatch.setenv("HELIOTILE_CACHE", "off")
    local, afar = heliotile.Atlas.open(atlas), heliotile.Atlas.open(served)
    assert [(part.name, part.state) for part in afar.parts()] == [(part.name, part.state) for part in local.parts()]
    assert [part.state for part in afar.parts()].count("missing") == 2
    part = local.parts()[0]
    box = (part.low[0] + 1, part.low[1] + 1, part.high[0] - 1, part.high[1] - 1)
    here, there = (some.replay(DAYS, receivers={"bbox": box}, every="total") for some in (local, afar))
    np.testing.assert_array_equal(np.asarray(there["total"]), np.asarray(here["total"]))
    with pytest.raises(heliotile.InputError, match="2 of its parts are not built"):
        list(afar.archives())
    with pytest.raises(heliotile.Error, match="request failed|is not there|holds no"):
        heliotile.Atlas.open(served + "/nowhere").parts()
