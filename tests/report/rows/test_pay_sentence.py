"""The pay in one line."""

import math
import re

import numpy as np
import pytest

from harness import load_results
from harness.report import format_number
from harness.report.rows.returns import PayPart, PaySentence, pay_of
from tests.report.conftest import NO_PAIR
from tests.results.recordings.conftest import PAYS, record


@pytest.fixture
def recorded_pay(tmp_path):
    """A comparison in an environment whose returns are below 0, and its pay."""
    pays = {**PAYS, "loss": lambda arm: arm - 2.0}
    for reward in ("plain", "loss"):
        for seed in range(3):
            record(tmp_path / f"{reward}-{seed}", reward, seed, np.linspace(0.0, 1.0, 10) + 0.01 * seed, pays=pays)
    (combination,) = load_results(tmp_path).combinations
    return combination, pay_of(combination)


def test_a_ratio_has_parts_that_multiply(build):
    """Their logarithms add up to that of the ratio."""
    (combination,) = build(baseline=(9, 12), proposed={"arp": (1, 20)}).combinations
    pay = pay_of(combination)
    split = combination.number.returns[combination.manner].ratio
    assert re.fullmatch(r"An episode is paid [\d.]+ instead of [\d.]+: [\d.]+ times as much", pay.told)
    assert [part.name for part in pay.parts] == ["ruler", "behaviour"]
    assert sum(part.size for part in pay.parts) == pytest.approx(math.log(split.eta.value), rel=1e-6)


def test_a_difference_has_parts_that_add_up(recorded_pay):
    """Where a return is not above 0."""
    combination, pay = recorded_pay
    change = combination.number.returns[combination.manner].total.change.mean
    assert pay.told == f"An episode is paid -5.23 instead of 9.77: {format_number(-change)} less"
    assert sum(part.size for part in pay.parts) == pytest.approx(change)
    assert all(part.text.startswith(("+", "-")) for part in pay.parts if part.size)


def test_what_is_not_split_has_its_reason(build):
    """The plugin of the reward is gone."""
    (combination,) = build(proposed={"gone": (9, 30)}).combinations
    pay = pay_of(combination)
    assert pay.parts == ()
    assert "No reward 'gone'" in pay.why
    assert not pay.is_ruler


def test_nothing_compared_has_no_pay(build):
    """No seed is done under both."""
    (combination,) = build(**NO_PAIR).combinations
    assert pay_of(combination) is None


def test_nearly_all_is_more_than_nine_tenths(subtests):
    """Of the change, whichever way the behaviour goes."""
    for ruler, behaviour, is_ruler in [
        (1.0, 0.05, True),
        (1.0, -0.05, True),
        (1.0, 0.5, False),
        (1.0, -0.9, False),
        (0.0, 1.0, False),
        (0.0, 0.0, False),
    ]:
        with subtests.test(ruler=ruler, behaviour=behaviour, is_ruler=is_ruler):
            pay = PaySentence("", (PayPart("ruler", "", ruler), PayPart("behaviour", "", behaviour)), "")
            assert pay.is_ruler is is_ruler
