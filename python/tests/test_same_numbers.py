"""Every function gives the command line's numbers, to the bit."""

import math

import numpy as np
import pytest
import vibroimpact as vi

WIRES = vi.Rig("wires")


def same(found, expected, path=""):
    """Whether everything in the command line's answer is in ours, equal to the bit."""
    if isinstance(expected, dict):
        for key, value in expected.items():
            if key == "made_from":
                continue
            assert key in found, f"{path}.{key} is missing"
            same(found[key], value, f"{path}.{key}")
    elif isinstance(expected, list):
        assert len(found) == len(expected), path
        for i, (a, b) in enumerate(zip(found, expected)):
            same(a, b, f"{path}[{i}]")
    elif expected is None:
        assert found is None or math.isnan(found), f"{path} is {found}"
    else:
        assert found == expected, f"{path} is {found!r}, not {expected!r}"


def same_rows(table, rows):
    assert table.rows == len(rows)
    for i, row in enumerate(rows):
        same(table.row(i), row, f"row {i}")


def rows_of(answer):
    """The rows of an answer that is a list, or a list with what it was made from beside it."""
    if isinstance(answer, list):
        return answer
    return answer.get("rows", answer.get("answer"))


def test_simulate(host_sim):
    same(vi.simulate(WIRES, ratio=2.7, gap_mm=2.4), host_sim("simulate", "--ratio", 2.7, "--gap", 2.4))


def test_simulate_from_a_start_with_the_switch_engine(host_sim):
    found = vi.simulate(
        WIRES, frequency_hz=3.7, gap_mm=0.5, cart="prescribed", start=(-1.0, 0.05), cycles=200, transient=100, engine="switch"
    )
    same(
        found,
        host_sim(
            "simulate", "--frequency", 3.7, "--gap", 0.5, "--initial=-1,0.05", "--cycles", 200, "--transient", 100,
            "--engine", "switch", "--cart", "prescribed",
        ),
    )


def test_simulate_with_a_cart_that_recoils(host_sim):
    found = vi.simulate(WIRES, ratio=2.02, gap_mm=0.0, cart="recoil")
    same(found, host_sim("simulate", "--ratio", 2.02, "--gap", 0, "--cart", "recoil"))


@pytest.mark.parametrize("direction", ["rest", "up", "down"])
def test_sweep(host_sim, direction):
    ratio = np.arange(1.0, 1.5001, 0.05)
    found = vi.sweep(WIRES, ratio=ratio, gap_mm=1.0, direction=direction, cycles=120, transient=100)
    expected = host_sim(
        "sweep", "--ratio", "1:1.5:0.05", "--gap", 1, "--direction", direction, "--cycles", 120, "--transient", 100
    )
    same_rows(found, rows_of(expected))


def test_pick(host_sim):
    found = vi.pick(WIRES, samples=8)
    expected = host_sim("pick", "--samples", 8)
    same(found, expected)
    assert found.force_ratio == expected["force_ratio"]


def test_pick_with_limits_and_a_prescribed_cart(host_sim):
    found = vi.pick(
        WIRES.replace(mass_kg=0.35), cart="prescribed", amplitude_percent=3, samples=4, seed=7, max_force_n=80
    )
    same(
        found,
        host_sim(
            "pick", "--set", "mass_kg=0.35", "--cart", "prescribed", "--amplitude-percent", 3, "--samples", 4, "--seed", 7,
            "--max-force-n", 80,
        ),
    )


def test_map(host_sim):
    found = vi.map(WIRES, gap_mm=np.arange(0, 1.01, 0.25), ratio=np.arange(1.5, 2.51, 0.1))
    [expected] = host_sim("map", "--gap", "0:1:0.25", "--ratio", "1.5:2.5:0.1")["maps"]
    assert found.shape == (5, 11)
    same(found.summary, expected["summary"])
    same(list(found.gap_mm), expected["gaps_mm"])
    same(list(found.frequency_hz), expected["frequencies_hz"])
    for layer, values in expected["layers"].items():
        same(list(found[layer].ravel()), values, layer)


def test_basins(host_sim):
    found = vi.basins(WIRES, ratio=2.02, gap_mm=1.0, grid=(12, 9), samples=20)
    expected = host_sim("basins", "--ratio", 2.02, "--gap", 1, "--grid", "12x9", "--samples", 20)
    assert found.impact.shape == (9, 12)
    same(found, expected)


def test_bifurcation(host_sim):
    found = vi.bifurcation(WIRES, ratio=np.arange(1.4, 1.8001, 0.02), gap_mm=2.4, direction="all")
    expected = host_sim("bifurcation", "--ratio", "1.4:1.8:0.02", "--gap", 2.4, "--direction", "all")
    for one in expected["diagrams"]:
        one.pop("measured_displacement_mm")
        one.pop("measured_force_n")
    expected.pop("section")
    same(found, expected)


def test_orbits(host_sim):
    found = vi.orbits(WIRES, ratio=(1.8, 2.6), gap_mm=0.5, periods=1, impacts=1, starts=5, checks=0)
    expected = host_sim(
        "orbits", "--ratio", "1.8:2.6", "--gap", 0.5, "--periods", 1, "--impacts", 1, "--starts", 5, "--checks", 0,
        "--behind", 0,
    )
    same_rows(found.orbits, expected.pop("orbits"))
    same_rows(found.special_points, expected.pop("special_points"))
    same(found, expected)


