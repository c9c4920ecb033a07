"""What the figures of a summary say."""

import xml.etree.ElementTree as ET
from dataclasses import replace

import pytest

from harness.eta import Estimate
from harness_plugins.committed.figures import flat_words, learning_file, measures_of

SVG = "{http://www.w3.org/2000/svg}"


def words(svg):
    """Every text of a figure, in order."""
    return ["".join(node.itertext()) for node in ET.fromstring(svg).iter(f"{SVG}text")]


def strokes(svg, colour, width):
    """How many lines of that colour and width there are."""
    return sum(
        (node.get("class"), node.get("stroke-width")) == (f"line {colour}", width)
        for node in ET.fromstring(svg).iter(f"{SVG}path")
    )


def test_every_run_and_the_mean_are_drawn(build, figures):
    """Thin and thick, in the two colours of the report."""
    svg = figures(build(seeds=3))["runs"]
    for colour in ("baseline", "proposed"):
        assert strokes(svg, colour, "1") == 3
        assert strokes(svg, colour, "3") == 1


@pytest.mark.parametrize("seeds", [1, 30])
def test_many_runs_have_few_points_each(build, figures, seeds):
    """All together as many as a figure holds."""
    svg = figures(build(seeds=seeds, baseline=(2_000, 2_000), proposed={"arp": (2_000, 2_000)}))["runs"]
    runs = [
        (it.get("d").count(" ") + 1) // 2
        for it in ET.fromstring(svg).iter(f"{SVG}path")
        if it.get("stroke-width") == "1"
    ]
    assert len(runs) == 2 * seeds
    assert min(runs) >= 40
    assert sum(runs) <= 8_000


def test_marks_of_both_panels_are_named(build, figures):
    """First negative and cross-over, each with its step; what never happens has no mark."""
    told = words(figures(build(proposed={"arp": (0, 39)}))["runs"])
    assert [text for text in told if "step" in text] == [
        "environment step",
        "first negative: step 1",
        "cross-over: step 18",
        "environment step",
    ]


def test_regions_of_the_indices_are_named(build, figures):
    """In each panel those that have an area."""
    told = words(figures(build(proposed={"arp": (0, 39)}))["runs"])
    assert [text for text in told if text in ("Ω₁", "Ω₂")] == ["Ω₁", "Ω₂", "Ω₂"]


def test_curves_that_look_like_a_line_are_told(build, figures):
    """Both panels have one scale; the mutant: curves that are as high as the other ones."""
    told = " ".join(words(figures(build(baseline=(3_000, 30_000), proposed={"arp": (1, 3)}, seeds=2))["runs"]))
    assert "the curves of arp cannot be told from a line" in told
    assert "cannot be told from a line" not in " ".join(words(figures(build(seeds=2))["runs"]))


def test_figure_stands_alone(build, figures):
    """What it is, what was compared where, over which seeds, and what is missing."""
    told = words(figures(build(seeds=4, ended={("arp", 3): ("failed", "it broke")}))["runs"])
    assert told[:3] == [
        "Accumulated reward",
        "mujoco · sac · fd100 · fd100-reach",
        "arp against baseline, 3 seeds (0, 1, 2); 1 failed of 8 cells",
    ]
    assert {"Baseline: baseline", "Proposed: arp"} <= set(told)


def test_split_has_every_number_with_its_interval(build, figures):
    """As the table says them."""
    told = words(figures(build(proposed={"arp": (5, 34)}))["split"])
    assert {"ηN = ruler × behaviour", "ηP = ruler × behaviour"} <= set(told)
    assert sum(text.endswith("]") and "[" in text for text in told) == 14


def test_near_zero_is_a_word_in_the_split(build, figures):
    """A ratio that says little is no number, as in the page."""
    results = build(baseline=(9, 9), proposed={"arp": (1, 3_000)}, seeds=2)
    assert words(figures(results)["split"]).count("near zero") == 12


def test_missing_part_is_a_word_in_the_split(build, figures):
    """So is one that is not defined."""
    assert words(figures(build(baseline=(39, 0)))["split"]).count("n/a") == 6


def test_unsplit_combination_has_no_split(build, figures):
    """What could not be scored has no ruler."""
    assert "split" not in figures(build(proposed={"gone": (9, 30)}))


@pytest.fixture
def learned(build, figures):
    """A combination that was evaluated while learning, how it learned, and the measures that are shown."""
    results = build(learned={10: 1})
    (combination,) = results.combinations
    learning = results.learning(combination)
    return combination, learning, measures_of(combination, learning)


def test_learning_says_how_many_trainings_its_lines_are_of(build, figures):
    """All of each reward, also where they have other seeds."""
    results = build(learned={10: 1}, ended={("arp", 2): ("failed", "it broke")})
    assert any("3 trainings with baseline, 2 with arp" in text for text in words(figures(results)["learning"]))


def test_learning_names_its_curves(learned):
    """Both rewards and the floor, in the legend, and in words below."""
    told = words(learning_file(*learned))
    assert {"baseline", "arp", "random actions", "success rate", "100\u202f%"} <= set(told)
    assert any(text.startswith("Success rate while learning: baseline 25.0\u202f% after 10 steps") for text in told)


def test_learning_shows_intervals(learned):
    """A band for each reward: of the measure that decides, and of the pay."""
    areas = [node.get("class") for node in ET.fromstring(learning_file(*learned)).iter(f"{SVG}path")]
    assert [kind for kind in areas if kind.startswith("area")] == 2 * ["area baseline", "area proposed"]


def test_learning_without_success_is_not_drawn(learned):
    """Where that metric is not installed."""
    combination, learning, _ = learned
    nothing = replace(learning, random={})
    assert learning_file(combination, nothing, measures_of(combination, nothing)) is None


def level(curve):
    """The same curve at 0."""
    points = {name: tuple(it._replace(mean=Estimate(0.0)) for it in points) for name, points in curve.points.items()}
    return replace(curve, points=points)


def test_learning_in_which_nothing_happens_is_words(learned):
    """The mutant of a flat line: its figure goes, and the words have its value."""
    combination, learning, measures = learned
    flat = replace(learning, curves=tuple(map(level, learning.curves)))
    assert learning_file(combination, flat, measures) is None
    assert flat_words(flat, measures).startswith("Success rate while learning: 0.0% under both rewards at each of 2 ")
    assert flat_words(learning, measures) == ""
