import numpy as np

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
        np.testing.assert_allclose(bars, [(ratio.low, ratio.high) for ratio in ratios], atol=1e-12)
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
