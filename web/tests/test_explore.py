"""The part "Explore": every control is used, and its numbers are the command line's."""

import csv
import io
import json
import os
import pathlib
import re
import struct
import zlib
from xml.etree import ElementTree

import pytest

from conftest import PAGE, host_json, host_rows, host_sim

SHOTS = pathlib.Path(os.environ["SHOTS"])

# Most numbers come from adaptive integration whose steps a last digit of `powf` may move; WebAssembly has its own `powf`, and
# no fused multiply-add. The engine's own tolerance is some 1e-9.
SAME = 1e-7


def shot(opened, name):
    SHOTS.mkdir(exist_ok=True)
    opened.page.screenshot(path=SHOTS / f"{name}.png", full_page=True)


def alike(a, b, within=SAME, at="", seen=None):
    """Whether two answers are the same, numbers within a share of themselves; the largest difference."""
    seen = [0.0, ""] if seen is None else seen
    if isinstance(a, float) or isinstance(b, float):
        # A change of the optimum in percent is a small difference of two optima, each found to some 1e-9.
        size = 1.0 if at.endswith("_percent") else 1e-9
        assert a is not None and b is not None, f"{at}: {a} {b}"
        share = abs(a - b) / max(abs(a), abs(b), size)
        assert share <= within, f"{at}: {a} {b}"
        seen[:] = max(seen, [share, at])
    elif isinstance(a, dict):
        for key in b:
            if key in a:
                alike(a[key], b[key], within, f"{at}.{key}", seen)
    elif isinstance(a, list):
        assert len(a) == len(b), at
        for number, pair in enumerate(zip(a, b)):
            alike(*pair, within, f"{at}[{number}]", seen)
    else:
        assert a == b, f"{at}: {a} {b}"
    return f"{seen[0]:.1e} ({seen[1].lstrip('.')})"


def unfold(opened):
    """Opens every group of parameters, which are folded at first."""
    for folded in opened.page.locator(".controls details > summary").all():
        folded.click()


def set_number(opened, key, value):
    field = opened.page.locator(f"[data-number={key}]")
    if not field.is_visible():
        opened.page.locator(f"details:has([data-number={key}]) > summary").click()
    field.fill(str(value))
    field.press("Enter")


def test_the_file_is_small_and_needs_nothing_else(opened):
    assert PAGE.stat().st_size < 3_000_000
    page = opened("#explore?detail=coarse")
    page.idle()
    outside = [url for url in page.asked if not url.startswith(("file:", "blob:", "data:"))]
    assert not outside and not page.said


def test_first_paint_first_map_and_a_move(opened):
    page = opened(width=1280, height=900)
    page.page.evaluate("""() => {
      window.shifts = [];
      new PerformanceObserver((list) => shifts.push(...list.getEntries().map((one) => one.value))).observe({ type: "layout-shift" });
    }""")
    page.idle()
    page.page.wait_for_selector(".explore[data-finest]")
    paint = page.page.evaluate("performance.getEntriesByName('first-contentful-paint')[0].startTime")
    parts = page.page.evaluate("({...document.querySelector('.explore').dataset})")
    first = page.page.locator(".answer").get_attribute("data-first-ms")
    workers = page.page.evaluate("navigator.hardwareConcurrency")
    print(
        f"\npage on {workers} processors: first paint after {paint:.0f} ms, then first recommendation {first} ms,"
        f" map coarse {parts['coarse']} ms, fine {parts['fine']} ms, finest {parts['finest']} ms"
    )
    assert float(parts["coarse"]) <= float(parts["fine"]) <= float(parts["finest"])
    # A move of a slider: the first answer after it takes the grey away.
    page.page.evaluate("""() => {
      const [slider, answer] = [document.querySelector("[data-key=mass_kg]"), document.querySelector(".answer")];
      const [began, before] = [performance.now(), document.querySelector(".headline").textContent];
      window.moved = new Promise((resolve) => new MutationObserver(() => {
        if (document.querySelector(".headline").textContent !== before && !answer.classList.contains("stale")) resolve(performance.now() - began);
      }).observe(answer, { subtree: true, childList: true, attributes: true }));
      slider.value = 0.2;
      slider.dispatchEvent(new Event("input"));
    }""")
    print(f"answer {page.page.evaluate('moved'):.0f} ms after a move of a slider")
    page.idle()
    # Nothing that stood on the screen was pushed away meanwhile.
    assert page.page.evaluate("shifts.reduce((a, b) => a + b, 0)") < 0.02


