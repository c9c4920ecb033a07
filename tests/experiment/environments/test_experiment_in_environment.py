"""An experiment whose task is an environment: from its plan to its records, on a toy of a few numbers."""

import csv
import json
import re
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow.csv
import pyarrow.parquet as pq
import pytest
from numpy.testing import assert_array_equal

from harness import load_registry, load_results
from harness.executor import CellOptions
from harness.experiment.experiment import check, prepare
from harness.experiment.plan import check_experiment, expand
from harness.experiment.run_cell import run_cell
from harness.experiment.run_options import RunOptions
from harness.experiment.verify import verify
from harness.policy import load_policy
from harness.record import (
    LOG,
    MANIFEST,
    POLICY,
    Store,
    TrainingFacts,
    partial_folder,
    read_manifest,
    read_recording,
)
from harness.record.cell import digests_in
from harness.record.merge import merge
from harness.record.progress import RETURN, SUCCESS
from harness.record.recording.recording_writer import write_recording
from harness.record.status import read_status
from harness.registry import read_given
from harness_plugins.exporters.csv_runs import write_runs
from tests.plugins.committed.kept import RECORDS
from tests.refusals import refused
from tests.stores import create_store

TOY = Path(__file__).with_name("toy.py")
STEPS = 32


def _plan(registry, **keys):
    asked = {"task": "toy", "algo": "random", "seeds": 2, "steps": STEPS, "evaluation_episodes": 3, **keys}
    return expand(check_experiment(asked), registry)


def _done(cell, folder, given, words=None):
    return run_cell(cell, folder, (words if words is not None else []).append, CellOptions(plugins=given))


@pytest.fixture(scope="module")
def folder(registry, given, tmp_path_factory):
    """An experiment of two rewards and two seeds."""
    path = tmp_path_factory.mktemp("toy") / "experiment"
    plan = _plan(registry)
    store = create_store(path, plan)
    for cell in plan.cells:
        assert _done(cell, store.cell_folder(cell), given).status == "done"
    return path


@pytest.fixture(scope="module")
def results(folder):
    """What it says."""
    return load_results(folder, plugins=[TOY])


def test_every_reward_of_the_environment_trains(registry):
    """By default all of them, the first as the baseline; simulator and robot are not the harness's."""
    plan = _plan(registry)
    pairs = [(reward, seed) for seed in range(2) for reward in ("near", "right")]
    assert [(cell.reward.label, cell.seed) for cell in plan.cells] == pairs
    assert (plan.baseline, plan.cells[0].title) == ("near", "toy · random · near · seed 0")
    assert all(cell.is_in_environment for cell in plan.cells)
    assert expand(check_experiment(plan.resolved), registry).cells == plan.cells  # `experiment.toml` is one again
    named = _plan(registry, baseline="right", reward=[])
    assert (named.baseline, {cell.reward.label for cell in named.cells}) == ("right", {"right"})


@pytest.mark.parametrize("member", ["lower_is_better", "bounds"])
def test_members_name_measures(tmp_path, member):
    """Any other name is a slip."""
    file = tmp_path / "slip.py"
    text = TOY.read_text().replace("class Toy", "class Slip").replace("np.inf)}", 'np.inf), "far": (0.0, 1.0)}')
    file.write_text(text if member == "bounds" else text.replace('frozenset({"distance"})', 'frozenset({"far"})'))
    with refused(f"slip: {member} names 'far', which is none of"):
        _plan(load_registry(given=read_given([file])), task="slip")


@pytest.mark.parametrize(
    ("keys", "told"),
    [
        ({"sim": "kinematic"}, "--sim does not go with an environment"),
        ({"robot": "fd100"}, "--robot does not go with an environment"),
        ({"reward": "nearer"}, "No reward 'nearer'. There is: near, right. Did you mean 'near'?"),
        ({"reward": "near:share=1"}, "takes no parameters"),
        ({"task": "toys"}, "Environments: fetch-reach, goal_toy, gymnasium"),
    ],
)
def test_what_does_not_go_with_an_environment_is_refused(registry, keys, told):
    """In a line that says what was given and what is allowed."""
    with refused(told.replace("?", r"\?")):
        _plan(registry, **keys)


