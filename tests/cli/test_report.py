import html

import numpy as np
import pytest

from tests.laws.writers import evaluations
from tests.left import files_of
from tests.plugins.committed.kept import RECORDS


@pytest.fixture
def experiment(finished):
    """A finished experiment."""
    return finished(seeds=2)


def test_json_is_all_that_goes_to_standard_output(harness, experiment):
    """`--json` prints one JSON document with the combinations and the cells."""
    answer = harness("report mine --json")
    data = answer.json
    assert set(data) == {
        "format",
        "baseline",
        "curve",
        "combinations",
        "over_places",
        "terms",
        "recovered",
        "looks",
        "choosing",
        "cells",
        "facts",
        "not_measured",
        "equal_trainings",
        "evaluation_returns",
        "notes",
        "ranking",
    }
    assert len(data["cells"]) == 4
    assert answer.err == ""


def test_details_are_all_there_is(harness, experiment):
    """The overview is the short form."""
    overview, details = (harness("report mine", *flags).out for flags in ((), ("--details",)))
    assert "harness report mine --details" in overview
    assert "I_N + I_P" not in overview
    assert "I_N + I_P" in details


def test_a_folder_in_a_shown_command_is_quoted(harness, experiment, tmp_path):
    """What is pasted into a shell reports the folder, and touches nothing."""
    named = ";touch X; a b"
    (tmp_path / "mine").rename(tmp_path / named)
    assert f"harness report '{named}' --details" in harness("report", named).out


def test_a_folder_in_the_command_of_the_page_is_quoted(harness, experiment, tmp_path):
    """What is copied from the page trains the experiment again, and touches nothing."""
    named = ";touch X; a b"
    (tmp_path / "mine").rename(tmp_path / named)
    assert harness("report", named, "--html", "page.html").status == 0
    page = html.unescape((tmp_path / "page.html").read_text())
    assert f"harness run '{named}/experiment.toml' --out NEW" in page


def test_several_folders_are_read_as_one(harness, quick, tmp_path):
    """Nothing is written, and no command names the folder that they were read in."""
    for name, seeds in (("one", "0,1"), ("two", "2")):
        harness("run", *quick, "--reward", "arp", "--seeds", f"{seeds},", "--out", name)
    before = files_of(tmp_path)
    answer = harness("report one two")
    assert (answer.status, answer.err) == (0, "")
    assert "3 seeds" in answer.out
    assert "harness report one two --details" in answer.out
    assert "harness-report-" not in answer.out
    assert len(harness("report one two --json").json["cells"]) == 6
    assert files_of(tmp_path) == before


def test_damage_in_one_of_several_folders_is_told(harness, quick, tmp_path):
    """The rest is read; status 1."""
    for name in ("one", "two"):
        harness("run", *quick, "--reward", "arp", "--seeds", "1", "--out", name)
    cell = next((tmp_path / "two" / "cells").iterdir())
    (cell / "trace.parquet").write_bytes(b"PAR1")
    answer = harness("report one two")
    assert answer.status == 1
    assert answer.err.startswith(f"harness: left out: two/cells/{cell.name}: ")


def test_per_step_curves_are_read_on_demand(harness, experiment):
    """`--curve per-step` reads the same traces by NOTE eq. 39-42: the same steps, other sums."""
    told = {kind: harness("report mine --json --curve", kind).json for kind in ("accumulated", "per-step")}
    assert [data["curve"] for data in told.values()] == ["accumulated", "per-step"]
    one, other = (data["combinations"][0]["baseline_index"] for data in told.values())
    assert one["steps"] == other["steps"]
    assert one["total"] != other["total"]


def test_a_run_reads_per_step_curves_too(harness, quick):
    """The flag decides what the table shows, not what is trained."""
    assert "0 of" not in harness("run --reward arp --seeds 1 --curve per-step --out mine", *quick).err
    of_kinds = [harness("report mine --details", *flags).out for flags in (("--curve", "per-step"), ())]
    assert len(set(of_kinds)) == 2


def test_evaluations_of_other_programs_have_a_page(harness, tmp_path):
    """They name no cell, so no episode is shown."""
    successes = np.random.default_rng(0).random((6, 10, 20)) < 0.5
    for at, success in enumerate(successes):
        name = f"logs/{('base', 'prop')[at % 2]}/{at // 2}/evaluations.npz"
        evaluations(tmp_path / name, np.arange(1, 11) * 1000, success)
    assert harness("report logs --html page.html").status == 0


def test_a_damaged_cell_is_told_in_one_line(harness, experiment, tmp_path):
    """A trace that is cut short costs its cell alone; the line names the file and says what to do."""
    trace = next((tmp_path / "mine" / "cells").glob("*/trace.parquet"))
    trace.write_bytes(trace.read_bytes()[:100])
    answer = harness("report mine")
    assert answer.status == 1
    assert answer.err == "harness: damaged cells: 1; harness verify mine says which files\n"
    told = " ".join(answer.out.split())
    assert "1 damaged" in told
    assert "trace.parquet is not what was written: its SHA-256 differs; run again to replace it" in told


def test_summary_goes_where_it_is_told(harness, experiment, tmp_path):
    """`--summary FOLDER` writes the records, says so on standard error, and prints no table."""
    answer = harness("report mine --summary records/kept")
    assert (answer.status, answer.out, answer.err) == (0, "", "Summary: records/kept\n")
    assert {path.name for path in (tmp_path / "records" / "kept").iterdir()} == {*RECORDS, "figures"}


def test_summary_holds_what_json_prints(harness, experiment, tmp_path):
    """Both in one call, and from one document."""
    answer = harness("report mine --summary kept --json")
    assert (tmp_path / "kept" / "results.json").read_text() == answer.out


def test_summary_keeps_what_else_is_there(harness, experiment, tmp_path):
    """A published table beside the records stays as it is."""
    (tmp_path / "kept").mkdir()
    (tmp_path / "kept" / "published.toml").write_text("eta_n = 0.2\n")
    for _ in range(2):
        assert harness("report mine --summary kept").status == 0
    assert (tmp_path / "kept" / "published.toml").read_text() == "eta_n = 0.2\n"


def test_committed_records_open(harness, experiment, tmp_path):
    """The table from the committed files; what needs cells says where they come from, and status is 2."""
    harness("report mine --summary records")
    before = files_of(tmp_path / "records")
    answer = harness("report records")
    assert (answer.status, answer.err) == (0, "")
    assert files_of(tmp_path / "records") == before
    assert "Committed records of 4 cells, 4 done." in answer.out
    assert harness("report records --json").out == harness("report mine --json").out
    for rest in (("--html", "page.html"), ("--ends", "time_to_target=0,9"), (experiment,)):
        answer = harness("report", "records", *rest)
        assert answer.status == 2
        assert "harness run records/experiment.toml --out NEW" in answer.err
