"""``harness verify``, with and without ``--repair``."""

import re
import shutil

from harness.record.cell import read_manifest


def test_sound_folder_ends_with_0(harness, experiment):
    """One line says so, and that there is nothing to repair."""
    assert harness("verify mine")[:2] == (0, "No file of 'mine' is damaged\n")
    told = "No file of 'mine' is damaged: there is nothing to repair\n"
    assert harness("verify mine --repair")[:2] == (0, told)


def test_damage_is_named_set_aside_and_done_again(harness, experiment, quick, tmp_path):
    """Verify, repair, run, verify."""
    trace = next((tmp_path / "mine" / "cells").glob("*/trace.parquet"))
    before = trace.read_bytes()
    trace.write_bytes(before[:100])
    answer = harness("verify mine")
    assert answer.status == 1
    assert (
        "trace.parquet is not what was written: its SHA-256 differs. What to do: run again to replace it." in answer.out
    )
    assert "moved to damaged/" in harness("verify mine --repair").out
    harness("run --reward arp --seeds 1 --out mine", *quick)
    assert trace.read_bytes() == before
    assert harness("verify mine").status == 0


def test_policy_without_numbers_is_damage(harness, experiment, tmp_path):
    """Its digest is right: the status is that of any damage."""
    cell = next((tmp_path / "mine" / "cells").glob("*/policy/card.json")).parents[1]
    (cell / "policy" / "card.json").write_text("{}")
    read_manifest(cell).write(cell)
    answer = harness("verify mine")
    assert answer.status == 1
    assert "holds no readable policy: 'format' is missing. What to do: run again to replace it." in answer.out


def test_page_that_is_made_again_is_what_was_made(harness, experiment, tmp_path):
    """By another version it may have other bytes."""
    page = tmp_path / "mine" / "report.html"
    page.write_text("<html>of an earlier version</html>")
    assert harness("verify mine").status == 1
    harness("report mine --html", page)
    assert harness("verify mine").status == 0


def test_problems_as_json(harness, experiment, tmp_path):
    """Other programs read them."""
    (tmp_path / "mine" / "plan.json").write_text("{")
    [problem] = harness("verify mine --json").json["problems"]
    assert problem["path"] == "plan.json"
    assert set(problem) == {"path", "problem", "remedy"}


def test_second_run_may_refuse_to_wait(harness, experiment, quick, tmp_path):
    """`--no-wait`: one line, exit status 2, nothing written."""
    from harness.record import Store

    before = (tmp_path / "mine" / "plan.json").read_bytes()
    with Store(tmp_path / "mine").locked():
        answer = harness("run --reward arp --seeds 3 --no-wait --out mine", *quick)
    assert answer.status == 2
    assert "Another run is using 'mine'" in answer.err
    assert (tmp_path / "mine" / "plan.json").read_bytes() == before


def test_cells_that_are_not_there_are_counted(harness, experiment, tmp_path):
    """They may be pending: the status says that nothing is damaged."""
    folder = tmp_path / "mine"
    shutil.rmtree(next((folder / "cells").glob("[!.]*")))
    answer = harness("verify mine")
    assert answer.status == 0
    assert re.search(
        r"^Cells of the plan that are not here: 1 of \d+, not run yet or taken away$", answer.out, re.MULTILINE
    )
    assert harness("verify mine --json").json["missing"] == 1
