"""Every combination at a glance."""

import xml.etree.ElementTree as ET

import pytest

SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture
def drawn(figures):
    """The texts of the overview, and the classes of what is drawn in it."""

    def read(results):
        svg = ET.fromstring(figures(results)["overview"])
        texts = ["".join(node.itertext()) for node in svg.iter(f"{SVG}text")]
        return texts, [node.get("class") for node in svg.iter(f"{SVG}path")]

    return read


def test_overview_has_a_row_per_combination(build, drawn):
    """With three numbers per eta, or the words in their place; one without a finished pair too, and what is missing."""
    results = build(proposed={"arp": (9, 30), "gone": (9, 30)}, ended={("gone", 0): ("failed", "it broke")}, seeds=1)
    told, _ = drawn(results)
    assert {"arp", "1 seed", "gone", "0 seeds; 1 failed of 2 cells"} <= set(told)
    assert told.count("n/a") == 6


def test_each_ratio_has_a_point_and_its_interval(build, drawn):
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


def test_overview_says_once_what_is_shared(build, drawn):
    """And for each row what is not; a row is never without a name."""
    told, _ = drawn(build(simulators=("mujoco", "pybullet")))
    shared = "sac · fd100 · fd100-reach · arp · against baseline · 40 steps"
    assert "".join(told[1:3]).replace(" ", "").startswith(shared.replace(" ", ""))
    assert {"mujoco", "pybullet"} <= set(told)
    assert "arp" in drawn(build())[0]


def test_an_eta_without_a_number_is_words(build, drawn):
    """No empty panel: a note says why."""
    told, kinds = drawn(build(baseline=(39, 0)))
    assert kinds.count("axis") == 1
    assert any(text.startswith("ηP is not drawn, no combination has a number") for text in told)


def test_no_number_no_overview(build, figures):
    """Where neither eta has one."""
    assert "overview" not in figures(build(baseline=(40, 0), proposed={"arp": (0, 0)}))
