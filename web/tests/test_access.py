"""The page for those who use a keyboard or a screen reader, or see little contrast: axe-core's rules."""

import pytest
from axe_playwright_python.sync_playwright import Axe


@pytest.mark.parametrize("dark", [False, True])
@pytest.mark.parametrize("width", [360, 1100])
def test_no_rule_of_axe_is_broken_in_any_part(opened, dark, width):
    found = opened(dark=dark, width=width)
    found.idle()
    tabs = found.page.get_by_role("tab").all()
    assert len(tabs) == 3
    for tab in tabs:
        tab.click()
        found.page.locator(f"#{tab.get_attribute('aria-controls')}").wait_for()
        if tab.inner_text().startswith("Emulated"):
            found.page.wait_for_selector(".emulated [data-setting]", state="attached")
        # What is folded, too.
        found.page.evaluate("for (const one of document.querySelectorAll('details')) one.open = true")
        results = Axe().run(found.page)
        assert results.violations_count == 0, results.generate_report()
