"""Every simulator that is installed is the same robot, and moves alike within known bounds."""

from itertools import combinations

import pytest

from harness_plugins.parity import Setting, choose_contenders, compare_simulators
from tests.registered import REGISTRY

SIMULATORS = ("mujoco", "dm_control", "pybullet", "drake", "physx", "kinematic")


DRIVEN = [("mujoco", 3e-3), ("dm_control", 3e-3), ("pybullet", 1e-3), ("drake", 3e-3), ("physx", 1e-3)]
"""Simulators with dynamics, and how far the end effector may be from where it was told to be, [m]."""
OTHERS = ("pybullet", "drake", "physx", "kinematic")
"""Those that are not MuJoCo."""


@pytest.fixture(scope="module")
def parity(each_robot):
    """Those of them that are installed, with their default settings."""
    specs = [spec for name in SIMULATORS for spec in REGISTRY.specs.get(("simulators", name), ())]
    names = [spec.name for spec in specs if not spec.missing]
    found = compare_simulators(choose_contenders(REGISTRY, names, None), Setting(each_robot, episodes=4))
    assert not found.failed
    return found


@pytest.fixture
def simulator(parity):
    """What was measured of a simulator; skips the test if it is not installed."""
    found = {simulator.name: simulator for simulator in parity.simulators}

    def call(name):
        if name not in found:
            pytest.skip(f"{name} is not installed: see 'harness describe simulators'")
        return found[name]

    return call


@pytest.fixture
def pair(parity, simulator):
    """What was measured of two; skips the test if one is not installed."""

    def call(*names):
        assert all(simulator(name) for name in names)
        return next(pair for pair in parity.pairs if {pair.a, pair.b} == set(names))

    return call


@pytest.mark.parametrize("name", SIMULATORS)
def test_a_placed_arm_is_the_robot(simulator, name):
    """Joints and tip are within a micrometre and a microradian of the robot's own kinematics."""
    placement = simulator(name).placement
    assert placement.error_m < 1e-6
    assert placement.error_rad < 1e-6


@pytest.mark.parametrize(("name", "bound"), DRIVEN)
def test_a_driven_arm_is_near_where_it_was_told_to_be(simulator, name, bound):
    """Over 200 steps of smooth motion; it does move, so that it is not exactly there."""
    assert 1e-7 < simulator(name).tracking.max_tip_error_m < bound


def test_the_kinematic_arm_is_exactly_where_it_was_told_to_be(simulator):
    """It has no dynamics."""
    assert simulator("kinematic").tracking.max_tip_error_m < 1e-12


def test_dm_control_is_mujoco(pair):
    """The same engine, model and settings: the same motion to a nanometre."""
    found = pair("mujoco", "dm_control")
    assert found.drift.max_tip_error_m < 1e-9
    assert found.placed_disagreement == 0.0


@pytest.mark.parametrize(("one", "other"), list(combinations(("mujoco", *OTHERS), 2)))
def test_engines_stay_near_one_another(pair, one, other):
    """Within 5 mm over 200 steps, and they see the ground within a period or so of one another."""
    found = pair(one, other)
    assert found.drift.max_tip_error_m < 5e-3
    assert found.contact.both == 4
    assert found.contact.max_delay_s <= 0.1 + 1e-9
    assert found.contact.disagreement < 0.05
    assert found.placed_disagreement < 0.05


@pytest.mark.parametrize(("one", "other"), list(combinations(SIMULATORS, 2)))
def test_slow_arms_are_within_5_mm_of_one_another(pair, one, other):
    """Of every two simulators with ideal drives, over 200 steps."""
    assert pair(one, other).differences["slow"].max_tip_error_m < 5e-3


def test_another_setting_is_another_simulator(each_robot):
    """MuJoCo at twice the substeps differs from itself, by less than from other engines."""
    pytest.importorskip("mujoco")
    contenders = choose_contenders(REGISTRY, ["mujoco,mujoco:substeps=40"], None)
    (pair,) = compare_simulators(contenders, Setting(each_robot, steps=60, episodes=2)).pairs
    assert 1e-7 < pair.drift.max_tip_error_m < 1e-3
