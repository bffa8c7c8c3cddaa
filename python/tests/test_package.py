"""Rigs, errors, progress, interruption, threads, tables, and what travels to other processes."""

import pickle
import signal
import threading
import time
import typing

import numpy as np
import pytest
import vibroimpact as vi

WIRES = vi.Rig("wires")


def test_a_rig_has_its_parameters_with_units_in_their_names():
    rig = vi.Rig("beam-170", mass_kg=0.5, gap_mm=1.0)
    assert rig.mass_kg == 0.5 and rig.parameters["gap_mm"] == 1.0
    assert repr(rig) == "Rig(\"beam-170\", mass_kg=0.5, gap_mm=1.0)"
    again = eval(repr(rig), {"Rig": vi.Rig})
    assert again == rig and len({again, rig}) == 1 and len({again, WIRES}) == 2
    assert {"mass_kg", "gap_mm", "to_toml"} <= set(dir(rig))
    assert rig.replace(mass_kg=0.6).mass_kg == 0.6 and rig.mass_kg == 0.5
    assert vi.presets() == ["wires", "beam-170", "beam-150", "beam-135"]


def test_a_rig_reads_its_own_file_and_a_text(tmp_path):
    rig = vi.Rig("wires", mass_kg=0.3)
    file = tmp_path / "mine.toml"
    file.write_text(rig.to_toml())
    assert vi.Rig(str(file)).parameters == rig.parameters
    assert vi.Rig(str(file)).name == "mine"
    assert vi.Rig.from_toml(rig.to_toml(), "mine").parameters == rig.parameters


