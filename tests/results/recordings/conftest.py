"""Recorded trainings of a bandit whose learner's actions are fixed sequences, so that ruler and behaviour are known."""

from collections.abc import Mapping

import numpy as np
import pytest

from harness import load_results
from harness.log import in_memory
from harness.record import TrainingFacts
from harness.record.recording.facts import Failure
from harness.record.recording.recording_writer import write_recording

PAYS = {
    "plain": lambda arms: arms + 1.0,
    "thrice": lambda a: 3.0 * a + 6.0,
}
"""What pulling an arm, a number from 0 to 1, is paid: `thrice` counts every pull as 3 (arm + 2)."""
PULLS = 5
"""Of an episode."""


def record(
    folder,
    trained_with,
    seed,
    arms,
    *,
    pays=PAYS,
    failures: Mapping = {},
    behaviour=None,
    ends=True,
    **facts,
):
    """A training that pulls one arm throughout each episode.

    Args:
        folder: To write.
        trained_with: The reward that taught it.
        seed: Of the training.
        arms: Of each episode.
        pays: Rewards by name, of the arms of all steps.
        failures: By column, from which step on it is given up.
        behaviour: By name, of the arms of all steps; by default `arm`, and `success`, whether it is above 0.5.
        ends: Whether episodes end.
        facts: Others than the usual ones.
    """
    pulled = np.repeat(np.asarray(arms, float), PULLS)
    measured = {"success": lambda a: (a > 0.5) * 1.0, "arm": lambda a: a} if behaviour is None else behaviour
    steps, ended = np.arange(len(pulled)), (np.arange(len(pulled)) % PULLS == PULLS - 1) & ends
    given_up = tuple(
        Failure(column, "ZeroDivisionError: division by zero", env=0, episode=step // PULLS, step=step % PULLS)
        for column, step in failures.items()
    )

    def values(kind, functions):
        return {
            f"{kind}/{name}": np.where(steps >= failures.get(f"{kind}/{name}", len(steps)), np.nan, function(pulled))
            for name, function in functions.items()
        }

    known = TrainingFacts(
        rewards=tuple(pays),
        trained_with=trained_with,
        behaviour=tuple(measured),
        seed=seed,
        failed=given_up,
        **{"spec": {"id": "Bandit-v0"}, "closed": True, **facts},
    )
    columns = {
        "tick": steps,
        "env": np.zeros(len(steps), np.int32),
        "episode": (steps // PULLS).astype(np.int32),
        "step": (steps % PULLS).astype(np.int32),
        **values("reward", pays),
        **values("behaviour", measured),
        "terminated": np.zeros(len(steps), bool),
        "truncated": ended,
    }
    write_recording(folder, in_memory(known, columns))
    return folder


@pytest.fixture
def study_folder(tmp_path):
    """Six seeds of two rewards: `thrice` teaches to pull better arms."""
    for seed in range(6):
        record(tmp_path / f"plain-{seed}", "plain", seed, np.linspace(0.0, 0.4 + 0.01 * seed, 40))
        record(tmp_path / f"thrice-{seed}", "thrice", seed, np.linspace(0.0, 0.9 + 0.01 * seed, 40))
    return tmp_path


def load_study(folder, metrics=None):
    """The results of the recorded trainings in a folder."""
    return load_results(folder, metrics=metrics)


def paid_in(results, manner):
    """What each reward pays the trainings by each, by both names, in one manner."""
    (matrix,) = (it for it in results.returns if it.manner == manner)
    return {(payer, trained): mean for payer, row in matrix.returns.items() for trained, mean in row.items()}
