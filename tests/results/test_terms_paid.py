"""What each term paid, as means over trainings: by hand, and of a run."""

import json
from itertools import product

import numpy as np
import pytest

from harness import load_results
from harness.record import read_trace
from harness.results import Group
from harness.results.by_term import ByTerm, TermMeans
from harness.results.trainings import TermsOfTraining, terms_paid
from tests.results.gentle import GENTLE

STEPS = 100


def _by_term(start, end, whole, pays=True, name="reach"):
    return ByTerm({name: TermMeans(start, end, whole, pays)}, STEPS)


def _trained(start, end, evaluation, pays=True, name="reach"):
    told = _by_term(start, end, 0.0, pays, name)
    return TermsOfTraining(told, ByTerm({name: TermMeans(0.0, 0.0, evaluation, pays)}, STEPS))


@pytest.fixture(name="group")
def _group(make_cell):
    return Group.of(make_cell())


def _paid(*given):
    found = terms_paid(*given)
    assert found is not None
    return found


def test_behaviour_is_what_the_term_pays_one_side_more(group):
    """Of the evaluations, whatever the trainings were paid."""
    own, others = ([_trained(0.0, 0.0, base + seed) for seed in (0.0, 1.0, 2.0)] for base in (5.0, 2.0))
    (term,) = _paid(group, ("gentle", "baseline"), own, others).terms
    assert (term.others.value, term.behaviour.value) == (3.0, 3.0)
    assert term.behaviour.low == pytest.approx(3.0 - 2.776445 * np.sqrt(2.0 / 3.0))


def test_ruler_is_what_the_own_term_of_that_name_pays_less(group):
    """On the same episodes; a term that only one reward has has none."""
    own, others, ours = ([_trained(0.0, 0.0, value)] for value in (5.0, 2.0, 0.5))
    assert _paid(group, ("a", "b"), own, others, ours).terms[0].ruler.value == 1.5
    apart = [_trained(0.0, 0.0, 0.5, name="other")]
    assert _paid(group, ("a", "b"), own, others, apart).terms[0].ruler.value is None


def test_a_term_never_paid_only_if_no_training_was_paid_it(group):
    """One step of one of them is enough."""
    quiet = [_trained(0.0, 0.0, 0.0, pays=False)] * 2
    found = _paid(group, ("gentle", ""), quiet)
    assert (found.never, found.steps) == (("reach",), 2 * STEPS)
    assert _paid(group, ("gentle", ""), [*quiet, _trained(0.0, 0.0, 0.0)]).never == ()


def test_the_term_that_changed_most_is_the_one_that_differs_most_from_the_baseline(group):
    """Where nothing is compared the one that changed most over the training."""

    def both(small, large, start):
        means = {"a": TermMeans(start, 0.0, small, True), "b": TermMeans(0.0, 0.0, large, True)}
        return TermsOfTraining(ByTerm(means, STEPS), ByTerm(means, STEPS))

    alone = _paid(group, ("gentle", ""), [both(0.0, -3.0, 9.0)])
    assert alone.most_changed.name == "a"
    compared = _paid(group, ("gentle", "baseline"), [both(0.0, -3.0, 9.0)], [both(1.0, 1.0, 0.0)])
    assert compared.most_changed.name == "b"


def test_without_evaluations_the_end_of_the_trainings_is_compared(group):
    """As recordings that lie loose have none."""
    own, others = ([TermsOfTraining(_by_term(0.0, end, 0.0), None)] for end in (7.0, 3.0))
    (term,) = _paid(group, ("gentle", "own"), own, others).terms
    assert (term.evaluation.value, term.others.value, term.behaviour.value) == (None, 3.0, 4.0)


def test_a_reward_without_terms_has_nothing_to_tell(group):
    """It pays a plain number."""
    assert terms_paid(group, ("arp", ""), [TermsOfTraining(ByTerm({}, STEPS), ByTerm({}, STEPS))]) is None


# Of a run


@pytest.fixture(name="results")
def _results(ran):
    return load_results(ran, plugins=[ran.parent / GENTLE])


def test_behaviour_by_term_adds_up_to_the_behaviour_part(results):
    """On the path that takes the ruler on the baseline's runs: what gentle pays its own minus what it pays theirs."""
    (found,) = results.terms
    (split,) = results.combinations[0].number.returns.values()
    behaviour = sum(it.behaviour.value or 0.0 for it in found.terms)
    returns = {pair: mean.value or 0.0 for pair, mean in split.returns.items()}
    (bb, bk, kb, kk) = (returns[pair] for pair in product(("baseline", "proposed"), repeat=2))
    assert behaviour == pytest.approx(kk - kb, rel=1e-12)
    assert split.total.behaviour.value == pytest.approx((behaviour + bk - bb) / 2.0, rel=1e-9)


def test_every_stage_is_that_of_the_columns(results):
    """Worked out apart, from the traces themselves."""
    (found,) = results.terms
    starts, evaluations = [], []
    for cell in (cell for cell in results.done_cells if cell.reward.label == "gentle"):
        traces = [read_trace(results.store.cell_folder(cell) / f"{it}.parquet") for it in ("trace", "evaluation")]
        trained, evaluated = ([trace["reward/effort"][it].sum() for it in trace.episodes] for trace in traces)
        in_order = sorted(range(len(trained)), key=lambda at: traces[0].episodes[at][-1])
        starts.append(np.mean([trained[at] for at in in_order[: max(1, round(0.1 * len(in_order)))]]))
        evaluations.append(np.mean(evaluated))
    effort = found.terms[1]
    assert (effort.name, effort.random is not None) == ("effort", True)
    assert effort.start.value == pytest.approx(np.mean(starts), rel=1e-12)
    assert effort.evaluation.value == pytest.approx(np.mean(evaluations), rel=1e-12)


def test_a_term_that_never_pays_is_named(results):
    """With the steps of all trainings of the reward."""
    (found,) = results.terms
    assert (found.never, found.steps, found.trainings) == (("dock",), 900, 3)


def test_a_second_report_reads_no_trace(ran, reads):
    """Numbers are kept."""
    first = [it.to_json() for it in load_results(ran, plugins=[ran.parent / GENTLE]).terms]
    reads.files.clear()
    again = [it.to_json() for it in load_results(ran, plugins=[ran.parent / GENTLE]).terms]
    assert json.dumps(first, allow_nan=False) == json.dumps(again)
    assert reads.files == []


def test_without_the_file_own_trainings_are_told_and_others_say_why(ran, results):
    """The columns of its own runs tell what the terms paid; what it would pay the others' runs is not known."""
    without = load_results(ran)
    (found,) = without.terms
    assert found.never == ("dock",)
    assert found.terms[0].evaluation.value is not None
    assert (found.is_compared, found.terms[0].others.value) == (False, None)
    assert "--plugin FILE" in found.missing
    own, others = (without.returns[0].returns["gentle"][label] for label in ("gentle", "baseline"))
    assert own.value == results.returns[0].returns["gentle"]["gentle"].value
    assert others.value is None
    assert "--plugin FILE" in others.note


def test_nothing_changes_for_rewards_without_terms(recorded):
    """No key, no term."""
    assert recorded.terms == ()