@pytest.mark.parametrize("drive", [{"ratio": (2.3, 2.8)}, {"ratio": 2.6, "curve": {"mass_kg": (0.25, 0.35, "log")}}], ids=["one", "two"])
def test_orbits_over_two_parameters(host_sim, drive):
    curve = {"gap_mm": (0, 0.5), **drive.pop("curve", {})}
    found = vi.orbits(WIRES, **drive, curve=curve, periods=1, impacts=1, starts=3, searches=2)
    ratio = "2.6" if drive["ratio"] == 2.6 else "2.3:2.8"
    both = ["--curve", "mass_kg=0.25:0.35:log"] if len(curve) == 2 else []
    expected = host_sim(
        "orbits", "--curve", "gap_mm=0:0.5", *both, "--ratio", ratio, "--periods", 1, "--impacts", 1, "--starts", 3, "--searches", 2
    )
    assert found.points.rows > 0
    for name in ["curves", "codimension_two", "points"]:
        same_rows(found[name], expected.pop(name))
    same(found, expected)


def test_poincare_and_lyapunov(host_sim):
    found = vi.poincare(WIRES, ratio=2.7, gap_mm=2.4, points=200, transient=50)
    exponents = vi.lyapunov(WIRES, ratio=2.7, gap_mm=2.4, periods=200, transient=50)
    expected = host_sim(
        "poincare", "--ratio", 2.7, "--gap", 2.4, "--points", 200, "--transient", 50, "--lyapunov"
    )
    same(exponents, expected.pop("lyapunov"))
    assert exponents.meaning == expected.pop("meaning")
    same(found, expected)


def test_contact(host_sim):
    same_rows(vi.contact(WIRES, speed_m_per_s=[0.1, 0.2]), rows_of(host_sim("contact", "--speed", "0.1:0.2:0.1")))


def test_drop_and_identify(host_sim, tmp_path):
    record = vi.drop(WIRES, noise_n=0.2, seed=3)
    same_rows(record, rows_of(host_sim("drop", "--noise-n", 0.2, "--seed", 3)))
    file = tmp_path / "drop.csv"
    lines = zip(record.time_s, record.force_n, record.displacement_mm)
    file.write_text("time_s,force_n,displacement_mm\n" + "".join(f"{t!r},{f!r},{d!r}\n" for t, f, d in lines)
                    .replace("np.float64(", "").replace(")", ""))
    found = vi.identify(WIRES, record.time_s, record.force_n, record.displacement_mm, misfit="force")
    expected = host_sim("identify", file, "--misfit", "force")
    expected.pop("file")
    for fit, other in zip(found.fits, expected["fits"]):
        same_rows(fit.impacts, other.pop("impacts"))
    same(found, expected)


def test_compare(host_sim, tmp_path):
    run = vi.simulate(WIRES, ratio=2.02, gap_mm=0.1, samples_per_period=400, cycles=604, transient=600).history
    file = tmp_path / "record.csv"
    lines = zip(run.time_s.tolist(), run.force_n.tolist(), run.displacement_mm.tolist())
    file.write_text("time_s,force_n,displacement_mm\n" + "".join(f"{t!r},{f!r},{d!r}\n" for t, f, d in lines))
    found = vi.compare(WIRES, run.time_s, run.force_n, run.displacement_mm, ratio=2.02, gap_mm=0)
    expected = host_sim("compare", file, "--ratio", 2.02, "--gap", 0)
    assert expected.pop("notes") is not None
    same(found, expected)
    assert found.rows.rows == found.samples == len(run.time_s) and found.displacement_rms_mm > 0


def test_modes(host_sim):
    found = vi.modes(vi.Rig("beam-170"), ratio=2, modes=[1, 3])
    expected = host_sim("modes", "--rig", "beam-170", "--ratio", 2, "--modes", "1,3")
    same_rows(found.modes, expected["modes"])
    same_rows(found.rows, expected["rows"])


def test_drill(host_sim):
    found = vi.drill(WIRES, threshold_n=25, ratio=np.arange(1.9, 2.3001, 0.1))
    expected = host_sim("drill", "--threshold-n", 25, "--ratio", "1.9:2.3:0.1")
    same_rows(found.rows, expected["rows"])
    same(found.advice, expected["advice"])
    assert (found.feed, found.bit) == (expected["feed"], expected["bit"]) == ("cart", None)


def test_drill_with_a_bit_that_is_fed_by_its_own_speed(host_sim):
    bit = dict(bit_mass_kg=0.3, bit_feed_force_n=2, feed=0.02, settle=10, threshold_percent=0, ground_stiffness_percent=0)
    found = vi.drill(vi.Rig("beam-170"), threshold_n=50, cart="prescribed", ratio=2.08, **bit)
    options = [word for key, value in bit.items() for word in ("--" + key.replace("_", "-"), value)]
    expected = host_sim("drill", "--rig", "beam-170", "--threshold-n", 50, "--cart", "prescribed", "--ratio", 2.08, *options)
    same_rows(found.rows, expected["rows"])
    same(found.advice, expected["advice"])
    same(found.bit, expected["bit"])
    assert found.feed == expected["feed"] == "0.02 mm/s"


@pytest.mark.parametrize("long", [False, True])
def test_trials(host_sim, long):
    found = vi.trials(WIRES, count=2, seconds=20, long=long, seed=3)
    expected = host_sim("trials", "--rig", "wires", "--count", 2, "--seconds", 20, "--seed", 3, *(["--long"] if long else []))
    same_rows(found.trials, expected.pop("trials"))
    if not long:
        same_rows(found.distributions, expected.pop("distributions"))
    same(found, expected)


def test_emulate(host_sim):
    text = vi.emulate("sensor-open", samples_per_second=0)
    same(text, host_sim("emulate", "sensor-open"))
