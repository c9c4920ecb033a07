from io import StringIO

import pytest
from rich.console import Console

from harness.report.tables.two_experiments import between_table
from harness.results.two_experiments import Verdict, between

ALL, NONE = {"arp": lambda seed: (8, 9, 10, 8)}, {"arp": lambda seed: ()}


def printed(found, width=80):
    """As it goes to a pipe."""
    output = StringIO()
    Console(file=output, width=width).print(between_table(found))
    return output.getvalue()


def test_worse_policies_are_a_regression(build):
    """Six seeds that all fail now; the measures that moved are told with their test."""
    found = between(build(seeds=6, reached=ALL), build(seeds=6, reached=NONE))
    (pair,) = found.pairs
    assert (pair.verdict, found.regressions) == (Verdict.WORSE, (pair,))
    assert pair.decisive.corrected <= 0.05
    text = " ".join(printed(found).split())
    assert "arp: success rate is worse: 100.0% -> 0.0%" in text
    assert "6 seeds, corrected p 0.031" in text


def test_too_few_seeds_cannot_tell(build):
    """Five seeds prove nothing, however they fail."""
    found = between(build(seeds=5, reached=ALL), build(seeds=5, reached=NONE))
    assert (found.pairs[0].verdict, found.regressions, found.pairs[0].moved) == (Verdict.CANNOT_TELL, (), ())
    assert "No measure moved by more than chance allows" in printed(found)


def test_what_is_in_one_alone_is_told(build):
    """And nothing is claimed of it."""
    found = between(build(proposed={"arp": (9, 30), "relative": (9, 20)}), build())
    assert [it.proposed for it in found.only_before] == ["relative"]
    assert "only in the first: mujoco · sac · fd100 · fd100-reach · relative" in printed(found)


@pytest.fixture(scope="module")
def several(build):
    """A comparison of two experiments with two rewards each."""
    rewards = {"arp": (9, 30), "scaled:factor=1.5": (9, 30)}
    return between(*(build(seeds=6, proposed=rewards, reached=reached) for reached in (ALL, NONE)))


@pytest.mark.parametrize("width", [60, 80, 120])
def test_nothing_is_cut(several, width):
    """At any width that the terminal has."""
    text = printed(several, width)
    assert "…" not in text
    assert max(map(len, text.splitlines())) <= width