def test_the_curve_has_the_map_s_axis_and_leads_to_the_motion(opened):
    page = opened("#explore?rig=wires&detail=coarse", width=1280, height=900)
    page.idle()
    ticks = """picture => [picture.getBoundingClientRect().left, ...[...picture.querySelectorAll("text[text-anchor=middle]")].filter((one) => one.textContent.trim() !== "" && Number.isFinite(Number(one.textContent)))
      .map((one) => [one.textContent, Number(one.getAttribute("x")).toFixed(3)])]"""
    curve, plane = page.page.locator(".map .chart"), page.page.locator(".plane svg")
    assert curve.bounding_box()["y"] < plane.bounding_box()["y"]
    seen = []
    for act in [lambda: None, lambda: page.page.get_by_role("button", name="zoom in").click(), lambda: page.page.select_option("#units", "absolute")]:
        act()
        seen.append(curve.evaluate(ticks))
        assert len(seen[-1]) > 3 and seen[-1] == plane.evaluate(ticks)
    assert seen[0] != seen[1] != seen[2]
    # A click takes the motion at that frequency, which both pictures mark.
    page.page.get_by_role("button", name="show the whole plane").click()
    curve.click(position={"x": 250, "y": 100})
    page.page.wait_for_selector(".motion[data-state=shown]")
    post, cross = curve.locator("line.mark").get_attribute("x1"), plane.locator(".cross").get_attribute("d")
    assert abs(float(post) - 11 - float(cross[1:].split(" ")[0])) < 0.01 and abs(float(post) - 250) < 1


@pytest.mark.parametrize("rig,cart", [("wires", "prescribed"), ("beam-150", "recoil")])
def test_the_recommendation_is_the_command_line_s(opened, rig, cart):
    page = opened(f"#explore?rig={rig}&cart={cart}&gap_mm=0.1&detail=coarse")
    page.page.wait_for_selector(".answer[data-state=nominal]")
    found = json.loads(page.saved("save pick as JSON"))
    native = host_json("pick", "--rig", rig, "--cart", cart, "--gap", "0.1", "--nominal")
    made = found.pop("made_from")
    assert made["rig"]["cart"] == cart and made["gap_mm"] == 0.1
    native.pop("made_from", None)
    assert set(native) - set(found) == set()
    print(f"\npick, {rig}, {cart}: largest difference {alike(found, native, within=1e-5)}")
    assert native["why"] in page.page.inner_text("#answer")


def test_the_uncertainty_begins_at_its_button_and_ends_with_the_question(opened):
    page = opened("#explore?rig=wires&cart=prescribed&detail=coarse")
    page.page.wait_for_selector(".answer[data-state=nominal]")
    page.page.click("#uncertain")
    page.page.wait_for_selector("#took:has-text('Computing the corners')")
    assert page.page.is_disabled("#uncertain")
    # Another rig gives it up: its worker is free again.
    page.page.select_option("#preset", "beam-170")
    page.page.wait_for_selector("#uncertain:enabled")
    page.page.wait_for_selector(".answer[data-state=nominal]")
    assert page.page.inner_text("#problem") == "" and not page.said


def test_limits_are_the_command_line_s(opened):
    page = opened("#explore?rig=wires&cart=prescribed&detail=coarse")
    page.page.get_by_text("Limits of the machine").click()
    limit = page.page.locator("[data-limit=max_frequency_hz]")
    limit.fill("3.2")
    limit.press("Enter")
    page.page.wait_for_selector(".beside td:has-text('max_frequency_hz')")
    found = json.loads(page.saved("save pick as JSON"))
    native = host_json("pick", "--rig", "wires", "--cart", "prescribed", "--nominal", "--max-frequency-hz", "3.2")
    alike(found, {k: v for k, v in native.items() if k != "made_from"}, within=1e-5)
    page.page.wait_for_function("location.hash.includes('limit=max_frequency_hz')")


