import os
import select
import signal
import subprocess
import sys
from dataclasses import replace

import pytest

from harness.record import Store
from tests.left import files_of


def test_missing_tensorboard_is_told_before_anything_runs(harness, quick, tmp_path, monkeypatch):
    """One line that says what to install, and an empty folder."""
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    answer = harness("run --reward arp --tracker tensorboard", *quick)
    assert (answer.status, answer.err.count("\n")) == (2, 1)
    assert "pip install 'fd100-harness[tensorboard]'" in answer.err
    assert list(tmp_path.iterdir()) == []


def test_tensorboard_leaves_event_files(harness, quick, tmp_path):
    """A folder for every cell, beside the cells; the next run finds nothing to do."""
    harness("run --reward arp --seeds 1 --tracker tensorboard --out watched", *quick)
    cells = sorted(folder.name for folder in (tmp_path / "watched" / "cells").iterdir())
    events = sorted((tmp_path / "watched" / "tensorboard").iterdir())
    assert sorted(folder.name.split("-")[-2] for folder in events) == cells
    assert all(list(folder.iterdir()) for folder in events)
    again = harness("run --reward arp --seeds 1 --tracker tensorboard --out watched", *quick)
    assert (again.status, "2 of 2 cells were done before" in again.err) == (0, True)


def test_a_tracker_that_raises_costs_one_line(harness, quick):
    """Every cell is done, and the line names the tracker and what it raised."""
    answer = harness("run --reward arp --seeds 1 --tracker clumsy", *quick)
    assert answer.status == 0
    [line] = [line for line in answer.err.splitlines() if "clumsy" in line]
    assert line == "harness: tracker 'clumsy' is switched off, the cells go on: ConnectionError: no such server"


def test_only_counts_the_cells_that_it_names(harness, quick):
    """What was done before and is not named is no part of the count."""
    harness("run --reward arp --seeds 2 --only baseline --out mine", *quick)
    answer = harness("run --reward arp --seeds 2 --only arp --out mine", *quick)
    assert "done before" not in answer.err
    assert "[2/2]" in answer.err


def test_evaluation_is_told_by_flags(harness, quick, tmp_path):
    """`--evaluate-every` and `--stochastic` are part of the cells, and the report says how policies acted."""
    flags = ("--algo", "narrate", "--seeds", "1", "--evaluate-every", "5", "--stochastic")
    harness("run", *quick[:2], *quick[4:], "--reward", "arp", *flags, "--out", "mine")
    assert "trained policies, stochastic" in harness("report mine --details").out
    data = harness("report mine --json").json
    assert data["combinations"][0]["deterministic"] is False
    curve = data["combinations"][0]["learning"]["metrics"]["success_rate"]["proposed"]
    assert [point["steps"] for point in curve] == [5, 10, 12]


def test_summaries_are_refused(harness, quick, tmp_path):
    """The records of an experiment are left alone, its `experiment.toml` among them."""
    harness("run --reward arp --seeds 1 --out mine", *quick)
    harness("report mine --summary kept")
    before = files_of(tmp_path / "kept")
    answer = harness("run --reward arp --seeds 2 --out kept", *quick)
    assert (answer.status, answer.err.count("\n")) == (2, 1)
    assert "--out 'kept' holds something else than an experiment" in answer.err
    assert files_of(tmp_path / "kept") == before


def test_a_missing_library_names_its_extra(harness, distant):
    """A simulator whose library is not installed ends with the line that installs it."""
    answer = harness("run --sim distant --algo wander")
    assert answer.status == 2
    assert "pip install 'far-away[engine]'" in answer.err


def test_a_run_prints_the_pay_and_leaves_its_results(harness, quick, tmp_path):
    """Pay, ruler and where the results and the report are stand on standard output, the progress on standard error."""
    answer = harness("run --reward arp --seeds 1 --out mine", *quick)
    assert answer.status == 0
    for text in ("pay", "ruler", "Success ", "Results: mine", "mine/report.html"):
        assert text in answer.out
        assert text not in answer.err
    assert "seed 0: started" in answer.err
    left = {path.name for path in (tmp_path / "mine").iterdir()}
    assert {"experiment.toml", "plan.json", "cells", "results.parquet", "report.html"} <= left


def test_a_reward_against_itself_is_trained_again(harness, quick):
    """The null control A/A: the baseline with other seeds; its ruler is 1, whatever eta is."""
    harness("run --reward baseline --seeds 2 --out mine", *quick)
    data = harness("report mine --json").json
    (control,) = data["combinations"]
    assert (control["proposed"], control["is_control"], control["seeds"]) == ("baseline", True, [0, 1])
    assert [cell["seed"] for cell in data["cells"]] == [0, 1, 2, 3]
    assert control["headline"]["answer"] == "cannot tell"  # two trainings that learn nothing do not show that none does
    rulers, etas = ([control[name][part]["value"] for name in ("eta_N", "eta_P")] for part in ("ruler", "eta"))
    assert set(rulers) - {None} == {1.0}
    assert 1.0 not in etas


