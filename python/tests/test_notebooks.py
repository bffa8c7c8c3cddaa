"""The notebooks run from top to bottom, what they assert holds, and what is stored under their cells is what they print.

``UPDATE_EXPECT=1`` stores it anew, with the pictures.
"""

import os
from pathlib import Path

import pytest

NOTEBOOKS = sorted((Path(__file__).resolve().parents[1] / "notebooks").glob("*.ipynb"))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
@pytest.mark.filterwarnings("ignore")
def test_a_notebook_runs(path):
    nbclient = pytest.importorskip("nbclient")
    pytest.importorskip("matplotlib")
    nbformat = pytest.importorskip("nbformat")
    notebook = nbformat.read(path, as_version=4)
    stored = printed(notebook)
    nbclient.NotebookClient(notebook, timeout=600, kernel_name="python3", record_timing=False).execute()
    if os.environ.get("UPDATE_EXPECT"):
        notebook.metadata.language_info = {"name": "python"}
        nbformat.write(notebook, path)
    else:
        assert printed(notebook) == stored


def printed(notebook):
    """The text of every output, and how many pictures there are."""
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    pictures = sum("image/png" in output.get("data", {}) for output in outputs)
    return [output.text for output in outputs if output.output_type == "stream"], pictures


def test_there_are_four():
    assert len(NOTEBOOKS) == 4