def test_the_motion_is_the_command_line_s(opened):
    page = opened("#explore?rig=wires&cart=prescribed&detail=coarse")
    page.page.wait_for_selector("#take:enabled")
    page.page.click("#take")
    page.page.wait_for_selector(".motion[data-state=shown]")
    field = page.page.locator("#frequency")
    field.fill("4")
    field.press("Enter")
    page.page.wait_for_selector("#motion:has-text('at 4 Hz')")
    found = json.loads(page.saved("save motion as JSON"))
    native = host_json("simulate", "--rig", "wires", "--frequency", "4", "--cart", "prescribed")
    native = native[0] if isinstance(native, list) else native
    native.pop("made_from", None)
    assert native["regime"] == found["regime"] == "1/1"
    print(f"\nsimulate: largest difference {alike(found, native)}")
    orbit = found["orbit"]
    assert orbit["stability"] == "stable" and orbit["modulus"] < 1
    history = list(csv.DictReader(io.StringIO(page.saved("save time-history as CSV").decode())))
    # 360 samples in each of two periods; contacts have more of their own.
    assert len(history) >= 720 and set(history[0]) >= {"time_s", "force_n", "relative_displacement_mm"}
    contacts = json.loads(page.saved("save contacts as JSON"))
    assert len(contacts["rows"]) == 2


def test_other_motions_are_those_of_basins(opened):
    page = opened("#explore?rig=wires&cart=prescribed&gap_mm=2.7&ratio=1.5&detail=coarse")
    page.page.wait_for_selector("#others[data-state=shown]")
    rows = page.page.locator("#others tbody tr")
    shown = [row.split("\t")[:2] for row in rows.all_inner_texts()]
    hz = json.loads(page.saved("save motion as JSON"))["frequency_hz"]
    native = host_json("basins", "--rig", "wires", "--cart", "prescribed", "--frequency", repr(hz), "--gap", "2.7", "--grid", "24x16", "--samples", "0")
    native = native[0] if isinstance(native, list) else native
    assert len(shown) == len(native["attractors"]) > 1
    for (name, share), one in zip(shown, native["attractors"]):
        assert name == one["name"]
        # A start within rounding of a boundary between two motions may end on the other side of it.
        assert abs(float(share.split()[0]) / 100 - one["share"]) <= 2 / (24 * 16)
    button = rows.locator("button").last
    button.click()
    page.page.wait_for_selector("#motion:has-text('from a point of the section')")
    page.page.get_by_role("button", name="from rest again").click()
    page.page.wait_for_selector("#motion:has-text('from rest')")


def test_cells_of_the_map_are_the_command_line_s(opened):
    page = opened("#explore?rig=wires&cart=prescribed&view=1,3,0,2&detail=fine")
    page.page.wait_for_selector(".explore[data-fine]")
    rows = list(csv.DictReader(io.StringIO(page.saved("save map as CSV").decode())))
    ratios = sorted({float(row["frequency_ratio"]) for row in rows})
    gaps = sorted({float(row["gap_mm"]) for row in rows})
    assert len(rows) == len(ratios) * len(gaps) > 3000
    # Every fourth frequency and gap: the native map is one rectangle of equal steps, as the page's lattice.
    some, few = ratios[::4], gaps[::4]
    step = lambda values: (values[-1] - values[0]) / (len(values) - 1)
    native = host_rows(
        "map", "--rig", "wires", "--cart", "prescribed",
        "--ratio", f"{some[0]!r}:{some[-1] + step(some) / 2!r}:{step(some)!r}",
        "--gap", f"{few[0]!r}:{few[-1] + step(few) / 2!r}:{step(few)!r}",
    )
    mine = {(round(float(r["gap_mm"]), 6), round(float(r["frequency_ratio"]), 6)): r for r in rows}
    pairs = [(mine[round(float(n["gap_mm"]), 6), round(float(n["frequency_ratio"]), 6)], n) for n in native]
    # What does not repeat is one: whether chaos seems to shrink over a hundred periods is a matter of rounding.
    kind = lambda row: "does not repeat" if row["regime"] in ("aperiodic", "unsettled") else row["regime"]
    same = [(a, b) for a, b in pairs if kind(a) == kind(b)]
    settled = [(a, b) for a, b in same if b["settled"] == "true"]
    far = max(abs(float(a["force_n"]) - float(b["force_n"])) / max(float(b["force_n"]), 1e-9) for a, b in settled)
    print(f"\nmap: {len(same)} of {len(pairs)} cells have the command line's regime; settled ones differ in force by {far:.1e} at most")
    # Motions that never settle (aperiodic ones) part after some hundred periods by what rounding differs.
    assert len(same) > 0.97 * len(pairs)
    assert far < 1e-3


