"""What each term paid, as means over trainings: by hand, and of a run."""

import json
from pathlib import Path

import numpy as np
import pytest

import harness
from harness.eta.scored_sums import BB, BK, KB, KK
from harness.record.cell import Cell
from harness.record.folder import EVALUATION, TRACE
from harness.record.trace import read_trace, terms_of
from harness.results import Results, load_results
from harness.results.by_term import ByTerm, TermMeans
from harness.results.comparison import Group
from harness.results.terms_paid import TermsPaid, terms_paid
from harness.results.trainings import TermsOfTraining
from tests.results.gentle import GENTLE, run_gentle

STEPS = 100


def _by_term(start: float, end: float, whole: float, pays: bool = True, name: str = "reach") -> ByTerm:
    return ByTerm({name: TermMeans(start, end, whole, pays)}, STEPS, 10)


def _trained(start: float, end: float, evaluation: float, pays: bool = True, name: str = "reach") -> TermsOfTraining:
    told = _by_term(start, end, 0.0, pays, name)
    return TermsOfTraining(told, ByTerm({name: TermMeans(0.0, 0.0, evaluation, pays)}, STEPS, 5))


@pytest.fixture(name="group")
def _group(make_cell) -> Group:
    cell: Cell = make_cell()
    return Group.of(cell)


def _paid(group: Group, *given, **named) -> TermsPaid:
    found = terms_paid(group, *given, **named)
    assert found is not None
    return found


def test_stages_are_means_over_trainings(group: Group):
    """Each with its interval."""
    own = [_trained(seed, 10.0 + seed, 20.0 + seed) for seed in (0.0, 1.0, 2.0)]
    (term,) = _paid(group, ("gentle", ""), own).terms
    assert (term.start.mean, term.end.mean, term.evaluation.mean) == (1.0, 11.0, 21.0)
    assert term.start.low == pytest.approx(1.0 - 4.302653 / np.sqrt(3.0))


def test_behaviour_is_what_the_term_pays_one_side_more(group: Group):
    """Of the evaluations, whatever the trainings were paid."""
    own, others = ([_trained(0.0, 0.0, base + seed) for seed in (0.0, 1.0, 2.0)] for base in (5.0, 2.0))
    (term,) = _paid(group, ("gentle", "baseline"), own, others).terms
    assert (term.others.mean, term.behaviour.mean) == (3.0, 3.0)
    assert term.behaviour.low == pytest.approx(3.0 - 2.776445 * np.sqrt(2.0 / 3.0))


def test_ruler_is_what_the_own_term_of_that_name_pays_less(group: Group):
    """On the same episodes; a term that only one reward has has none."""
    own, others, ours = ([_trained(0.0, 0.0, value)] for value in (5.0, 2.0, 0.5))
    assert _paid(group, ("a", "b"), own, others, ours).terms[0].ruler.mean == 1.5
    apart = [_trained(0.0, 0.0, 0.5, name="other")]
    assert _paid(group, ("a", "b"), own, others, apart).terms[0].ruler.mean is None


def test_a_term_never_paid_only_if_no_training_was_paid_it(group: Group):
    """One step of one of them is enough."""
    quiet = [_trained(0.0, 0.0, 0.0, pays=False)] * 2
    found = _paid(group, ("gentle", ""), quiet)
    assert (found.never, found.steps) == (("reach",), 2 * STEPS)
    assert _paid(group, ("gentle", ""), [*quiet, _trained(0.0, 0.0, 0.0)]).never == ()


def test_the_term_that_changed_most_is_the_one_that_differs_most_from_the_baseline(group: Group):
    """Where nothing is compared the one that changed most over the training."""

    def both(small: float, large: float, start: float) -> TermsOfTraining:
        means = {"a": TermMeans(start, 0.0, small, True), "b": TermMeans(0.0, 0.0, large, True)}
        return TermsOfTraining(ByTerm(means, STEPS, 9), ByTerm(means, STEPS, 9))

    alone = _paid(group, ("gentle", ""), [both(0.0, -3.0, 9.0)])
    assert alone.most_changed is not None
    assert alone.most_changed.name == "a"
    compared = _paid(group, ("gentle", "baseline"), [both(0.0, -3.0, 9.0)], [both(1.0, 1.0, 0.0)])
    assert compared.most_changed is not None
    assert compared.most_changed.name == "b"


def test_without_evaluations_the_end_of_the_trainings_is_compared(group: Group):
    """As recordings that lie loose have none."""
    own, others = ([TermsOfTraining(_by_term(0.0, end, 0.0), None)] for end in (7.0, 3.0))
    (term,) = _paid(group, ("gentle", "own"), own, others).terms
    assert (term.evaluation.mean, term.others.mean, term.behaviour.mean) == (None, 3.0, 4.0)


def test_a_reward_without_terms_has_nothing_to_tell(group: Group):
    """It pays a plain number."""
    assert terms_paid(group, ("arp", ""), [TermsOfTraining(ByTerm({}, STEPS, 3), ByTerm({}, STEPS, 3))]) is None


