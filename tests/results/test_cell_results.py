"""What follows from a cell's files: read once, and again when what it follows from is another."""

import json
import shutil
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from harness import load_results
from harness.record import TRACE, read_manifest, read_trace
from harness.record.merge import merge
from harness.report import Report, report_text
from harness.score.installed_reward import InstalledReward
from harness_plugins.committed.tables import write_cells

FOLLOWS = {"trace.parquet", "evaluation.parquet"}


@pytest.fixture(name="ended")
def _ended(ran_toys):
    """Two seeds of three rewards, run and not yet reported."""
    return ran_toys(evaluate_every=5)


def fresh(results):
    """As another process reads the folder."""
    return load_results(results.folder, results.kind, registry=results.registry)


def without_kept(results):
    """As if nothing had ever been kept."""
    for path in (results.folder / "derived").rglob("*"):
        if path.is_file():
            path.unlink()
    return fresh(results)


def test_run_reads_each_trace_once(ran_toys, reads):
    """As a cell ends: all metrics, returns and what other rewards pay follow from traces that are open together."""
    results = ran_toys(anew=True, evaluate_every=5)
    assert len(reads.files) == len(set(reads.files))
    traces = {path for path in (results.folder / "cells").rglob("*.parquet") if path.name != "scores.parquet"}
    assert set(reads.files) == traces


def test_first_report_reads_one_trace_after_the_other_once(ended, reads):
    """With nothing kept: hundreds would fill the memory. All that is compared follows when the cells are looked at."""
    results = without_kept(ended)
    assert len(reads.files) == len(set(reads.files)) == len(list(results.folder.glob("cells/*/**/*.parquet")))
    assert reads.most == 1
    reads.files.clear()
    report_text(Report(results))
    assert reads.files == []


@pytest.mark.parametrize("rows", [0, 4_001], ids=["none", "too many"])
def test_a_trace_that_no_cell_can_have_left_costs_the_cell(ended, monkeypatch, rows):
    """By what the cell says of its steps, and by how many rows there are; others are told."""
    monkeypatch.setattr("harness.results.cell_results.SLACK", 0)
    cell = ended.done_cells[0]
    folder = ended.store.cell_folder(cell)
    table = pq.read_table(folder / TRACE)
    pq.write_table(table.take(np.zeros(rows, int)), folder / TRACE)
    read_manifest(folder).write(folder)
    (told,) = [it for it in json.loads(report_text(Report(without_kept(ended))))["cells"] if it["status"] == "damaged"]
    assert told["id"] == cell.id
    assert f"{rows:,} rows" in told["reason"]


def test_records_of_cells_read_no_trace_after_a_run(ended, monkeypatch):
    """The indices of each run alone are those of the kept rewards."""
    monkeypatch.setattr("pyarrow.parquet.ParquetFile", None)  # whoever opens a trace fails
    assert len(write_cells(ended).splitlines()) == 1 + len(ended.done)


def test_merged_cells_bring_what_is_kept(ended, tmp_path, reads):
    """A report of several folders computes nothing again, and nor does the first one after a run.

    All that follows from traces was made as the cells ended.
    """
    merge([ended.folder], tmp_path / "all")
    assert report_text(Report(load_results(tmp_path / "all", registry=ended.registry))) == report_text(Report(ended))
    assert reads.files == []


@pytest.mark.parametrize("kind", ["accumulated", "per-step"])
def test_report_makes_what_is_missing(ended, reads, kind):
    """Byte for byte what was kept, of both kinds of curves; the next one finds it."""
    read = lambda: load_results(ended.folder, kind, registry=ended.registry)  # noqa: E731
    kept = report_text(Report(read()))
    without_kept(ended)
    assert report_text(Report(read())) == kept
    assert reads.names >= FOLLOWS
    reads.files.clear()
    assert report_text(Report(read())) == kept
    assert reads.files == []


def test_folder_that_allows_no_writing_is_reported(ended, reads):
    """Every time from the traces, with the same words."""
    before = report_text(Report(ended))
    without_kept(ended)
    for path in (ended.folder / "derived").iterdir():
        shutil.rmtree(path)
        path.write_text("")  # a file where a folder would be: not even root can write in it
    assert report_text(Report(fresh(ended))) == before
    reads.files.clear()
    assert report_text(Report(fresh(ended))) == before
    assert "trace.parquet" in reads.names


