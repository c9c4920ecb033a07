"""What a parity says by class of motions."""

import pytest

from harness_plugins.parity.page import class_grid, classes_text, explanations, reference_pairs, response_grid


@pytest.fixture(scope="module")
def found(compare, toolbox):
    """One that is right, one whose tip is a millimetre off, one that is a period late."""
    return compare(right=toolbox.ideal, off=toolbox.shifted_tip(1e-3), late=toolbox.late)


def test_every_class_is_a_row(found):
    """Of each pair with the reference; the others have both names."""
    rows = class_grid(found, reference_pairs(found)).rows
    classes = ("slow", "smooth", "fast", "singular", "contact")
    assert [row[0] for row in rows] == [f"{name}: {kind}" for name in ("off", "late") for kind in classes]
    assert rows[0][1:3] == ("1", "1")
    assert class_grid(found, [found.pairs[2]]).rows[0][0] == "late against off: slow"
    assert class_grid(found, []).rows == []


def test_what_explains_a_difference_is_told(found):
    """Who is off, who is late and by how much, and where; who is too slow."""
    lines = {line.partition(":")[0]: line for line in explanations(found, reference_pairs(found))}
    assert "off is up to 1 mm from where it is told to be, right 0 mm" in lines["off, slow"]
    assert "late is 100 ms behind right, which explains 100%" in lines["late, slow"]
    assert "s into a motion, where joint" in lines["late, fast"]
    assert "late is slower than told in" in lines["late, fast"]
    assert "after the first contact" in lines["late, contact"]


def test_small_differences_need_no_explanation(compare, toolbox):
    """A hundredth of a millimetre."""
    parity = compare(right=toolbox.ideal, off=toolbox.shifted_tip(1e-5))
    assert explanations(parity, list(parity.pairs)) == []


def test_each_simulator_says_how_it_follows(found):
    """A row for each class."""
    rows = {row[0]: row[1:] for row in response_grid(found).rows}
    assert rows["right: fast"] == ("0", "100%", "100%", "0.0%", "0")
    assert float(rows["late: smooth"][4]) == pytest.approx(100.0, rel=0.1)
    assert len(rows) == 15


def test_classes_are_told_in_words(found):
    """Each with what it is."""
    text = classes_text(found)
    assert text.startswith("slow: up to 20% of the speed and 10% of the acceleration; smooth: up to 80% and 60%")
    assert "smallest singular value" in text
