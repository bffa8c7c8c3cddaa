"""The page in a browser, and the command line beside it. `cargo xtask web --test` sets what is needed:
PAGE (the file), SITE (the folder), CHROMIUM and HOST_SIM (the programs), SHOTS (a folder for pictures)."""

import csv
import io
import json
import os
import pathlib
import subprocess

import pytest
from playwright.sync_api import sync_playwright

PAGE = pathlib.Path(os.environ["PAGE"])

# A slow or busy machine is no failure: what hangs is ended by xtask, which looks at processor time.
PATIENCE_MS = 600_000


@pytest.fixture(scope="session")
def browser():
    with sync_playwright() as playwright:
        # Without the sandbox, as whoever runs the checks may be root; the page is this project's own.
        found = playwright.chromium.launch(
            executable_path=os.environ["CHROMIUM"], args=["--no-sandbox"]
        )
        yield found
        found.close()


class Opened:
    """A page that is open, with what it said and asked for meanwhile."""

    def __init__(self, page):
        self.page = page
        self.said = []
        self.asked = []
        page.on("console", lambda message: self.said.append(message.text) if message.type in ("error", "warning") else None)
        page.on("pageerror", lambda error: self.said.append(str(error)))
        page.on("request", lambda request: self.asked.append(request.url))

    def idle(self):
        """Waits for the recommendation and the map's first pass."""
        self.page.wait_for_selector(".answer[aria-busy=false]")
        self.page.wait_for_selector(".explore[data-coarse]")

    def saved(self, label):
        """The bytes of the file that a button saves."""
        with self.page.expect_download() as download:
            self.page.get_by_role("button", name=label, exact=True).click()
        return pathlib.Path(download.value.path()).read_bytes()


@pytest.fixture
def opened(browser):
    contexts = []

    def open_page(fragment="", width=700, height=800, dark=False, file=PAGE, **more):
        context = browser.new_context(
            viewport={"width": width, "height": height},
            color_scheme="dark" if dark else "light",
            accept_downloads=True,
            **more,
        )
        context.set_default_timeout(PATIENCE_MS)
        contexts.append(context)
        found = Opened(context.new_page())
        found.page.goto(file.as_uri() + fragment)
        return found

    yield open_page
    for context in contexts:
        context.close()


def host_sim(*words):
    """What the command line answers."""
    command = [os.environ["HOST_SIM"], *map(str, words)]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def host_json(*words):
    return json.loads(host_sim(*words, "--format", "json"))


def host_rows(*words):
    return list(csv.DictReader(io.StringIO(host_sim(*words, "--format", "csv"))))