# Of a run


@pytest.fixture(name="ran", scope="module")
def _ran(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return run_gentle(tmp_path_factory.mktemp("gentle"), reward=["gentle"])


@pytest.fixture(name="results")
def _results(ran: Path) -> Results:
    return load_results(ran, plugins=[ran.parent / GENTLE])


def test_behaviour_by_term_adds_up_to_the_behaviour_part(results: Results):
    """On the path that takes the ruler on the baseline's runs: what gentle pays its own minus what it pays theirs."""
    (found,) = results.terms
    (split,) = results.combinations[0].number.returns.values()
    behaviour = sum(it.behaviour.mean or 0.0 for it in found.terms)
    returns = {pair: split.returns[pair].mean or 0.0 for pair in (BB, BK, KB, KK)}
    assert behaviour == pytest.approx(returns[KK] - returns[KB], rel=1e-12)
    assert split.total.behaviour.mean == pytest.approx((behaviour + returns[BK] - returns[BB]) / 2.0, rel=1e-9)


def test_every_stage_is_that_of_the_columns(ran: Path, results: Results):
    """Worked out apart, from the traces themselves."""
    (found,) = results.terms
    cells = [cell for cell in results.done_cells if cell.reward.label == "gentle"]
    starts, evaluations = [], []
    for cell in cells:
        trace = read_trace(results.store.cell_folder(cell) / TRACE)
        ended = sorted(trace.episodes, key=lambda rows: rows[-1])
        starts.append(np.mean([terms_of(trace)["effort"][it].sum() for it in ended[: max(1, round(0.1 * len(ended)))]]))
        trace = read_trace(results.store.cell_folder(cell) / EVALUATION)
        evaluations.append(np.mean([terms_of(trace)["effort"][it].sum() for it in trace.episodes]))
    effort = found.terms[1]
    assert (effort.name, effort.random is not None) == ("effort", True)
    assert effort.start.mean == pytest.approx(np.mean(starts), rel=1e-12)
    assert effort.evaluation.mean == pytest.approx(np.mean(evaluations), rel=1e-12)


def test_a_term_that_never_pays_is_named(results: Results):
    """With the steps of all trainings of the reward."""
    (found,) = results.terms
    assert (found.never, found.steps, found.trainings) == (("dock",), 900, 3)


def test_a_second_report_reads_no_trace(ran: Path, monkeypatch: pytest.MonkeyPatch):
    """Numbers are kept."""
    first = [it.to_json() for it in load_results(ran, plugins=[ran.parent / GENTLE]).terms]

    def refuse(*given: object) -> None:
        raise AssertionError(f"it reads {given}")

    monkeypatch.setattr("harness.results.cell_results.read_trace", refuse)
    again = [it.to_json() for it in load_results(ran, plugins=[ran.parent / GENTLE]).terms]
    assert json.dumps(first, allow_nan=False) == json.dumps(again)


def test_without_the_file_own_trainings_are_told_and_others_say_why(ran: Path):
    """The columns of its own runs tell what the terms paid."""
    (found,) = load_results(ran).terms
    assert found.never == ("dock",)
    assert found.terms[0].evaluation.mean is not None
    assert (found.is_compared, found.terms[0].others.mean) == (False, None)
    assert "--plugin FILE" in found.missing


def test_without_the_file_the_own_return_is_what_was_recorded(ran: Path, results: Results):
    """That of the others' runs is not known."""
    (with_file,), (without,) = results.returns, load_results(ran).returns
    assert without.returns["gentle"]["gentle"].mean == with_file.returns["gentle"]["gentle"].mean
    assert without.returns["gentle"]["baseline"].mean is None
    assert "--plugin FILE" in without.returns["gentle"]["baseline"].note


def test_one_trace_is_in_memory_at_a_time(ran: Path, monkeypatch: pytest.MonkeyPatch):
    """A report asks one cell after the other, so that its memory does not grow with their number."""
    from weakref import WeakSet

    held: WeakSet = WeakSet()
    most = 0

    def read(path: Path):
        nonlocal most
        trace = read_trace(path)
        held.add(trace)
        most = max(most, len(held))
        return trace

    import shutil

    monkeypatch.setattr("harness.results.cell_results.read_trace", read)
    anew = ran.parent / "anew"
    shutil.copytree(ran, anew, ignore=shutil.ignore_patterns("derived"))
    assert load_results(anew, plugins=[ran.parent / GENTLE]).terms
    assert 0 < most <= 2  # a training and its evaluation


def test_nothing_changes_for_rewards_without_terms(tmp_path: Path):
    """No key, no term."""
    results = harness.run(
        sim="kinematic", algo="random", seeds=1, steps=60, evaluation_episodes=1, out=tmp_path / "plain", jobs=1
    )
    assert results.terms == ()
