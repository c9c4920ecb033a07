"""The same comparisons in two experiments: what became better, worse, or is the same."""

import pytest

from harness.errors import UsageError
from harness.results.two_experiments import Verdict, between
from tests.report.conftest import build_results

ALL, NONE = {"arp": lambda seed: (8, 9, 10, 8)}, {"arp": lambda seed: ()}


@pytest.fixture
def build(tmp_path_factory):
    """Writes a new experiment's folder and opens it; see `build_results`."""
    return lambda **given: build_results(tmp_path_factory.mktemp("experiment"), **given)


def test_worse_policies_are_a_regression(build):
    """Six seeds that all fail now."""
    found = between(build(seeds=6, reached=ALL), build(seeds=6, reached=NONE))
    assert (found.pairs[0].verdict, found.regressions) == (Verdict.WORSE, found.pairs)


def test_better_policies_are_none(build):
    """The other way round."""
    found = between(build(seeds=6, reached=NONE), build(seeds=6, reached=ALL))
    assert (found.pairs[0].verdict, found.regressions) == (Verdict.BETTER, ())


def test_no_seed_in_both_cannot_tell(build):
    """Nothing is compared that is no pair."""
    ended = {("arp", seed): ("pending", "") for seed in range(3)}
    found = between(build(seeds=3), build(seeds=3, ended=ended))
    assert found.pairs[0].verdict == Verdict.CANNOT_TELL
    assert found.pairs[0].changes == ()


def test_the_same_is_said_of_equal_values_alone(build):
    """That is a fact and no test."""
    assert between(build(), build()).pairs[0].verdict == Verdict.SAME


def test_nothing_in_common_is_refused(build):
    """There is nothing to compare."""
    with pytest.raises(UsageError, match="have no comparison in common"):
        between(build(), build(proposed={"relative": (9, 20)}))


def test_json_has_all_of_it(build):
    """Verdicts, both sides and every change."""
    data = between(build(seeds=6, reached=ALL), build(seeds=6, reached=NONE)).to_json()
    assert data["regressions"] == 1
    (one,) = data["combinations"]
    assert (one["verdict"], one["before"]["seeds"], one["after"]["answer"]) == ("worse", [0, 1, 2, 3, 4, 5], "hurts")
    assert {change["name"] for change in one["behaviour"]} >= {"success_rate", "path_ratio"}


@pytest.mark.parametrize("unfinished", [0, 1])
def test_an_unfinished_plan_says_neither_better_nor_worse(build, unfinished):
    """Whichever of both it is: of five seeds alone the test would say it."""
    plans = [{"seeds": 6}, {"seeds": 6}]
    plans[unfinished] |= {"ended": {("arp", 5): ("pending", "")}}
    (pair,) = between(build(reached=ALL, **plans[0]), build(reached=NONE, **plans[1])).pairs
    assert (pair.verdict, pair.moved) == (Verdict.INTERIM, ())


def test_equal_values_are_a_fact_also_before_the_end(build):
    """No test is made for it."""
    pending = {("arp", 2): ("pending", "")}
    assert between(build(ended=pending), build()).pairs[0].verdict == Verdict.SAME
