"""What follows from a cell's files: read once, and again when what it follows from is another."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any
from weakref import WeakSet

import numpy as np
import pytest

import harness.results.cell_results as module
from harness.experiment.plan import Plan, check_experiment, expand
from harness.log import Log
from harness.record.folder import DERIVED, EVALUATION, RANDOM, SCORES, TRACE
from harness.record.manifest import read_manifest
from harness.record.merge import merge
from harness.record.returns import EVENTS
from harness.record.store import CELLS
from harness.record.trace import read_trace
from harness.registry.registry import Registry
from harness.report.document import report_text
from harness.results import Results
from harness.results.comparison import Group
from harness.score.installed_reward import InstalledReward
from harness_plugins.committed.tables import write_cells

GIVEN = {
    "sim": "ideal", "algo": "narrate", "task": "fd100-reach:horizon=5", "seeds": 2, "steps": 12,
    "evaluation_episodes": 3, "evaluate_every": 5, "reward": "arp,dense",
}  # fmt: skip


class Reads:
    """Reads traces, and remembers which."""

    def __init__(self) -> None:
        self.files: list[Path] = []
        self.held: WeakSet[Log] = WeakSet()
        self.most = 0

    @property
    def names(self) -> set[str]:
        """Names of the files that were read."""
        return {path.name for path in self.files}

    def __call__(self, path: Path) -> Log:
        """Read one."""
        self.files.append(path)
        trace = read_trace(path)
        self.held.add(trace)
        self.most = max(self.most, len(self.held))
        return trace


@pytest.fixture(name="reads")
def _reads(monkeypatch: pytest.MonkeyPatch) -> Reads:
    reads = Reads()
    monkeypatch.setattr(module, "read_trace", reads)
    return reads


@pytest.fixture(name="ended")
def _ended(toys: Registry, run_once: Callable[..., Results], tmp_path: Path) -> Results:
    """Two seeds of three rewards, run and not yet reported."""
    plan: Plan = expand(check_experiment(GIVEN), toys)
    return run_once(plan, tmp_path / "out")


def fresh(results: Results) -> Results:
    """As another process reads the folder."""
    return Results(results.folder, results.registry, results.kind)


def remove_kept(results: Results) -> None:
    """As if nothing had ever been kept."""
    for path in (results.folder / DERIVED).rglob("*"):
        if path.is_file():
            path.unlink()


def test_first_report_after_a_run_reads_no_trace(ended: Results, reads: Reads):
    """All that follows from traces was made as the cells ended."""
    report_text(ended)
    assert reads.files == []


def test_run_reads_each_trace_once(toys: Registry, run_here: Callable[..., Results], tmp_path: Path, reads: Reads):
    """As a cell ends: all metrics, returns and what other rewards pay follow from traces that are open together."""
    results = run_here(expand(check_experiment(GIVEN), toys), tmp_path / "out")
    assert len(reads.files) == len(set(reads.files))
    traces = {path for path in (results.folder / CELLS).rglob("*.parquet") if path.name != SCORES}
    assert set(reads.files) == traces


def test_first_report_reads_each_trace_whole_once(ended: Results, reads: Reads):
    """With nothing kept: what a training was paid comes from the trace that its metrics were read from."""
    remove_kept(ended)
    results = fresh(ended)
    assert results.not_measured == {}
    read = len(reads.files)
    assert read == len(set(reads.files))
    for cell in results.done_cells:
        results.traces.of(cell).recorded()
    assert len(reads.files) == read


def test_comparisons_hold_no_trace(toys: Registry, run_here: Callable[..., Results], tmp_path: Path, reads: Reads):
    """Those that are read to see whether a reward still pays the same: with many rewards they would fill the memory."""
    asked = {name: value for name, value in GIVEN.items() if name != "evaluate_every"}
    ended = run_here(expand(check_experiment(asked), toys), tmp_path / "out")
    remove_kept(ended)
    results = fresh(ended)
    assert results.not_measured == {}  # as a report asks first
    reads.files.clear()
    assert len(results.combinations) == 2
    assert reads.files != []
    assert len(reads.held) == 0


def test_learning_curves_hold_one_trace_at_a_time(ended: Results, reads: Reads):
    """With nothing kept: hundreds of trainings would fill the memory."""
    remove_kept(ended)
    results = fresh(ended)
    cells = [cell for cell in results.done_cells if cell.reward.label == "dense"]
    results.trainings(Group.of(cells[0])).learned("dense", cells)
    assert (len(reads.files), reads.most) == (2, 1)


def test_records_of_cells_read_no_trace_after_a_run(ended: Results, monkeypatch: pytest.MonkeyPatch):
    """The indices of each run alone are those of the kept rewards."""
    monkeypatch.setattr("pyarrow.parquet.ParquetFile", None)  # whoever opens a trace fails
    assert len(write_cells(ended).splitlines()) == 1 + len(ended.done)


def test_merged_cells_bring_what_is_kept(ended: Results, tmp_path: Path, reads: Reads):
    """A report of several folders computes nothing again."""
    merge([ended.folder], tmp_path / "all")
    assert report_text(Results(tmp_path / "all", ended.registry)) == report_text(ended)
    assert reads.files == []


@pytest.mark.parametrize("kind", ["accumulated", "per-step"])
def test_report_is_the_same_with_and_without_what_is_kept(ended: Results, kind: Any):
    """Byte for byte, of both kinds of curves."""
    kept = report_text(Results(ended.folder, ended.registry, kind))
    remove_kept(ended)
    made = report_text(Results(ended.folder, ended.registry, kind))
    assert kept == made
    assert report_text(Results(ended.folder, ended.registry, kind)) == made


def test_report_makes_what_is_missing(ended: Results, reads: Reads):
    """The next one finds it."""
    remove_kept(ended)
    report_text(fresh(ended))
    assert {TRACE, EVALUATION} <= reads.names
    reads.files.clear()
    report_text(fresh(ended))
    assert reads.files == []


def test_folder_that_allows_no_writing_is_reported(ended: Results, reads: Reads):
    """Every time from the traces, with the same words."""
    before = report_text(ended)
    remove_kept(ended)
    for path in (ended.folder / DERIVED).iterdir():
        path.rmdir()
        path.write_text("")  # a file where a folder would be: not even root can write in it
    assert report_text(fresh(ended)) == before
    reads.files.clear()
    assert report_text(fresh(ended)) == before
    assert TRACE in reads.names


def test_changed_trace_is_read_again(ended: Results, reads: Reads):
    """The cell's own, and no other."""
    report_text(ended)
    first, other = (ended.store.cell_folder(cell) / EVALUATION for cell in ended.done_cells[:2])
    first.write_bytes(other.read_bytes())
    read_manifest(first.parent).write(first.parent)  # as a cell leaves it that was trained again
    report_text(fresh(ended))
    assert reads.names == {EVALUATION}


