"""What stands in the documents runs."""

import re
import textwrap
from pathlib import Path

import pytest
import vibroimpact as vi

ROOT = Path(__file__).resolve().parents[2]


def test_the_examples_of_the_page_run_one_after_the_other(capsys):
    pytest.importorskip("pandas")
    pytest.importorskip("xarray")
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "docs/python.md").read_text(), re.DOTALL)
    assert blocks
    names = {}
    for block in blocks:
        exec(compile(block, "docs/python.md", "exec"), names)
    printed = capsys.readouterr().out
    assert printed.startswith("3.68 Hz, 30 times the weight\n(61, 161)\n"), printed
    # The package's own page shows the same answer; its fields are there.
    short = (ROOT / "python/README.md").read_text()
    fields = re.findall(r"answer\.(\w+)", short)
    assert fields and all(field in names["answer"] for field in fields)


@pytest.mark.parametrize("page", ["basins", "bifurcation", "orbits", "pick", "simulate"])
def test_an_example_beside_the_command_line_runs(page):
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / f"docs/{page}.md").read_text(), re.DOTALL)
    assert blocks
    for block in blocks:
        exec(compile(textwrap.dedent(block), f"docs/{page}.md", "exec"), {})


def test_every_public_function_says_what_it_takes_and_gives():
    for name in vi.__all__:
        thing = getattr(vi, name)
        assert name == "__version__" or thing.__doc__, f"{name} has no documentation"
