"""Numbers, signs and symbols as print has them."""

import pytest
from hypothesis import given, strategies as st

from harness.report import typeset
from harness.report.page.page import to_html


def test_a_sign_is_set(subtests):
    """What a keyboard lacks."""
    for plain, printed in [
        ("ruler x behaviour", "ruler × behaviour"),
        ("-78.9 [-80, -.5]", "−78.9 [−80, −.5]"),
        ("99 -> 100 %", "99 → 100\u202f%"),
        ("95% intervals", "95\u202f% intervals"),
        ("0.37 s instead of 0.86 s", "0.37\u202fs instead of 0.86\u202fs"),
        ("p <= 0.05", "p ≤ 0.05"),
        ("1e-4, 1e5 and -3.2e-05", "10⁻⁴, 10⁵ and −3.2 × 10⁻⁵"),
        ("9.81 m/s^2, rad^-1", "9.81\u202fm/s², rad⁻¹"),
    ]:
        with subtests.test(plain=plain):
            assert typeset(plain) == printed


def test_what_people_type_stays(subtests):
    """The mutants: labels, dates, ranges and words that look like signs or units."""
    for text in [
        "arp:k2=-2",
        "sac:lr=3e-4",
        "x [m]",
        "two-sided",
        "2026-11-24",
        "0-9",
        "3 steps",
        "10 seeds",
        "1e-4x",
        "-",
    ]:
        with subtests.test(text=text):
            assert typeset(text) == text


@pytest.mark.parametrize(
    ("text", "html"),
    [
        ("eta_N = ruler x 2", "η<sub>N</sub> = ruler × 2"),
        ("I_P", "I<sub>P</sub>"),
        ("x 1.50", "× 1.50"),
        ("x [m]", "x [m]"),
        ("the mean: eta", "the mean: η"),
        ("beta, my_eta_N and eta:k=2", "beta, my_eta_N and eta:k=2"),
        ("", ""),
        ("eta_P of <b>", "η<sub>P</sub> of &lt;b&gt;"),
    ],
)
def test_a_symbol_has_its_subscript(text, html):
    """A word that only contains one stays, and a label cannot become a tag."""
    assert to_html(text) == html


@given(st.text(alphabet="x-><=e^0159.% msN_IPetaη[](", max_size=30))
def test_setting_again_changes_nothing(text):
    """A text may pass through twice."""
    assert typeset(typeset(text)) == typeset(text)
