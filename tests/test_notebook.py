"""The notebook in `examples/` runs from top to bottom, and its committed outputs are those of today."""

import ast
import json
from pathlib import Path

NOTEBOOK = Path(__file__).parent.parent / "examples" / "first-steps.ipynb"
CODE = [it for it in json.loads(NOTEBOOK.read_text())["cells"] if it["cell_type"] == "code"]


def run_cells(cells):
    """What the cells leave, and each one's last expression: its text, and its HTML if it has some."""
    seen = {}
    shown = []
    for cell in cells:
        *before, last = ast.parse("".join(cell["source"])).body
        exec(compile(ast.Module(before, []), str(NOTEBOOK), "exec"), seen)
        assert isinstance(last, ast.Expr)
        value = eval(compile(ast.Expression(last.value), str(NOTEBOOK), "eval"), seen)
        html = getattr(value, "_repr_html_", None)
        shown.append((repr(value), html() if html else ""))
    return seen, shown


def kept(cells):
    """The committed text and HTML of each cell; a notebook breaks a long dict into lines."""
    told = [it["outputs"][0]["data"] for it in cells]
    return [("".join(it["text/plain"]).replace("\n", ""), "".join(it.get("text/html", ""))) for it in told]


def test_notebook_runs_and_its_outputs_are_those_of_today(tmp_path, monkeypatch):
    """Its cells, one after the other, in an empty folder; the number is all ruler."""
    monkeypatch.chdir(tmp_path)
    seen, shown = run_cells(CODE)
    split = seen["split"]
    assert round(split.ruler.value, 9) == round(split.eta.value, 9) == 1.5
    assert seen["results"].folder == Path("first-steps")
    assert shown == kept(CODE)


def test_first_output_is_a_table():
    """What a forge shows of the notebook: a line per comparison."""
    assert "<table>" in "".join(CODE[0]["outputs"][0]["data"]["text/html"])


def test_notebook_names_no_place():
    """Neither a time nor a machine's folder."""
    text = NOTEBOOK.read_text()
    assert not any(it in text for it in ("/root", "/home", "/tmp", 'execution": {'))