def test_the_map_moves_by_pointer_keys_and_buttons(opened):
    page = opened("#explore?rig=wires&detail=coarse")
    page.idle()
    plane = page.page.locator(".plane")
    plane.scroll_into_view_if_needed()
    box = plane.bounding_box()
    middle = [box["x"] + box["width"] / 2, box["y"] + box["height"] / 2]
    page.page.mouse.move(*middle)
    assert "gap/A0" in page.page.inner_text("#plane-cell")
    page.page.mouse.wheel(0, -400)
    page.page.wait_for_function("location.hash.includes('view=')")
    zoomed = page.page.url
    page.page.mouse.down()
    page.page.mouse.move(middle[0] + 60, middle[1] + 30, steps=4)
    page.page.mouse.up()
    page.page.wait_for_function("zoomed => location.href !== zoomed", arg=zoomed)
    page.page.get_by_role("button", name="zoom in").click()
    page.page.get_by_role("button", name="zoom out").click()
    page.page.get_by_role("button", name="show the whole plane").click()
    page.page.wait_for_function("!location.hash.includes('view=')")
    page.page.mouse.click(*middle)
    page.page.wait_for_selector(".motion[data-state=shown]")
    said = page.page.inner_text("#motion")
    plane.focus()
    for key in ["ArrowRight", "ArrowUp", "Shift+ArrowLeft", "Shift+ArrowDown", "+", "-"]:
        plane.press(key)
    plane.press("Home")
    plane.press("ArrowRight")
    plane.press("Enter")
    page.page.wait_for_function("said => document.querySelector('#motion').innerText !== said", arg=said)
    assert not page.said


def test_every_parameter_has_a_slider_that_counts(opened):
    page = opened("#explore?rig=wires&detail=coarse")
    page.idle()
    # The usual ones stand open; that one of the others is changed is told while it is folded.
    shown = [slider.get_attribute("data-key") for slider in page.page.locator(".parameter input[type=range]:visible").all()]
    assert shown == ["mass_kg", "natural_frequency_hz", "amplitude_mm", "gap_mm"]
    assert page.page.locator(".controls details.changed").count() == 0
    unfold(page)
    sliders = page.page.locator(".parameter input[type=range]")
    keys = [slider.get_attribute("data-key") for slider in sliders.all()]
    assert {"mass_kg", "amplitude_mm", "gap_mm", "wire_length_mm", "contact_stiffness_n_per_m", "shaker_loop_hz"} <= set(keys)
    for key in keys:
        before = page.page.input_value(f"[data-number={key}]")
        page.page.focus(f"[data-key={key}]")
        # To the left: one of them stands at its right end.
        page.page.keyboard.press("ArrowLeft")
        assert page.page.input_value(f"[data-number={key}]") != before, key
        page.page.wait_for_function("key => new RegExp('(set=|)' + key + '(%3D|=)').test(location.hash)", arg=key)
    page.page.get_by_role("button", name="Back to the rig's own values").click()
    page.page.wait_for_function("!location.hash.includes('set=')")
    set_number(page, "mass_kg", 0.5)
    page.page.wait_for_selector("#rig-notes:has-text('weight 4.90')")
    page.page.select_option("[data-key=torque]", "cosine")
    page.page.wait_for_function("location.hash.includes('torque%3Dcosine')")
    page.page.wait_for_selector(".controls details.changed > summary:has-text('More of the hammer')")
    page.page.select_option("[data-key=contact_law]", "hertz")
    page.page.wait_for_selector("[data-key=contact_exponent]")
    page.page.select_option("#preset", "beam-135")
    page.page.wait_for_selector("[data-key=damping_ratio]")
    page.page.select_option("#cart", "prescribed")
    page.page.wait_for_function("location.hash.includes('cart=prescribed')")
    assert page.page.inner_text("#problem") == ""


