"""Two groups of recorded files compared: every figure against loops in plain Python, and the edges."""

import csv
import json
import math
import re
from importlib.metadata import entry_points
from pathlib import Path

import numpy as np
import pytest

import harness.score.compare
from harness import load_registry
from harness.hookspecs import PROJECT
from harness.record.cell_log import cell_log
from harness.registry import Choice
from harness.score.compare import compare_logs
from harness.score.open_steps import match_steps
from tests.oracles.answers import first_negative_and_crossover, indices
from tests.refusals import refused
from tests.registered import REGISTRY
from tests.score.conftest import HEADER, arp, write_run

BASELINE, K2 = "baseline", "arp:k1=1,k2=1.5"


@pytest.fixture
def groups(tmp_path):
    """A folder with five base-line runs in `base` and four K2 runs in `k2`, 86 to 90 rows each."""
    for seed in range(5):
        write_run(tmp_path / "base" / f"{seed}.csv", arp(1.0), seed, 86 + seed, "base line")
    for seed in range(4):
        write_run(tmp_path / "k2" / f"{seed}.csv", arp(1.5), 100 + seed, 90 - seed)
    return tmp_path


def compare(baseline, proposed, **given):
    """Compare all CSV files of two folders, or what two patterns match."""
    patterns = [f"{where}/*.csv" if Path(where).is_dir() else str(where) for where in (baseline, proposed)]
    return compare_logs(*map(match_steps, patterns), REGISTRY, **given).to_json()


def write_rewards(folder, *runs):
    """Files with nothing but rewards."""
    folder.mkdir()
    for number, run in enumerate(runs):
        (folder / f"{number}.csv").write_text("\n".join(["reward", *map(str, run)]) + "\n")
    return folder


# Plain Python, from the files' text to the figures


def read_run(path):
    """One file's rows."""
    rows, names = [], ("beginDistance", "prevBest", "distance", "reward")
    for row in csv.DictReader(path.read_text().splitlines()):
        begin, best, distance, reward = (float(row[name]) for name in names)
        if row["t"]:
            start, before = row["t"] == "0", distance - float(row["delta_distance"])
        else:
            start, before = row["delta_distance"] != "", best
        rows.append((reward, begin, before, distance, float(start)))
    return rows


def score_run(run, pay):
    """What another reward pays for a run."""
    return [0.0 if start else pay(begin, before, distance) for _, begin, before, distance, start in run]


def test_every_figure_equals_plain_python(groups):
    """Indices, etas, rulers and behaviours, from files of both programs and of different length."""
    data = compare(groups / "base", groups / "k2")
    base, k2 = ([read_run(path)[:86] for path in sorted((groups / name).glob("*.csv"))] for name in ("base", "k2"))
    paid = {
        "BB": [[row[0] for row in run] for run in base],
        "KK": [[row[0] for row in run] for run in k2],
        "KB": [score_run(run, arp(1.5)) for run in base],
        "BK": [score_run(run, arp(1.0)) for run in k2],
    }
    for name, pair in (("baseline", "BB"), ("proposed", "KK")):
        first, crossover = first_negative_and_crossover(paid[pair])
        negative, positive = indices(paid[pair])
        assert data[name] == {
            "first_negative": first,
            "crossover": crossover,
            "steps": 86,
            "I_N": pytest.approx(negative, abs=0.0501),
            "I_P": pytest.approx(positive, abs=0.0501),
            "total": pytest.approx(negative + positive, abs=0.0501),
        }
    for position, name in enumerate(("eta_N", "eta_P")):
        split, index = data[name], {pair: indices(runs)[position] for pair, runs in paid.items()}
        first, second = split["paths"]
        for shown, right in (
            (split["eta"], index["KK"] / index["BB"]),
            (first["ruler"], index["KK"] / index["BK"]),
            (first["behaviour"], index["BK"] / index["BB"]),
            (second["ruler"], index["KB"] / index["BB"]),
            (second["behaviour"], index["KK"] / index["KB"]),
            (split["ruler"], math.sqrt(index["KK"] * index["KB"] / index["BK"] / index["BB"])),
            (split["behaviour"], math.sqrt(index["BK"] * index["KK"] / index["BB"] / index["KB"])),
        ):
            assert shown["value"] == pytest.approx(right, rel=1e-9)
    assert data["rewards"] == {"baseline": BASELINE, "proposed": K2}
    assert data["runs"] == {"baseline": 5, "proposed": 4}
    assert data["rows_left_out"] == {"baseline": 1 + 2 + 3 + 4, "proposed": 4 + 3 + 2 + 1}
    assert (data["curve"], data["with_events"]) == ("accumulated", False)
    assert data["number"].startswith(f"I_N with {K2} is ")
    json.dumps(data, allow_nan=False)
    each = compare(groups / "base", groups / "k2", kind="per-step")
    assert each["curve"] == "per-step"
    means = np.mean(paid["BB"], axis=0)
    assert each["baseline"]["total"] == pytest.approx(means.sum(), abs=0.0501)