def test_a_rig_travels_to_another_process_without_its_file(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text('preset = "wires"\nmass_kg = 0.3\n[uncertainty]\nmass_percent = 1\n')
    rig = vi.Rig(str(file), gap_mm=0.1)
    sent = pickle.dumps(rig)
    file.unlink()
    assert pickle.loads(sent) == rig


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: vi.Rig("wire"), ["wire", "wires"]),
        (lambda: vi.Rig("wires", mass_kg=-1), ["mass_kg", "-1"]),
        (lambda: vi.Rig("wires", mass=1), ["mass"]),
        (lambda: vi.Rig("no/such/file.toml"), ["no/such/file.toml"]),
        (lambda: vi.Rig.from_toml("mass_kg = "), ["line 1"]),
        (lambda: vi.simulate(WIRES), ["ratio", "frequency_hz"]),
        (lambda: vi.simulate(WIRES, ratio=2, frequency_hz=3), ["ratio", "frequency_hz"]),
        (lambda: vi.simulate(WIRES, ratio=float("nan")), ["NaN"]),
        (lambda: vi.simulate(WIRES, ratio=2, start="up"), ["start", "up"]),
        (lambda: vi.simulate(WIRES, ratio=2, start=(float("inf"), 0)), ["start"]),
        (lambda: vi.simulate(WIRES, ratio=2, start=(1,)), ["start", "(1,)"]),
        (lambda: vi.simulate(WIRES, ratio=2, tick_us=5), ["tick_us", "switch"]),
        (lambda: vi.map(WIRES, engine="reference", tick_us=5), ["tick_us", "switch"]),
        (lambda: vi.simulate(WIRES, ratio=2, cart="loose"), ["cart", "loose"]),
        (lambda: vi.simulate(WIRES, ratio=2, cycles=10, transient=10), ["transient", "10"]),
        (lambda: vi.simulate(WIRES, ratio=2, cycles=-1), ["cycles", "-1"]),
        (lambda: vi.sweep(WIRES, ratio=[2, 1]), ["ratio", "rising"]),
        (lambda: vi.sweep(WIRES, ratio=[]), ["ratio", "empty"]),
        (lambda: vi.sweep(WIRES, ratio=[2], threads=0), ["threads", "0"]),
        (lambda: vi.map(WIRES, gap_mm=[0, 500], ratio=[2]), ["gap"]),
        (lambda: vi.map(WIRES, gap_mm=[0], ratio=[2], recorded=0), ["recorded"]),
        (lambda: vi.pick(WIRES, nominal=True, mass_percent=1), ["nominal", "mass_percent"]),
        (lambda: vi.pick(WIRES, mass_percent=-1), ["mass_percent", "-1"]),
        (lambda: vi.pick(WIRES, max_force_n=-1), ["max_force_n", "-1"]),
        (lambda: vi.pick(WIRES, max_force_n=1e-3, samples=1), ["max_force_n"]),
        (lambda: vi.pick(WIRES, samples=100_001), ["samples", "100000"]),
        (lambda: vi.basins(WIRES, ratio=2, displacement_mm=(1, -1)), ["displacement"]),
        (lambda: vi.basins(WIRES, ratio=2, samples=1_000_001), ["samples", "1000000"]),
        (lambda: vi.basins(WIRES, ratio=2, grid=2.5), ["grid", "2.5"]),
        (lambda: vi.bifurcation(WIRES, recorded=0), ["recorded", "300"]),
        (lambda: vi.orbits(WIRES, periods=9), ["periods is 9", "8"]),
        (lambda: vi.poincare(WIRES, ratio=2, points=0), ["points is 0", "from 1 to 10000000"]),
        (lambda: vi.poincare(WIRES, ratio=2, phases_turns=[0, 1.5]), ["phases_turns", "1.5"]),
        (lambda: vi.drop(WIRES, impacts=0), ["impacts is 0, must be from 1 to 100"]),
        (lambda: vi.drop(WIRES, release_mm=-2000), ["release_mm is -2000, must be from -1000 to 1000"]),
        (lambda: vi.identify(WIRES, range(30), [0] * 30, clock_percent=60), ["clock_percent is 60, must be from 0 to 50"]),
        (lambda: vi.identify(WIRES, [0, 1], [0, 0]), ["time_s", "2"]),
        (lambda: vi.identify(WIRES, range(30), [0] * 29), ["force_n", "29", "30"]),
        (lambda: vi.emulate("nowhere"), ["nowhere"]),
        (lambda: vi.trials(seconds=5), ["seconds is 5", "20 to 3600"]),
        (lambda: vi.orbits(WIRES, curve={"gap": (0, 3)}), ["curve", "gap_mm"]),
        (lambda: vi.orbits(WIRES, curve={"gap_mm": (3, 0)}), ["curve: gap_mm", "rising"]),
        (lambda: vi.orbits(WIRES, curve={"gap_mm": (0, 3, "log")}), ["curve: gap_mm", "positive"]),
        (lambda: vi.orbits(WIRES, curve={"damping_ratio": (0, 0.1)}), ["curve", "damping_ratio"]),
        (lambda: vi.orbits(WIRES, curve={"mass_kg": (0.2, 0.4), "gap_mm": (0, 1)}), ["ratio or frequency_hz"]),
        (lambda: vi.orbits(WIRES, curve={}), ["one or two"]),
        (lambda: vi.orbits(WIRES, curve={"gap_mm": (0, 3)}, searches=10**9), ["searches", "200"]),
        (lambda: vi.orbits(WIRES, curve={"gap_mm": (0, 3)}, along="gap"), ["along"]),
        (lambda: vi.emulate(samples_per_second=10**6), ["samples_per_second"]),
        (lambda: vi.drill(WIRES, threshold_n=-5), ["-5"]),
        (lambda: vi.drill(WIRES, threshold_n=25, threshold_percent=120), ["threshold_percent", "120"]),
        (lambda: vi.drill(WIRES, threshold_n=25, bit_feed_force_n=2), ["bit_feed_force_n", "bit_mass_kg"]),
        (lambda: vi.drill(WIRES, threshold_n=25, feed="slow"), ["feed", "slow"]),
    ],
)
def test_a_mistake_is_a_value_error_that_names_the_argument(call, words):
    with pytest.raises(ValueError) as error:
        call()
    message = str(error.value)
    assert all(word in message for word in words), message
    assert "--" not in message and "\n" not in message, message


def test_a_wrong_type_or_name_is_a_type_error_that_names_the_argument():
    with pytest.raises(TypeError, match="argument 'cycles'"):
        vi.simulate(WIRES, ratio=2, cycles="many")
    with pytest.raises(TypeError, match="cyclez"):
        vi.map(WIRES, cyclez=3)
    assert vi.basins(WIRES, ratio=2.02, grid=np.int64(3), samples=0).shape == (3, 3)


