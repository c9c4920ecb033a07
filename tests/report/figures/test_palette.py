"""One palette for pages, figures and films."""

import re
from pathlib import Path

import pytest

import harness.report
from harness.report.figures.chart import light_colours

WORDS = (
    "ruler",
    "behaviour",
    "baseline",
    "proposed",
    "random",
    "helps",
    "hurts",
    "ahead",
    "same",
    "unknown",
    "soft",
    "ink",
)
"""Colours in which words are written too."""
READABLE = 4.5
"""The least contrast of a text with its page (WCAG 2.2, 1.4.3)."""


def _colours(scheme):
    style = Path(harness.report.__file__).with_name("figures") / "palette.css"
    return dict(re.findall(r"--([\w-]+): ([^;]+);", style.read_text().split(":root")[1:][scheme]))


def _brightness(colour):
    digits = colour[1:] if len(colour) == 7 else "".join(2 * it for it in colour[1:])
    shares = [int(digits[at : at + 2], 16) / 255 for at in (0, 2, 4)]
    red, green, blue = (it / 12.92 if it <= 0.04045 else ((it + 0.055) / 1.055) ** 2.4 for it in shares)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def _contrast(one, other):
    low, high = sorted((_brightness(one), _brightness(other)))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("scheme", [0, 1], ids=["light", "dark"])
@pytest.mark.parametrize("name", WORDS)
def test_words_can_be_read_on_either_screen(name, scheme):
    """On the page itself and on its shaded parts."""
    colours = _colours(scheme)
    assert min(_contrast(colours[name], colours[back]) for back in ("page", "shade")) >= READABLE


@pytest.mark.parametrize("scheme", [0, 1], ids=["light", "dark"])
def test_what_a_badge_says_can_be_read_on_its_area(scheme):
    """Each answer on the area of its colour."""
    colours = _colours(scheme)
    for name in ("helps", "hurts", "ahead", "same", "unknown"):
        assert _contrast(colours[name], colours[f"{name}-area"]) >= READABLE, name


def test_both_screens_have_the_same_names():
    """A colour that only one of them had would be missing on the other."""
    assert list(_colours(0)) == list(_colours(1))


def test_a_film_has_the_colours_of_the_light_screen():
    """By the names of the style sheet; what stands beside another has a colour of its own."""
    found = light_colours()
    assert found == _colours(0)
    names = ("ruler", "behaviour", "baseline", "proposed", "helps", "hurts", "ahead")
    assert len({found[name] for name in names}) == len(names)
