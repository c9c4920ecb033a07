"""Drawing trials, and keeping them."""

from pathlib import Path

import pytest

from harness.errors import SchemaError, UsageError
from harness_plugins.tune.space import Options, Range
from harness_plugins.tune.study import JOURNAL, Study, open_storage, require_optuna
from harness_plugins.tune.trial import Outcome

SPACE = (Range("effort", 0.0, 1.0, False, False), Options("layers", ("4", "8x8"), ((4,), (8, 8))))


@pytest.fixture
def open_study(tmp_path):
    """The study of a folder, as another process would open it; a seed may be given."""
    return lambda seed=0, pruner="median": Study(open_storage(tmp_path), "s", SPACE, seed=seed, pruner=pruner)


def _finish(study: Study, count: int) -> None:
    for _ in range(count):
        number = study.draw(None)
        effort = study.trials[number].params["effort"]
        study.report(number, 0, effort, Outcome(effort, 0.0), 1)
        study.end(number, "complete", effort)


def _params(study: Study) -> list:
    return [trial.params for trial in study.trials]


def test_stops_do_not_change_what_is_drawn(open_study, tmp_path):
    """Opened anew after every trial, the model's trials included, a study draws what it draws in one go."""
    _finish(open_study(), 14)
    whole = _params(open_study())
    (tmp_path / JOURNAL).unlink()
    for _ in range(14):
        _finish(open_study(), 1)
    assert _params(open_study()) == whole
    assert len({tuple(params.values()) for params in whole}) == 14


def test_another_seed_draws_otherwise(open_study, tmp_path):
    """The seed is what decides."""
    _finish(open_study(0), 2)
    first = _params(open_study())
    (tmp_path / JOURNAL).unlink()
    _finish(open_study(1), 2)
    assert _params(open_study()) != first


def test_very_first_trial_may_be_given(open_study):
    """It is tried as it is; the next ones are drawn."""
    study = open_study()
    first = study.draw({"effort": 0.25, "layers": "8x8"})
    second = study.draw({"effort": 0.25, "layers": "8x8"})
    assert study.trials[first].params == {"effort": 0.25, "layers": (8, 8)}
    assert study.trials[second].params != study.trials[first].params


def test_half_a_line_of_a_killed_process_is_dropped(open_study, tmp_path):
    """The journal goes on after the last whole line, and the lock of the dead is no obstacle."""
    _finish(open_study(), 2)
    with (tmp_path / JOURNAL).open("ab") as file:
        file.write(b'{"op_code":4,"wor')
    (tmp_path / f"{JOURNAL}.lock").symlink_to(tmp_path / JOURNAL)
    _finish(open_study(), 1)
    assert [trial.status for trial in open_study().trials] == ["complete"] * 3


def test_trial_that_was_begun_elsewhere_goes_on(open_study):
    """With its settings; what was reported is not reported twice."""
    number = open_study().draw(None)
    open_study().report(number, 0, 0.5, Outcome(0.5, 0.0), 2)
    study = open_study()
    study.report(number, 0, 0.5, Outcome(0.5, 0.0), 2)
    study.complete_drawing(number)
    study.end(number, "complete", 0.5)
    (trial,) = study.trials
    assert (trial.status, trial.value, trial.outcome, trial.cells) == ("complete", 0.5, Outcome(0.5, 0.0), 2)


@pytest.mark.parametrize(("pruner", "hopeless"), [("median", True), ("none", False)])
def test_trial_below_the_median_is_hopeless(open_study, pruner, hopeless):
    """After five finished ones; without a pruner none is."""
    study = open_study(pruner=pruner)
    _finish(study, 5)
    number = study.draw(None)
    study.report(number, 0, -1.0, Outcome(0.0, 9.0), 1)
    assert study.is_hopeless(number) is hopeless


def test_ends_are_told_apart(open_study):
    """Pruned, failed and refused trials say what they are, the latter two with the reason."""
    study = open_study()
    for status, reason in (("pruned", ""), ("failed", "it fell"), ("refused", "not together")):
        study.end(study.draw(None), status, reason=reason)
    assert [(trial.status, trial.reason) for trial in study.trials] == [
        ("pruned", ""), ("failed", "it fell"), ("refused", "not together"),
    ]  # fmt: skip


def test_optuna_keeps_its_voice_to_itself(open_study, capfd):
    """Nothing on standard error when a study is made."""
    _finish(open_study(), 1)
    assert capfd.readouterr() == ("", "")


def test_missing_optuna_names_the_extra(monkeypatch):
    """One line that says what to install."""
    monkeypatch.setitem(__import__("sys").modules, "optuna", None)
    with pytest.raises(UsageError, match=r"needs optuna: pip install 'fd100-harness\[tune\]'"):
        require_optuna()


@pytest.mark.parametrize(
    "content", [b"7\n", b"{}\n", b"[\n{}\n", b"\xff\n", b'{"op_code": 99}\n', b"[" * 100_000 + b"\n"]
)
def test_a_damaged_journal_is_refused(tmp_path: Path, content: bytes):
    """Whatever Optuna says of it."""
    (tmp_path / JOURNAL).write_bytes(content)
    with pytest.raises(SchemaError, match="is no readable study"):
        open_storage(tmp_path)


def test_a_large_journal_is_not_opened(tmp_path: Path):
    """A sparse file of 10 GB is refused at once."""
    with (tmp_path / JOURNAL).open("wb") as file:
        file.truncate(10**10)
    with pytest.raises(SchemaError, match="it has 10,000,000,000 bytes, 268,435,456 are allowed"):
        open_storage(tmp_path)
