"""What the figures of a summary say."""

import xml.etree.ElementTree as ET

import pytest

from harness.report.palette import BLUE, VERMILION
from harness.report.regions import OMEGA_1, OMEGA_2
from harness.report.split_rows import split_rows
from harness.report.summary.learning_figure import draw_learning
from harness.report.summary.overview_figure import draw_overview, name_apart
from harness.report.summary.runs_figure import draw_runs
from harness.report.summary.split_figure import draw_splits
from harness.results.learning import learning_of

SVG = "{http://www.w3.org/2000/svg}"
LONG = "scaled:reward=(arp:k1=2,k2=3.25),factor=12.5"


def words(svg):
    """Every text of a figure, in order."""
    return ["".join(node.itertext()).strip() for node in ET.fromstring(svg).iter(f"{SVG}text")]


def strokes(svg, colour, width):
    """How many lines of that colour and width there are."""
    styles = [node.get("style", "").lower() for node in ET.fromstring(svg).iter(f"{SVG}path")]
    wanted = f"stroke-width: {width}"
    return sum(f"stroke: {colour.lower()};" in style and f"{wanted};" in style + ";" for style in styles)


def test_every_run_and_the_mean_are_drawn(build):
    """Thin and thick, in the two colours of the report."""
    svg = draw_runs(build(seeds=3).combinations[0])
    for colour in (BLUE, VERMILION):
        assert strokes(svg, colour, "0.8") == 3
        assert strokes(svg, colour, "2.6") == 1


def test_marks_of_both_panels_are_named(build):
    """First negative and cross-over, each with its step; what never happens has no mark."""
    told = words(draw_runs(build(proposed={"arp": (0, 39)}).combinations[0]))
    assert [text for text in told if "step" in text] == [
        "environment step",
        "first negative: step 1",
        "cross-over: step 18",
        "environment step",
    ]


def test_regions_of_the_indices_are_named(build):
    """In each panel those that have an area."""
    told = words(draw_runs(build(proposed={"arp": (0, 39)}).combinations[0]))
    assert [text for text in told if text in (OMEGA_1, OMEGA_2)] == [OMEGA_1, OMEGA_2, OMEGA_2]


def test_figure_stands_alone(build):
    """What was compared where, over which seeds, and what is missing."""
    told = words(draw_runs(build().combinations[0], "1 failed of 8 cells"))
    assert "mujoco · sac · fd100 · fd100-reach" in told
    assert "arp against baseline, 3 seeds (0, 1, 2); 1 failed of 8 cells" in told
    assert {"Baseline: baseline", "Proposed: arp"} <= set(told)


def test_no_pair_no_figures(build):
    """Without a finished pair there is nothing to draw."""
    (combination,) = build(seeds=1, ended={("arp", 0): ("failed", "it broke")}).combinations
    assert draw_runs(combination) is draw_splits(combination) is draw_overview([combination], [""]) is None


def test_split_has_every_number_with_its_interval(build):
    """As the table says them."""
    told = words(draw_splits(build(proposed={"arp": (5, 34)}).combinations[0]))
    assert {"eta_N = ruler x behaviour", "eta_P = ruler x behaviour"} <= set(told)
    assert sum(text.endswith("]") and "[" in text for text in told) == 14


def test_near_zero_is_a_word_in_the_split(build):
    """A ratio that says little is no number, as in the page."""
    (combination,) = build(baseline=(9, 9), proposed={"arp": (1, 3_000)}, seeds=2).combinations
    ratios = [row.ratio for name, split in combination.splits.items() for row in split_rows(name, split)]
    count = sum(ratio.near_zero is not None for ratio in ratios)
    assert count > 4
    assert words(draw_splits(combination)).count("near zero") == count


def test_missing_part_is_a_word_in_the_split(build):
    """So is one that is not defined."""
    assert words(draw_splits(build(baseline=(39, 0)).combinations[0])).count("n/a") == 6


def test_unsplit_combination_has_no_split(build):
    """What could not be scored has no ruler."""
    assert draw_splits(build(proposed={"gone": (9, 30)}).combinations[0]) is None


def test_learning_names_its_curves(build):
    """Both rewards and the floor."""
    results = build(learned={10: 1, 20: 2})
    (combination,) = results.combinations
    told = words(draw_learning(combination, learning_of(results, combination)))
    assert {"baseline", "arp", "random actions", "success rate", "100%"} <= set(told)


def test_learning_without_success_is_not_drawn(build):
    """Where that metric is not installed."""
    results = build(learned={10: 1})
    (combination,) = results.combinations
    learning = learning_of(results, combination)
    assert draw_learning(combination, type(learning)(learning.baseline, learning.proposed, {})) is None


def test_overview_has_a_row_per_combination(build):
    """With three numbers per eta, or the words in their place; one without a finished pair too, and what is missing."""
    results = build(proposed={"arp": (9, 30), "gone": (9, 30)}, ended={("gone", 0): ("failed", "it broke")}, seeds=1)
    told = words(draw_overview(results.combinations, ["", "1 failed of 2 cells"]))
    assert {"arp", "1 seed", "gone", "0 seeds; 1 failed of 2 cells"} <= set(told)
    assert told.count("n/a") == 6


def test_overview_says_once_what_is_shared(build):
    """And for each row what is not; a row is never without a name."""
    shared, names = name_apart(build(simulators=("mujoco", "pybullet")).combinations)
    assert shared == "sac · fd100 · fd100-reach · arp · against baseline · 40 steps, evaluated deterministically"
    assert names == ["mujoco", "pybullet"]
    assert name_apart(build().combinations)[1] == ["arp"]


@pytest.mark.parametrize("proposed", [LONG, "arp"])
def test_long_labels_and_single_seeds_leave_room(build, proposed):
    """The layout holds: it warns where it does not, and a warning is an error."""
    results = build(seeds=1, proposed={proposed: (0, 39)}, learned={10: 1})
    (combination,) = results.combinations
    assert draw_runs(combination, "1 failed of 4 cells")
    assert draw_splits(combination)
    assert draw_overview([combination], [""])
    assert draw_learning(combination, learning_of(results, combination))
