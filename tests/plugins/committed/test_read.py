"""Committed records, as a terminal shows them."""

import json

import pytest
from rich.console import Console

from harness.errors import SchemaError
from harness.eta.headline import interval_text
from harness.report.document import report_text
from harness.results.overview import decider_text, measure_text
from harness_plugins.committed import committed_table, committed_text, is_committed, refuse_committed
from tests.refusals import refused
from tests.report.conftest import squeezed


@pytest.fixture
def commit(tmp_path):
    """Leaves the records of an experiment in a folder."""

    def write(results):
        folder = tmp_path / "records"
        folder.mkdir()
        (folder / "results.json").write_text(report_text(results) + "\n")
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


def test_every_comparison_has_a_line(build, commit):
    """With the answer and the success that the experiment itself has; what is the same in all is said once."""
    results = build(seeds=1, simulators=("mujoco", "pybullet"), proposed={"arp": (9, 30), "relative": (30, 9)})
    lines = lines_of(commit(results))
    assert lines[:2] == [
        "Committed records of 6 cells, 6 done.",
        "sac · fd100 · fd100-reach · against baseline · 40 steps",
    ]
    rows = [line for line in lines if line.startswith(("mujoco ·", "pybullet ·"))]
    assert len(rows) == len(results.combinations) == 4
    for row, it in zip(rows, results.combinations, strict=True):
        assert row.startswith(f"{it.group.labels['simulator']} · {it.proposed} ")
        assert f" {it.headline.answer.value.upper()} " in row
        assert f" {decider_text(it)} " in row
        assert f" {measure_text(it.decisive)} " in row
    text = squeezed("\n".join(lines))
    for pool in results.pools:
        assert f"Over all places: {pool.headline.answer.value.upper()}. {pool.headline.robot}" in text


def test_intervals_stand_beside_the_ratios_where_there_is_room(build, commit):
    """Those of the experiment; a narrow window has the ratios alone."""
    results = build()
    (combination,) = results.combinations
    wide, narrow = (
        next(line for line in lines_of(folder, width) if line.startswith("arp "))
        for folder in [commit(results)]
        for width in (120, 60)
    )
    assert interval_text(combination.number.eta_p) in wide
    assert "[" not in narrow


def test_a_single_comparison_is_told_in_sentences(build, commit):
    """Both answers."""
    results = build()
    text = " ".join(lines_of(commit(results)))
    (combination,) = results.combinations
    assert combination.headline.robot in text
    assert combination.headline.number in text


def test_what_is_to_be_kept_in_mind_stands_below(build, commit):
    """A number with a star has a remark."""
    lines = lines_of(commit(build(seeds=1, baseline=(39, 0))))
    assert any(line.startswith("* arp: eta_P: ") for line in lines)


def test_the_way_to_the_cells_is_told(build, commit):
    """And where all numbers and figures are."""
    folder = commit(build())
    text = "".join(lines_of(folder))
    assert f"harness run {folder / 'experiment.toml'} --out NEW".replace(" ", "") in text.replace(" ", "")


def test_json_is_the_file(build, commit):
    """As the experiment itself would print it."""
    results = build()
    assert committed_text(commit(results)) == report_text(results)


def test_what_needs_cells_is_refused(build, commit):
    """With the way to get them."""
    with refused(r"--html needs cells.*harness run .*experiment.toml --out NEW"):
        refuse_committed(commit(build()), "--html")


@pytest.mark.parametrize("broken", ["", "[]", '{"combinations": [{"steps": "many"}], "cells": []}'])
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


def test_records_of_an_unfinished_plan_say_so_first(build, commit):
    """As the report that they were written with did."""
    first, second, *_ = lines_of(commit(build(ended={("arp", 2): ("pending", ""), ("arp", 1): ("failed", "x")})))
    assert first == "Committed records of 6 cells, 4 done."
    assert second.startswith("Interim: 2 trainings are missing.")


def test_records_count_the_trainings_of_each_reward(build, commit):
    """They need not be as many."""
    lines = lines_of(commit(build(ended={("arp", 2): ("failed", "it broke")})))
    assert any(line.startswith("arp ") and " 3 / 2 " in line for line in lines)
