"""`harness bench`: what one types and sees."""

import json
import os
import select
import signal
import subprocess
import sys
import tempfile

import pytest

from harness_plugins.bench.contests import Round
from harness_plugins.bench.timed_cell import Failed

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
        (
            ("--sim", "ideal", "--algo", "wander", "--num-envs", "3"),
            "--num-envs: only 'harness bench simulators' takes it",
        ),
        (("simulator",), "Did you mean 'simulators'?"),
        (("cells", "simulators"), "timed alone"),
        (("simulators", "--sim", "ideall"), "Did you mean 'ideal'?"),
        (("simulators", "--reward", "arp"), "--reward: only 'harness bench cells' takes it"),
        (("simulators", "--num-envs", "1,x"), "--num-envs 1,x: give numbers from 1 on"),
        (("simulators", "--num-envs", "0"), "--num-envs 0: give numbers from 1 on"),
        (("algorithms", "--steps", "0"), "--steps 0: must be at least 1"),
        (("--compare", "nowhere.json"), "'nowhere.json' cannot be read: No such file"),
        (("--compare", "nowhere.json", "--sim", "ideal"), "--sim: --compare measures what OLD.json holds"),
        (("simulators", "--compare", "nowhere.json"), "WHAT: --compare measures what OLD.json holds"),
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


@pytest.fixture
def timed(monkeypatch):
    """Rounds without processes: what the env's speed is, one number after the other, for ever the last."""
    speeds = [0.5]

    def pretend(work, folder):
        if work.entry.name in pretend.broken:
            return Failed("it broke")
        speed = speeds.pop(0) if len(speeds) > 1 else speeds[0]
        return Round({"bare engine": 1e-4, "env": 1e-4 / speed}, {"env": speed})

    pretend.broken = ()
    monkeypatch.setattr("harness_plugins.bench.measure.time_contest", pretend)
    return speeds, pretend


SPEEDS = ("simulators", "--sim", "ideal", "--num-envs", "1,8")


def test_speeds_are_a_table(harness, timed, tmp_path):
    """On standard output; what happens meanwhile on standard error; nothing is kept."""
    answer = harness("bench", *SPEEDS, "--rounds", 2)
    assert answer.status == 0
    assert "ideal, 8 envs: env" in answer.out
    assert "0.50" in answer.out
    assert answer.err.splitlines() == [
        f"[{n}/4] ideal, {n_envs}" for n, n_envs in enumerate(["1 env", "8 envs"] * 2, 1)
    ]
    assert list(tmp_path.iterdir()) == []


def _keep(harness, tmp_path, *arguments) -> str:
    (tmp_path / "old.json").write_text(harness("bench", *SPEEDS, *arguments, "--json").out)
    return "old.json"


def test_the_same_speed_is_no_regression(harness, timed, tmp_path):
    """Status 0; the same entries as then, as often."""
    answer = harness("bench", "--compare", _keep(harness, tmp_path))
    assert answer.status == 0
    assert "Nothing of 2 became slower beyond the noise." in answer.out
    assert "[18/18] ideal, 8 envs" in answer.err


def test_a_regression_has_status_1_and_names_what_by_how_much(harness, timed, tmp_path):
    """In the table, and as JSON."""
    old = _keep(harness, tmp_path)
    timed[0][:] = [0.4]
    answer = harness("bench", "--compare", old)
    assert answer.status == 1
    assert "SLOWER  ideal, 8 envs: env is 20% slower beside the bare engine" in " ".join(answer.out.split("\n"))
    answer = harness("bench", "--compare", old, "--json")
    comparison = json.loads(answer.out)["comparison"]
    assert (answer.status, comparison["slower"]) == (1, 2)
    assert comparison["changes"][0]["ratio"] == pytest.approx(0.8)


def test_other_versions_are_told(harness, timed, tmp_path):
    """They may be why."""
    path = tmp_path / _keep(harness, tmp_path)
    data = json.loads(path.read_text())
    data["versions"]["numpy"], data["cpu"] = "0.1", "an abacus"
    path.write_text(json.dumps(data))
    out = harness("bench", "--compare", path).out
    assert "The versions of numpy differ: 0.1 before" in out
    assert "The machines differ: an abacus before" in out


def test_a_run_of_two_rounds_cannot_be_compared(harness, timed, tmp_path):
    """It says how many it takes, before anything is measured."""
    answer = harness("bench", "--compare", _keep(harness, tmp_path, "--rounds", 2))
    assert (answer.status, answer.out) == (2, "")
    assert "'old.json' has 2 rounds: at least 3 are needed to estimate the noise" in answer.err


def test_a_file_of_cells_cannot_be_compared(harness, tmp_path):
    """It has seconds alone, which differ from moment to moment."""
    (tmp_path / "old.json").write_text('{"format": 1, "combinations": []}')
    answer = harness("bench", "--compare", "old.json")
    assert (answer.status, answer.err.count("\n")) == (2, 1)
    assert "holds no speeds" in answer.err


@pytest.mark.parametrize("content", [b"hello", b"{", b"\xff\xfe", b"[]"])
def test_what_is_no_json_of_speeds_is_a_usage_error(harness, tmp_path, content):
    """Status 2 and one line, which says which file it takes."""
    (tmp_path / "old.json").write_bytes(content)
    answer = harness("bench", "--compare", "old.json")
    assert (answer.status, answer.out, answer.err.count("\n")) == (2, "", 1)
    assert "harness bench simulators --json" in answer.err


def test_what_fails_has_status_1(harness, timed):
    """With its reason."""
    timed[1].broken = ("ideal",)
    answer = harness("bench", *SPEEDS)
    assert answer.status == 1
    assert "failed: ideal, 1 env: it broke" in answer.out


def test_a_page_is_written_where_it_is_wanted(harness, timed, tmp_path):
    """Beside the table."""
    answer = harness("bench", *SPEEDS, "--html", "page.html")
    assert answer.status == 0
    assert "Page: page.html" in answer.err
    assert "ideal, 8 envs: env" in (tmp_path / "page.html").read_text()
