"""The search of the site, in a browser, from a folder without a server."""

import os
import pathlib

import pytest

SITE = pathlib.Path(os.environ["SITE"])
SHOTS = pathlib.Path(os.environ["SHOTS"])


@pytest.mark.parametrize("width", [1280, 360])
def test_the_search_leads_to_the_section_with_all_words(opened, width):
    found = opened(width=width, file=SITE / "map.html")
    page = found.page
    box = page.get_by_role("searchbox", name="Search all pages")
    status = page.get_by_role("status")
    box.fill("semicolons between the columns")
    page.wait_for_function("document.querySelectorAll('.found a').length > 0")
    first = page.locator(".found a").first
    assert first.get_attribute("href") == "recordings.html#as-oscilloscopes-and-spreadsheets-write-them"
    assert page.locator(".found mark").first.inner_text().lower() in "semicolons between the columns"
    SHOTS.mkdir(exist_ok=True)
    page.screenshot(path=SHOTS / f"site-search-{width}.png")
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    box.fill("natural frequency")
    page.wait_for_function("document.querySelectorAll('.found a').length === 12")
    assert "the first 12" in status.inner_text()
    # Every place that is found is there.
    for link in page.locator(".found a").all():
        file, anchor = link.get_attribute("href").split("#")
        assert f'id="{anchor}"' in (SITE / file).read_text()
    box.fill("semicolons zzyzx")
    page.wait_for_function("document.querySelector('.said').textContent.startsWith('No place')")
    assert page.locator(".found a").count() == 0
    box.fill("semicolons between the columns")
    page.wait_for_function("document.querySelectorAll('.found a').length > 0")
    box.press("Enter")
    page.wait_for_url("**/recordings.html#as-oscilloscopes-and-spreadsheets-write-them")
    assert found.said == []


def test_what_is_searched_for_is_never_taken_for_a_page_part(opened):
    page = opened(file=SITE / "index.html").page
    page.get_by_role("searchbox").fill("<img src=x> (")
    page.wait_for_function("document.querySelector('.said').textContent !== ''")
    assert page.locator(".found img, .said img").count() == 0


@pytest.mark.parametrize("width", [1280, 360])
def test_no_page_is_wider_than_the_screen_and_no_picture_is_missing(opened, width):
    found = opened(width=width, file=SITE / "index.html")
    files = sorted(SITE.glob("*.html"))
    assert len(files) > 30
    for file in files:
        found.page.goto(file.as_uri())
        assert found.page.evaluate("document.documentElement.scrollWidth") <= width, file.name
        broken = found.page.evaluate("[...document.images].filter((one) => !one.naturalWidth).map((one) => one.src)")
        assert broken == [], file.name
    assert found.said == []