def test_progress_is_told_from_the_calling_thread_and_ends_at_all():
    seen = []
    vi.map(
        WIRES, gap_mm=np.linspace(0, 1, 8), ratio=np.linspace(1, 3, 300),
        progress=lambda done, steps: seen.append((done, steps, threading.get_ident())),
    )
    assert seen[-1][:2] == (2400, 2400)
    assert {thread for *_, thread in seen} == {threading.get_ident()}
    assert [done for done, *_ in seen] == sorted(done for done, *_ in seen)


def test_what_a_progress_callback_raises_ends_the_work():
    def give_up(done, steps):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        vi.basins(WIRES, ratio=2.02, gap_mm=1, grid=400, progress=give_up)


@pytest.mark.parametrize(
    "work",
    [
        lambda: vi.map(WIRES, engine="reference"),
        lambda: vi.emulate("softening"),
        lambda: vi.trials(count=1000),
        lambda: vi.orbits(WIRES, curve={"gap_mm": (0, 3)}, searches=200),
    ],
    ids=["map", "emulate", "trials", "curves"],
)
def test_ctrl_c_interrupts_and_the_interpreter_runs_meanwhile(work):
    began = time.monotonic()
    ran = threading.Event()

    timer = threading.Timer(0.3, lambda: (ran.set(), signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)))
    # A shell that starts the tests in the background leaves them deaf to it.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    timer.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            work()
    finally:
        signal.signal(signal.SIGINT, before)
    assert ran.is_set()
    assert time.monotonic() - began < 120


def test_an_emulated_run_tells_how_far_it_is():
    told = []
    vi.emulate("sensor-open", samples_per_second=0, progress=lambda done, steps: told.append((done, steps)))
    steps = {steps for _, steps in told}
    assert len(steps) == 1 and told == sorted(told) and told[-1] == (max(steps), max(steps))


def test_the_numbers_do_not_depend_on_threads():
    keywords = dict(gap_mm=np.linspace(0, 2, 30), ratio=np.linspace(1, 4, 150))
    one, many = vi.map(WIRES, threads=1, **keywords), vi.map(WIRES, threads=3, **keywords)
    assert all(one[layer].tobytes() == many[layer].tobytes() for layer in one.layers)


def test_records_travel_and_print():
    found = vi.map(WIRES, gap_mm=[0.0, 0.5], ratio=[1.9, 2.0, 2.1])
    again = pickle.loads(pickle.dumps(found))
    assert again.shape == (2, 3) and again == found
    assert again != vi.map(WIRES, gap_mm=[0.0, 0.5], ratio=[1.9, 2.0, 2.2])
    assert "2 x 3 cells" in repr(found)
    assert "data:image/png" in found._repr_html_() and "gap_mm 0 to 0.5" in found._repr_html_()
    assert vi.sweep(WIRES, ratio=[1.9, 2.0], cycles=60, transient=40)._repr_html_().count("<circle") == 2
    run = vi.simulate(WIRES, ratio=2.02, gap_mm=0.0, samples_per_period=20)
    assert pickle.loads(pickle.dumps(run)) == run
    assert "regime='1/1'" in repr(run) and "<td>regime</td><td>1/1</td>" in run._repr_html_()
    assert run.section._repr_html_().count("<tr>") == 11 and "120 rows" in run.section._repr_html_()
    with pytest.raises(AttributeError, match="there is no field"):
        run.nothing


def answers_of(rig):
    """An answer of each function that returns no bare table."""
    yield vi.simulate(rig, ratio=2.02, cycles=60, transient=40)
    yield vi.pick(rig, samples=0)
    yield vi.bifurcation(rig, ratio=[1.8, 2.0], gap_mm=0.0, cycles=60, recorded=20)
    found = {"starts": 4, "periods": 1, "impacts": 1}
    yield vi.orbits(rig, ratio=[1.9, 2.1], gap_mm=0.0, **found)
    yield vi.orbits(rig, ratio=[1.9, 2.9], curve={"gap_mm": (0.0, 0.2)}, searches=2, **found)
    yield vi.poincare(rig, ratio=2.0, points=20, transient=50)
    yield vi.lyapunov(rig, ratio=2.0, periods=100, transient=50)
    record = vi.drop(rig)
    yield vi.identify(rig, record.time_s, record.force_n, misfit="force")
    run = vi.simulate(rig, ratio=2.02, cycles=304, transient=300, samples_per_period=2000)
    yield vi.compare(rig, run.history.time_s, run.history.force_n, ratio=2.02)
    yield vi.compare(rig, run.history.time_s, displacement_mm=run.history.displacement_mm, ratio=2.02)
    yield vi.drill(rig, threshold_n=25, ratio=[1.8, 2.0])
    yield vi.trials(rig, count=1, seconds=20)
    yield vi.trials(rig, count=1, seconds=20, long=True)
    yield vi.emulate("two seconds", toml=f'duration_s = 2\n[true_rig]\npreset = "{rig.name}"\n', samples_per_second=10)
    if rig.name != "wires":
        yield vi.modes(rig, ratio=[1.8], cycles=60, transient=40, modes=[1, 2])