def test_the_default_folder_is_named_for_the_plan(harness, quick, tmp_path):
    """Without --out the results go under results/runs, and the same command finds them again."""
    harness("run --reward arp --seeds 1", *quick)
    again = harness("run --reward arp --seeds 1", *quick)
    assert len(list((tmp_path / "results" / "runs").iterdir())) == 1
    assert "2 of 2 cells were done before" in again.err


def test_lists_take_commas_and_repeated_flags(harness, quick):
    """Commas and repeated flags make the same matrix; parameters stay with the name before them."""
    harness("run --reward arp:k1=1,k2=2,arp --reward arp:k2=3 --seeds 1, --out mine", *quick)
    data = harness("report mine --json").json
    assert [entry["proposed"] for entry in data["combinations"]] == ["arp:k2=2", "arp", "arp:k2=3"]
    assert {cell["seed"] for cell in data["cells"]} == {1}


def test_a_file_is_the_same_as_flags_and_a_flag_wins(harness, quick, tmp_path):
    """An experiment file gives the cells that its keys would give as flags; a flag overrules its key."""
    (tmp_path / "my.toml").write_text(
        'sim = "ideal"\nalgo = [{name = "wander", width = 8}]\nreward = "arp"\nseeds = [4]\nsteps = 24\n'
        "evaluation_episodes = 2\n"
    )
    harness("run my.toml --steps 12 --executor here --out a")
    harness("run --reward arp --seeds 4, --out b", *quick, "--algo", "wander:width=8")
    ids = [{cell["id"] for cell in harness("report", name, "--json").json["cells"]} for name in "ab"]
    assert ids[0] <= ids[1]  # b has `wander` as it stands too


def test_a_failed_cell_costs_itself_alone(harness, quick):
    """A cell that raises is shown with its reason, the others are done, and the status is 1."""
    answer = harness("run --reward arp --seeds 1 --out mine", *quick, "--algo", "wander:then=raise")
    assert answer.status == 1
    assert "FAILED: RuntimeError: the arm fell off" in answer.err
    assert {cell["status"] for cell in harness("report mine --json").json["cells"]} == {"done", "failed"}


def test_combinations_that_cannot_work_are_skipped_with_the_reason(harness, quick):
    """An algorithm for other actions is skipped, said so, and no failure."""
    task = "fd100-reach:action=discrete"
    line = "run --reward arp --seeds 1 --out mine"
    assert harness(line, *quick, "--algo", "wander,buttons", "--task", task).status == 0
    told = {(cell["algorithm"], cell["status"], cell["reason"]) for cell in harness("report mine --json").json["cells"]}
    reason = "wander takes continuous actions, the task's are discrete"
    assert told == {("wander", "skipped", reason), ("buttons", "done", "")}


def test_one_task_serves_continuous_and_discrete_algorithms(harness, quick):
    """Each algorithm is compared on the task in its own form, and the report names it."""
    assert harness("run --reward arp --seeds 2 --out mine", *quick, "--algo", "wander,buttons").status == 0
    found = harness("report mine --json").json["combinations"]
    forms = {combination["algorithm"]: combination["task"] for combination in found}
    assert forms["buttons"] == f"{forms['wander']}:action=discrete:action=movej"
    assert all(combination["seeds"] == [0, 1] for combination in found)


def test_ctrl_c_keeps_what_is_finished(toys, tmp_path):
    """SIGINT ends with status 130, no worker is left, and finished cells are there."""
    pipe, out = tmp_path / "pid", tmp_path / "mine"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    flags = ["--sim", "ideal", "--steps", "12", "--seeds", "1", "--jobs", "1", "--evaluation-episodes", "2"]
    flags += ["--reward", "arp", "--algo", f"wander,wander:then=wait,note={pipe}", "--out", str(out)]
    command = [sys.executable, "-c", "from harness.cli import main; main()", "run", *flags]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, cwd=tmp_path)
    assert select.select([reader], [], [], 60.0)[0], "the cell that never ends was not started"
    worker = int(os.read(reader, 100))
    os.close(reader)
    process.send_signal(signal.SIGINT)
    told = process.communicate(timeout=30)[1]
    assert process.returncode == 130
    assert "finished cells are kept" in told
    with pytest.raises(ProcessLookupError):
        os.kill(worker, 0)
    assert len(list((out / "cells").glob("[!.]*"))) == 2