def test_changed_trace_is_read_again(ended, reads):
    """The cell's own, and no other."""
    report_text(Report(ended))
    first, other = (ended.store.cell_folder(cell) / "evaluation.parquet" for cell in ended.done_cells[:2])
    first.write_bytes(other.read_bytes())
    read_manifest(first.parent).write(first.parent)  # as a cell leaves it that was trained again
    report_text(Report(fresh(ended)))
    assert reads.names == {"evaluation.parquet"}


@pytest.mark.parametrize("damage", [lambda path: path.write_bytes(b"PAR1"), Path.unlink], ids=["changed", "missing"])
def test_what_was_kept_of_a_damaged_cell_is_not_taken_for_it(ended, damage):
    """The cell is left out, and said to be damaged."""
    report_text(Report(ended))
    cell = ended.done_cells[0]
    damage(ended.store.cell_folder(cell) / "evaluation.parquet")
    told = json.loads(report_text(Report(fresh(ended))))
    assert [it["id"] for it in told["cells"] if it["status"] == "damaged"] == [cell.id]
    assert cell not in fresh(ended).done_cells


@pytest.mark.parametrize(
    ("code", "read"),
    [
        ("harness.results.cell_results.fingerprint", FOLLOWS),
        ("harness.score.installed_reward.fingerprint", {*FOLLOWS, "random.parquet"}),
    ],
    ids=["metrics", "rewards"],
)
def test_changed_code_computes_again(ended, reads, monkeypatch, code, read):
    """Of every trace: its fingerprint is another. A reward pays training, evaluation and random actions anew."""
    before = report_text(Report(ended))
    monkeypatch.setattr(code, lambda plugin: f"edited {plugin}")
    assert report_text(Report(fresh(ended))) == before
    assert reads.names >= read


def test_new_metric_is_computed(ended, reads):
    """The others are there."""
    report_text(Report(ended))
    results = fresh(ended)
    results.metrics["half"] = _Half()
    assert '"half"' in report_text(Report(results))
    assert reads.names >= FOLLOWS


def test_null_control_finds_what_it_needs(ran_toys, reads):
    """The baseline's cells with other seeds are measured as they end too."""
    results = ran_toys(reward="baseline,arp")
    reads.files.clear()
    report_text(Report(results))
    assert reads.files == []


def test_payer_of_a_reward_keeps_its_own(ended):
    """Two rewards pay one training: neither takes the other's for its own."""
    cell = ended.done_cells[0]
    of = ended.run(cell)
    paid = [of.paid_by(InstalledReward(choice, ended.registry)) for choice in {it.reward: 0 for it in ended.done_cells}]
    assert len({tuple(rewards) for rewards in paid}) == 3


class _Half:
    """A metric that was installed after the run."""

    unit, better = "", "higher"

    def __call__(self, trace):
        return 0.5


def test_own_pay_and_random_pay_are_those_of_whole_episodes(ended):
    """With the events, which a training maximises too; random actions are paid again by each reward."""
    comparison = ended.combinations[0]
    cells = [cell for cell in ended.done_cells if cell.reward.label == comparison.baseline]
    evaluated = [read_trace(ended.store.cell_folder(cell) / "evaluation.parquet") for cell in cells]
    (path,) = ended.folder.glob(f"{'cells'}/*/{'random.parquet'}")
    at_random = read_trace(path)
    payer = InstalledReward(cells[0].reward, ended.registry)
    found = comparison.measured.paid[0]
    assert found.reward == comparison.baseline
    assert found.trained == pytest.approx([_paid(trace, trace["reward"]) for trace in evaluated])
    assert found.at_random == pytest.approx(_paid(at_random, payer.pay(at_random, cells[0].reward).total))


def _paid(trace, shaped):
    """What a finished episode was paid, mean."""
    events = sum(trace[f"reward_{name}"] for name in ("ground", "target", "step"))
    assert any(events != 0.0)
    return float(np.mean([(shaped + events)[rows].sum() for rows in trace.episodes]))


def test_a_reward_that_is_gone_has_no_pay_beside_random_actions(ended, monkeypatch):
    """Nothing is claimed of it, and the report goes on."""
    pays = InstalledReward.pays_recorded
    monkeypatch.setattr(
        InstalledReward, "pays_recorded", lambda payer, own: payer.choice.name == "arp" and pays(payer, own)
    )
    assert [it.reward for it in without_kept(ended).combinations[0].measured.paid] == ["arp"]
