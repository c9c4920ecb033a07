"""The parts of the pay, and the sentence that stands beside them."""

import math

import numpy as np
import pytest

from harness import load_results
from harness.report.rows.returns import PayPart, is_ruler, pay_parts
from tests.report.conftest import NO_PAIR
from tests.results.recordings.conftest import PAYS, record


@pytest.fixture
def recorded_pay(tmp_path):
    """A comparison in an environment whose returns are below 0."""
    pays = {**PAYS, "loss": lambda arm: arm - 2.0}
    for reward in ("plain", "loss"):
        for seed in range(3):
            record(tmp_path / f"{reward}-{seed}", reward, seed, np.linspace(0.0, 1.0, 10) + 0.01 * seed, pays=pays)
    (combination,) = load_results(tmp_path).combinations
    return combination


def test_a_ratio_has_parts_that_multiply(build):
    """Their logarithms add up to that of the ratio."""
    (combination,) = build(baseline=(9, 12), proposed={"arp": (1, 20)}).combinations
    parts = pay_parts(combination)
    split = combination.number.returns[combination.manner].ratio
    assert "times as much" in combination.pay_sentence
    assert [part.name for part in parts] == ["ruler", "behaviour"]
    assert sum(part.size for part in parts) == pytest.approx(math.log(split.eta.value), rel=1e-6)


def test_a_difference_has_parts_that_add_up(recorded_pay):
    """Where a return is not above 0."""
    parts = pay_parts(recorded_pay)
    change = recorded_pay.number.returns[recorded_pay.manner].total.change.value
    assert "is paid -5.23 with loss and 9.77 with plain: a change of -15.0 [-15.0, -15.0]" in recorded_pay.pay_sentence
    assert sum(part.size for part in parts) == pytest.approx(change)
    assert all(part.text.startswith(("+", "-")) for part in parts if part.size)


def test_what_is_not_split_has_its_reason(build):
    """The plugin of the reward is gone."""
    (combination,) = build(proposed={"gone": (9, 30)}).combinations
    assert pay_parts(combination) == ()
    assert combination.pay_sentence.startswith("The pay of an episode is not known: No reward 'gone' is installed")
    assert not is_ruler(())


def test_nothing_compared_has_no_pay(build):
    """No seed is done under both."""
    (combination,) = build(**NO_PAIR).combinations
    assert (pay_parts(combination), combination.pay_sentence) == ((), "")


def test_nearly_all_is_more_than_nine_tenths(subtests):
    """Of the change, whichever way the behaviour goes."""
    for ruler, behaviour, is_told in [
        (1.0, 0.05, True),
        (1.0, -0.05, True),
        (1.0, 0.5, False),
        (1.0, -0.9, False),
        (0.0, 1.0, False),
        (0.0, 0.0, False),
    ]:
        with subtests.test(ruler=ruler, behaviour=behaviour, is_told=is_told):
            assert is_ruler((PayPart("ruler", "", ruler), PayPart("behaviour", "", behaviour))) is is_told
