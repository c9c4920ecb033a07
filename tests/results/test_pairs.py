"""What an arm has as an environment has it: every two rewards, and the split of its mean return."""

from pathlib import Path

import pytest

from harness.eta.scored_sums import BB, KK
from harness.results import Results, load_results
from tests.report.conftest import build_results

PROPOSED = {"arp": (9, 30), "relative": (9, 30)}


@pytest.fixture
def results(tmp_path: Path) -> Results:
    """Two proposed rewards."""
    return build_results(tmp_path, seeds=3, proposed=PROPOSED)


def test_each_reward_is_compared_with_the_baseline(results: Results):
    """Unless more is asked for."""
    assert [(it.baseline, it.proposed) for it in results.combinations] == [
        ("baseline", "arp"),
        ("baseline", "relative"),
    ]


def test_every_two_rewards_are_compared_if_asked_for(results: Results):
    """All claims are one family: none is more significant than in the smaller one."""
    few, all_pairs = results.combinations, load_results(results.folder, pairs=True).combinations
    names = [(it.baseline, it.proposed) for it in all_pairs]
    assert names == [("baseline", "arp"), ("baseline", "relative"), ("arp", "relative")]
    assert all_pairs[0].answer.claims > few[0].answer.claims
    for one, other in zip(few[0].measured.changes, all_pairs[0].measured.changes, strict=True):
        assert one.corrected is None or other.corrected >= one.corrected


def test_the_mean_return_is_split(results: Results):
    """Of the final evaluation; the indices stay what the number is told by, and it makes no claim."""
    found = results.combinations[0]
    split = found.number.returns[found.manner]
    assert split.is_split
    total = split.total
    assert total.change.mean == pytest.approx(split.returns[KK].mean - split.returns[BB].mean)
    assert total.change.mean == pytest.approx(total.ruler.mean + total.behaviour.mean)
    assert found.number.main is None
    assert split.ratio.outcomes is None
    assert found.number.sentence(found.names).startswith("I_N")