@pytest.mark.parametrize(
    ("task", "algo", "told"),
    [
        ("toy", "ik", "computes with the arm"),
        ("toy:discrete=true", "sac-fast", "takes continuous actions"),
        ("toy", "random:num_envs=3", "not a multiple of the 3 envs"),
    ],
)
def test_an_algorithm_that_does_not_fit_is_skipped(registry, task, algo, told):
    """With the reason."""
    plan = _plan(registry, task=task, algo=algo)
    assert not plan.cells
    assert all(told in reason for _, reason in plan.skipped)


def test_a_cell_leaves_its_folder(folder, registry):
    """Recordings of training and evaluation, the policy, and what it was made with; the note is empty."""
    store, cell = Store.open(folder), _plan(registry).cells[1]
    place, names = store.cell_folder(cell), ("training", "evaluation", "stochastic", "random", POLICY, MANIFEST)
    assert {path.name for path in place.iterdir()} - {LOG} == {*names}
    training, evaluation = read_recording(place / "training"), read_recording(place / "evaluation")
    assert (training.facts.trained_with, training.facts.seed, len(training)) == ("right", 0, STEPS)
    assert list(training.facts.behaviour) == ["success", "distance"]
    assert training.facts.lower_is_better == ("distance",)
    assert training.facts.bounds == evaluation.facts.bounds == {"distance": (0.0, np.inf)}
    assert evaluation.facts.evaluation
    assert (evaluation["terminated"] | evaluation["truncated"]).sum() == 3
    assert load_policy(place / POLICY).kind == "uniform"
    manifest = store.examine(cell)
    assert (set(manifest.environment["sources"]), manifest.note) == ({"environments", "algorithms"}, "")


def _left(folder):
    """Digests of every file but the log and the manifest."""
    return {name: it for name, it in digests_in(folder).items() if name != LOG}


def test_the_learner_is_paid_by_the_reward_of_its_cell(registry, given, tmp_path):
    """And told of success, as other processes see it."""
    words = []
    _done(_plan(registry).cells[1], tmp_path / "cell", given, words)
    training = read_recording(tmp_path / "cell" / "training")
    ended = np.flatnonzero(training["terminated"] | training["truncated"])
    paid = np.add.reduceat(training["reward/right"], [0, *(ended[:-1] + 1)])[: len(ended)]
    assert words[-1].steps == STEPS
    told = next(word.scalars for word in reversed(words) if RETURN in word.scalars)
    assert told[RETURN] == pytest.approx(paid.mean())
    assert told[SUCCESS] == pytest.approx(training["behaviour/success"][ended].mean())
    assert not [name for word in words for name in word.scalars if name.startswith("Evaluation/")]  # nobody listens


def test_trackers_get_the_evaluation(registry, given, tmp_path):
    """What the reward of the cell paid an episode, and every measure of behaviour, after the last step."""
    words = []
    options = CellOptions(plugins=given, tracked=True)
    run_cell(_plan(registry).cells[1], tmp_path / "cell", words.append, options)
    (told,) = (word for word in words if any(name.startswith("Evaluation/") for name in word.scalars))
    evaluation = read_recording(tmp_path / "cell" / "evaluation")
    ends = evaluation["terminated"] | evaluation["truncated"]
    assert told.steps == STEPS
    assert told.scalars == pytest.approx(
        {
            "Evaluation/Cumulative Reward": evaluation["reward/right"].sum() / 3,
            "Evaluation/Success": evaluation["behaviour/success"][ends].mean(),
            "Evaluation/Distance": evaluation["behaviour/distance"][ends].mean(),
        }
    )


