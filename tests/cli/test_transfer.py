import json
import os
import select
import signal
import subprocess
import sys


def test_json_is_all_that_goes_to_standard_output(transferred_here, harness, experiment):
    """`--json` prints one JSON document: a matrix per algorithm and reward, and what failed."""
    answer = harness("transfer mine --to stuck --json")
    data = answer.json
    assert answer.status == 0
    assert set(data) == {"format", "combinations", "failed"}
    assert [(item["algorithm"], item["reward"]) for item in data["combinations"]] == [
        ("wander", "baseline"), ("wander", "arp"),
    ]  # fmt: skip
    first = data["combinations"][0]
    assert (first["trained_in"], first["evaluated_in"]) == (["ideal"], ["ideal", "stuck"])
    for name in ("success", "return", "drop"):
        assert [len(row) for row in first[name]] == [2]
        assert set(first[name][0][0]) == {"value", "low", "high", "seeds", "note"}


def test_engine_that_talks_does_not_disturb_the_json(harness, quick, tmp_path):
    """What an engine prints when it is imported does not come before the document."""
    assert harness("run --reward arp --seeds 1 --out mine", *quick).status == 0
    command = [sys.executable, "-c", "from harness.cli import main; main()"]
    command += ["transfer", "mine", "--to", "pybullet", "--json"]
    told = subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    assert json.loads(told.stdout)["combinations"][0]["evaluated_in"] == ["ideal", "pybullet"]


def test_table_has_the_matrix(transferred_here, harness, experiment):
    """Without a flag: a row per simulator trained in, a column per simulator evaluated in."""
    out = harness("transfer mine --to stuck").out
    assert "ideal: success" in out
    assert "trained in \\ evaluated in" in out
    assert "one seed: no interval below 3 seeds" in out


def test_second_call_evaluates_nothing(harness, experiment):
    """It says what was done before, and prints the same."""
    first = harness("transfer mine --to stuck --jobs 1")
    second = harness("transfer mine --to stuck")
    assert first.err.splitlines()[-1].startswith("[2/2] ideal · wander · arp · seed 0 in stuck: ")
    assert second.err == "2 of 2 evaluations were done before and are not run again\n"
    assert second.out == first.out


def test_failed_evaluation_ends_with_1(transferred_here, harness, experiment):
    """Its reason is on both streams; the rest is there."""
    answer = harness("transfer mine --to stuck,stuck:then=raise")
    assert answer.status == 1
    assert answer.err.count("FAILED: RuntimeError: the arm fell off") == 2
    assert "failed: ideal · wander · baseline · seed 0 in stuck:then=raise" in " ".join(answer.out.split())
    data = harness("transfer mine --to stuck --json").json
    assert data["failed"][0] == {
        "cell": data["failed"][0]["cell"],
        "algorithm": "wander",
        "reward": "baseline",
        "seed": 0,
        "trained_in": "ideal",
        "evaluated_in": "stuck:then=raise",
        "reason": "RuntimeError: the arm fell off",
    }


def test_only_the_home_is_nothing_to_do(harness, experiment):
    """Where the policies were trained they were evaluated: there is no matrix, and the command says so."""
    answer = harness("transfer mine --to ideal")
    assert (answer.status, answer.err) == (0, "")
    assert answer.out.startswith("Nothing to evaluate")


def test_report_shows_what_is_recorded(transferred_here, harness, experiment, tmp_path):
    """The report has a section on transfer once there is one, in table, JSON and page; before, it has none."""
    assert "Transfer" not in harness("report mine").out
    before = {*harness("report mine --json").json}
    harness("transfer mine --to stuck")
    assert "Transfer between simulators" in harness("report mine").out
    data = harness("report mine --json").json
    assert {*data} - before == {"transfer"}
    assert data["transfer"] == harness("transfer mine --to stuck --json").json
    harness("report mine --html page.html")
    assert "Transfer between simulators" in (tmp_path / "page.html").read_text()


def test_missing_library_names_its_extra(harness, experiment, distant):
    """A simulator that was asked for and is not installed ends with the line that installs it."""
    answer = harness("transfer mine --to distant")
    assert (answer.status, answer.err.count("\n")) == (2, 1)
    assert "pip install 'far-away[engine]'" in answer.err


def test_interrupt_keeps_what_was_done(harness, experiment, tmp_path):
    """Ctrl-C ends with 130, one line that says how to go on, no worker and nothing half-done."""
    note = tmp_path / "pid"
    os.mkfifo(note)
    arguments = ["transfer", experiment, "--to", f"stuck:then=wait,note={note}", "--jobs", "1"]
    script = f"from harness.cli import main; main({arguments!r})"
    call = subprocess.Popen([sys.executable, "-c", script], stderr=subprocess.PIPE, text=True)
    watch = os.pidfd_open(int(note.read_text()))
    try:
        call.send_signal(signal.SIGINT)
        _, err = call.communicate(timeout=60)
        assert select.select([watch], [], [], 30.0)[0] == [watch]
    finally:
        os.close(watch)
    assert call.returncode == 130
    assert "interrupted: what was evaluated is kept in 'mine'" in err
    assert not list((tmp_path / "mine" / "transfer").glob("*/*"))
