"""The page's parts "Emulated rig" and "Live" in a browser. Boards are emulated: in the page, behind `host-sim link PORT --page`,
and behind a Web Serial that is put in the browser's place."""

import json
import os
import pathlib
import signal
import subprocess
import time

import pytest

from conftest import PAGE, PATIENCE_MS, host_sim

SHOTS = pathlib.Path(os.environ["SHOTS"])


def state(page, wanted):
    """Waits until the board is in one of these states."""
    page.wait_for_selector(", ".join(f".facts[data-state='{name}']:visible" for name in wanted))


def says(page, words):
    """Waits until the part that is shown says so. (A page of the server's lets no test evaluate a text.)"""
    page.wait_for_selector(f"p:visible:has-text({json.dumps(words)})")


def power(page, on):
    """Waits until the emulated drive truly has power, or none."""
    page.wait_for_selector(f".truth[data-powered={'true' if on else 'false'}]")


def press(page, name):
    """Presses the button of that name in the part that is shown."""
    page.locator(f"button:visible:text-is('{name}')").click()


def wrong(page):
    """What the part that is shown complains of."""
    return " ".join(page.locator("p.wrong:visible").all_inner_texts()).strip()


def shot(page, name):
    SHOTS.mkdir(parents=True, exist_ok=True)
    page.screenshot(path=SHOTS / f"{name}.png", full_page=True)


def begin(page):
    """Begins the chosen scenario anew, and waits for its board."""
    page.wait_for_selector(".truth[data-run]")
    before = int(page.locator(".truth").get_attribute("data-run"))
    press(page, "Begin")
    page.wait_for_selector(f".truth[data-run='{before + 1}']")


def emulated(opened, scenario="field", events=False, speed="2", **more):
    """The emulated rig, begun anew."""
    page = opened("#emulated", **{"width": 1280, "height": 900, **more}).page
    page.wait_for_selector(".facts[data-state]")
    page.get_by_label("scenario", exact=True).select_option(scenario)
    page.get_by_label("with its events").set_checked(events)
    page.get_by_label("Speed").select_option(speed)
    begin(page)
    if not events:
        page.wait_for_selector(".facts[data-state=idle]")
    return page


def test_a_scenario_runs_and_holds(opened):
    page = emulated(opened, events=True, speed="5")
    page.get_by_label("shows").select_option("10")
    power(page, True)
    state(page, ["hold"])
    # What happened stands on the scope, too.
    page.wait_for_selector(".scope[aria-label*='seek → hold']")
    assert wrong(page) == ""
    factor = float(page.locator(".factor").get_attribute("data-factor"))
    print(f"emulated rig: {factor:.2f} times real time was measured at 5 times")
    assert factor > 0
    page.wait_for_function("document.querySelectorAll('figure svg.chart circle').length > 20")
    shot(page, "emulated-1280")


@pytest.mark.parametrize(("width", "dark"), [(1280, True), (360, False), (360, True)])
def test_it_is_shown_at_every_width_and_theme(opened, width, dark):
    page = emulated(opened, events=True, width=width, height=800, dark=dark)
    power(page, True)
    page.wait_for_timeout(1500)
    wide = page.evaluate("document.documentElement.scrollWidth")
    assert wide <= width, f"{wide} of {width}"
    shot(page, f"emulated-{width}-{'dark' if dark else 'light'}")


def test_start_break_clear_and_stop(opened):
    page = emulated(opened)
    press(page, "Start")
    power(page, True)
    # A broken sensor switches the drive off, by what is true of the rig.
    page.get_by_label("sensor", exact=True).select_option("force")
    page.get_by_label("defect").select_option(label="open wire")
    press(page, "for 2 s")
    state(page, ["fault"])
    power(page, False)
    assert "open" in page.locator(".facts tr.wrong").inner_text()
    # Refused until the wire is whole again, which takes two seconds of the rig's time.
    while page.locator(".facts").get_attribute("data-state") == "fault":
        page.locator("button:visible:text-is('Clear the fault'):not([disabled])").click()
        page.wait_for_timeout(500)
    state(page, ["idle"])
    press(page, "Start")
    power(page, True)
    page.keyboard.press("Escape")
    power(page, False)
    state(page, ["idle"])


