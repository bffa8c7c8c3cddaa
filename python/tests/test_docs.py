"""What stands in the documents runs."""

import re
from pathlib import Path

import pytest
import vibroimpact as vi

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize("page", ["docs/python.md", "python/README.md"])
def test_the_examples_of_a_page_run_one_after_the_other(page, capsys):
    pytest.importorskip("pandas")
    pytest.importorskip("xarray")
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / page).read_text(), re.DOTALL)
    assert blocks
    names = {}
    for block in blocks:
        exec(compile(block, page, "exec"), names)
    if page == "docs/python.md":
        printed = capsys.readouterr().out
        assert printed.startswith("3.68 Hz, 30 times the weight\n(61, 161)\n"), printed
        assert (names["whole"].regime == vi.map(names["rig"], **names["asked"]).regime).all()


def test_every_public_function_says_what_it_takes_and_gives():
    for name in vi.__all__:
        thing = getattr(vi, name)
        assert name == "__version__" or thing.__doc__, f"{name} has no documentation"