def test_a_killed_cell_without_a_checkpoint_starts_over(registry, given, tmp_path):
    """What it left is thrown away, the manifest says so, and the result is as if nothing had happened."""
    cell = _plan(registry).cells[0]
    _done(cell, tmp_path / "whole", given)
    left = partial_folder(tmp_path / "killed")
    (left / "training").mkdir(parents=True)
    (left / "training" / "recording-0.json").write_text("half")
    assert _done(cell, tmp_path / "killed", given).note.startswith("started over")
    assert _left(tmp_path / "whole") == _left(tmp_path / "killed")


@pytest.fixture
def broken(tmp_path):
    """The toy with a reward that fails in the third step of its second episode."""
    text = TOY.read_text().replace("class Toy", "class Broken")
    file = tmp_path / "broken.py"
    file.write_text(text.replace("lambda before, action, after, info: env.unwrapped.at}", "_Fails()}") + FAILS)
    return read_given([file])


FAILS = """

class _Fails:
    episodes = 0

    def reset(self):
        self.steps, self.episodes = 0, self.episodes + 1

    def __call__(self, before, action, after, info):
        self.steps += 1
        if (self.episodes, self.steps) == (3, 3):  # the algorithm resets the envs once more before its first step
            raise SystemExit("the arm fell off")
        return 1.0
"""


@pytest.mark.filterwarnings("ignore:reward 'right'. it remembers something beyond reset")
def test_a_reward_that_fails_is_the_reason_of_its_failed_cell(broken, tmp_path):
    """The learner cannot be paid."""
    cell = _plan(load_registry(given=broken), task="broken").cells[1]
    manifest = _done(cell, tmp_path / "cell", broken)
    assert (cell.reward.label, manifest.status) == ("right", "failed")
    assert "reward 'right' failed in env 0, episode 1, step 2: SystemExit: the arm fell off" in manifest.reason


@pytest.mark.filterwarnings("ignore:reward 'right' failed")
@pytest.mark.filterwarnings("ignore:reward 'right'. it remembers something beyond reset")
def test_a_reward_that_only_looks_on_fails_alone(broken, tmp_path):
    """The cell is done, the manifest says what was given up, and everything else is recorded."""
    cell = _plan(load_registry(given=broken), task="broken").cells[0]
    manifest = _done(cell, tmp_path / "cell", broken)
    assert (cell.reward.label, manifest.status) == ("near", "done")
    failed, _, remembers = manifest.note.partition("; ")
    assert failed == "reward right given up in the training, episode 1, step 2: SystemExit: the arm fell off"
    assert remembers.startswith("reward 'right': it remembers something beyond reset()")  # it counts episodes
    training = read_recording(tmp_path / "cell" / "training")
    unknown = np.isnan(training["reward/right"])
    assert (unknown.sum(), np.flatnonzero(~unknown).max()) == (STEPS - 10, 9)
    for name in ("reward/near", "behaviour/success", "behaviour/distance"):
        assert not np.isnan(training[name]).any()


def test_an_evaluation_of_endless_episodes_ends(registry, given, tmp_path):
    """Each is cut at the cell's horizon, and is recorded as truncated; the manifest says what never ended."""
    manifest = _done(_plan(registry, task="toy:endless=true", evaluation_horizon=5).cells[0], tmp_path / "cell", given)
    evaluation = read_recording(tmp_path / "cell" / "evaluation")
    assert (evaluation.facts.cut, evaluation.facts.horizon) == (3, 5)
    assert np.flatnonzero(evaluation["truncated"]).tolist() == [4, 9, 14]
    assert (manifest.status, manifest.note) == (
        "done",
        "no episode of the training ended: give the environment a time limit; "
        "3 of 3 evaluation episodes were cut after 5 steps",
    )