def test_set_points_by_hand(opened):
    page = emulated(opened)
    press(page, "Start by hand")
    state(page, ["manual"])
    page.get_by_label("Frequency, Hz", exact=True).fill("2.5")
    page.get_by_label("Amplitude, mm", exact=True).fill("0.4")
    press(page, "Set")
    page.wait_for_function("[...document.querySelectorAll('.facts td')].some(cell => cell.textContent.startsWith('2.5 Hz'))")
    # An empty field is no zero, what cannot be is refused, and what a limit holds back is told.
    amplitude = page.get_by_label("Amplitude, mm", exact=True)
    for value, said in [("", "Amplitude: write a number"), ("-5", "not negative")]:
        amplitude.fill(value)
        press(page, "Set")
        page.wait_for_function(f"[...document.querySelectorAll('p.wrong')].some(p => p.textContent.includes('{said}'))")
    amplitude.fill("99")
    press(page, "Set")
    page.wait_for_function("[...document.querySelectorAll('.facts tr')].some(row => /limited by.*amplitude/.test(row.textContent))")
    press(page, "Stop")
    state(page, ["idle"])
    # What was measured of the drive is from before.
    page.wait_for_selector(".facts tr.old:has-text('peak force')")


def test_a_drive_that_runs_is_seen_and_stopped_on_every_tab(opened):
    page = emulated(opened)
    tab = lambda name: page.get_by_role("tab", name=name)
    for how in ["Escape", "Stop"]:
        press(page, "Start")
        power(page, True)
        tab("Explore").click()
        page.wait_for_selector("#tab-emulated.drives")
        if how == "Escape":
            page.keyboard.press("Escape")
        else:
            page.locator("button:visible:text-is('Stop the drive: Emulated rig')").click()
        page.wait_for_selector("#tab-emulated:not(.drives)")
        assert page.locator("button.everywhere").is_hidden()
        tab("Emulated rig").click()
        power(page, False)
        state(page, ["idle"])


def test_begin_pressed_twice_is_begin(opened):
    page = emulated(opened)
    for clicks in [2, 3]:
        page.locator("button:visible:text-is('Begin')").click(click_count=clicks)
        page.wait_for_selector("button:text-is('Begin'):not([disabled])")
        time_of = "[...document.querySelectorAll('.facts tr')].find(row => row.textContent.startsWith('board'))?.lastChild.textContent"
        before = page.evaluate(time_of)
        page.wait_for_function(f"({time_of}) !== '{before}'")
        assert wrong(page) == ""
    # Another scenario that is chosen waits for Begin, and says so.
    page.get_by_label("scenario", exact=True).select_option("crash")
    page.wait_for_selector("text=Not begun yet (field without its events runs on until Begin)")
    begin(page)
    assert page.locator("text=Not begun yet").count() == 0


def test_everything_that_can_be_done_to_the_rig(opened):
    page = emulated(opened)
    deeds = page.locator(".deed").all_inner_texts()
    assert len(deeds) >= 8
    for deed in deeds:
        page.locator(f".deed:text-is('{deed}')").click()
        page.wait_for_selector(".timeline li")
    for kind in page.get_by_label("defect").locator("option").all_inner_texts():
        page.get_by_label("defect").select_option(label=kind)
        press(page, "for 2 s")
    page.wait_for_timeout(1500)
    assert wrong(page) == ""


def test_every_scenario_begins(opened):
    page = emulated(opened)
    for name in page.get_by_label("scenario", exact=True).locator("option").all_inner_texts():
        page.get_by_label("scenario", exact=True).select_option(name)
        begin(page)
    page.wait_for_timeout(500)
    assert wrong(page) == ""