def test_what_is_out_of_range_marks_its_field_and_greys_what_stood_there(opened):
    page = opened("#explore?rig=wires&detail=coarse")
    page.idle()
    mass = "[data-number=mass_kg]"
    set_number(page, "mass_kg", -1)
    page.page.wait_for_selector(f"{mass}[aria-invalid=true]")
    said = page.page.inner_text("#problem")
    assert said.startswith("mass (kg) is -1, must be") and "--set" not in said
    why = page.page.get_attribute(mass, "aria-errormessage")
    assert said.startswith(page.page.inner_text(f"#{why}"))
    assert page.page.locator(".map.stale").count() == page.page.locator(".answer.stale").count() == 1
    shot(page, "explore-refused")
    # Another change does not hide it; mending it does.
    set_number(page, "amplitude_mm", 0.9)
    page.page.wait_for_function("location.hash.includes('amplitude_mm')")
    page.page.wait_for_selector(f"{mass}[aria-invalid=true]")
    set_number(page, "mass_kg", 1)
    page.page.wait_for_function("document.querySelector('#problem').innerText === ''")
    page.page.wait_for_selector(".answer:not(.stale)[aria-busy=false]")
    assert page.page.locator("[aria-invalid=true]").count() == page.page.locator(".stale").count() == 0
    page.page.set_input_files("#rigfile", {"name": "bad.toml", "mimeType": "text/plain", "buffer": b'preset = "wires"\nmas_kg = 1\n'})
    page.page.wait_for_selector("#problem:has-text('bad.toml, line 2')")
    # The rig before stays, also in the address.
    assert page.page.inner_text("#problem").endswith("The rig before stays")
    assert "bad.toml" not in page.page.evaluate("location.hash")
    assert page.page.locator(".stale").count() == 0


def test_frequency_length_and_gravity_lead_to_no_dead_end(opened):
    page = opened("#explore?rig=wires&detail=coarse")
    page.idle()
    for key, value in [("gravity_m_per_s2", 5), ("natural_frequency_hz", 2.5), ("gravity_m_per_s2", 9.81), ("wire_length_mm", 100), ("natural_frequency_hz", 1.5), ("gravity_m_per_s2", 3)]:
        set_number(page, key, value)
        page.page.wait_for_function(f"location.hash.includes('{key}%3D{value}') || {value} === 9.81")
        page.page.wait_for_selector(".answer:not(.stale)[aria-busy=false]")
        assert page.page.inner_text("#problem") == ""
    assert page.page.locator("#rig-notes").inner_text().startswith("Natural frequency 1.5000 Hz")
    # Its own frequency at another gravity, and wires so short that part of the map's gaps cannot be.
    for gravity, value, shown in [(3, 1.82, "1.8200"), (9.81, 7, "7.0000")]:
        set_number(page, "gravity_m_per_s2", gravity)
        set_number(page, "natural_frequency_hz", value)
        page.page.wait_for_function(f"document.querySelector('#rig-notes').innerText.startsWith('Natural frequency {shown} Hz')")
        page.page.wait_for_selector(".answer:not(.stale)[data-state=nominal]")
        page.idle()
        assert page.page.inner_text("#problem") == ""
        assert page.page.locator("[aria-invalid=true]").count() == page.page.locator(".stale").count() == 0
    set_number(page, "natural_frequency_hz", 1e-9)
    page.page.wait_for_selector("[data-number=natural_frequency_hz][aria-invalid=true]")


def test_an_answer_under_way_does_not_stand_behind_a_refusal(opened):
    page = opened("#explore?rig=wires&detail=coarse")
    page.page.wait_for_selector(".answer[data-state=nominal]")
    set_number(page, "amplitude_mm", 0.5)
    page.page.wait_for_selector(".answer[aria-busy=true]")
    set_number(page, "mass_kg", -1)
    page.page.wait_for_selector("[data-number=mass_kg][aria-invalid=true]")
    page.page.wait_for_timeout(4000)
    assert page.page.locator(".answer.stale").count() == 1
    assert page.page.locator("#take").is_disabled()