@pytest.mark.parametrize("rig", ["wires", "beam-170"])
def test_the_types_of_answers_are_stated(rig):
    for found in answers_of(vi.Rig(rig)):
        assert type(found) is not vi.Record
        kinds = typing.get_type_hints(type(found))
        assert kinds.keys() == set(found)
        for name, kind in kinds.items():
            allowed = typing.get_args(kind) if typing.get_origin(kind) is typing.Union else (kind,)
            assert isinstance(found[name], tuple(typing.get_origin(one) or one for one in allowed)), name


@pytest.mark.parametrize("options", [{}, {"engine": "switch", "tick_us": 20.0, "cart": "prescribed"}])
def test_a_history_is_evenly_spaced_and_a_record_like_any_other(options):
    cycles, samples = 4, 20_000 if not options else 13_000
    run = vi.simulate(WIRES, ratio=2.02, gap_mm=0.0, cycles=300, transient=300 - cycles, samples_per_period=samples, **options)
    history = run.history
    assert history.time_s.shape == history.force_n.shape == (cycles * samples,)
    step = 1 / (run.frequency_hz * samples)
    slack = 1e-9 if not options else 20e-6
    assert np.abs(np.diff(history.time_s) - step).max() <= slack
    # The mean force is the impulse of the contacts over the time, which uneven rows would not give.
    assert history.force_n.mean() == pytest.approx(run.contacts.impulse_n_s.mean() * run.frequency_hz, rel=0.02)


def test_identify_takes_the_history_of_a_run():
    run = vi.simulate(WIRES, ratio=2.02, gap_mm=0.0, cart="prescribed", cycles=304, transient=300, samples_per_period=20_000)
    record = (WIRES, run.history.time_s, run.history.force_n)
    fit = vi.identify(*record, misfit="force", gap_mm=0.0, impacts=1).fits[0]
    values = {one["key"]: one["value"] for one in fit.parameters}
    assert values["contact_stiffness_n_per_m"] == pytest.approx(5.5e6, rel=0.005) and not fit.refused
    assert values["contact_damping_n_s_per_m"] == pytest.approx(1200, rel=0.005)
    # The blows of a driven run are all alike: together they are no drop test, and it says so.
    assert vi.identify(*record, misfit="force", gap_mm=0.0).fits[0].refused


def test_tables_become_pandas_and_xarray():
    pandas = pytest.importorskip("pandas")
    xarray = pytest.importorskip("xarray")
    table = vi.sweep(WIRES, ratio=[1.9, 2.0], cycles=60, transient=40)
    assert list(table.to_pandas().columns) == list(table)
    assert isinstance(table.to_xarray(), xarray.Dataset)
    found = vi.map(WIRES, gap_mm=[0.0, 0.5], ratio=[1.9, 2.0, 2.1])
    frame, cube = found.to_pandas(), found.to_xarray()
    assert isinstance(frame, pandas.DataFrame) and len(frame) == 6
    assert frame.force_n[4] == found.force_n[1, 1] == cube.force_n.values[1, 1]
    assert cube.sizes == {"gap_mm": 2, "frequency_hz": 3} and cube.attrs["rig"] == "wires"
    assert cube.source == table.to_xarray().source == f"vibroimpact {vi.__version__}"
    assert (cube.gap_mm.units, cube.frequency_hz.units, cube.force_n.units) == ("mm", "Hz", "N")


def test_an_emulated_run_has_its_motion_and_its_events():
    run = vi.emulate("sensor-open", samples_per_second=100)
    assert run.verdict == "pass" and run.final_state
    assert run.samples.true_force_n.max() > 0 and run.timeline.rows > 3
    assert "field" in vi.scenarios()