def test_settings_are_a_form_that_is_checked_and_written(opened):
    page = emulated(opened)
    field = page.locator("[data-setting='trips.no_contact_s']")
    said = page.locator(".settings [role=status]")
    assert "As on the board" in said.inner_text()
    # What cannot be is refused at once and marks its field, a folded one, too.
    page.locator(".settings summary:text-is('Rig')").click()
    for key, value in [("trips.force_n", "1"), ("rig.mass_kg", "-1"), ("aim.force_n", "")]:
        other = page.locator(f"[data-setting='{key}']")
        before = other.input_value()
        other.fill(value)
        other.press("Enter")
        page.wait_for_selector(f"[data-setting='{key}'][aria-invalid=true]")
        assert key.split(".")[1] in page.locator(".settings .wrong").inner_text()
        other.fill(before)
        other.press("Enter")
        page.wait_for_selector(f"[data-setting='{key}']:not([aria-invalid])")
    # Another law of the contact brings its own parameters, and takes them with it.
    law, exponent = page.locator("[data-setting='rig.contact_law']"), page.locator("[data-setting='rig.contact_exponent']")
    law.select_option("hertz")
    exponent.wait_for()
    law.select_option("spring-dashpot")
    exponent.wait_for(state="detached")
    assert "As on the board" in said.inner_text() and page.locator(".settings .wrong").inner_text() == ""
    field.fill("7.5")
    field.press("Enter")
    assert "1 of them differs" in said.inner_text()
    press(page, "Write what differs")
    says(page, "in use and stored")
    assert float(field.input_value()) == 7.5 and "As on the board" in said.inner_text()
    # The same as a text.
    page.get_by_text("As the text of a settings file").click()
    page.wait_for_function("document.querySelector('.settings textarea').value.includes('no_contact_s = 7.5')")
    box = page.locator(".settings textarea")
    box.fill("[trips]\nforce = 1\n")
    press(page, "Put the text into the form")
    says(page, "did you mean 'force_n'")
    box.fill("[trips]\nno_contact_s = 6.5\n[operator]\nheartbeat = true\n")
    press(page, "Put the text into the form")
    assert float(field.input_value()) == 6.5 and "2 of them differ" in said.inner_text()
    press(page, "Read again")
    says(page, "Read. As on the board.")
    assert float(field.input_value()) == 7.5


def test_a_recording_replays_bit_for_bit_on_this_machine(opened, tmp_path):
    page = emulated(opened)
    press(page, "Record")
    page.wait_for_function("document.body.innerText.includes(' s recorded')")
    press(page, "Start")
    power(page, True)
    page.wait_for_timeout(1000)
    with page.expect_download() as download:
        press(page, "End and save")
    path = tmp_path / "page.parquet"
    download.value.save_as(path)
    replayed = host_sim("replay", path, "--quiet")
    assert "same decisions" in replayed, replayed
    print(f"recorded in the page: {path.stat().st_size} bytes; {replayed.strip().splitlines()[-1]}")


class Server:
    """`host-sim link PORT --page` at an emulated board."""

    def __init__(self):
        self.board = self.begin("emulate", "field", "--pty")
        self.port = self.board.stdout.readline().strip()
        self.server = self.begin("link", self.port, "--page", "--no-open", "--page-file", str(PAGE))
        self.address = self.server.stdout.readline().strip()

    @staticmethod
    def begin(*words):
        command = [os.environ["HOST_SIM"], *words]
        return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)

    def end(self):
        for program in (self.server, self.board):
            program.kill()
            program.wait()


@pytest.fixture
def server():
    found = Server()
    yield found
    found.end()