def test_the_horizon_of_evaluations_belongs_to_a_cell(registry):
    """Where it is not the default, which a resolved experiment names: cells of a version without it keep their ids."""
    plans = [_plan(registry, **keys) for keys in ({}, {"evaluation_horizon": 10_000}, {"evaluation_horizon": 9})]
    usual, named, other = (plan.cells[0] for plan in plans)
    assert usual.id == named.id != other.id
    assert (usual.evaluation_horizon, other.evaluation_horizon) == (10_000, 9)
    assert plans[0].resolved["evaluation_horizon"] == 10_000


def test_a_horizon_of_evaluations_goes_with_environments_alone(registry):
    """A task of an arm has its own."""
    asked = {"sim": "kinematic", "algo": "random"}
    with refused("--evaluation-horizon goes with an environment"):
        expand(check_experiment({**asked, "evaluation_horizon": 9}), registry)
    assert "evaluation_horizon" not in expand(check_experiment(asked), registry).resolved


def test_the_plan_says_when_evaluations_are_cut(say, tmp_path):
    """Before anything runs."""
    asked = ["--task", "toy", "--plugin", TOY, "--algo", "random", "--out", tmp_path / "new"]
    _, out, _ = say("run", *asked, "--evaluation-horizon", "50", "--dry-run")
    assert "Evaluations: 100 episodes of each policy, each cut after 50 steps if it goes on so long" in out.splitlines()


@pytest.mark.slow
def test_an_evaluation_that_hangs_is_ended(tmp_path):
    """A step that never returns is no progress, also behind the training."""
    file = tmp_path / "hanging.py"
    text = TOY.read_text().replace("class Toy", "class Hanging")
    text = text.replace("        self.steps += 1\n", "        self.steps += 1\n        self._hang()\n")
    hang = """
    def _hang(self) -> None:
        import time

        self.all = getattr(self, "all", 0) + 1
        while self.seeded and self.all > 4:  # the second evaluation's step, or later
            time.sleep(1.0)
"""
    text = text.replace("    def render(self)", f"{hang}\n    def render(self)")
    file.write_text(
        text.replace("super().reset(seed=seed)", "super().reset(seed=seed)\n        self.seeded = (seed or 0) >= 10**9")
    )
    asked = check_experiment({"task": "hanging", "algo": "random", "seeds": 1, "steps": STEPS, "reward": []})
    options = RunOptions(out=tmp_path / "out", stall_after=2.0, jobs=1)
    (failed,) = prepare(asked, options, read_given([file])).run().failed
    assert failed.reason == "no progress for 2 s (--stall-after)"


def test_status_and_verify_know_it(folder):
    """Like any other experiment."""
    assert read_status(folder).count("done") == 4
    assert not list(verify(folder))


def test_a_folder_does_not_mix_with_experiments_of_arms(folder):
    """Their reports have nothing in common."""
    asked = check_experiment({"sim": "kinematic", "algo": "random", "steps": 10, "seeds": 1})
    with refused("do not go into one folder"):
        check(asked, RunOptions(out=folder))


def test_a_study_compares_the_cells(results):
    """Trainings and evaluations of all seeds, the plan's baseline first."""
    (trainings,) = results.trainings
    assert trainings.rewards == ["near", "right"]
    (comparison,) = results.combinations
    assert (comparison.seeds, comparison.group.task.label) == ((0, 1), "toy")
    assert comparison.measured.deciding == ("success",)
    assert all(run.evaluation is not None for run in trainings.runs.values())


@pytest.mark.parametrize(("asked", "shown"), [("distance", ("success", "distance")), ("success", ("success",))])
def test_chosen_measures_are_shown_beside_the_one_that_decides(folder, asked, shown):
    """No other claim is made."""
    results = load_results(folder, metrics=asked, plugins=[TOY])
    (comparison,) = results.combinations
    assert results.measures == tuple(dict.fromkeys(change.name for change in comparison.measured.changes)) == shown


