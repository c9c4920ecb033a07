"""Comparisons at a glance, as text."""

from types import SimpleNamespace

import pytest

from harness.eta import Change, Estimate, Quantity
from harness.results.overview import (
    Overview,
    decider_text,
    measure_text,
    overview_html,
    overview_row,
    shared_text,
)


@pytest.mark.parametrize(
    ("ratio", "text"),
    [
        (Estimate(1.2345), "1.23"),
        (Estimate(0.5), "0.500"),
        (Estimate(123456.7), "123,000"),
        (Estimate(2.5e7), "2.50e+07"),
        (Estimate(None), "n/a"),
        (Estimate(1e9, near_zero="I_P of the baseline is near zero"), "near zero"),
        (Estimate(0.5, 0.25, 12.3), "0.500 [0.250, 12.3]"),
        (Estimate(-0.5, -0.75, 0.0), "-0.500 [-0.750, 0.00]"),
        (Estimate(1.0, 0.0, 2.0, near_zero="I_P"), "near zero"),
    ],
)
def test_a_ratio_and_its_interval_have_three_digits(ratio, text):
    """Below a million without an exponent; no interval where it says nothing."""
    splits = {name: SimpleNamespace(eta=ratio, ruler=Estimate(1.0)) for name in ("eta_N", "eta_P")}
    headline = SimpleNamespace(answer=SimpleNamespace(value="helps"), decided_by=None)
    told = SimpleNamespace(number=SimpleNamespace(splits=splits), decisive=None, decisive_changes=(), headline=headline)
    assert list(overview_row("arp", told, True, Overview("robot", "success", "indices"))[4:6]) == [text] * 2


def test_two_values_stand_beside_an_arrow():
    """As on the page, with the digits that tell them apart: no sign that reads as an inequality."""
    share = Quantity("success_rate", "", "higher", "deterministic", 100)
    time = Quantity("time_to_target", "s", "lower", "deterministic")
    assert measure_text(Change(share, 0.99, 1.0, None)) == "99.0 -> 100.0 %"
    assert measure_text(Change(time, -1140.0, -78.9, None)) == "-1,140 -> -79 s"


def _decided(name):
    share = Change(Quantity("success_rate", "", "higher", "deterministic", 100), 0.98, 0.99, None)
    time = Change(Quantity("time_to_target", "s", "lower", "deterministic"), 0.861, 0.37, None)
    speed = Change(Quantity("success_rate", "", "higher", "while training", 100), 0.42, 0.61, None)
    headline = SimpleNamespace(decided_by=name)
    return SimpleNamespace(headline=headline, decisive_changes=(share, time, speed), decisive=share)


@pytest.mark.parametrize(
    ("name", "told"),
    [
        (None, "-"),
        ("success_rate", "success"),
        ("time_to_target", "the time, 0.86 -> 0.37 s"),
        ("success_rate while training", "success while training, 42 -> 61 %"),
    ],
)
def test_what_decided_is_named(name, told):
    """With its values where the table has no column for it."""
    assert decider_text(_decided(name)) == told


def test_success_that_nobody_knows_is_none():
    """Of what was not measured."""
    assert measure_text(None) == "n/a"


def test_a_notebook_sees_no_table_of_nothing():
    """An experiment of one reward compares nothing."""
    assert overview_html(()) == ""


def _comparison(simulator, steps, counts=(2, 2)):
    """As far as what is shared looks at it."""
    labels = {"simulator": simulator, "task": "reach"}
    group = SimpleNamespace(labels=labels, shown=labels, steps=steps, manner="deterministically")
    return SimpleNamespace(group=group, proposed="arp", baseline="baseline", counts=counts)


def test_what_is_shared_is_said_once():
    """The reward too where only the places differ; the steps where they are equal."""
    mujoco, longer = _comparison("mujoco", 1_000), _comparison("pybullet", 2_000)
    assert shared_text([mujoco, longer]) == "reach · arp · against baseline · 2 seeds"
    odd = _comparison("mujoco", 1_000, (10, 5))
    assert shared_text([odd]) == "mujoco · reach · against baseline · 1,000 steps · 10 seeds against 5 seeds"