@pytest.mark.parametrize("damage", [lambda path: path.write_bytes(b"PAR1"), Path.unlink], ids=["changed", "missing"])
def test_what_was_kept_of_a_damaged_cell_is_not_taken_for_it(ended: Results, damage: Callable[[Path], object]):
    """The cell is left out, and said to be damaged."""
    report_text(ended)
    cell = ended.done_cells[0]
    damage(ended.store.cell_folder(cell) / EVALUATION)
    told = json.loads(report_text(fresh(ended)))
    assert [it["id"] for it in told["cells"] if it["status"] == "damaged"] == [cell.id]
    assert cell not in fresh(ended).done_cells


def test_changed_metric_is_computed_again(ended: Results, reads: Reads, monkeypatch: pytest.MonkeyPatch):
    """Of every trace: its fingerprint is another."""
    before = report_text(ended)
    monkeypatch.setattr("harness.results.metrics.fingerprint", lambda metric: f"edited {metric}")
    assert report_text(fresh(ended)) == before
    assert {TRACE, EVALUATION} <= reads.names


def test_new_metric_is_computed(ended: Results, reads: Reads):
    """The others are there."""
    report_text(ended)
    results = fresh(ended)
    results.metrics["half"] = _Half()
    assert '"half"' in report_text(results)
    assert {TRACE, EVALUATION} <= reads.names


def test_changed_reward_pays_again(ended: Results, reads: Reads, monkeypatch: pytest.MonkeyPatch):
    """Its sources are others: training, evaluation and random actions are paid anew."""
    before = report_text(ended)
    monkeypatch.setattr("harness.score.installed_reward.fingerprint", lambda reward: f"edited {reward}")
    assert report_text(fresh(ended)) == before
    assert reads.names == {TRACE, EVALUATION, RANDOM}


def test_null_control_finds_what_it_needs(
    toys: Registry, run_here: Callable[..., Results], tmp_path: Path, reads: Reads
):
    """The baseline's cells with other seeds are measured as they end too."""
    given = {**GIVEN, "reward": "baseline,arp"}
    results = run_here(expand(check_experiment(given), toys), tmp_path / "out")
    reads.files.clear()
    report_text(results)
    assert reads.files == []


def test_payer_of_a_reward_keeps_its_own(ended: Results):
    """Two rewards pay one training: neither takes the other's for its own."""
    cell = ended.done_cells[0]
    of = ended.traces.of(cell)
    paid = [of.paid_by(InstalledReward(choice, ended.registry)) for choice in {it.reward: 0 for it in ended.done_cells}]
    assert len({tuple(rewards) for rewards in paid}) == 3


class _Half:
    """A metric that was installed after the run."""

    unit, better = "", "higher"

    def __call__(self, trace: Any) -> float:
        return 0.5


def test_own_pay_and_random_pay_are_those_of_whole_episodes(ended: Results):
    """With the events, which a training maximises too; random actions are paid again by each reward."""
    comparison = ended.combinations[0]
    cells = [cell for cell in ended.done_cells if cell.reward.label == comparison.baseline]
    evaluated = [read_trace(ended.store.cell_folder(cell) / EVALUATION) for cell in cells]
    (path,) = ended.folder.glob(f"{CELLS}/*/{RANDOM}")
    at_random = read_trace(path)
    payer = InstalledReward(cells[0].reward, ended.registry)
    found = comparison.measured.paid[0]
    assert found.reward == comparison.baseline
    assert found.trained == pytest.approx([_paid(trace, trace["reward"]) for trace in evaluated])
    assert found.at_random == pytest.approx(_paid(at_random, payer.pay(at_random, cells[0].reward).total))


def _paid(trace: Log, shaped: Any) -> float:
    """What a finished episode was paid, mean."""
    events = sum(trace[name] for name in EVENTS)
    assert any(events != 0.0)
    return float(np.mean([(shaped + events)[rows].sum() for rows in trace.episodes]))


def test_a_reward_that_is_gone_has_no_pay_beside_random_actions(ended: Results, monkeypatch: pytest.MonkeyPatch):
    """Nothing is claimed of it, and the report goes on."""
    pays = InstalledReward.pays_recorded
    monkeypatch.setattr(
        InstalledReward, "pays_recorded", lambda payer, own: payer.choice.name == "arp" and pays(payer, own)
    )
    remove_kept(ended)
    assert [it.reward for it in fresh(ended).combinations[0].measured.paid] == ["arp"]
