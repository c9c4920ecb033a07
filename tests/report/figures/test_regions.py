"""The regions of a mean curve that I_N and I_P sum."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from numpy.testing import assert_allclose

from harness.eta import curve_of
from harness.report.figures.accumulated import panel_of, regions_of

OMEGA_1, OMEGA_2 = "Ω₁", "Ω₂"
VALUES = st.lists(st.integers(-9, 9).map(float), min_size=2, max_size=40)


def panel(curve, kind="accumulated"):
    """One run whose curve this is."""
    whole = curve_of([np.array(curve) if kind == "per-step" else np.diff(curve, prepend=0.0)], kind)
    return panel_of("Baseline", "baseline", whole, whole.index, (0,))


def regions(curve, kind="accumulated"):
    """The regions by name."""
    return {region.name: region for region in regions_of(panel(curve, kind))}


@given(VALUES)
def test_areas_add_up_to_that_between_the_curve_and_zero(curve):
    """Each on its side, with the exact places where the curve goes through 0."""
    fine = np.linspace(0.0, len(curve) - 1, 5040 * (len(curve) - 1) + 1)
    drawn = np.interp(fine, np.arange(len(curve)), curve)
    found = regions(curve)
    for name, side in ((OMEGA_1, np.minimum(drawn, 0.0)), (OMEGA_2, np.maximum(drawn, 0.0))):
        area = np.trapezoid(found[name].y, found[name].x) if name in found else 0.0
        assert area == pytest.approx(np.trapezoid(side, fine), abs=1e-4)


def test_curve_goes_through_zero_between_two_steps():
    """There both regions end: neither reaches to the other's side."""
    found = regions([-1.0, 3.0])
    assert_allclose((found[OMEGA_1].x, found[OMEGA_1].y), [[0.0, 0.25], [-1.0, 0.0]])
    assert_allclose((found[OMEGA_2].x, found[OMEGA_2].y), [[0.25, 1.0], [0.0, 3.0]])


@pytest.mark.parametrize(("curve", "name"), [([-1.0, -2.0], OMEGA_1), ([1.0, 2.0], OMEGA_2)])
def test_region_without_area_is_left_out(curve, name):
    """A curve that stays on one side has one region; one that is 0 has none."""
    assert list(regions(curve)) == [name]
    assert regions([0.0, 0.0]) == {}


def test_region_in_parts_is_zero_between_them():
    """A curve that turns negative again has more below 0; the points on 0 between are not drawn."""
    below = regions([-1.0, 1.0, 1.0, 1.0, 1.0, -1.0])[OMEGA_1]
    assert_allclose(below.x, [0.0, 0.5, 4.5, 5.0])
    assert_allclose(below.y, [-1.0, 0.0, 0.0, -1.0])


def test_centre_has_half_of_the_area_before_it():
    """Inside the region, halfway up."""
    assert regions([4.0, 4.0, 4.0, 4.0])[OMEGA_2].centre == (1.5, 2.0)
    x, y = regions([0.0, -1.0, -9.0, -1.0, 0.0])[OMEGA_1].centre
    assert 1.0 < x < 3.0
    assert -9.0 < y < 0.0


def test_per_step_regions_meet_behind_the_crossover():
    """There I_N sums up to and with the cross-over, whatever the signs."""
    found = regions([1.0, -1.0, -2.0, 1.0, 2.0, -1.0, 2.0], "per-step")
    assert found[OMEGA_1].x.tolist() == [0.0, 1.0, 2.0, 3.0]
    assert found[OMEGA_2].y.tolist() == [2.0, -1.0, 2.0]


@pytest.mark.parametrize(("curve", "name"), [([1.0, -1.0, -2.0], OMEGA_1), ([1.0, 0.0, 2.0], OMEGA_2)])
def test_per_step_curve_without_crossover_is_one_region(curve, name):
    """One that never comes back is all I_N, one that is never negative is all I_P."""
    found = regions(curve, "per-step")
    assert list(found) == [name]
    assert found[name].y.tolist() == curve


def test_region_of_few_steps_has_no_room_for_its_name():
    """Below a fiftieth of the axis, or if it is flat: the name would cover more than the region."""
    (region,) = regions_of(panel([0.0, -1.0, 0.0]))
    assert region.has_room(100.0, 12.0)
    assert not region.has_room(101.0, 12.0)
    assert not region.has_room(100.0, 13.0)