def test_a_limit_or_a_frequency_that_cannot_be_marks_its_field(opened):
    page = opened("#explore?rig=wires&detail=coarse")
    page.page.wait_for_selector(".answer[data-state=nominal]")
    page.page.get_by_text("Limits of the machine").click()
    for field, waited in [("[data-limit=max_force_n]", ".answer.stale #no-answer:has-text('must be above 0')"), ("#frequency", "#frequency[aria-invalid=true]")]:
        page.page.locator(field).fill("-1")
        page.page.locator(field).press("Enter")
        page.page.wait_for_selector(f"{field}[aria-invalid=true]")
        page.page.wait_for_selector(waited)
    for field in ["[data-limit=max_force_n]", "#frequency"]:
        page.page.locator(field).fill("60" if "limit" in field else "3")
        page.page.locator(field).press("Enter")
    page.page.wait_for_selector(".answer[data-state=nominal]:not(.stale)")
    assert page.page.locator("[aria-invalid=true]").count() == 0


def test_a_rig_without_an_answer_says_so_where_the_answer_stood(opened):
    page = opened("#explore?rig=wires&detail=coarse")
    page.page.wait_for_selector(".answer[data-state=nominal]")
    page.page.get_by_text("Limits of the machine").click()
    limit = page.page.locator("[data-limit=max_frequency_hz]")
    limit.fill("0.01")
    limit.press("Enter")
    page.page.wait_for_selector(".answer.stale #no-answer:not(:empty)")
    limit.fill("")
    limit.press("Enter")
    page.page.wait_for_selector(".answer[data-state=nominal]:not(.stale)")
    assert page.page.inner_text("#no-answer") == ""


def test_back_goes_from_part_to_part(opened):
    page = opened("#explore?rig=wires&detail=coarse")
    page.page.wait_for_selector(".answer[data-state=nominal]")
    page.page.get_by_role("tab", name="Live").click()
    page.page.wait_for_selector("#part-explore[hidden]", state="attached")
    page.page.go_back()
    page.page.wait_for_selector("#part-explore:not([hidden])")
    assert page.page.get_attribute("#tab-explore", "aria-selected") == "true"


def test_an_own_rig_file_by_choice_and_by_drop(opened):
    page = opened("#explore?rig=wires&detail=coarse")
    page.page.wait_for_selector("[data-number=mass_kg]")
    text = host_sim("rigs", "beam-150")
    page.page.set_input_files("#rigfile", {"name": "mine.toml", "mimeType": "text/plain", "buffer": text.encode()})
    page.page.wait_for_selector("[data-key=damping_ratio]", state="attached")
    assert page.page.input_value("#preset") == "mine.toml"
    drop = """text => {
      const carried = new DataTransfer();
      carried.items.add(new File([text], "dropped.toml"));
      document.querySelector(".controls").dispatchEvent(new DragEvent("drop", { dataTransfer: carried, bubbles: true, cancelable: true }));
    }"""
    page.page.evaluate(drop, 'preset = "wires"\nmass_kg = 0.7\ngap_mm = 0.5\n')
    page.page.wait_for_selector("[data-key=wire_length_mm]", state="attached")
    assert page.page.input_value("[data-number=mass_kg]") == "0.7"
    assert page.page.input_value("[data-number=gap_mm]") == "0.5"
    saved = json.loads(page.saved("save rig as JSON"))
    assert saved["parameters"]["mass_kg"] == 0.7
    page.page.wait_for_function("location.hash.includes('dropped')")
    # The address has the file's text: it opens the same rig elsewhere.
    other = opened("#" + page.page.url.split("#", 1)[1])
    other.page.wait_for_selector("[data-number=mass_kg]")
    assert other.page.input_value("[data-number=mass_kg]") == "0.7"


def test_an_address_opens_what_was_seen_and_a_broken_one_opens_the_page(opened):
    page = opened("#explore?rig=beam-170&set=mass_kg%3D0.9&gap_mm=0.2&ratio=2&units=absolute&colour=force&view=1,3,0,1&detail=coarse")
    page.page.wait_for_selector(".motion[data-state=shown]")
    assert page.page.input_value("#preset") == "beam-170"
    assert page.page.input_value("[data-number=mass_kg]") == "0.9"
    assert page.page.input_value("#units") == "absolute" and page.page.input_value("#colour") == "force"
    page.page.select_option("#detail", "fine")
    page.page.wait_for_selector(".explore[data-fine]")
    page.page.select_option("#units", "ratios")
    page.page.select_option("#colour", "regime")
    page.page.get_by_role("button", name="Share by address").click()
    for broken in ["#explore?rig=nothing", "#explore?set=x", "#explore?view=3,1,0,0&gap_mm=x&ratio=-1", "#explore?view=-5,1e9,-1e9,1e9&detail=coarse", "#no", "#explore?rig=a&file=%5B"]:
        other = opened(broken)
        other.page.wait_for_selector("[data-number=mass_kg]")
        assert other.page.input_value("#preset") == "wires"
        other.page.close()


