"""A map shared by the workers of a local Dask cluster has the same bytes."""

import numpy as np
import pytest
import vibroimpact as vi


@pytest.mark.filterwarnings("ignore")
def test_a_dask_cluster_makes_the_same_map():
    distributed = pytest.importorskip("distributed")
    rig = vi.Rig("wires", mass_kg=0.31)
    asked = dict(gap_mm=np.linspace(0, 2, 40), ratio=np.linspace(1, 4, 200))
    numbers = range(vi.map_tiles(rig, **asked))
    cluster = distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
    with cluster, distributed.Client(cluster) as client:
        tiles = client.gather(client.map(lambda i: vi.map_tile(rig, i, threads=1, **asked), numbers))
    merged, whole = vi.merge_map(rig, tiles, **asked), vi.map(rig, **asked)
    assert len(numbers) > 2
    assert all(merged[layer].tobytes() == whole[layer].tobytes() for layer in whole.layers)
