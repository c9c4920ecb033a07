"""The figure of ruler x behaviour, on a logarithmic axis."""

import math
from itertools import pairwise

from numpy.testing import assert_allclose

from harness.eta import Estimate, Split
from harness.report import Dots, Line, describe_split
from harness.report.figures.chart import Note, Word
from harness.report.figures.split import draw_split


def figures(results):
    """The splits of the only combination, and their figures."""
    (combination,) = results.combinations
    both = combination.number.splits
    return both, {name: draw_split(name, split) for name, split in both.items()}


def marks(chart, kind):
    """The marks of one kind."""
    return [mark for mark in chart.marks if isinstance(mark, kind)]


def test_every_part_is_drawn_with_its_interval(build):
    """A point per ratio, a bar from end to end of its interval, on a logarithmic axis that holds them and 1."""
    both, drawn = figures(build())
    for name, chart in drawn.items():
        split = both[name]
        ratios = [split.eta, split.ruler, split.behaviour, *(part for path in split.paths for part in path)]
        assert [point.x for point in marks(chart, Dots)] == [[ratio.value] for ratio in ratios]
        bars = [bar.x for bar in marks(chart, Line)]
        assert_allclose(bars, [(ratio.low, ratio.high) for ratio in ratios], atol=1e-12)
        assert chart.x.is_log
        assert chart.x.low < min(1.0, *(ratio.low for ratio in ratios))
        assert chart.x.high > max(1.0, *(ratio.high for ratio in ratios))


def test_near_zero_is_a_word_in_the_figure(build):
    """A ratio that says little is no point: it would stretch the axis."""
    _, drawn = figures(build(baseline=(9, 9), proposed={"arp": (1, 3_000)}, seeds=2))
    chart = drawn["eta_P"]
    assert [note.text for note in marks(chart, Note)].count("near zero") == 6
    assert len(marks(chart, Dots)) == 1
    assert chart.x.high < 10.0


def test_missing_part_is_a_word_in_the_figure(build):
    """What has no value is n/a in its row; what has one is still drawn."""
    _, drawn = figures(build(baseline=(39, 0)))
    assert sorted(note.text for note in marks(drawn["eta_P"], Note)) == ["1.89", *["n/a"] * 6]


def test_parts_are_told_apart_by_colour_and_shape(build):
    """Those of a single path are open."""
    _, drawn = figures(build())
    looks = [(dot.colour, dot.shape, dot.is_open) for dot in marks(drawn["eta_N"], Dots)]
    ruler, behaviour = ("ruler", "square"), ("behaviour", "diamond")
    paths = [(*part, True) for part in (ruler, behaviour)] * 2
    assert looks == [("ink", "circle", False), (*ruler, False), (*behaviour, False), *paths]


def test_words_say_the_same(build):
    """The caption has every number of the figure."""
    both, drawn = figures(build())
    text = describe_split("eta_P", both["eta_P"])
    assert text == "eta_P 1.89 = ruler 1.89 x behaviour 1.00; interaction 1.00."
    assert all(note.text.split()[0] in text for note in marks(drawn["eta_P"], Note)[:3])


def test_numbers_stand_in_a_column_beside_the_panel(build):
    """One for each row, at its height, and no text over a mark; each path has a heading."""
    _, drawn = figures(build())
    chart = drawn["eta_N"]
    assert [note.y for note in marks(chart, Note)] == [dots.y[0] for dots in marks(chart, Dots)]
    assert marks(chart, Word) == []
    assert [name for _, name in chart.y.ticks] == [
        *["eta_N", "ruler", "behaviour"], *["ruler", "behaviour"] * 2, "proposed runs", "baseline's runs",
    ]  # fmt: skip


NEAR_ZERO = "I_N of the baseline is near zero beside I_P of the same runs"


def drawn_of(*ratios):
    """The figure of an eta, its ruler and its behaviour."""
    eta, ruler, behaviour, *_ = (*ratios, Estimate(None), Estimate(None))
    return draw_split("eta_P", Split(eta, eta, ruler, behaviour, eta))


def test_ticks_are_few_in_order_and_keep_apart(subtests):
    """Wherever the axis ends, 1 is marked, and names are half a character or more apart."""
    spans = [(0.8, 1.2), (0.97, 1.03), (0.1, 3.0), (0.01, 40.0), (1e-9, 1e9)]
    lows, highs = (0.95, 0.5, 0.05, 0.001, 2e-4, 1e-5, 1e-8), (1.3, 2.0, 20.0, 3e3, 1e8)
    for low, high in (*spans, *((low, high) for low in lows for high in highs)):
        with subtests.test(low=low, high=high):
            axis = drawn_of(Estimate(low), Estimate(high)).x
            marks, names = zip(*axis.ticks, strict=True)
            assert "1" in names
            assert [*marks] == sorted({*marks})
            assert len(marks) <= 10
            assert axis.low <= marks[0] < marks[-1] <= axis.high
            places = [26 * math.log(mark / axis.low) / math.log(axis.high / axis.low) for mark in marks]
            ends = [at + sign * len(name) / 2 for at, name in zip(places, names, strict=True) for sign in (-1, 1)]
            assert min(right - left for left, right in [*pairwise(ends[1:-1])][::2]) >= 0.5
    assert [name for _, name in drawn_of(Estimate(1e-6), Estimate(1e6)).x.ticks] == [
        "1e-6",
        "0.001",
        "1",
        "1,000",
        "1e6",
    ]


def test_what_has_no_logarithm_is_not_drawn():
    """Neither is what says little, and what is not there; without any part there is no figure."""
    nothing = (Estimate(0.0), Estimate(-1.0), Estimate(None), Estimate(2.0, near_zero=NEAR_ZERO))
    for ratio in nothing:
        assert len(marks(drawn_of(ratio, Estimate(0.2)), Dots)) == 1
        assert drawn_of(Estimate(0.2), ratio) is None


def test_range_holds_what_is_drawn_and_one():
    """A ratio that says little does not stretch it; near 1 it is an axis around 1."""
    axis = drawn_of(Estimate(1e9, near_zero=NEAR_ZERO), Estimate(3.0, 2.0, 9.0)).x
    assert axis.low < 1.0
    assert 9.0 < axis.high < 20.0
    axis = drawn_of(Estimate(1.0), Estimate(1.0)).x
    assert 0.5 < axis.low < 1.0 < axis.high < 2.0


def test_endless_interval_is_cut():
    """An interval far beyond the ratios ends with the axis; the ratio keeps its place, and one without has no bar."""
    chart = drawn_of(Estimate(2.0), Estimate(2.0, 1.0, 1e30))
    assert 60.0 < chart.x.high < 90.0
    assert [bar.x for bar in marks(chart, Line)] == [[1.0, chart.x.high]]


def test_interval_stands_behind_its_ratio_where_there_is_one():
    """A ratio without an interval, or with one that says little, stands alone."""
    whole, weak = (
        drawn_of(Estimate(2.0, 1.5, 3.0), Estimate(2.0)),
        drawn_of(Estimate(2e9, 1e9, 3e9, near_zero="I_P"), Estimate(2.0)),
    )
    numbers = [note.text for chart in (whole, weak) for note in marks(chart, Note)]
    assert numbers == ["2.00 [1.50, 3.00]", "2.00", "n/a", "near zero", "2.00", "n/a"]
