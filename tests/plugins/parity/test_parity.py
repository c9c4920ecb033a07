"""Simulators compared: each fault is in the figure that is there for it, and in no other simulator's."""

import json
from dataclasses import replace

import pytest
from numpy.testing import assert_array_equal

from harness_plugins.parity import Missing


def test_the_same_simulator_twice_does_not_differ(compare, toolbox):
    """Every figure is 0, and so are its own errors."""
    parity = compare(one=toolbox.ideal, two=toolbox.ideal)
    (pair,) = parity.pairs
    assert (pair.drift.max_tip_error_m, pair.drift.max_joint_error_rad) == (0.0, 0.0)
    assert (pair.contact.disagreement, pair.placed_disagreement, pair.contact.both) == (0.0, 0.0, 3)
    for simulator in parity.simulators:
        assert simulator.placement == (0.0, 0.0)
        assert (simulator.tracking.max_tip_error_m, simulator.tracking.max_joint_error_rad) == (0.0, 0.0)
        assert 0.0 < simulator.seconds_per_step < 0.1


def test_a_tip_that_is_a_millimetre_off_is_caught(compare, toolbox):
    """In placement and drift, of the tip alone."""
    parity = compare(right=toolbox.ideal, wrong=toolbox.shifted_tip(1e-3))
    right, wrong = parity.simulators
    (pair,) = parity.pairs
    assert right.placement.error_m == 0.0
    assert wrong.placement == (pytest.approx(1e-3), 0.0)
    assert pair.drift.max_tip_error_m == pytest.approx(1e-3)
    assert pair.drift.mean_tip_error_m == pytest.approx(1e-3)
    assert pair.drift.max_joint_error_rad == 0.0
    assert pair.contact.disagreement == 0.0


def test_an_arm_that_lags_a_period_is_caught(compare, toolbox):
    """In drift, by as far as the fastest joint moves in a period; and in the dives. Placed it is right."""
    parity = compare(right=toolbox.ideal, late=toolbox.late)
    (pair,) = parity.pairs
    assert parity.simulators[1].placement == (0.0, 0.0)
    assert pair.drift.max_tip_error_m > 0.02
    fastest = 0.8 * parity.setting.robot.max_speed.max() * parity.setting.period
    assert 0.5 * fastest < pair.drift.max_joint_error_rad <= fastest
    assert pair.contact.mean_delay_s == pytest.approx(0.1)
    assert pair.contact.disagreement > 0.0


def test_an_arm_that_feels_nothing_is_caught(compare, toolbox):
    """It disagrees from the first contact on, and on poses below the ground."""
    (pair,) = compare(right=toolbox.ideal, numb=toolbox.numb).pairs
    assert pair.contact.only_a == 3
    assert pair.contact.disagreement > 0.1
    assert pair.placed_disagreement > 0.1
    assert pair.contact.mean_delay_s is None
    assert pair.drift.max_tip_error_m == 0.0


def test_an_arm_that_feels_the_ground_too_early_is_caught(compare, toolbox):
    """With a delay that has the sign of early."""
    (pair,) = compare(right=toolbox.ideal, shy=toolbox.shy(0.2)).pairs
    assert pair.contact.mean_delay_s < 0.0
    assert pair.contact.disagreement > 0.0


def test_an_arm_that_is_put_elsewhere_is_caught(compare, toolbox):
    """In placement, of joints and tip; driven it is right."""
    wrong = compare(right=toolbox.ideal, wrong=toolbox.misplaced).simulators[1]
    assert wrong.placement.error_rad == pytest.approx(0.01)
    assert 1e-3 < wrong.placement.error_m < 0.1
    assert wrong.tracking.max_tip_error_m == 0.0


def test_all_pairs_are_there_the_reference_first(compare, toolbox):
    """Each two once, in the order of the simulators."""
    parity = compare(c=toolbox.ideal, a=toolbox.ideal, b=toolbox.late)
    assert parity.reference == "c"
    assert [(pair.a, pair.b) for pair in parity.pairs] == [("c", "a"), ("c", "b"), ("a", "b")]