def test_measure_that_no_environment_has_is_refused(folder):
    """With those that there are."""
    results = load_results(folder, metrics="distence", plugins=[TOY])
    with refused(r"No measure 'distence'\. There is: distance, success\. Did you mean"):
        _ = results.trainings


def test_measure_that_no_environment_has_is_refused_before_a_run(registry, tmp_path):
    """Nothing is written."""
    asked = {"task": "toy", "algo": "random", "steps": STEPS}
    options = RunOptions(out=tmp_path / "new", metrics="work")
    with refused("No measure 'work'"):
        prepare(check_experiment(asked), options, read_given([TOY]))
    assert not (tmp_path / "new").exists()


def test_trainings_are_exported_as_csv(results, tmp_path):
    """A row for each step, every number as it was recorded."""
    assert write_runs(results, tmp_path) == {tmp_path / "random-toy" / reward: 2 for reward in ("near", "right")}
    cell = next(cell for cell in results.done_cells if (cell.reward.name, cell.seed) == ("near", 1))
    recorded = read_recording(results.store.cell_folder(cell) / "training")
    table = pyarrow.csv.read_csv(tmp_path / "random-toy" / "near" / "seed-1.csv")
    assert table.column_names[:4] == ["time", "env", "episode", "step"]
    assert_array_equal(table["reward_right"], recorded["reward/right"])
    assert_array_equal(table["behaviour_distance"], recorded["behaviour/distance"])
    assert_array_equal(table["truncated"], recorded["truncated"])


def test_folders_merge(registry, given, tmp_path):
    """Two seeds of two machines are one experiment."""
    for seed in (0, 1):
        plan = _plan(registry, seeds=[seed])
        store = create_store(tmp_path / str(seed), plan)
        for cell in plan.cells:
            _done(cell, store.cell_folder(cell), given)
    merge([tmp_path / "0", tmp_path / "1"], tmp_path / "both")
    assert load_results(tmp_path / "both", plugins=[TOY]).combinations[0].seeds == (0, 1)


def test_a_cell_that_is_done_in_both_folders_is_taken_once(folder, results, tmp_path, report):
    """Both recorded the same steps; `harness report` reads the two together all the same."""
    shutil.copytree(folder, tmp_path / "other")
    merge([folder, tmp_path / "other"], tmp_path / "both")
    both = load_results(tmp_path / "both", plugins=[TOY])
    assert [manifest.cell for manifest in both.done] == [manifest.cell for manifest in results.done]
    assert "\n4 cells: 4 done\n" in report(folder, tmp_path / "other")


def _write_again(cell, part, change):
    """A recording of a cell, changed, as if the cell had left it so."""
    recording = read_recording(cell / part).load()
    shutil.rmtree(cell / part)
    write_recording(cell / part, change(recording))
    read_manifest(cell).write(cell)


@pytest.mark.parametrize("part", ["training", "evaluation"])
def test_two_trainings_of_a_cell_that_differ_are_refused(folder, tmp_path, part):
    """In a step of their training, or of their evaluation; the message names the cell and both folders."""
    shutil.copytree(folder, tmp_path / "other")
    cell = Store.open(folder).read_plan().cells[1]
    _write_again(
        Store(tmp_path / "other").cell_folder(cell), part, lambda it: it.add({"truncated": np.roll(it["truncated"], 1)})
    )
    with refused(f"Cell {cell.id} .* is done in '{folder}.*' and in .*, and {part}.* is not the same in both"):
        merge([folder, tmp_path / "other"], tmp_path / "both")
    assert not (tmp_path / "both").exists()


def test_versions_make_no_other_training_of_a_cell(folder, tmp_path):
    """Two machines may have recorded the same steps."""
    shutil.copytree(folder, tmp_path / "other")
    cell = Store.open(folder).read_plan().cells[1]
    folder_there = Store(tmp_path / "other").cell_folder(cell)
    facts = folder_there / "training" / "recording-0.json"
    replace(TrainingFacts.read(facts), versions={"python": "3.99"}).write(facts)
    read_manifest(folder_there).write(folder_there)
    assert len(merge([folder, tmp_path / "other"], tmp_path / "both").plan.cells) == 4