def connected(context, server):
    page = context.new_page()
    page.set_default_timeout(PATIENCE_MS)
    said = []
    page.on("console", lambda message: said.append(message.text) if message.type == "error" else None)
    page.on("pageerror", lambda error: said.append(str(error)))
    page.goto(server.address + "#live")
    press(page, f"Connect to {server.port}")
    page.wait_for_selector(".live .facts[data-state]")
    page.said = said
    return page


def test_a_shared_address_keeps_the_secret_back(browser, server):
    allowed = ["clipboard-read", "clipboard-write"]
    for address, whole in [(server.address, False), (PAGE.as_uri(), True)]:
        context = browser.new_context(permissions=allowed)
        page = context.new_page()
        page.set_default_timeout(PATIENCE_MS)
        page.goto(f"{address}#explore?ratio=2.1&detail=coarse")
        page.click("#share")
        page.wait_for_selector("text=is copied")
        copied = page.evaluate("navigator.clipboard.readText()")
        assert "ratio=2.1" in copied
        assert copied.startswith(address if whole else "#explore?"), copied
        context.close()


def test_two_pages_at_one_board(browser, server):
    context = browser.new_context(viewport={"width": 1280, "height": 900})
    one, other = connected(context, server), connected(context, server)
    assert one.locator("button:visible:text-is('Start')").is_disabled()
    press(one, "Take the command")
    one.wait_for_selector("button:text-is('Start'):not([disabled])")
    says(other, "commands, this page watches")
    assert other.locator("button:visible:text-is('Start')").is_disabled()
    press(one, "Start")
    state(one, ["prove", "ramp", "seek"])
    state(other, ["prove", "ramp", "seek"])
    one.wait_for_selector(".timeline li:has-text('idle →')")
    one.wait_for_timeout(3000)
    shot(one, "live-1280")
    # The other takes over, and the drive goes on.
    other.locator("button:visible", has_text="Take over from page").click()
    says(one, "this page watches")
    other.wait_for_timeout(2500)
    state(other, ["prove", "ramp", "seek", "hold"])
    # A watcher may stop.
    one.keyboard.press("Escape")
    state(other, ["stop", "idle"])
    state(other, ["idle"])
    # The page that drives is closed: the board is stopped.
    press(other, "Start")
    state(one, ["prove", "ramp", "seek"])
    began = time.monotonic()
    other.close()
    state(one, ["stop", "idle"])
    print(f"the page that drives is closed: seen as stopping after {time.monotonic() - began:.2f} s")
    state(one, ["idle"])
    assert one.said == [], one.said
    context.close()


def test_what_a_silent_board_said_last_is_grey(browser, server):
    context = browser.new_context()
    page = connected(context, server)
    page.wait_for_selector(".live[data-stale=false]")
    server.board.send_signal(signal.SIGSTOP)
    page.wait_for_selector(".live[data-stale=true]")
    server.board.send_signal(signal.SIGCONT)
    page.wait_for_selector(".live[data-stale=false]")
    server.server.kill()
    page.wait_for_selector(".live[data-stale=true]")
    context.close()


def test_the_policy_lets_the_whole_page_work(browser, server):
    context = browser.new_context()
    page = connected(context, server)
    page.get_by_role("tab", name="Emulated rig").click()
    page.wait_for_selector(".emulated .facts[data-state]")
    page.get_by_role("tab", name="Explore").click()
    page.wait_for_timeout(2000)
    assert page.said == [], page.said
    context.close()


def test_a_site_of_the_same_browser_gets_nothing(browser, server, tmp_path):
    """A page from a file has the origin null; it knows the port, and even the secret."""
    stranger = tmp_path / "stranger.html"
    stranger.write_text("<!doctype html><title>stranger</title>")
    context = browser.new_context()
    page = context.new_page()
    page.goto(stranger.as_uri())
    tried = page.evaluate(
        """async (address) => {
            const socket = new WebSocket(address.replace("http", "ws") + "wire");
            const open = await new Promise((resolve) => { socket.onopen = () => resolve("open"); socket.onerror = () => resolve("refused"); });
            const read = await fetch(address + "board").then((answer) => answer.text(), () => "refused");
            const frame = document.createElement("iframe");
            frame.src = address;
            document.body.append(frame);
            await new Promise((resolve) => setTimeout(resolve, 1000));
            let framed = "refused";
            try { if (frame.contentDocument?.getElementById("tabs")) framed = "framed"; } catch { framed = "refused"; }
            return [open, read, framed];
        }""",
        server.address,
    )
    assert tried == ["refused", "refused", "refused"], tried
    context.close()


