"""Experiment folders made by hand, with rewards worked out apart."""

from collections.abc import Mapping

import numpy as np

from harness import load_results
from harness.record import COLUMN, SCALARS, Manifest, TraceWriter
from harness.record.trace import NOTHING_KNOWN, EpisodeFacts
from harness.registry import Choice
from harness.results.logs.told import Told

BASELINE = Choice("baseline", (), "baseline")
ARP = Choice("arp", (("k1", 1.0), ("k2", 1.5)), "arp")
# Distances at each step of one episode, its start first; binary fractions, so that sums are exact.
BASELINE_RUNS = {
    0: [1.0, 1.5, 1.25, 0.5, 0.25, 0.125, 0.0625],
    1: [1.0, 1.75, 1.5, 0.75, 0.5, 0.25, 0.125, 0.0],
    2: [0.5, 1.0, 0.75, 0.25, 0.125, 0.0625, 0.0],
}
ARP_RUNS = {
    0: [1.0, 1.25, 0.75, 0.25, 0.5, 0.125],
    1: [1.0, 1.5, 0.5, 0.25, 0.75, 0.0],
    2: [0.5, 1.25, 0.25, 0.125, 0.0],
}


def paid(distances, k2=1.0):
    """What `arp` pays, worked out apart; with k2 = 1 what `baseline` pays. Nothing in the start row."""
    best, rewards = distances[0], [0.0]
    for distance in distances[1:]:
        rewards.append(-(distance - best) if distance > best else k2 * (distances[0] - distance))
        best = min(best, distance)
    return rewards


def fail(store, cell, reason):
    """As if the cell had failed, whatever it did."""
    store.cell_folder(cell).mkdir(exist_ok=True)
    Manifest(cell, status="failed", reason=reason).write(store.cell_folder(cell))


def load_without(store, *cells):
    """The results without some cells, as the user says."""
    return load_results(store.folder, told=Told(leave_out=tuple(map(store.cell_folder, cells))))


def finish(
    store,
    cell,
    distances=(1.0, 0.5),
    trained=(True,),
    floor=(False,),
    rewards=None,
    otherwise=None,
    learned: Mapping = {},
    took: int = 4,
    facts: EpisodeFacts = NOTHING_KNOWN,
):
    """Leave what a done cell leaves, as far as results read it.

    Args:
        store: Of the experiment.
        cell: The cell.
        distances: Of its training, one unfinished episode.
        trained: Which evaluation episodes of the trained policy reach the target.
        floor: The same of random actions.
        rewards: Of the training; what its reward pays if None.
        otherwise: Which episodes reach it in the other manner; None as by version 0.1, which had none.
        learned: Which reach it in evaluations during the training, by steps.
        took: The steps of each episode of an evaluation.
        facts: What is known of them.
    """
    if rewards is None:
        rewards = paid(distances, dict(cell.reward.params).get("k2", 1.0))
    folder = store.cell_folder(cell)
    folder.mkdir()
    _write_training(folder / "trace.parquet", distances, rewards)
    evaluations = {"evaluation": trained, "random": floor}
    if otherwise is not None:
        evaluations["stochastic" if cell.deterministic else "deterministic"] = otherwise
    (folder / "evaluations").mkdir()
    for name, reached in {**evaluations, **{f"evaluations/{steps}": it for steps, it in learned.items()}}.items():
        _write_evaluation(folder / f"{name}.parquet", reached, took, facts)
    Manifest(cell, status="done", started=f"2026-01-01T00:00:{cell.seed % 60:02}+00:00", seconds=1.5).write(folder)


def only(results):
    """The one combination."""
    (combination,) = results.combinations
    return combination


def _write_training(path, distances, rewards):
    """One unfinished episode."""
    rows = np.zeros((len(distances), len(SCALARS) + 2))
    best = np.minimum.accumulate([distances[0], *distances])[:-1]
    rows[:, COLUMN["step"]] = np.arange(len(rows))
    rows[:, COLUMN["begin_distance"]], rows[:, COLUMN["previous_best"]] = distances[0], best
    rows[:, COLUMN["distance"]], rows[:, COLUMN["reward"]] = distances, rewards
    _write(path, rows)


def _write_evaluation(path, reached, took, facts):
    """One ended episode per flag, at a distance of 0.01 or 0.5 m."""
    rows = np.zeros((len(reached), len(SCALARS) + 2))
    for number, (row, is_reached) in enumerate(zip(rows, reached, strict=True)):
        row[COLUMN["env"]], row[COLUMN["step"]] = number, took
        row[COLUMN["reached"]] = row[COLUMN["terminated"]] = is_reached
        row[COLUMN["truncated"]] = not is_reached
        row[COLUMN["distance"]] = 0.01 if is_reached else 0.5
    _write(path, rows, facts)


def _write(path, rows, facts=NOTHING_KNOWN):
    with TraceWriter(path, dof=1, action_size=1) as writer:
        writer.facts = facts
        writer.append(rows)
