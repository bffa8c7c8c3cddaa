"""The analyses. Arguments have the meaning and the defaults of the command line's options; so have the numbers.

``locals()`` is first in each function, so that it holds the arguments by their names, and nothing else.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Literal, Union

import numpy as np

from . import _native
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
from ._native import Rig
from ._records import Grid, Record, Table

Numbers = Union[float, Iterable[float]]
Start = Union[str, tuple[float, float]]
Cart = Literal["prescribed", "recoil"]
Direction = Literal["rest", "up", "down"]
Progress = Callable[[int, int], object]


def simulate(
    rig: Rig,
    *,
    ratio: float | None = None,
    frequency_hz: float | None = None,
    gap_mm: float | None = None,
    cart: Cart | None = None,
    start: Start = "rest",
    cycles: int = 600,
    transient: int = 480,
    samples_per_period: int = 400,
    engine: Literal["event", "switch"] = "event",
    precision: Literal["f32", "f64"] | None = None,
    tick_us: float | None = None,
) -> Run:
    """One run at one drive frequency.

    Parameters
    ----------
    rig:
        The rig.
    ratio, frequency_hz:
        The drive frequency, over the natural frequency (Ω/ω) or in Hz: one of the two.
    gap_mm:
        Clearance at rest, mm; the rig's if left out.
    cart:
        ``"recoil"`` (contacts push the cart off its course) where the rig's shaker is known (``shaker_loop_hz``), else
        ``"prescribed"`` (as the chapter). The switch engine needs ``"prescribed"``.
    start:
        ``"rest"``, ``"fixed"`` (at rest in the fixed frame), or displacement in mm and velocity in m/s relative to the cart.
    cycles, transient:
        Drive cycles in all, and how many of the first are not recorded.
    samples_per_period:
        Samples of the history in a drive period, evenly spaced (with ``"switch"`` to a tick, and one a tick at
        most); 0 keeps none. A contact lasts about 0.6 ms, less than a sample at 400: peak, mean and spectrum of
        ``force_n`` then mean nothing. Take ``contacts``, or ask for 20,000.
    engine, precision, tick_us:
        ``"event"`` is the event-located reference in f64; ``"switch"`` is the microcontroller's switch model of a fixed tick
        (50 µs) in ``"f32"`` or ``"f64"``.

    Returns
    -------
    Run
        Regime z = p/n (``regime``, ``impacts``, ``periods``), ``force_n``, ``force_ratio`` (over the weight), the strongest
        contact's speed, time, energy and impulse; tables ``history`` (time_s, displacement_mm, force_n, ... of shape
        ((cycles - transient) * samples_per_period,)), ``section`` (drive phase 0, one row a cycle) and ``contacts``.

    Raises
    ------
    ValueError
        An argument cannot be used, or the hammer leaves the range of the model.

    Notes
    -----
    Equations (3-8) to (3-18) of the chapter; regimes by the Poincaré section at drive phase 0.
    """
    return Run(_native.simulate(locals()))


def sweep(
    rig: Rig,
    *,
    ratio: Numbers | None = None,
    frequency_hz: Numbers | None = None,
    gap_mm: float | None = None,
    cart: Cart | None = None,
    direction: Direction = "rest",
    cycles: int = 600,
    transient: int = 480,
    engine: Literal["event", "switch"] = "event",
    precision: Literal["f32", "f64"] | None = None,
    tick_us: float | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Table:
    """Force over drive frequency (figures 3.12 to 3.14).

    Parameters
    ----------
    ratio, frequency_hz:
        The frequencies, rising: over the natural frequency, or in Hz.
    direction:
        ``"rest"``: each from rest; ``"up"``, ``"down"``: the state carried, which shows the jumps.
    threads:
        Threads; one for each processor if left out. The numbers do not depend on it.
    progress:
        Called with the steps done and the steps in all, from the calling thread.

    The other arguments are those of :func:`simulate`.

    Returns
    -------
    Table
        A row for each frequency: ``frequency_hz``, ``frequency_ratio``, ``regime``, ``force_n``, ``force_ratio``,
        ``approach_speed_m_per_s``, ``contact_time_ms``. Where the hammer could not be followed ``regime`` is "failed".

    Raises
    ------
    ValueError
        An argument cannot be used, or every run fails.
    KeyboardInterrupt
        On Ctrl-C.
    """
    return _native.sweep(locals())


def pick(
    rig: Rig,
    *,
    gap_mm: float = 0.0,
    cart: Cart | None = None,
    nominal: bool = False,
    natural_frequency_percent: float | None = None,
    amplitude_percent: float | None = None,
    contact_stiffness_percent: float | None = None,
    contact_stiffness_factor: float | None = None,
    contact_damping_percent: float | None = None,
    contact_damping_ratio_percent: float | None = None,
    gap_tolerance_mm: float | None = None,
    mass_percent: float | None = None,
    cart_mass_percent: float | None = None,
    shaker_loop_percent: float | None = None,
    shaker_damping_percent: float | None = None,
    samples: int = 256,
    seed: int = 1,
    max_force_n: float | None = None,
    max_frequency_hz: float | None = None,
    max_shaker_force_n: float | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Pick:
    """The frequency to run at: the strongest stable 1/1 that holds over the uncertainty and within the limits.

    Parameters
    ----------
    gap_mm:
        Clearance at rest, mm. The field's is 0.0, whatever the rig file says.
    cart:
        As in :func:`simulate`.
    nominal:
        Takes the parameters as exact.
    natural_frequency_percent, ..., shaker_damping_percent:
        Half-widths of the uncertainty; what is left out is the rig file's, else 2, 5, 20, 20 %, 0.05 mm, 0, and 5, 30, 30 %
        where the cart recoils.
    contact_stiffness_factor:
        In place of ``contact_stiffness_percent``: the stiffness is up to so many times as large or as small.
    contact_damping_ratio_percent:
        In place of ``contact_damping_percent``: the damping goes with the stiffness.
    samples, seed:
        Random rigs within the uncertainty beside its corners.
    max_force_n, max_frequency_hz, max_shaker_force_n:
        Limits: contact force (for every rig of the uncertainty), drive frequency, the shaker's force.

    Returns
    -------
    Pick
        The fields of ``host-sim pick --format json``, among them ``operating_frequency_hz``, ``force_ratio``, ``safe_band_hz``,
        ``stable_one_one_hz``, ``multipliers``, ``shaker``, ``sensitivity``; and the nominal stable 1/1 as
        ``curve_frequency_hz`` and ``curve_force_ratio``.

    Raises
    ------
    ValueError
        An argument cannot be used, or no frequency has a stable 1/1 within the limits.
    KeyboardInterrupt
        On Ctrl-C.
    """
    return Pick(_native.pick(locals()))


class Map(Grid):
    """A Peterka map: what the hammer does over gap and drive frequency. Layers have the shape (gaps, frequencies).

    Axes: ``gap_mm`` and ``frequency_hz``, beside them ``gap_ratio`` (gap/A0) and ``frequency_ratio`` (Ω/ω). Layers:
    ``regime`` ("p/n", "none", "aperiodic", "chatter", "unsettled", "failed"), ``impacts`` (p), ``periods`` (n; NaN
    where nothing repeats), ``force_ratio`` (over the weight), ``force_n``, ``settling_cycles`` (NaN: not settled),
    ``largest_period_searched``, ``uncertain`` (the fast engine handed the cell to the reference), ``failed``.
    """

    _LAYERS = (
        "regime", "impacts", "periods", "force_ratio", "force_n", "settling_cycles", "largest_period_searched",
        "uncertain", "failed",
    )

    def __init__(self, given: Record) -> None:
        found = dict(given)
        names = np.array(found.pop("regime_names"))
        found["regime"] = names[found.pop("regime_index")]
        shape = (len(found["gap_mm"]), len(found["frequency_hz"]))
        for name in self._LAYERS:
            found[name] = found[name].reshape(shape)
        super().__init__(found, ("gap_mm", "frequency_hz"), self._LAYERS)


def map(  # noqa: A001
    rig: Rig,
    *,
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
    threads: int | None = None,
    progress: Progress | None = None,
) -> Map:
    """The Peterka map (figures 3.24 to 3.26): regime and force at each gap and drive frequency.

    Parameters
    ----------
    gap_mm:
        Clearances at rest, mm, rising; the chapter's if left out.
    ratio, frequency_hz:
        Drive frequencies, rising: over the natural frequency, or in Hz; the chapter's if left out (1.41 to 7.28 Hz in
        steps of 0.01 Hz on wires, and the same Ω/ω for other rigs).
    cart, precision, tick_us:
        As in :func:`simulate`.
    engine:
        ``"event"`` (fast, in vector registers, uncertain cells by the reference), ``"reference"`` (hours), or ``"switch"``.
    direction:
        Each cell from rest, or the state carried up or down the frequencies of each gap.
    cycles, recorded, settle:
        Drive cycles of each cell, how many of the last are recorded, and to how many a cell that has not settled runs on.
    threads, progress:
        As in :func:`sweep`.

    Returns
    -------
    Map
        Layers of shape (gaps, frequencies); ``summary`` counts the regimes.

    Raises
    ------
    ValueError
        An argument cannot be used.
    KeyboardInterrupt
        On Ctrl-C.
    """
    return Map(_native.map(locals()))


class Basins(Grid):
    """Basins of attraction. Layers have the shape (velocities, displacements).

    Axes: ``start_velocity_m_per_s`` and ``start_displacement_mm``, relative to the cart. Layers: ``impact`` (a contact in
    the recorded cycles), ``attractor`` (its name), ``regime``, ``force_ratio``, ``settled_after_cycles``,
    ``last_contact_cycle``. The other fields are those of ``host-sim basins --format json``: shares with their intervals,
    attractors, entropies.
    """

    _LAYERS = ("impact", "attractor", "regime", "force_ratio", "settled_after_cycles", "last_contact_cycle")

    def __init__(self, given: Record) -> None:
        found = dict(given)
        names = np.array(found.pop("attractor_names"))
        found["attractor"] = names[found.pop("which")]
        found["regime"] = np.array(found["regime"])
        shape = (len(found["start_velocity_m_per_s"]), len(found["start_displacement_mm"]))
        for name in self._LAYERS:
            found[name] = found[name].reshape(shape)
        super().__init__(found, ("start_velocity_m_per_s", "start_displacement_mm"), self._LAYERS)


def basins(
    rig: Rig,
    *,
    ratio: float | None = None,
    frequency_hz: float | None = None,
    gap_mm: float | None = None,
    cart: Cart | None = None,
    grid: int | tuple[int, int] = 500,
    displacement_mm: tuple[float, float] | None = None,
    velocity_m_per_s: tuple[float, float] | None = None,
    phase: float = 0.0,
    cycles: int = 300,
    recorded: int = 100,
    samples: int = 2000,
    seed: int = 1,
    until: int | None = None,
    engine: Literal["event", "switch"] = "event",
    precision: Literal["f32", "f64"] | None = None,
    tick_us: float | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Basins:
    """Which starts lead to lasting impacts, and to which motion (figures 3.36 to 3.38).

    Parameters
    ----------
    grid:
        Starts along displacement and velocity, or one number for both.
    displacement_mm, velocity_m_per_s:
        The window, from and to, relative to the cart; -6 mm to the gap and -0.15 to 0.15 m/s if left out.
    phase:
        Drive phase at the start, turns from 0 to below 1.
    samples, seed, until:
        Random starts beside the grid, for shares with confidence intervals, run on to ``until`` cycles.

    The other arguments are those of :func:`simulate` and :func:`map`.

    Raises
    ------
    ValueError
        An argument cannot be used.
    KeyboardInterrupt
        On Ctrl-C.
    """
    return Basins(_native.basins(locals()))


def bifurcation(
    rig: Rig,
    *,
    ratio: Numbers | None = None,
    frequency_hz: Numbers | None = None,
    gap_mm: Numbers | None = None,
    cart: Cart | None = None,
    direction: Literal["rest", "up", "down", "all"] = "rest",
    cycles: int = 300,
    recorded: int = 100,
    engine: Literal["event", "switch"] = "event",
    precision: Literal["f32", "f64"] | None = None,
    tick_us: float | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Bifurcation:
    """Displacement and force on the section over frequency (figures 3.28 to 3.35).

    Returns
    -------
    Bifurcation
        ``points``: a table with a row for each point of the section (as many for each frequency as the motion has periods; where
        it does not repeat, all recorded); ``diagrams``: for each gap and direction where the number of branches ``changes``;
        ``twofold``: where the sweeps up and down differ (with ``direction="all"``).

    The arguments are those of :func:`sweep` and :func:`map`.
    """
    return Bifurcation(_native.bifurcation(locals()))


def orbits(
    rig: Rig,
    *,
    along: Literal["frequency", "gap"] = "frequency",
    ratio: Numbers | None = None,
    frequency_hz: Numbers | None = None,
    gap_mm: Numbers | None = None,
    cart: Cart | None = None,
    periods: int = 2,
    impacts: int = 2,
    starts: int = 40,
    checks: int | None = None,
    curve: Mapping[str, tuple[float, float] | tuple[float, float, str]] | None = None,
    searches: int = 5,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Orbits | Curves:
    """Periodic orbits, stable or not, followed over frequency or gap, with their period doublings, folds and grazes.

    Parameters
    ----------
    along:
        ``"frequency"``: ``ratio`` or ``frequency_hz`` is a pair (from, to), Ω/ω 0.8 to 4 if left out, and ``gap_mm`` one number;
        ``"gap"``: ``gap_mm`` is the pair, and ``ratio`` or ``frequency_hz`` one number.
    periods, impacts:
        Orbits of up to so many drive periods (1 to 8) and contacts (1 to 16).
    cart:
        As in :func:`simulate`.
    starts, checks:
        Values at which simulations look for orbits, and at which they check that none was missed.
    curve:
        Follows period doublings, folds and grazes over two parameters: ``{"gap_mm": (0, 3)}`` over the frequency and this number of the
        rig, two entries over these two at one frequency. ``(1e6, 1e8, "log")`` goes by factors.
    searches:
        Values of the second parameter of ``curve`` at which the search for orbits begins.

    Returns
    -------
    Orbits or Curves
        ``branches`` (each with its range, stable stretches and ends), tables ``special_points`` and ``orbits`` (a row for each orbit
        and strobe, with both multipliers), and ``seen_elsewhere``: regimes that simulations settled on off these branches. With ``curve`` the tables
        ``curves``, ``codimension_two`` and ``points``.
    """
    return (Orbits if curve is None else Curves)(_native.orbits(locals()))


def poincare(
    rig: Rig,
    *,
    ratio: float | None = None,
    frequency_hz: float | None = None,
    gap_mm: float | None = None,
    cart: Cart | None = None,
    points: int = 10_000,
    transient: int = 500,
    phases_turns: Numbers = 0.0,
    start: Start = "rest",
    progress: Progress | None = None,
) -> Poincare:
    """Poincaré sections of one trajectory at one or several drive phases (figures 3.15 to 3.23).

    The arguments are those of :func:`simulate`; ``points`` is the number of points of each section.

    Returns
    -------
    Poincare
        ``section``: a table with a row for each point (``phase_turns``, ``relative_displacement_mm``,
        ``relative_velocity_m_per_s``, ``force_n``, ...); ``trajectory``: the periods after the last point; ``regime``.
    """
    return Poincare(_native.poincare(locals()))


def lyapunov(
    rig: Rig,
    *,
    ratio: float | None = None,
    frequency_hz: float | None = None,
    gap_mm: float | None = None,
    cart: Cart | None = None,
    periods: int = 10_000,
    transient: int = 500,
    start: Start = "rest",
) -> Lyapunov:
    """The two largest Lyapunov exponents of a trajectory, through its contacts.

    The arguments are those of :func:`simulate`. With a prescribed cart there are two exponents in all, with one that recoils
    four.

    Returns
    -------
    Lyapunov
        ``largest_per_s`` and its ``standard_error_per_s``, ``other_per_s``, ``largest_per_period``, and ``meaning``:
        "chaotic", "contracting" or "undecided", at three standard errors.

    Notes
    -----
    The derivative of a drive period comes from dual numbers, the jump at each switch included (Müller 1995,
    doi:10.1016/0960-0779(94)00170-U).
    """
    return Lyapunov(_native.lyapunov(locals()))


def contact(
    rig: Rig, *, speed_m_per_s: Numbers | None = None, law: Literal["all", "own"] = "all"
) -> Table:
    """One contact of the free hammer with a wall under each contact law, (3-2) to (3-5), over approach speed.

    Returns
    -------
    Table
        A row for each law and speed: ``contact_time_ms``, ``restitution``, ``force_n``, ``energy_lost_j``, ...
        Speeds are 0.02 to 0.3 m/s in steps of 0.02 if left out.
    """
    return _native.contact(locals())


def drop(
    rig: Rig,
    *,
    gap_mm: float | None = None,
    release_mm: float = -3.0,
    impacts: int = 4,
    sampling_hz: float = 50e3,
    noise_n: float = 0.0,
    ringing: float = 0.0,
    bits: int = 0,
    full_scale_n: float = 100.0,
    force_gain_percent: float = 0.0,
    offset_n: float = 0.0,
    drift_n_per_s: float = 0.0,
    filter_hz: float = 0.0,
    displacement_gain_percent: float = 0.0,
    seed: int = 1,
) -> Table:
    """A drop test as sensors would see it, to try :func:`identify` on (figures 3.8 to 3.10).

    Returns
    -------
    Table
        A row for each sample: ``time_s``, ``force_n``, ``displacement_mm``, ``acceleration_m_per_s2``.
    """
    return _native.drop(locals())


def identify(
    rig: Rig,
    time_s: Iterable[float],
    force_n: Iterable[float],
    displacement_mm: Iterable[float] | None = None,
    *,
    gap_mm: float | None = None,
    law: str | Sequence[str] = "spring-dashpot",
    misfit: str | Sequence[str] = ("force", "peaks"),
    release_mm: float | None = None,
    seek_release: bool = False,
    seek_exponent: bool = False,
    impacts: int = 6,
    gain_percent: float = 2.0,
    release_height_percent: float = 1.0,
    clock_percent: float = 0.02,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Identification:
    """Contact parameters from a drop test, with 95 % intervals.

    Parameters
    ----------
    time_s, force_n, displacement_mm:
        The record: arrays of one length, times rising. Displacement, if there, gives the release.
    impacts:
        How many impacts are fitted. Of a driven run, which is no drop test, take one.
    law:
        ``"spring-dashpot"``, ``"hertz"``, ``"hunt-crossley"``, ``"lankarani-nikravesh"``, ``"flores"``, or several.
    misfit:
        ``"force"`` (the whole force) and ``"peaks"`` (the chapter's).
    gain_percent, release_height_percent, clock_percent:
        How uncertain the sensor's gain, the release and the clock of the samples are: standard deviations, %.

    Returns
    -------
    Identification
        ``fits``: one for each law and misfit, with ``parameters`` (key, value, low, high), ``refused`` (the law does not fit),
        ``rms_n`` and a table ``impacts``.

    Raises
    ------
    ValueError
        The record has no impact, or an argument cannot be used.
    """
    return Identification(_native.identify(locals()))


def compare(
    rig: Rig,
    time_s: Iterable[float],
    force_n: Iterable[float] | None = None,
    displacement_mm: Iterable[float] | None = None,
    cart_mm: Iterable[float] | None = None,
    *,
    ratio: float | None = None,
    frequency_hz: float | None = None,
    gap_mm: float | None = None,
    cart: Cart | None = None,
    frame: Literal["fixed", "relative"] = "fixed",
    start: Start = "rest",
    cycles: int = 600,
    transient: int = 480,
    engine: Literal["event", "switch"] = "event",
    precision: Literal["f32", "f64"] | None = None,
    tick_us: float | None = None,
) -> Comparison:
    """A record beside its simulation: both motions, and the errors.

    Parameters
    ----------
    time_s, force_n, displacement_mm, cart_mm:
        The record: arrays of one length, times rising; force or displacement of the hammer, or both, and the cart's motion
        if it was measured.
    ratio, frequency_hz:
        The drive frequency, as in :func:`simulate`; found from the record if left out.
    frame:
        The measured displacement is in the ``"fixed"`` frame or ``"relative"`` to the cart.

    The other arguments are those of :func:`simulate`.

    Returns
    -------
    Comparison
        Errors of displacement, force, contacts and contact time, and a table ``rows`` with both motions at each sample.
    """
    return Comparison(_native.compare(locals()))


def modes(
    rig: Rig,
    *,
    ratio: Numbers | None = None,
    frequency_hz: Numbers | None = None,
    gap_mm: float | None = None,
    cart: Cart | None = None,
    modes: Sequence[int] = (1, 2, 3, 5),
    springs_mass: float = 0.1,
    tip: Literal["guided", "free"] = "guided",
    cycles: int = 600,
    transient: int = 480,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Modes:
    """Beam springs that bend in several modes: force, swing, and where the energy goes.

    Parameters
    ----------
    modes:
        Numbers of bending modes to keep, up to 8; each is run at each frequency.
    springs_mass:
        Mass of the springs over the hammer's (assumed: the chapter gives none).
    tip:
        How the hammer holds the springs' end: it cannot turn (``"guided"``), or turns with it (``"free"``).

    The other arguments are those of :func:`sweep`.

    Returns
    -------
    Modes
        Tables ``modes`` (a row for each bending mode) and ``rows`` (a row for each frequency and number of modes).
    """
    return Modes(_native.modes(locals()))


def drill(
    rig: Rig,
    *,
    threshold_n: float,
    ground_stiffness_n_per_m: float | None = None,
    ground_damping_n_s_per_m: float | None = None,
    threshold_percent: float = 20.0,
    ground_stiffness_percent: float = 20.0,
    bit_mass_kg: float | None = None,
    bit_stiffness_n_per_m: float | None = None,
    bit_damping_n_s_per_m: float | None = None,
    bit_feed_force_n: float | None = None,
    feed: Literal["cart", "ground", "steady"] | float = "cart",
    ratio: Numbers | None = None,
    frequency_hz: Numbers | None = None,
    gap_mm: float | None = None,
    cart: Cart | None = None,
    settle: int = 300,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Drill:
    """Rate of penetration over frequency on ground that gives way at ``threshold_n``.

    Parameters
    ----------
    threshold_n:
        Contact force at which the ground gives way, N.
    ground_stiffness_n_per_m, ground_damping_n_s_per_m:
        The ground before it does; the rig's contact if left out.
    threshold_percent, ground_stiffness_percent:
        Half-widths of their uncertainty.
    bit_mass_kg:
        Mass of a bit between hammer and ground, kg; no bit if left out.
    bit_stiffness_n_per_m, bit_damping_n_s_per_m, bit_feed_force_n:
        The hammer's contact with the bit (the rig's contact if left out), and the static force that presses it on the ground
        (its weight).
    feed:
        How the gap is kept: ``"cart"`` (each period the cart is moved on by what was dug), ``"ground"`` (the ground is brought
        back), ``"steady"`` (at the mean speed of the last period), or a speed in mm/s, at which the gap sets itself.
    settle:
        Drive cycles in which a run may settle.

    The other arguments are those of :func:`sweep`.

    Returns
    -------
    Drill
        ``rows``: a table with a row for each frequency; ``advice``: the best 1/1 and how far it moves over the uncertainty.

    Raises
    ------
    ValueError
        An argument cannot be used, or the ground holds at every frequency.
    KeyboardInterrupt
        On Ctrl-C.

    Notes
    -----
    The ground is the drifting oscillator of Pavlovskaia, Wiercigroch and Grebogi (Physical Review E 64, 056224, 2001).
    """
    return Drill(_native.drill(locals()))


def emulate(
    scenario: str = "field",
    *,
    toml: str | None = None,
    samples_per_second: int = 1000,
    progress: Progress | None = None,
) -> Emulation:
    """Runs the board's controller in a closed loop with an emulated rig.

    Parameters
    ----------
    scenario:
        A built-in scenario (:func:`scenarios`) or a scenario file.
    toml:
        The text of a scenario; ``scenario`` is then only its name.
    samples_per_second:
        Samples of the true motion that are kept, at most 20000; 0 keeps none.
    progress:
        As in :func:`sweep`; the steps are the blocks of samples that the controller is given, 2000 for a second of the rig.

    Returns
    -------
    Emulation
        The verdict as ``host-sim emulate --format json`` has it; tables ``samples`` (true motion, state, drive frequency),
        ``contact_list`` and ``timeline``.

    Raises
    ------
    ValueError
        There is no such scenario, or it cannot be used.
    KeyboardInterrupt
        On Ctrl-C.
    """
    return Emulation(_native.emulate(locals()))


def scenarios() -> dict[str, str]:
    """The built-in scenarios: names and descriptions."""
    return dict(_native.scenarios())


def trials(
    rig: Rig | None = None,
    *,
    count: int | None = None,
    seconds: float | None = None,
    long: bool = False,
    seed: int = 1,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Trials | LongTrials:
    """Runs the board's controller on many rigs that differ at random from its settings: time to Hold, and force.

    Parameters
    ----------
    rig:
        The rig that the settings describe; the four presets in turn if left out.
    count, seconds:
        Number of trials, and rig time of each; 200 of 60 s if left out, with ``long`` 40 of 600 s after the start.
    long:
        The rigs drift during each trial: natural frequency, a sensor's delay, each sensor's gain.
    seed:
        Seed of the random numbers.
    threads, progress:
        As in :func:`sweep`; the steps are the trials.

    Returns
    -------
    Trials or LongTrials
        Tables ``trials`` (a row for each) and ``distributions`` (each rig, then all); with ``long`` ``campaign`` in its place.
    """
    return (Trials if not long else LongTrials)(_native.trials(locals()))
