"""Vibro-impact hammer: which drive frequency, how hard, and will it stay there.

A hammer hangs in a cart, on wires or on beam springs; a shaker moves the cart; at the right frequency the hammer
strikes the cart's impact surface hard, once in each cycle. This package computes that frequency, and the maps, orbits,
basins and sections around it, as the command line ``host-sim`` does: the numbers are the same to the bit.

>>> import vibroimpact as vi
>>> answer = vi.pick(vi.Rig("wires"))
>>> f"{answer.operating_frequency_hz:.2f} Hz, {answer.force_ratio:.0f} times the weight"
'3.68 Hz, 30 times the weight'

Everything here is simulation; no real rig has been run.
"""

from ._analyses import (
    Basins,
    Map,
    basins,
    bifurcation,
    compare,
    contact,
    drill,
    drop,
    emulate,
    identify,
    lyapunov,
    map,
    modes,
    orbits,
    pick,
    poincare,
    scenarios,
    simulate,
    sweep,
    trials,
)
from ._answers import (
    Bifurcation,
    Comparison,
    Curves,
    Drill,
    Emulation,
    Identification,
    LongTrials,
    Lyapunov,
    Modes,
    Orbits,
    Pick,
    Poincare,
    Run,
    Trials,
)
from ._native import Rig, __version__, presets
from ._records import Grid, Record, Table
from ._store import map_to_zarr

__all__ = [
    "Basins",
    "Bifurcation",
    "Comparison",
    "Curves",
    "Drill",
    "Emulation",
    "Grid",
    "Identification",
    "LongTrials",
    "Lyapunov",
    "Map",
    "Modes",
    "Orbits",
    "Pick",
    "Poincare",
    "Record",
    "Rig",
    "Run",
    "Table",
    "Trials",
    "__version__",
    "basins",
    "bifurcation",
    "compare",
    "contact",
    "drill",
    "drop",
    "emulate",
    "identify",
    "lyapunov",
    "map",
    "map_to_zarr",
    "modes",
    "orbits",
    "pick",
    "poincare",
    "presets",
    "scenarios",
    "simulate",
    "sweep",
    "trials",
]
