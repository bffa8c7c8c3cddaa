"""The site: what a reader does with it in a browser, from a folder without a server; and the mistakes that it refuses."""

import os
import pathlib
import shutil
import subprocess

import pytest

SITE = pathlib.Path(os.environ["SITE"])
SHOTS = pathlib.Path(os.environ["SHOTS"])
ROOT = pathlib.Path(__file__).parents[2]


def searched(page, words):
    """Searches as a reader does; how many results there are."""
    box = page.get_by_role("textbox", name="Search")
    if not box.is_visible():
        page.locator(".nav-overlay-icon").click()
    box.fill(words)
    box.press("Enter")
    page.wait_for_url("**/search.html?*")
    page.wait_for_function("/Search Results/.test(document.querySelector('#search-results h2')?.innerText)")
    return page.locator("ul.search li").count()


@pytest.mark.parametrize("width", [1920, 1280, 768, 360])
def test_the_search_leads_to_the_section_with_all_words(opened, width):
    found = opened(width=width, file=SITE / "docs/map.html")
    page = found.page
    assert searched(page, "natural frequency") > 12
    # Every place that is found is there.
    for link in page.locator("ul.search a").all():
        file, anchor = link.get_attribute("href").split("#")
        assert f'id="{anchor}"' in (SITE / file).read_text()
    assert searched(page, "semicolons zzyzx") == 0
    # Words that say nothing and a slip of the finger do not stand in the way.
    assert searched(page, "how do I mutliplier") == searched(page, "multiplier") > 3
    assert searched(page, "<img src=x> (") == 0
    assert page.locator("#search-results img").count() == 0
    assert searched(page, "semicolons between the columns") == 1
    assert "semicolons" in page.locator("ul.search .highlighted").all_inner_texts()
    SHOTS.mkdir(exist_ok=True)
    page.screenshot(path=SHOTS / f"site-search-{width}.png")
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    page.locator("ul.search a").click()
    page.wait_for_url("**/docs/recordings.html#as-oscilloscopes-and-spreadsheets-write-them")
    assert found.said == []


def test_no_page_is_wider_than_the_screen_and_no_picture_is_missing(opened):
    found = opened(file=SITE / "index.html")
    found.page.wait_for_url("**/README.html")
    files = sorted(set(SITE.rglob("*.html")) - {SITE / "index.html"})
    assert len(files) > 30
    for file in files:
        found.page.goto(file.as_uri())
        for width in [1920, 1280, 768, 360]:
            found.page.set_viewport_size({"width": width, "height": 800})
            assert found.page.evaluate("document.documentElement.scrollWidth") <= width, (file.name, width)
        broken = found.page.evaluate("[...document.images].filter((one) => !one.naturalWidth).map((one) => one.src)")
        assert broken == [], file.name
        # A picture opens alone, and a link says where it leads.
        assert found.page.locator("article img").count() == found.page.locator("article a img").count(), file.name
        named = found.page.locator("article a").all_inner_texts() if file.parent.name == "docs" else []
        assert [one for one in named if one.endswith(".md")] == [], file.name
    assert found.said == []
    # Nothing is asked for but the site's own files.
    assert [url for url in found.asked if not url.startswith((SITE.as_uri(), "blob:"))] == []


def test_the_example_in_tabs_and_the_page_within_a_page(opened):
    found = opened(file=SITE / "docs/pick.html")
    example = found.page.get_by_text("vi.pick(").first
    assert not example.is_visible()
    found.page.get_by_text("Python", exact=True).first.click()
    assert example.is_visible()
    found.page.goto((SITE / "docs/tutorial-explore.html").as_uri())
    found.page.locator("iframe").scroll_into_view_if_needed()
    found.page.frame_locator("iframe").locator(".answer[aria-busy=false]").wait_for()
    assert found.said == []


MISTAKES = {
    "[x](nowhere.md)": "nowhere.md",
    "[x](gap.md#nowhere)": "local id not found in doc 'docs/gap': 'nowhere'",
    "[x](#nowhere)": "'nowhere'",
    "[x](../shared/nowhere.rs)": "nowhere.rs",
    "[x](../python/README.md)": "Unknown source document 'python/README'",
    "![x](nowhere.png)": "image file not readable: docs/nowhere.png",
    "![](map-wires.png)": "a picture without words",
    r"$\nowhere$": r"the formula \nowhere",
    r"$\frac{1}{$": r"the formula \frac{1}{: not as many",
    r"$\left(x$": r"the formula \left(x: not as many",
}


def test_mistakes_are_refused(tmp_path):
    for name in ["docs", "tests/fuzz"]:
        shutil.copytree(ROOT / name, tmp_path / name)
    for name in [*ROOT.glob("*.md"), "shared", "python/README.md"]:
        source = ROOT / name
        target = tmp_path / source.relative_to(ROOT)
        target.parent.mkdir(exist_ok=True)
        target.mkdir() if source.is_dir() else shutil.copy(source, target)
    with open(tmp_path / "docs/map.md", "a") as page:
        page.write("".join(f"\n{mistake}\n" for mistake in MISTAKES))
    (tmp_path / "docs/lost.md").write_text("# A page that is not in the order\n")
    words = ["-q", "-n", "-W", "--keep-going", "-c", ROOT / "xtask/src/site", tmp_path, tmp_path / "out"]
    built = subprocess.run([ROOT / "target/sphinx/bin/sphinx-build", *words], capture_output=True, text=True)
    assert built.returncode != 0
    for said in [*MISTAKES.values(), "lost.md: WARNING: document isn't included in any toctree"]:
        assert said in built.stderr
