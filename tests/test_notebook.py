"""The notebook in `examples/` runs from top to bottom."""

import json
from pathlib import Path

import pytest

NOTEBOOK = Path(__file__).parent.parent / "examples" / "first-steps.ipynb"


@pytest.mark.slow
def test_notebook_runs_and_the_number_is_all_ruler(tmp_path, monkeypatch):
    """Its cells, one after the other, in an empty folder."""
    monkeypatch.chdir(tmp_path)
    seen = {}
    for cell in json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"]:
        if cell["cell_type"] == "code":
            exec("".join(cell["source"]), seen)
    split = seen["split"]
    assert round(split.ruler.value, 9) == round(split.eta.value, 9) == 1.5
    assert seen["results"].folder == Path("first-steps")


def test_notebook_keeps_no_output():
    """What it shows is made where it runs."""
    cells = json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"]
    assert all(not cell.get("outputs") and not cell.get("execution_count") for cell in cells)
