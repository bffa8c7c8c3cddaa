"""A map that outgrows one machine or one session: chunks of gaps in a zarr store, computed by a Dask cluster."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any, Literal

from . import _native
from ._analyses import Cart, Direction, Map, Numbers, map
from ._native import Rig

if TYPE_CHECKING:
    import xarray
    from dask.distributed import Client


def map_to_zarr(
    rig: Rig,
    store: str,
    *,
    client: Client | None = None,
    gaps_at_once: int = 16,
    gap_mm: Numbers | None = None,
    ratio: Numbers | None = None,
    frequency_hz: Numbers | None = None,
    cart: Cart | None = None,
    engine: Literal["event", "reference", "switch"] = "event",
    precision: Literal["f32", "f64"] | None = None,
    tick_us: float | None = None,
    direction: Direction = "rest",
    cycles: int = 300,
    recorded: int | None = None,
    settle: int | None = None,
) -> xarray.Dataset:
    """The map of :func:`map`, by chunks of gaps in a zarr store. Chunks that are there are not computed again.

    Needs xarray, dask and zarr; a client, distributed.

    Parameters
    ----------
    store:
        Folder of the store (``"map.zarr"``). Every worker must see it under this name.
    client:
        A ``dask.distributed.Client``: each of its workers computes a chunk on one thread. Without one the chunks are
        computed here, one after the other on all threads.
    gaps_at_once:
        Gaps of a chunk: what is lost with a worker.

    The other arguments are those of :func:`map`.

    Returns
    -------
    xarray.Dataset
        The layers of :class:`Map`, read from the store as they are needed: those of :func:`map` to the bit, whoever
        computed them and however often the work broke off.

    Raises
    ------
    ValueError
        An argument cannot be used, or the store holds another map.
    """
    import xarray

    # A single cycle of each cell gives the axes, and the types of the layers.
    axes = map(rig, gap_mm=gap_mm, ratio=ratio, frequency_hz=frequency_hz, cart=cart, cycles=1, recorded=1)
    asked = {
        "gap_mm": axes.gap_mm.tolist(), "ratio": None, "frequency_hz": axes.frequency_hz.tolist(), "cart": cart,
        "engine": engine, "precision": precision, "tick_us": tick_us, "direction": direction, "cycles": cycles,
        "recorded": recorded, "settle": settle,
    }
    request = json.dumps([_native.__version__, rig.name, rig.to_toml(), gaps_at_once, asked])
    try:
        there = xarray.open_zarr(store)
    except FileNotFoundError:
        empty = _layers(axes).assign(done=("gap_mm", [False] * len(axes.gap_mm))).assign_attrs(request=request)
        empty.chunk(gap_mm=gaps_at_once).to_zarr(store, compute=False, zarr_format=2)
        there = xarray.open_zarr(store)
    if there.attrs.get("request") != request or "done" not in there:
        raise ValueError(f"{store} holds another map, or one in other chunks or of another version; choose another store")
    starts = [start for start in range(0, len(there.done), gaps_at_once) if not there.done[start]]
    chunks = [slice(start, start + gaps_at_once) for start in starts]
    if client is None:
        for chunk in chunks:
            _compute(chunk, rig, asked, store, None)
    else:
        client.gather(client.map(_compute, chunks, rig=rig, asked=asked, store=store, threads=1, pure=False))
    return xarray.open_zarr(store).drop_vars("done")


def _compute(chunk: slice, rig: Rig, asked: dict[str, Any], store: str, threads: int | None) -> None:
    """Puts some gaps into the store, and when they are there, that they are."""
    part = asked | {"gap_mm": asked["gap_mm"][chunk]}
    found = _layers(map(rig, threads=threads, **part)).drop_vars(("gap_mm", "frequency_hz"))
    region = {"gap_mm": slice(chunk.start, chunk.start + found.sizes["gap_mm"])}
    found.to_zarr(store, region=region)
    found[[]].assign(done=("gap_mm", [True] * found.sizes["gap_mm"])).to_zarr(store, region=region)


def _layers(found: Map) -> xarray.Dataset:
    """The layers, without options: the axes' are not the map's. Names of regimes have the same room in every chunk."""
    layers = found.to_xarray()
    layers.attrs = {"rig": found.rig}
    return layers.assign(regime=layers.regime.astype("U12"))
