"""In somebody's own script what is not finite is noted once, and ends nothing."""

import warnings

import numpy as np
import pytest

from harness.record import read_recording
from harness.recorder import taken
from harness.recorder.recorder import GivenUp, Noted
from tests.recorder.conftest import MODES, Counting, recorder, take

LAST = 300
BAD = {"NaN": np.nan, "infinite": np.inf}


class Spoilt(Counting):
    """One number is not finite, from a step on."""

    more = {"name": "told", "tip": np.zeros(3)}  # noqa: RUF012

    def __init__(self, field, at, bad):
        super().__init__(50, fresh=True)
        self.field, self.at, self.bad, self.steps = field, at, bad, 0

    def step(self, action):
        """Go on."""
        seen, paid, *ended, _ = super().step(action)
        self.steps += 1
        spoilt = {self.field: self.bad} if self.steps >= self.at else {}
        info = {"x": spoilt.get("info", 0.0), **self.more}
        return seen + np.float32(spoilt.get("observation", 0.0)), spoilt.get("pay", paid), *ended, info


def notes_of(tmp_path, mode, field, at, bad):
    """What is warned of, and what the recording says; `LAST` steps are taken whatever happens."""
    rewards = {"still": lambda o, a, n, i: 1.0}
    makes = [lambda: Spoilt("", 0, 0), lambda: Spoilt(field, at, bad)][mode is None :]
    actions = np.zeros((LAST, 1) if mode is None else (LAST, 2, 1), np.float32)
    if field == "action":
        actions[at - 1 :, -1] = bad
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        take(recorder(makes, mode, tmp_path / "run", rewards=rewards), actions, mode)
    found = read_recording(tmp_path / "run")
    assert len(found) >= LAST
    assert np.isfinite(found["reward/still"]).all()
    assert {it.category for it in told} <= {Noted, GivenUp}
    return [str(it.message) for it in told if it.category is Noted], list(found.facts.notes)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("field", ["observation", "action", "pay", "info"])
def test_first_number_that_is_not_finite_is_noted_once(field, mode, tmp_path, subtests):
    """With its field and step, in every way of starting episodes, in the first steps and later."""
    for name, bad in BAD.items():
        for at in (1, 150, LAST - 10):
            with subtests.test(name, at=at):
                warned, noted = notes_of(tmp_path / name / str(at), mode, field, at, bad)
                assert warned == noted
                (line,) = noted
                assert line.startswith(field)
                assert f"was {name} at step " in line
                if mode is None:
                    assert f"at step {at}. The training goes on" in line


def test_what_is_finite_is_not_noted(tmp_path, monkeypatch):
    """Nor are numbers whose sum is not."""
    monkeypatch.setattr(Spoilt, "more", {"y": 1e308})
    assert notes_of(tmp_path, None, "info", 1, 1e308) == ([], [])


def test_a_recorder_that_does_not_look_notes_nothing(tmp_path, monkeypatch):
    """The mutant."""
    monkeypatch.setattr(taken, "is_finite", lambda value: True)
    assert notes_of(tmp_path, None, "observation", 1, np.nan) == ([], [])