def test_a_group_against_itself_is_one(groups):
    """Value and both ends of the interval: the same files are paired."""
    data = compare(groups / "base", groups / "base")
    for name in ("eta_N", "eta_P"):
        assert [data[name]["eta"][end] for end in ("value", "low", "high")] == [1.0, 1.0, 1.0]


@pytest.mark.parametrize("held", [5, 35, 300])
def test_pieces_of_any_size_give_the_same(groups, monkeypatch, held):
    """How many rows are held at once changes nothing but the last digit."""
    whole = compare(groups / "base", groups / "k2")
    monkeypatch.setattr(harness.score.compare, "HELD", held)
    pieces = compare(groups / "base", groups / "k2")
    assert pieces["baseline"] == whole["baseline"]
    assert pieces["rows_left_out"] == whole["rows_left_out"]
    for name in ("eta_N", "eta_P"):
        for part in ("eta", "ruler", "behaviour"):
            assert pieces[name][part]["value"] == pytest.approx(whole[name][part]["value"], rel=1e-12)


# Edges


def test_runs_are_cut_to_the_shortest_of_both_groups(tmp_path):
    """The mean is over all runs at every step; how many rows were left out is said, and which run is the shortest."""
    base = write_rewards(tmp_path / "b", [-1, -1, 7, 7], [-3, 1, 0, 0])
    data = compare(base, write_rewards(tmp_path / "k", [1, 2]))
    assert data["baseline"]["steps"] == data["proposed"]["steps"] == 2
    assert data["baseline"]["I_N"] == -4.0
    assert data["rows_left_out"] == {"baseline": 4, "proposed": 0}
    assert data["notes"] == [
        f"All runs are cut to the 2 steps of the shortest, '{tmp_path}/k/0.csv'; the longest has 4"
    ]


@pytest.mark.parametrize(
    ("last", "told"),
    [
        ([1], "it ends after 1 steps, and another one of the baseline after 10"),
        ([*range(9), "nan"], "it is paid no number from step 9 on"),
    ],
)
def test_a_run_that_broke_off_or_diverged_is_missing(tmp_path, last, told):
    """How it ended is an outcome: nothing is compared without it, unless the user leaves it out by name."""
    base = write_rewards(tmp_path / "b", range(10), [5, *range(1, 10)], last)
    with refused(re.escape(f"'{base}/2.csv' is missing: {told}")):
        compare(base, write_rewards(tmp_path / "k", range(1, 11)))


def varied(seed, rows=40):
    """Rewards that no other training pays."""
    return np.random.default_rng(seed).normal(-1.0, 1.0, rows).tolist()


def test_a_copy_counts_once(tmp_path):
    """Each of three runs stored again under another name, longer or not: the same answer, and told."""
    runs = [varied(seed) for seed in range(3)]
    proposed = write_rewards(tmp_path / "k", *map(varied, range(10, 13)))
    distinct = compare(write_rewards(tmp_path / "b", *runs), proposed)
    copies = compare(write_rewards(tmp_path / "c", *runs, *[[*run, 7.0] for run in runs]), proposed)
    assert copies["notes"][0] == f"'{tmp_path}/c/3.csv' is equal to '{tmp_path}/c/0.csv': the run counts once"
    assert copies["runs"] == distinct["runs"] == {"baseline": 3, "proposed": 3}
    assert copies["eta_N"]["eta"] == distinct["eta_N"]["eta"]
    assert distinct["notes"] == []


def test_equal_runs_of_few_rewards_may_be_chance(tmp_path):
    """-1 a step and 0 at an episode's start: three trainings that never succeed count as three, and are told."""
    data = compare(write_rewards(tmp_path / "b", *[[0, -1, -1]] * 3), write_rewards(tmp_path / "k", [0, -2, -1]))
    assert data["runs"]["baseline"] == 3
    assert data["notes"][0].endswith("record the same rewards; each counts")


def test_equal_runs_in_both_groups_are_told(tmp_path):
    """A file that was copied into the other group under another name."""
    b, k = write_rewards(tmp_path / "b", varied(0), varied(1)), write_rewards(tmp_path / "k", varied(1), varied(2))
    assert compare(b, k)["notes"] == [
        f"'{b}/1.csv' and '{k}/0.csv' record the same rewards: between them there is nothing to compare",
    ]