# A Web Serial whose one port leads to the emulated rig's worker of the page itself.
SERIAL = """
navigator.serial ?? Object.defineProperty(navigator, "serial", { value: {}, configurable: true });
Object.defineProperty(navigator, "serial", { configurable: true, value: { async requestPort() {
  return {
    async open({ baudRate }) {
      (window.bauds ??= []).push(baudRate);
      // A debugger that passes nothing on at the usual rate.
      if (window.bauds.length === 1) {
        this.readable = new ReadableStream();
        this.writable = new WritableStream();
        return;
      }
      const code = document.getElementById("emulated-worker").textContent;
      const worker = new Worker(URL.createObjectURL(new Blob([code], { type: "text/javascript" })));
      const coded = document.getElementById("module").textContent;
      const packed = Uint8Array.from(atob(coded), (letter) => letter.charCodeAt(0));
      const unpacked = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
      const module = await WebAssembly.compile(await new Response(unpacked).arrayBuffer());
      let give;
      this.readable = new ReadableStream({ start: (controller) => { give = (bytes) => controller.enqueue(bytes); } });
      this.writable = new WritableStream({ write: (bytes) => worker.postMessage({ bytes }) });
      await new Promise((resolve) => {
        worker.onmessage = ({ data }) => {
          if (data.scenarios) worker.postMessage({ scenario: { name: "field", events: false } });
          if (data.started) resolve();
          if (data.bytes) give(data.bytes);
          if (data.truth) window.truth = data.truth;
        };
        worker.postMessage({ module });
      });
    },
    async close() { window.portClosed = true; },
  };
} } });
"""


def test_web_serial(browser):
    context = browser.new_context(viewport={"width": 360, "height": 800})
    context.add_init_script(SERIAL)
    page = context.new_page()
    page.set_default_timeout(PATIENCE_MS)
    page.goto(PAGE.as_uri() + "#live")
    press(page, "Connect by Web Serial")
    page.wait_for_selector(".live .facts[data-state=idle]")
    assert page.evaluate("window.bauds") == [2_250_000, 921_600]
    press(page, "Take the command")
    page.wait_for_selector("button:text-is('Start'):not([disabled])")
    press(page, "Start")
    page.wait_for_function("window.truth?.powered")
    page.wait_for_timeout(2000)
    shot(page, "live-360")
    wide = page.evaluate("document.documentElement.scrollWidth")
    assert wide <= 360, wide
    press(page, "Disconnect")
    page.wait_for_function("!window.truth.powered")
    page.wait_for_function("window.portClosed")
    context.close()


def test_the_rig_is_seen_to_move_and_the_hammer_to_strike(opened):
    page = emulated(opened, events=True, speed="5")
    state(page, ["hold"])
    page.wait_for_selector(".rig:visible .hammer.touches")
    shot(page, "rig-moves")
    caption = page.locator("figure:has(.rig):visible figcaption")

    def seen():
        captions = set()
        for _ in range(10):
            page.wait_for_timeout(100)
            captions.add(caption.inner_text())
        return captions

    moving = seen()
    assert len(moving) > 4 and all("hammer" in one for one in moving)
    # Who wants no motion sees the newest moment, every few seconds another.
    page.emulate_media(reduced_motion="reduce")
    page.wait_for_timeout(200)
    assert len(seen()) < 4
