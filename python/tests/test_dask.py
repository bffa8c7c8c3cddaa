"""A map in a zarr store is the map made at once, to the bit, however often the work broke off."""

import os
import signal
import threading
import time

import numpy as np
import pytest
import vibroimpact as vi
from vibroimpact import _store

for package in "xarray", "dask", "zarr":
    pytest.importorskip(package)
pytestmark = pytest.mark.filterwarnings("ignore")

RIG = vi.Rig("wires", mass_kg=0.31)
ASKED = dict(gap_mm=np.linspace(0, 2, 38), ratio=np.linspace(1, 4, 200))


def assert_same(found, whole):
    for axis in whole.axes:
        assert found[axis].values.tobytes() == whole[axis].tobytes()
    assert (found.regime == whole.regime).all()
    for layer in set(whole.layers) - {"regime"}:
        assert found[layer].values.tobytes() == whole[layer].tobytes(), layer


def test_a_store_goes_on_where_it_broke_off_and_is_of_one_request(tmp_path, monkeypatch):
    store, began, compute = str(tmp_path / "map.zarr"), [], _store._compute

    def breaks_off(chunk, *others):
        began.append(chunk.start)
        if began == [0, 16]:
            raise KeyboardInterrupt
        compute(chunk, *others)

    monkeypatch.setattr(_store, "_compute", breaks_off)
    with pytest.raises(KeyboardInterrupt):
        vi.map_to_zarr(RIG, store, **ASKED)
    found = vi.map_to_zarr(RIG, store, **ASKED)
    assert began == [0, 16, 16, 32]
    assert_same(found, vi.map(RIG, **ASKED))
    for other in {"cycles": 200}, {"gaps_at_once": 8}:
        with pytest.raises(ValueError, match="choose another store"):
            vi.map_to_zarr(RIG, store, **ASKED, **other)
    with pytest.raises(ValueError, match="choose another store"):
        vi.map_to_zarr(RIG.replace(mass_kg=0.3), store, **ASKED)


def test_two_workers_are_killed(tmp_path):
    distributed = pytest.importorskip("distributed")
    store, asked = str(tmp_path / "map.zarr"), ASKED | {"direction": "up", "cycles": 1200, "recorded": 100}
    cluster = distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
    with cluster, distributed.Client(cluster) as client:
        workers = client.run(os.getpid).values()
        done = []

        def kill():
            while not (there := list(tmp_path.glob("map.zarr/done/[0-9]*"))):
                time.sleep(0.02)
            done.append(len(there))
            for worker in workers:
                os.kill(worker, signal.SIGKILL)

        killer = threading.Thread(target=kill)
        killer.start()
        found = vi.map_to_zarr(RIG, store, client=client, gaps_at_once=2, **asked)
        killer.join()
    assert done[0] < 19, "they were to be killed in the middle"
    assert_same(found, vi.map(RIG, **asked))