def test_other_units_are_told(tmp_path):
    """Millimetres beside metres: the reward is 1,000 times as large, and nothing else."""
    for seed in range(3):
        write_run(tmp_path / "m" / f"{seed}.csv", arp(1.0), seed, 60)
        lines = (tmp_path / "m" / f"{seed}.csv").read_text().splitlines()
        cells = [line.split(",") for line in lines[1:]]
        rows = [",".join([first, *(str(1000.0 * float(cell)) for cell in rest)]) for first, *rest in cells]
        (tmp_path / "mm").mkdir(exist_ok=True)
        (tmp_path / "mm" / f"{seed}.csv").write_text("\n".join([lines[0], *rows]) + "\n")
    notes = compare(tmp_path / "m", tmp_path / "mm")["notes"]
    assert "are both in metres?" in notes[-1]
    assert compare(tmp_path / "m", tmp_path / "m")["notes"] == []


def test_a_fault_behind_the_shortest_run_is_told(tmp_path):
    """A file with a fault is not half right."""
    folder = write_rewards(tmp_path / "b", [-1, -1], [-1, -1, -1, "oops"])
    with refused(r"1\.csv, line 5, column 'reward': 'oops' is no finite number"):
        compare(folder, folder)


# Which rewards


def test_without_distances_the_etas_are_not_split(tmp_path, groups):
    """One bare file is enough; the etas stay, and the parts say which file it is."""
    bare = write_rewards(tmp_path / "bare", [0, -1, 3])
    data = compare(bare, groups / "k2")
    assert data["eta_N"]["eta"]["value"] is not None
    nothing = {
        "value": None,
        "low": None,
        "high": None,
        "seeds": 0,
        "note": f"{bare}/0.csv has no distances to score again",
    }
    for name in ("eta_N", "eta_P"):
        assert data[name]["paths"] == []
        assert data[name]["ruler"] == data[name]["behaviour"] == data[name]["interaction"] == nothing
    assert data["rewards"] == {"baseline": None, "proposed": K2}


def test_runs_of_one_group_under_two_rewards_are_not_split(groups):
    """The reason names the first file that the others' reward did not pay."""
    write_run(groups / "base" / "9.csv", arp(1.5), 9, 90)
    data = compare(groups / "base", groups / "k2")
    assert data["rewards"]["baseline"] is None
    assert data["eta_N"]["ruler"]["note"].startswith(
        f"no one reward pays all runs of a group: {groups}/base/9.csv, line "
    )


def test_a_given_reward_is_used_and_checked(groups):
    """A name that paid the runs is taken as it stands; any other is refused with the row that shows it."""
    given = compare(groups / "base", groups / "k2", proposed_reward="arp", baseline_reward="arp:k2=1")
    assert given["rewards"] == {"baseline": "arp:k2=1", "proposed": "arp"}
    told = compare(groups / "base", groups / "k2")
    named = {"rewards": 0, "number": ""}
    assert given | named == told | named
    with refused(r"The runs were not paid by arp:k2=2: .*/k2/0\.csv, line \d+: recorded"):
        compare(groups / "base", groups / "k2", proposed_reward="arp:k2=2")
    with refused("No reward 'arpp'"):
        compare(groups / "base", groups / "k2", proposed_reward="arpp")


# Traces


@pytest.fixture
def write_run_as_trace(write_trace):
    """The trace of `write_run`, with its manifest, and `target` paid on top in every third step."""

    def write(folder, pay, seed, reward, target=0.0):
        write_run(folder / "as.csv", pay, seed, 88)
        run = read_run(folder / "as.csv")
        (folder / "as.csv").unlink()
        steps = []
        for *_, start in run:
            steps.append(0 if start else steps[-1] + 1)
        _, begin, before, distance, _ = np.transpose(run)
        columns = {
            "step": steps,
            "begin_distance": begin,
            "previous_best": before,
            "distance": distance,
            "delta_distance": distance - before,
            "reward": score_run(run, pay),
            "reward_target": np.where(np.mod(steps, 3) == 1, target, 0.0),
        }
        name, _, k2 = reward.partition(":k2=")
        write_trace(folder, columns, reward=Choice(name, (("k2", k2),) if k2 else (), reward), seed=seed)

    return write


def test_traces_and_csv_files_mix(tmp_path, groups, write_run_as_trace):
    """A group may hold both: the trace declares what the files of its group show."""
    write_run_as_trace(groups / "traces", arp(1.5), 3, "arp")
    recordings = match_steps([f"{groups}/traces/*.parquet", f"{groups}/k2/*.csv"])
    base = match_steps(f"{groups}/base/*.csv")
    data = compare_logs(base, recordings, REGISTRY).to_json()
    assert data["runs"] == {"baseline": 5, "proposed": 5}
    assert data["eta_N"]["ruler"]["value"] is not None