# Chromium lets a page save some ten files in a row: hence two pages.
@pytest.mark.parametrize("names", [["map", "pick-curve", "time-history"], ["force", "phase-plane", "section", "multipliers"]])
def test_pictures_are_files_that_say_what_they_were_made_from(opened, names):
    page = opened("#explore?rig=wires&gap_mm=0.1&ratio=2&detail=coarse")
    page.idle()
    page.page.wait_for_selector(".motion[data-state=shown]")
    for name in names:
        text = page.saved(f"save {name} as SVG").decode()
        # The letters of an image's data may be any.
        written = re.sub(r"base64,[A-Za-z0-9+/=]*", "", text)
        assert written.startswith("<svg") and "undefined" not in written and "NaN" not in written, name
        said = ElementTree.fromstring(text).find("{http://www.w3.org/2000/svg}metadata[@id='made_from']").text
        png = page.saved(f"save {name} as PNG")
        assert png.startswith(b"\x89PNG")
        at = png.index(b"iTXtmade_from\0")
        (length,) = struct.unpack(">I", png[at - 4 : at])
        body = png[at : at + 4 + length]
        assert struct.unpack(">I", png[at + 4 + length :][:4])[0] == zlib.crc32(body)
        made = json.loads(body.split(b"\0\0\0\0\0", 1)[1])
        assert made["version"] and made["rig"]["parameters"]["mass_kg"] > 0
        assert json.loads(said) == made


def test_every_control_has_a_name_and_can_be_reached(opened):
    page = opened("#explore?rig=wires&ratio=2&detail=coarse")
    page.idle()
    nameless = page.page.evaluate("""() => [...document.querySelectorAll("button, select, input, [role=application]")].filter((one) => {
      const said = one.getAttribute("aria-label") ?? one.textContent;
      const label = one.labels?.length ? one.labels[0].textContent : "";
      return !(said.trim() || label.trim());
    }).map((one) => one.outerHTML)""")
    assert not nameless
    page.page.keyboard.press("Tab")
    assert page.page.evaluate("document.activeElement.className") == "skip"
    seen = set()
    for _ in range(80):
        page.page.keyboard.press("Tab")
        seen.add(page.page.evaluate("document.activeElement.id || document.activeElement.className"))
    assert {"theme", "preset", "plane", "uncertain"} <= seen


def test_the_tutorial_s_addresses_show_what_it_says(opened):
    tutorial = pathlib.Path(__file__).parents[2] / "docs/tutorial-explore.md"
    addresses = [line.strip() for line in tutorial.read_text().splitlines() if line.startswith("    #explore?")]
    assert len(addresses) == 2
    for address, motions in zip(addresses, [{"1/1"}, {"1/1", "no impact"}]):
        page = opened(f"{address}&detail=coarse")
        page.idle()
        page.page.wait_for_selector("#others[data-state=shown]")
        found = {row.split("\t")[0].strip() for row in page.page.locator("#others tbody tr").all_inner_texts()}
        assert motions <= found, f"{address}: {found}"
        assert not page.said


@pytest.mark.parametrize("dark", [False, True])
@pytest.mark.parametrize("width", [1280, 360])
def test_it_fits_and_is_pictured(opened, width, dark):
    page = opened("#explore?rig=wires&gap_mm=0.4&ratio=2.4&detail=fine", width=width, height=800, dark=dark)
    page.idle()
    page.page.wait_for_selector("#others[data-state=shown]")
    page.page.wait_for_selector(".explore[data-fine]")
    assert page.page.evaluate("document.documentElement.scrollWidth") <= width
    shot(page, f"explore-{width}-{'dark' if dark else 'light'}")
    ground = page.page.evaluate("getComputedStyle(document.documentElement).backgroundColor")
    assert (ground == "rgb(20, 23, 26)") == dark
    page.page.select_option("#theme", "light" if dark else "dark")
    changed = page.page.evaluate("getComputedStyle(document.documentElement).backgroundColor")
    assert (changed == "rgb(20, 23, 26)") != dark