@pytest.fixture
def report(say):
    """`harness report` with arguments, and what it prints."""

    def run(*arguments):
        status, told, why = say("report", *arguments)
        assert not status, why
        return told

    return run


def test_the_report_is_a_page(folder, tmp_path, report):
    """That of recorded trainings."""
    report(folder, "--html", tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text()
    assert "against near" in page
    assert "<h2>right</h2>" in page


def test_table_has_what_the_policies_did(results):
    """A row for each cell: measures of the evaluation, and what every reward paid for it."""
    rows = pq.read_table(results.write_table()).to_pylist()
    assert len(rows) == 4
    for row, cell in zip(rows, results.done_cells, strict=True):
        recorded = read_recording(results.store.cell_folder(cell) / "evaluation")
        ended = recorded["terminated"] | recorded["truncated"]
        assert row["behaviour_distance"] == pytest.approx(recorded["behaviour/distance"][ended].mean())
        assert row["return_near"] == pytest.approx(recorded["reward/near"].sum() / ended.sum())
        assert row["not_measured"] == ""


def test_json_has_the_form_of_an_arms(folder, report):
    """Comparisons and cells under the same names; an environment has no robot."""
    told = json.loads(report(folder, "--json"))
    assert told["format"] == 2
    (combination,) = told["combinations"]
    assert (combination["task"], combination["algorithm"], combination["proposed"]) == ("toy", "random", "right")
    assert not {"robot", "simulator"} & combination.keys()
    assert combination["headline"]["behaviour"]
    assert combination["deciding"] == ["success"]
    assert {change["manner"] for change in combination["behaviour"]} >= {combination["decided_in"]}
    assert set(combination["returns"]) | set(combination["returns_missing"]) >= {"in evaluations"}
    assert {cell["task"] for cell in told["cells"]} == {"toy"}


def test_records_hold_what_the_report_says(folder, tmp_path, report):
    """JSON, a row for each cell, and the comparisons as a table; they are read without any cell."""
    target = tmp_path / "records"
    report(folder, "--summary", target)
    assert {path.name for path in target.iterdir()} == {*RECORDS, "figures"}
    told = json.loads((target / "results.json").read_text())
    assert told == json.loads(report(folder, "--json"))
    rows = list(csv.DictReader((target / "cells.csv").read_text().splitlines()))
    assert len(rows) == 4
    assert all(float(row["return_near"]) <= 0.0 for row in rows)
    assert "right against near" in (target / "summary.md").read_text()
    told = report(target)
    assert re.search(r"An episode is paid \S+ with right and \S+ with near: a change of", " ".join(told.split()))
    assert "random · toy · against near · 32 steps" in told


def test_records_show_what_they_say(folder, tmp_path, report):
    """Figures of every comparison, which the page shows: a line for each reward, and the parts of eta."""
    report(folder, "--summary", tmp_path / "records")
    figures = {path.name: path.read_text() for path in (tmp_path / "records" / "figures").iterdir()}
    stem = "random-toy-right-against-near"
    own = [f"{stem}.{what}.svg" for what in ("learning", "runs", "split")]
    assert sorted(figures) == ["overview.svg", *own]
    shown = (tmp_path / "records" / "summary.md").read_text()
    assert "| gymnasium |" in shown.partition("## What it took")[2]
    assert all(f"(figures/{name})" in shown for name in figures)
    assert all(word in figures[f"{stem}.learning.svg"] for word in (">right<", ">near<", ">Success while learning<"))
    assert all(word in figures[f"{stem}.split.svg"] for word in (">ruler<", ">behaviour<"))