def test_event_terms_are_added_on_demand(tmp_path, write_run_as_trace):
    """Under either ruler the events are paid as they were; files without them are refused by name."""
    for seed in range(2):
        write_run_as_trace(tmp_path / f"b{seed}", arp(1.0), seed, "baseline", target=10.0)
        write_run_as_trace(tmp_path / f"k{seed}", arp(1.5), seed, "arp", target=10.0)
    patterns = f"{tmp_path}/b*/trace.parquet", f"{tmp_path}/k*/trace.parquet"
    data = compare(*patterns, with_events=True)
    paid = []
    for seed in range(2):
        rows = cell_log(tmp_path / f"b{seed}" / "trace.parquet")
        paid.append((rows[f"reward/{rows.facts.trained_with}"] + np.where(rows["step"] % 3 == 1, 10.0, 0.0)).tolist())
    negative, positive = indices(paid)
    assert data["baseline"]["I_P"] == pytest.approx(positive, abs=0.0501)
    assert data["baseline"]["I_N"] == pytest.approx(negative, abs=0.0501)
    assert data["with_events"]
    assert data["eta_P"]["ruler"]["value"] is not None
    assert compare(*patterns)["baseline"]["I_P"] < positive
    (tmp_path / "bare.csv").write_text("reward\n1\n")
    with refused(r"bare\.csv has no event terms: leave out --with-events"):
        compare(patterns[0], tmp_path / "bare.csv", with_events=True)


def test_runs_of_known_seeds_are_paired(tmp_path, write_run_as_trace):
    """Whatever the folders are called, equal seeds meet: a change that is the same in all pairs has no spread."""
    for seed in range(5):
        write_run_as_trace(tmp_path / f"b{seed}", arp(1.0), seed, "baseline")
        write_run_as_trace(tmp_path / f"k{9 - seed}", arp(2.0, 2.0), seed, "arp:k2=2")
    patterns = f"{tmp_path}/b*/trace.parquet", f"{tmp_path}/k*/trace.parquet"
    eta = compare(*patterns)["eta_N"]["eta"]
    assert [eta["value"], eta["low"], eta["high"]] == pytest.approx([2.0, 2.0, 2.0], rel=1e-12)
    (tmp_path / "b0" / "manifest.json").unlink()  # one seed is not known: nothing is paired
    eta = compare(*patterns)["eta_N"]["eta"]
    assert eta["low"] < 1.9
    assert eta["high"] > 2.1


def test_a_reward_that_is_not_finite_on_the_others_runs_is_told(tmp_path, write_plugin):
    """The etas stay; the parts say why they are missing."""
    source = """
import harness
from dataclasses import dataclass
@dataclass(frozen=True)
class Inverse:
    def initial_carry(self, begin_distance):
        return ()
    def __call__(self, carry, sample):
        return carry, 1.0 / sample.distance - 2.0
@harness.hookimpl
def register_rewards(register):
    register("inverse", __name__ + ":Inverse", summary="infinite at the target")
"""
    for name, rows in (
        ("b", ("0,1,1,1,0,0", "1,1,1,2,1,-1", "2,1,0,0,-1,1")),
        ("k", ("0,1,1,1,0,0", "1,1,1,4,3,-1.75", "2,1,1,2,1,-1.5")),
    ):
        (tmp_path / name).mkdir()
        (tmp_path / name / "run.csv").write_text("\n".join([HEADER, *rows]) + "\n")
    registry = load_registry([*entry_points(group=PROJECT), write_plugin(source, "inverse-reward")])
    groups = (match_steps(f"{tmp_path}/{name}/*.csv") for name in "bk")
    data = compare_logs(*groups, registry).to_json()
    assert data["rewards"] == {"baseline": BASELINE, "proposed": "inverse"}
    assert data["eta_N"]["eta"]["value"] == 5.0
    assert data["eta_N"]["ruler"]["value"] is None
    assert data["eta_N"]["ruler"]["note"] == "one group's reward is not finite on the other group's runs"


def test_both_etas_are_corrected_together(groups):
    """Two claims of one comparison: no corrected p is below its own."""
    logs = (match_steps(f"{groups / name}/*.csv") for name in ("base", "k2"))
    splits = compare_logs(*logs, REGISTRY).decomposition.splits.values()
    assert all(split.corrected >= split.p for split in splits)
    assert any(split.corrected != split.p for split in splits)