def test_hint_of_a_missing_extra_is_whole(harness, quick, monkeypatch):
    """What to type stands there with its brackets, which are no markup."""
    monkeypatch.setitem(sys.modules, "jinja2", None)
    assert "pip install 'fd100-harness[report]'" in harness("run --reward arp --seeds 1 --out mine", *quick).out


def test_cells_of_other_plugins_are_not_mixed_in_silence(harness, quick, tmp_path):
    """Refused in one line that says what can be done; kept, the table marks it; done again, nothing is left to say."""
    harness("run --reward arp --seeds 1 --out mine", *quick)
    store = Store.open(tmp_path / "mine")
    first = store.manifests()[0]
    edited = {**first.environment, "sources": {**first.environment["sources"], "algorithms": "9340a572" * 8}}
    replace(first, environment=edited).write(store.cell_folder(first.cell))
    asked = ("run --reward arp --seeds 2 --out mine", *quick)
    refused = harness(*asked)
    assert (refused.status, refused.out, refused.err.count("\n")) == (2, "", 1)
    assert refused.err.startswith("harness: 1 done cell was made by another wander (9340a572, now ")
    assert "--changed keep" in refused.err
    assert len(store.manifests()) == 2
    kept = harness(*asked, "--changed", "keep")
    assert (kept.status, "1 of 4 cells was made by another wander (9340a572; the others " in kept.out) == (0, True)
    again = harness(*asked, "--changed", "again")
    assert (again.status, "another wander" in again.out) == (0, False)


def test_dry_run_says_what_it_would_do_and_writes_nothing(harness, quick, tmp_path):
    """Where, which cells, and that nobody knows how long it takes."""
    answer = harness("run --reward arp --seeds 2 --out mine --dry-run", *quick)
    assert (answer.status, answer.err) == (0, "")
    assert "Folder: mine (new)\n4 cells: 4 to do\n" in answer.out
    assert "to do: ideal · wander · arp: 2 seeds: 0, 1\n" in answer.out
    unknown = "no cell of ideal · wander is done in the folder yet, and the executor here trains elsewhere. --only "
    assert f"Time: not known: {unknown}" in answer.out
    assert answer.out.endswith("Nothing is written.\n")
    assert list(tmp_path.iterdir()) == []


def test_dry_run_knows_what_is_done(harness, quick):
    """Time and disk follow from it; as JSON too."""
    harness("run --reward arp --seeds 1 --out mine", *quick)
    asked = ("run --reward arp --seeds 2 --out mine --dry-run", *quick)
    out = harness(*asked).out
    assert "done: ideal · wander · arp: seed 0\n" in out
    assert "to do: ideal · wander · arp: seed 1\n" in out
    assert "Time: about " in out
    assert "Disk: about " in out
    data = harness(*asked, "--json").json
    assert (len(data["done"]), len(data["to_do"]), data["left"], data["unknown"]) == (2, 2, 0, "")


def test_quiet_shows_the_results_alone(harness, quick):
    """Nothing on standard error."""
    answer = harness("run --reward arp --seeds 1 --out mine --quiet", *quick)
    assert (answer.status, answer.err) == (0, "")
    assert "pay of an episode" in answer.out


def test_json_stands_alone_on_standard_output(harness, quick):
    """What `harness report --json` prints; where it was written is told on standard error."""
    answer = harness("run --reward arp --seeds 1 --out mine --quiet --json", *quick)
    assert answer.json == harness("report mine --json").json
    assert answer.err == "Results: mine\nReport:  mine/report.html\n"


@pytest.mark.slow
@pytest.mark.parametrize(
    "base",
    ["xyz_m = [0, 0, 1.2], rpy_deg = [0, 90, 0]", "xyz_m = [0, 0, 2], rpy_deg = [180, 0, 0]", "xyz_m = [0, 0, 0.75]"],
    ids=["wall", "ceiling", "table"],
)
def test_an_arm_on_its_mount_is_trained_without_another_flag(harness, tmp_path, base, monkeypatch):
    """By a robot.toml of three lines, in every simulator; from another folder nothing is done again."""
    (tmp_path / "arm").mkdir()
    lines = ['name = "iiwa"', 'urdf = "pybullet_data:kuka_iiwa/model.urdf"', f"base = {{ {base} }}"]
    (tmp_path / "arm" / "robot.toml").write_text("\n".join(lines))
    flags = ("--sim", "kinematic,mujoco,pybullet", "--algo", "sac", "--reward", "arp", "--steps", "300", "--seeds", "1")
    assert harness("run", *flags, "--robot", "arm/", "--out", "mine").status == 0
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    answer = harness("run ../mine/experiment.toml --out ../mine")
    assert answer.status == 0
    assert "started" not in answer.err
    assert len(list((tmp_path / "mine" / "cells").iterdir())) == 6
