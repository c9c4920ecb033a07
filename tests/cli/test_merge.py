"""``harness merge`` as it is typed."""


def test_two_folders_become_one(harness, quick):
    """What was merged is told, and reported like any experiment."""
    harness("run --reward arp --seeds 0,1 --out one", *quick)
    harness("run --reward arp --seeds 1,2 --out two", *quick)
    answer = harness("merge one two --out all")
    assert (answer.status, answer.err) == (0, "")
    assert answer.out == "Merged:  6 of 6 cells have ended\nResults: all\nReport:  all/report.html\n"
    assert harness("verify all").status == 0
    assert "3 seeds (0, 1, 2) compared" in harness("report all --details").out


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
