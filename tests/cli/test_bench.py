"""`harness bench`: what one types and sees."""

import json
import os
import select
import signal
import subprocess
import sys
import tempfile

import pytest

QUICK = ("--sim", "ideal", "--algo", "wander", "--steps", 12, "--evaluation-episodes", 2, "--rounds", 1)
PARTS = {"start_up", "simulator", "reward", "trace", "env", "algorithm", "evaluation", "saving"}


@pytest.fixture(autouse=True)
def temporary(tmp_path_factory, monkeypatch):
    """Where temporary folders are made."""
    folder = tmp_path_factory.mktemp("temporary")
    monkeypatch.setenv("TMPDIR", str(folder))
    monkeypatch.setattr(tempfile, "tempdir", None)
    return folder


def test_the_table_says_where_the_time_goes(harness, tmp_path, temporary):
    """On standard output; what happens meanwhile on standard error; nothing is left anywhere."""
    answer = harness("bench", *QUICK)
    assert answer.status == 0
    for text in ("ideal · wander · baseline · fd100", "12 environment steps, one round", "start-up", "rest of the env"):
        assert text in answer.out
    assert "[1/1] ideal · wander" in answer.err
    assert list(tmp_path.iterdir()) == list(temporary.iterdir()) == []


def test_json_is_one_object(harness):
    """Everything on standard output is the object; of every combination the parts, their sums and the rounds."""
    data = json.loads(harness("bench", *QUICK, "--rounds", 2, "--reward", "arp:k2=2", "--json").out)
    assert set(data) == {"format", "rounds", "cpu", "versions", "combinations", "failed", "skipped"}
    assert (data["format"], data["rounds"], data["failed"], data["skipped"]) == (1, 2, [], [])
    [first] = data["combinations"]
    assert first["reward"] == "arp:k2=2"
    assert (first["simulator"], first["algorithm"], first["robot"]) == ("ideal", "wander", "fd100")
    assert (first["task"], first["environment_steps"]) == ("fd100-reach", 12)
    assert set(first["seconds"]) == PARTS
    assert min(first["seconds"].values()) > 0.0
    assert first["whole_s"] == pytest.approx(sum(first["seconds"].values()))
    assert first["steps_per_second"] == pytest.approx(12 / first["training_s"])
    assert 0.0 < first["timing_overhead_s"] < first["training_s"]
    assert 0.0 < first["core_share"] < 1.1
    assert [len(entry["seconds"]) for entry in first["rounds"]] == [len(PARTS)] * 2


def test_every_combination_is_timed(harness):
    """Simulators x algorithms; without --reward the baseline alone."""
    data = json.loads(harness("bench", *QUICK, "--sim", "stuck", "--algo", "sweep", "--json").out)
    names = [(entry["simulator"], entry["algorithm"], entry["reward"]) for entry in data["combinations"]]
    assert names == [(s, a, "baseline") for s in ("ideal", "stuck") for a in ("wander", "sweep")]


def test_a_cell_that_raises_is_told_and_the_others_go_on(harness, temporary):
    """Status 1, the reason, and the times of the rest."""
    answer = harness("bench", *QUICK, "--algo", "wander:then=raise")
    assert answer.status == 1
    assert "failed: ideal · wander:then=raise · baseline · seed 0: RuntimeError: the arm fell off" in answer.out
    assert "12 environment steps, one round" in answer.out
    assert list(temporary.iterdir()) == []


def test_what_cannot_work_is_told_with_its_reason(harness):
    """As `harness run` does: it is no failure."""
    answer = harness("bench", "--sim", "ideal", "--algo", "wander", "--task", "fd100-reach:action=discrete")
    assert answer.status == 0
    assert answer.out.startswith("skipped: ideal · wander · baseline · seed 0: ")
    assert "discrete" in answer.out


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ((), "names no sim"),
        (("--sim", "ideal"), "names no algo"),
        (("--sim", "ideall", "--algo", "wander"), "Did you mean 'ideal'?"),
        (("--sim", "ideal", "--algo", "wonder"), "Did you mean 'wander'?"),
        (("--sim", "ideal", "--algo", "wander", "--reward", "ap"), "Did you mean 'arp'?"),
        (("--sim", "ideal", "--algo", "wander", "--task", "fd10-reach"), "Did you mean 'fd100-reach'?"),
        (("--sim", "ideal", "--algo", "wander", "--robot", "fd10"), "Did you mean 'fd100'?"),
        (("--sim", "ideal", "--algo", "wander", "--steps", "0"), "greater than 0"),
        (("--sim", "ideal", "--algo", "wander", "--rounds", "0"), "--rounds 0: must be at least 1"),
        (("--sim", "ideal", "--algo", "wander", "--rounds", "some"), "valid integer"),
    ],
)
def test_usage_errors_are_one_line(harness, tmp_path, temporary, arguments, text):
    """Status 2, one line that says what was given, nothing on standard output, nothing written."""
    answer = harness("bench", *arguments)
    assert (answer.status, answer.out, answer.err.count("\n")) == (2, "", 1)
    assert text in answer.err
    assert list(tmp_path.iterdir()) == list(temporary.iterdir()) == []


def test_an_interrupt_leaves_nothing(toys, tmp_path, temporary):
    """Ctrl-C ends it with status 130; neither a process nor a folder stays."""
    pipe = tmp_path / "pid"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    flags = ["--sim", "ideal", "--algo", f"wander:then=wait,note={pipe}", "--steps", "12"]
    command = [sys.executable, "-c", "from harness.cli import main; main()", "bench", *flags]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert select.select([reader], [], [], 60.0)[0], "the cell that never ends was not started"
        worker = int(os.read(reader, 100))
        os.close(reader)
        assert list(temporary.iterdir())
        process.send_signal(signal.SIGINT)
        try:
            process.communicate(timeout=30)
        finally:
            process.kill()  # if it did not end: the block waits for it
    assert process.returncode == 130
    with pytest.raises(ProcessLookupError):
        os.kill(worker, 0)
    assert list(temporary.iterdir()) == []