def test_one_that_fails_costs_itself_alone(compare, toolbox, subtests):
    """Wherever it fails, in the batch or when it is timed alone."""
    for call, envs in [("place", 3), *((call, envs) for envs in (3, 1) for call in ("reset", "drive", "close"))]:
        with subtests.test(call=call):
            parity = compare(good=toolbox.ideal, bad=toolbox.raising(call, envs), late=toolbox.late)
            assert {name: failure.reason for name, failure in parity.failed.items()} == {
                "bad": "RuntimeError: the belt slipped"
            }
            assert [simulator.name for simulator in parity.simulators] == ["good", "late"]
            assert [(pair.a, pair.b) for pair in parity.pairs] == [("good", "late")]


def test_a_simulation_that_diverges_is_a_failure(compare, toolbox):
    """Not a NaN in the figures."""
    parity = compare(good=toolbox.ideal, bad=toolbox.exploding, shut=toolbox.closed)
    assert "qpos is not finite after control period 3" in parity.failed["bad"].reason
    assert parity.failed["shut"].reason == "MemoryError"
    assert parity.pairs == ()


def test_an_interrupt_is_no_failure_of_a_simulator(compare, toolbox):
    """It ends the command."""
    with pytest.raises(KeyboardInterrupt):
        compare(one=toolbox.interrupted)


def test_arrays_that_a_simulation_writes_over_are_copied(compare, toolbox):
    """One that always returns the same arrays is where it was told to be, too."""
    assert compare(one=toolbox.reusing).simulators[0].tracking.max_tip_error_m == 0.0


def test_a_reference_that_fails_is_still_named(compare, toolbox):
    """The others are compared with one another."""
    parity = compare(bad=toolbox.exploding, one=toolbox.ideal, two=toolbox.late)
    assert parity.reference == "bad"
    assert [(pair.a, pair.b) for pair in parity.pairs] == [("one", "two")]


def test_an_arm_that_does_not_reach_the_ground_has_no_contact_figures(compare, toolbox, robot):
    """Null with a reason, not 0."""
    stiff = replace(robot, lower=robot.home - 0.05, upper=robot.home + 0.05)
    (pair,) = compare(arm=stiff, one=toolbox.ideal, two=toolbox.late).to_json()["pairs"]
    assert pair["contact_disagreement"] is None
    assert pair["mean_contact_delay_s"] is None
    assert "contact" not in pair["classes"]
    assert pair["contact_note"] == "no part of the arm was found to get into the ground"


def test_json_has_what_it_promises(compare, toolbox):
    """Keys, finite numbers, curves of one value per row, the missing and the failed."""
    parity = compare(
        [Missing("far", "away", "pip install far")], one=toolbox.ideal, two=toolbox.late, bad=toolbox.closed
    )
    data = json.loads(json.dumps(parity.to_json(), allow_nan=False))
    assert (data["format"], data["reference"], data["robot"], data["steps"]) == (1, "one", "fd100", 40)
    assert data["control_period_s"] == 0.1
    assert [one["name"] for one in data["simulators"]] == ["one", "two"]
    assert data["missing"] == [{"name": "far", "extra": "away", "remedy": "pip install far"}]
    assert data["failed"] == [{"name": "bad", "reason": "MemoryError"}]
    (pair,) = data["pairs"]
    assert (pair["a"], pair["b"]) == ("one", "two")
    assert pair["dives"] == {"both": 3, "only_a": 0, "only_b": 0, "neither": 0}
    assert 0.0 < pair["mean_tip_error_m"] < pair["max_tip_error_m"]
    assert list(data["classes"]) == list(pair["classes"]) == ["slow", "smooth", "fast", "singular", "contact"]
    assert pair["classes"]["smooth"]["max_tip_error_m"] == pair["max_tip_error_m"]
    assert set(data["simulators"][1]["classes"]["fast"]) == {
        *("tracking_error_m", "speed_told", "speed_reached", "falls_short", "lag_s")
    }
    curve = pair["curves"]["max_tip_error_m"]
    assert (len(curve), curve[0], max(curve)) == (41, 0.0, pair["max_tip_error_m"])


def test_a_setting_gives_the_same_figures_again(compare, toolbox):
    """Apart from the cost, which is a matter of the weather."""
    first, second = (compare(one=toolbox.ideal, two=toolbox.late).pairs[0] for _ in range(2))
    assert_array_equal(first.drift.tip, second.drift.tip)
    assert first.contact == second.contact
