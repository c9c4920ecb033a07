"""Committed records, as a terminal shows them."""

import json
import re

import pytest
from rich.console import Console

from harness.errors import SchemaError
from harness.report import FactsTable, Report, report_text
from harness_plugins.committed import committed_table, committed_text, is_committed, refuse_committed
from tests.refusals import refused
from tests.report.conftest import printed


@pytest.fixture
def commit(tmp_path):
    """Leaves the records of an experiment in a folder."""

    def write(results):
        folder = tmp_path / "records"
        folder.mkdir()
        (folder / "results.json").write_text(report_text(Report(results)) + "\n")
        return folder

    return write


def lines_of(folder, width=120):
    """What stands in the terminal, so many columns wide."""
    console = Console(width=width, record=True, file=None, force_terminal=False)
    with console.capture() as capture:
        console.print(committed_table(folder))
    return [line.rstrip() for line in capture.get().splitlines()]


def test_records_are_told_from_an_experiment(build, commit):
    """An experiment's folder has a plan."""
    results = build(seeds=1)
    (results.folder / "results.json").write_text("{}")
    assert not is_committed(results.folder)
    assert is_committed(commit(results))


def test_records_say_what_the_report_said_first(build, commit):
    """Line by line, in a wide window and in a narrow one."""
    results = build(seeds=1, simulators=("mujoco", "pybullet"), proposed={"arp": (9, 30), "relative": (30, 9)})
    folder = commit(results)
    for width in (60, 120, 200):
        first, _, *rest = lines_of(folder, width)
        assert first == "Committed records of 6 cells, 6 done."
        facts = [it for it in Report(results).short if it.kind != "command"]
        report = [line.rstrip() for line in printed(FactsTable(facts), width).splitlines()]
        assert rest[: len(report)] == report


def test_records_name_no_folder_of_the_machine(build, commit):
    """Advice to train more names one: it stands in the report alone."""
    results = build()
    folder = commit(results)
    assert any("--until decided" in line for fact in Report(results).short for line in fact.lines)
    told = json.dumps(json.loads((folder / "results.json").read_text())["facts"])
    assert str(results.folder) not in told
    assert "--until decided" not in told


def test_records_of_an_earlier_release_show_their_page_of_text(build, commit):
    """They have no facts; without that page the file is named that lacks."""
    folder = commit(build())
    data = json.loads((folder / "results.json").read_text())
    del data["facts"]
    (folder / "results.json").write_text(json.dumps(data))
    with pytest.raises(SchemaError, match=r"summary\.md is no readable record"):
        committed_table(folder)
    (folder / "summary.md").write_text("# arp-2021\n\n| reward | answer |\n| --- | --- |\n| arp | HURTS |\n")
    text = "\n".join(lines_of(folder))
    assert re.search("reward +answer", text)
    assert re.search("arp +HURTS", text)


def test_the_way_to_the_cells_is_told(build, commit):
    """And where all numbers and figures are."""
    folder = commit(build())
    text = "".join(lines_of(folder))
    assert f"harness run {folder / 'experiment.toml'} --out NEW".replace(" ", "") in text.replace(" ", "")


def test_json_is_the_file(build, commit):
    """As the experiment itself would print it."""
    results = build()
    assert committed_text(commit(results)) == report_text(Report(results))


def test_what_needs_cells_is_refused(build, commit):
    """With the way to get them."""
    with refused(r"--html needs cells.*harness run .*experiment.toml --out NEW"):
        refuse_committed(commit(build()), "--html")


@pytest.mark.parametrize(
    "broken",
    [
        "",
        "[]",
        '{"cells": [], "facts": [{"title": 1}]}',
        '{"cells": [], "facts": [{"grids": [{"headings": ["a", "b"], "rows": [["1"]], "notes": []}]}]}',
    ],
)
def test_damaged_records_are_refused(tmp_path, broken):
    """One line that names the file."""
    (tmp_path / "results.json").write_text(broken)
    with pytest.raises(SchemaError, match=r"results\.json is no readable record"):
        committed_table(tmp_path)


def test_the_committed_records_of_the_project_open(request):
    """Those of the FD100's own experiment."""
    lines = lines_of(request.config.rootpath / "results" / "reference" / "fd100")
    record = json.loads((request.config.rootpath / "results" / "reference" / "fd100" / "results.json").read_text())
    assert lines[0] == f"Committed records of {len(record['cells'])} cells, {len(record['cells'])} done."
    (dense,) = (line for line in lines if line.startswith("dense "))
    assert " the time, 0.770 -> 0.365 s " in dense
    assert " near zero* " in dense
