"""The page of four engines says what its records hold: parity, rankings, and a budget that tells rewards apart."""

import json
import re
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "results" / "reference" / "engines"
PAGE = (ROOT / "docs" / "studies" / "engines.md").read_text(encoding="utf-8")
RECORD: dict[str, Any] = json.loads((FOLDER / "reach-sac-fast" / "results.json").read_text())
PARITY: dict[str, Any] = json.loads((FOLDER / "parity.json").read_text())
RANKING = RECORD["ranking"]["tasks"][0]
SERVO = ":drive=servo"
PROSE = " ".join(PAGE.split())


def millimetres(metres: float) -> str:
    """As the page writes it."""
    return f"{1e3 * metres:.3f}" if metres < 1e-3 else f"{1e3 * metres:.1f}"


def apart(one: str, other: str) -> list[float]:
    """The largest distance of two simulators' tips in each class of motions, in metres."""
    pair = next(it for it in PARITY["pairs"] if (it["a"], it["b"]) == (one, other))
    return [it["max_tip_error_m"] for it in pair["classes"].values()]


def pairs_of_engines() -> list[tuple[str, str]]:
    """Each two with ideal drives."""
    return [(it["a"], it["b"]) for it in PARITY["pairs"] if SERVO not in it["a"] + it["b"]]


@pytest.mark.parametrize("pair", pairs_of_engines())
def test_page_says_how_far_two_engines_are_apart(pair: tuple[str, str]):
    """In every class of motions, with ideal and with servo drives."""
    one, other = pair
    found = [*apart(one, other), *apart(one + SERVO, other + SERVO)]
    assert f"| `{one}`, `{other}` | {' | '.join(map(millimetres, found))} |" in PAGE


def test_slow_motions_are_within_what_the_page_says():
    """With ideal and with servo drives."""
    slow = [apart(one + drive, other + drive)[0] for one, other in pairs_of_engines() for drive in ("", SERVO)]
    assert max(slow) < 0.2e-3
    assert "all engines are within 0.2 mm" in PROSE


def test_largest_distances_are_told():
    """Of servo drives in fast motions, and after contact."""
    pairs = pairs_of_engines()
    fast = max(apart(one + SERVO, other + SERVO)[2] for one, other in pairs)
    contact = max(apart(one + drive, other + drive)[4] for one, other in pairs for drive in ("", SERVO))
    assert f"up to {millimetres(fast)} mm apart" in PROSE
    assert f"by up to {millimetres(contact)} mm" in PROSE


def test_the_budget_tells_rewards_apart():
    """In no simulator does the baseline reach nearly all targets, or nearly none."""
    success = [place["success"]["baseline"] for place in RANKING["places"]]
    assert 0.3 <= min(success) <= max(success) <= 0.9
    assert f"between {100 * min(success):.1f}% and {100 * max(success):.1f}% of the targets" in PROSE


def test_page_says_which_reward_is_first_by_success():
    """Counted over the simulators."""
    first = [max(place["success"], key=place["success"].get) for place in RANKING["places"]]
    assert (first.count("dense"), first.count("arp")) == (7, 1)
    assert RANKING["places"][first.index("arp")]["simulator"] == "drake:drive=servo"


def test_page_says_by_how_much_dense_is_ahead():
    """The smallest and the largest difference of success, in points."""
    ahead = [100 * (place["success"]["dense"] - place["success"]["baseline"]) for place in RANKING["places"]]
    assert f"by {min(ahead):.1f} to {max(ahead):.1f} points" in PROSE


def test_page_says_how_far_the_orders_agree():
    """Kendall's tau between simulators, with its interval."""
    tau = RANKING["between_simulators"]
    assert f"a mean Kendall tau of {tau['tau']:.3f}" in PROSE
    assert f"interval is {tau['low']:.0f} to {tau['high']:.0f}" in PROSE


def test_page_says_that_no_choice_is_decided():
    """Both ways, for every pair."""
    ways = ("chosen_in_one_used_in_other", "chosen_in_other_used_in_one")
    answers = [pair[way]["answer"] for pair in RANKING["pairs"] for way in ways]
    assert set(answers) == {"not decided"}
    assert f"each of the {len(RANKING['pairs'])} pairs" in PROSE
    assert f"All {len(answers)} answers" in PROSE


def test_eta_n_puts_dense_last_everywhere():
    """Less counts as better."""
    etas = [place["etas"]["eta_N"]["values"] for place in RANKING["places"]]
    assert {max(values, key=values.get) for values in etas} == {"dense"}


@pytest.mark.parametrize(("reward", "part"), [("dense", "eta"), ("dense", "ruler"), ("arp", "ruler")])
def test_page_says_between_what_eta_and_ruler_lie(reward: str, part: str):
    """Over the eight simulators."""
    values = [it["eta_N"][part]["value"] for it in RECORD["combinations"] if it["proposed"] == reward]
    low, high = (f"{value:#.3g}" for value in (min(values), max(values)))
    assert re.search(rf"{re.escape(low)} (to|and) {re.escape(high)}", PROSE)
