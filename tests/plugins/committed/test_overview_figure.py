"""Every combination at a glance."""

import xml.etree.ElementTree as ET

from harness_plugins.committed.figures import draw_overview, name_apart

SVG = "{http://www.w3.org/2000/svg}"


def drawn(results, missing=None):
    """The texts of the overview, and the classes of what is drawn in it."""
    told = missing or [""] * len(results.combinations)
    svg = ET.fromstring(draw_overview(results.combinations, told))
    return ["".join(node.itertext()) for node in svg.iter(f"{SVG}text")], [
        node.get("class") for node in svg.iter(f"{SVG}path")
    ]


def test_overview_has_a_row_per_combination(build):
    """With three numbers per eta, or the words in their place; one without a finished pair too, and what is missing."""
    results = build(proposed={"arp": (9, 30), "gone": (9, 30)}, ended={("gone", 0): ("failed", "it broke")}, seeds=1)
    told, _ = drawn(results, ["", "1 failed of 2 cells"])
    assert {"arp", "1 seed", "gone", "0 seeds; 1 failed of 2 cells"} <= set(told)
    assert told.count("n/a") == 6


def test_each_ratio_has_a_point_and_its_interval(build):
    """Of both panels; the legend has one sample of each kind."""
    told, kinds = drawn(build(proposed={"arp": (5, 34)}))
    for colour in ("ink", "ruler", "behaviour"):
        assert kinds.count(f"dot {colour}") == 2 + 1
        assert kinds.count(f"line {colour}") == 2
    assert [text for text in told if text in ("η, equal to", "ruler times", "behaviour")] == [
        "η, equal to",
        "ruler times",
        "behaviour",
    ]


def test_overview_says_once_what_is_shared(build):
    """And for each row what is not; a row is never without a name."""
    shared, names = name_apart(build(simulators=("mujoco", "pybullet")).combinations)
    assert shared == "sac · fd100 · fd100-reach · arp · against baseline · 40 steps, evaluated deterministically"
    assert names == ["mujoco", "pybullet"]
    assert name_apart(build().combinations)[1] == ["arp"]


def test_no_pair_no_overview(build):
    """Without a finished pair there is nothing to draw."""
    results = build(seeds=1, ended={("arp", 0): ("failed", "it broke")})
    assert draw_overview(results.combinations, [""]) is None


def test_an_eta_without_a_number_is_words(build):
    """No empty panel: a note says why."""
    told, kinds = drawn(build(baseline=(39, 0)))
    assert kinds.count("axis") == 1
    assert any(text.startswith("ηP is not drawn, no combination has a number") for text in told)


def test_no_number_no_overview(build):
    """Where neither eta has one."""
    results = build(baseline=(40, 0), proposed={"arp": (0, 0)})
    assert draw_overview(results.combinations, [""]) is None
