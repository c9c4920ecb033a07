import json
import os
import select
import shutil
import signal
import subprocess
import sys
import tomllib

import pytest

QUICK = (
    "--sim", "ideal", "--algo", "sweep", "--task", "fd100-reach:epsilon=0.2,horizon=5", "--search", "effort=0..1",
    "--trials", "2", "--seeds", "1", "--steps", "2", "--validation-episodes", "5", "--jobs", "1",
)  # fmt: skip
HERE = (*QUICK, "--executor", "here")

BAD = [
    (["--search", "effort=0..1"], "no sim and no algo: give --sim NAME and --algo NAME, or the keys 'sim' and 'algo'"),
    (["--sim", "ideal"], "names no algo"),
    ([*QUICK, "--sim", "stuck"], "--sim names 2"),
    ([*QUICK, "--search", "efort=0..1"], "Did you mean 'effort'?"),
    ([*QUICK, "--search", "effort=0..1"], "--search names 'effort' twice"),
    ([*QUICK, "--search", "turns"], "--search 'turns' names no values of 'turns': write turns=LOW..HIGH"),
    ([*QUICK, "--search", "turns="], "--search 'turns=' names no values of 'turns'"),
    ([*QUICK, "--search", "=1..3"], "--search '=1..3' names no parameter: write KEY=LOW..HIGH"),
    ([*QUICK, "--search", "turns=1..3,layers=4|8"], "names several parameters: give --search once for each"),
    ([*QUICK, "--search", "turns=0..3"], "greater than or equal to 1"),
    ([*QUICK, "--trials", "0"], "greater than 0"),
    ([*QUICK, "--pruner", "some"], "'median' or 'none'"),
    ([*QUICK, "--seed", "-1"], "greater than or equal to 0"),
    ([*QUICK, "--jobs", "0"], "jobs=0: must be at least 1"),
    ([*QUICK, "--executor", "cloud"], "No executor 'cloud'"),
    (["missing.toml"], "No tuning file 'missing.toml'"),
]


@pytest.mark.parametrize(
    ("arguments", "told"), BAD, ids=lambda value: " ".join(value)[-40:] if isinstance(value, list) else ""
)
def test_bad_input_is_told_in_one_line_and_writes_nothing(harness, tmp_path, arguments, told):
    """What cannot be used ends with status 2, one line that says what is allowed, and an empty folder."""
    answer = harness("tune", *arguments)
    assert (answer.status, answer.out, answer.err.count("\n")) == (2, "", 1)
    assert told in answer.err
    assert list(tmp_path.iterdir()) == []


def test_missing_optuna_names_the_extra(harness, tmp_path, monkeypatch):
    """One line that says what to install, and nothing written."""
    monkeypatch.setitem(sys.modules, "optuna", None)
    answer = harness("tune", *QUICK)
    assert (answer.status, answer.err) == (2, "harness: harness tune needs optuna: pip install 'fd100-harness[tune]'\n")
    assert list(tmp_path.iterdir()) == []


def test_tuning_prints_its_trials_and_leaves_an_experiment(harness, tmp_path):
    """A table on standard error, JSON alone on standard output, and a file that `harness run` reads."""
    answer = harness("tune", *HERE, "--out", "mine", "--json")
    assert answer.status == 0
    data = json.loads(answer.out)
    assert [trial["status"] for trial in data["searches"][0]["trials"]] == ["complete", "complete"]
    for text in ("[trial 2/2] baseline and arp", "final distance", "Tuned: mine/tuned.toml"):
        assert text in answer.err
    assert tomllib.loads((tmp_path / "mine" / "tuned.toml").read_text())["algo"][0]["name"] == "sweep"
    ran = harness("run", "mine/tuned.toml", "--seeds", "1", "--evaluation-episodes", "2", "--executor", "here")
    assert ran.status == 0


def test_a_file_is_the_same_as_flags_and_a_flag_wins(harness, tmp_path):
    """What a folder's tuning.toml says is the same search; the default folder shows it."""
    harness("tune", *HERE, "--trials", "1")
    (folder,) = (tmp_path / "results" / "runs").iterdir()
    shutil.copy(folder / "tuning.toml", tmp_path / "my.toml")
    again = harness("tune", "my.toml", "--trials", "2", "--executor", "here", "--jobs", "1")
    assert again.status == 0
    assert list((tmp_path / "results" / "runs").iterdir()) == [folder]
    assert "[trial 2/2]" in again.err
    assert "[trial 1/2]" not in again.err


def test_failed_cells_end_with_1(harness):
    """The trial's reason is in the table, and in the JSON."""
    answer = harness("tune", *HERE[:2], "--algo", "sweep:breaks_above=0,effort=1", *HERE[4:], "--json")
    assert answer.status == 1
    assert "trial 0 failed: RuntimeError: the arm fell off" in answer.err
    assert json.loads(answer.out)["searches"][0]["trials"][0]["reason"] == "RuntimeError: the arm fell off"


def test_ctrl_c_keeps_what_is_finished(toys, tmp_path):
    """SIGINT ends with status 130 and one line that says how to go on; no worker is left."""
    pipe = tmp_path / "pid"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    flags = ["--sim", "ideal", "--algo", f"wander:then=wait,note={pipe}", "--search", "width=1..4", "--jobs", "1"]
    command = [sys.executable, "-c", "from harness.cli import main; main()", "tune", *flags, "--steps", "2"]
    process = subprocess.Popen([*command, "--out", "mine"], stderr=subprocess.PIPE, text=True, cwd=tmp_path)
    assert select.select([reader], [], [], 60.0)[0], "no cell was started"
    worker = int(os.read(reader, 100))
    os.close(reader)
    process.send_signal(signal.SIGINT)
    told = process.communicate(timeout=30)[1]
    assert process.returncode == 130
    assert "finished cells are kept in 'mine'. The same command goes on with the rest" in told
    with pytest.raises(ProcessLookupError):
        os.kill(worker, 0)


def test_command_line_imports_no_optuna():
    """It is imported by this command alone, when it is used."""
    script = "import sys, harness.cli; assert not [m for m in sys.modules if m.split('.')[0] == 'optuna']"
    subprocess.run([sys.executable, "-c", script], check=True)
