"""``harness merge`` as it is typed."""

import shutil
from dataclasses import replace

import pytest

from harness.record import read_manifest


def test_two_folders_become_one(harness, quick):
    """What was merged is told, and reported like any experiment."""
    harness("run --reward arp --seeds 0,1 --out one", *quick)
    harness("run --reward arp --seeds 1,2 --out two", *quick)
    answer = harness("merge one two --out all")
    assert (answer.status, answer.err) == (0, "")
    assert answer.out == "Merged:  6 of 6 cells have ended\nResults: all\nReport:  all/report.html\n"
    assert harness("verify all").status == 0
    assert "3 seeds (0, 1, 2) compared" in harness("report all --details").out


@pytest.fixture
def two(harness, quick, tmp_path):
    """Two folders of an experiment."""
    harness("run --reward arp --seeds 0,1 --out one", *quick)
    harness("run --reward arp --seeds 2,3 --out two", *quick)
    return tmp_path / "one", tmp_path / "two"


@pytest.mark.parametrize(
    ("part", "key", "told"),
    [
        ("machine", "kernel", "2 of 8 cells were made by another kernel of OpenBLAS (of another CPU; the others "),
        ("versions", "numpy", "2 of 8 cells were made by another numpy (of another CPU; the others "),
        ("sources", "algorithms", "2 of 8 cells were made by another wander (of anoth; the others "),
    ],
)
def test_what_is_not_the_same_in_all_cells_is_told(harness, two, part, key, told):
    """A line where they are merged, and in every report of them."""
    for folder in sorted((two[1] / "cells").glob("*"))[:2]:
        manifest = read_manifest(folder)
        there = {**manifest.environment[part], key: "of another CPU"}
        replace(manifest, environment={**manifest.environment, part: there}).write(folder)
    assert told in harness("merge one two --out all").err
    assert told in harness("report one two").out
    assert told in harness("report all").out


def test_plan_that_was_put_together_is_told_by_every_command(harness, quick, two):
    """Also when it was merged, or written again: until one command asks for all of its cells."""
    told = "The plan was put together from 3 cells; run the same command as before to mend it"
    shutil.rmtree(sorted((two[0] / "cells").glob("[!.]*"))[0])
    (two[0] / "plan.json").write_text("{")
    assert told in harness("verify one").out
    assert told in harness("merge one two --out all").err
    harness("verify one --repair")
    for folder in ("one", "all"):
        assert told in harness(f"status {folder}").out
        assert told in harness(f"verify {folder}").out
        for command in ("status", "verify", "report"):
            assert told in harness(f"{command} {folder} --json").json["recovered"]
        report = harness(f"report {folder}").out
        assert "Interim: nobody knows how many trainings are missing." in report
        assert told in " ".join(report.split())
        harness(f"report {folder} --summary {folder}-records")
        assert "Interim: nobody knows how many trainings are missing." in harness(f"report {folder}-records").out
    harness("run --reward arp --seeds 7,8 --out one", *quick)
    assert told in harness("status one").out
    harness("run --reward arp --seeds 0,1,7,8 --out one", *quick)
    assert told not in harness("status one").out


def test_damaged_cell_is_named(harness, quick, tmp_path):
    """One line for each, and status 1."""
    harness("run --reward arp --seeds 1 --out one", *quick)
    cell = sorted((tmp_path / "one" / "cells").iterdir())[0]
    (cell / "trace.parquet").write_bytes(b"PAR1")
    answer = harness("merge one --out all")
    assert answer.status == 1
    assert answer.err.startswith(f"harness: left out: one/cells/{cell.name}: ")
    assert answer.err.count("\n") == 1
    assert "1 of 2 cells have ended" in answer.out
