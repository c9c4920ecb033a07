import pytest
from numpy.testing import assert_allclose

from harness.report import Dots, Line
from harness.report.figures.accumulated import draw_both, panels_of
from harness.report.figures.chart import Area, Flag, Word


def panels(results):
    """The only combination and its two panels."""
    (combination,) = results.combinations
    return combination, draw_both(panels_of(combination))


def marks(panel, kind):
    """The marks of one kind."""
    return [mark for mark in panel.marks if isinstance(mark, kind)]


def test_every_run_is_thin_and_their_mean_thick(build):
    """A panel holds one thin curve per seed and the mean curve, thicker and last."""
    combination, drawn = panels(build(seeds=3))
    for panel, who in zip(drawn, ("baseline", "proposed"), strict=True):
        runs = combination.curves[who, who].runs
        *thin, thick = marks(panel, Line)
        assert [line.name for line in thin] == ["seed 0", "seed 1", "seed 2"]
        assert_allclose([line.y for line in thin], runs)
        assert_allclose(thick.y, runs.mean(axis=0))
        assert thick.width > 2 * thin[0].width
        assert {line.colour for line in marks(panel, Line)} == {who}


def test_long_run_is_drawn_at_its_steps(build):
    """Of a long run every so many steps are kept; they, and the marks between them, are drawn where they belong."""
    combination, (panel, _) = panels(build(seeds=1, baseline=(7_001, 12_998)))
    curve = combination.curves["baseline", "baseline"]
    assert curve.stride > 1
    drawn, (dots,) = marks(panel, Line)[0], marks(panel, Dots)
    assert drawn.x[-1] == (curve.runs.shape[1] - 1) * curve.stride
    assert drawn.y[-1] == pytest.approx(12_998 - 7_001, abs=curve.stride)
    assert dots.x == [1, 14_002]
    assert_allclose(dots.y, [-1.0, 0.0], atol=1e-6)


def test_first_negative_and_crossover_are_marked(build):
    """Both steps have a dot on the mean curve, a line and a label with the step."""
    _, (panel, other) = panels(build())
    assert marks(other, Dots)[0].x == [1, 15]  # k2 lets it climb faster
    assert marks(panel, Dots)[0].x == [1, 18]
    assert marks(panel, Flag) == [Flag(1, "first negative: step 1", 1), Flag(18, "cross-over: step 18", 0)]


def test_what_never_happens_is_not_marked(build):
    """A curve that is never negative has no mark."""
    _, (_, panel) = panels(build(proposed={"arp": (0, 39)}))
    assert marks(panel, Flag) == marks(panel, Dots)[0].x == []
    assert [word.text for word in marks(panel, Word)] == ["Ω₂"]


def test_regions_of_the_indices_are_shaded(build):
    """Below 0 up to the cross-over, above 0 behind it, each with its name inside, under all curves."""
    _, (panel, _) = panels(build())
    below, above = panel.marks[:2]
    assert marks(panel, Area) == [below, above]
    assert max(below.y) == min(above.y) == 0.0
    assert max(below.x) <= 18 <= sorted(set(above.x))[1]
    assert [word.text for word in marks(panel, Word)] == ["Ω₁", "Ω₂"]
    for shade, word in zip((below, above), marks(panel, Word), strict=True):
        assert min(shade.x) < word.x < max(shade.x)
        assert min(shade.y) < word.y < max(shade.y)


def test_panels_have_equal_axes(build):
    """Both panels span the same steps and rewards, all values and zero among them."""
    _, (one, other) = panels(build(proposed={"arp": (0, 59)}))
    assert (one.x, one.y) == (other.x, other.y)
    assert (one.x.low, one.x.high) == (0, 59)
    assert one.y.low < -9.0
    assert one.y.high > 1.5 * 1.2 * 59
