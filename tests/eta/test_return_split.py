import numpy as np
import pytest
from hypothesis import assume, given, strategies as st

from harness.eta import BB, BK, KB, KK, Names, return_sentence, split_returns, swaps_of

AMOUNTS = st.floats(0.01, 100.0)
RETURNS = st.integers(1, 8).flatmap(
    lambda seeds: st.fixed_dictionaries(
        {pair: st.lists(AMOUNTS, min_size=seeds, max_size=seeds) for pair in (BB, KK, BK, KB)}
    )
)
OTHER = {BB: KK, KK: BB, BK: KB, KB: BK}
"""What a pair is where the other reward is called the baseline."""


def split(returns):
    """With all ways of swapping."""
    seeds = range(len(returns[BB]))
    return split_returns(returns, seeds, swaps_of(seeds))


@given(RETURNS)
def test_parts_make_up_the_whole(returns):
    """Their product is eta, and ruler + behaviour is the difference."""
    found = split(returns)
    ratio, total = found.ratio, found.total
    assert ratio.ruler.value * ratio.behaviour.value == pytest.approx(ratio.eta.value)
    assert total.ruler.value + total.behaviour.value == pytest.approx(total.change.value)
    assert ratio.eta.value == pytest.approx(np.mean(returns[KK]) / np.mean(returns[BB]))


@given(RETURNS)
def test_nothing_depends_on_which_reward_is_called_the_baseline(returns):
    """Ratios become their inverses, differences their opposites, and p stays."""
    there, back = split(returns), split({OTHER[pair]: values for pair, values in returns.items()})
    assert back.ratio.ruler.value == pytest.approx(1.0 / there.ratio.ruler.value)
    assert back.total.behaviour.value == pytest.approx(-there.total.behaviour.value)
    assert back.ratio.p == there.ratio.p


@given(RETURNS, st.floats(0.1, 10.0))
def test_another_unit_of_a_reward_is_all_ruler(returns, factor):
    """The proposed reward in other units: the behaviour stays as it was."""
    scaled = {
        pair: [value * (factor if pair[0] == "proposed" else 1.0) for value in it] for pair, it in returns.items()
    }
    one, other = split(returns).ratio, split(scaled).ratio
    assert other.behaviour.value == pytest.approx(one.behaviour.value)
    assert other.ruler.value == pytest.approx(factor * one.ruler.value)


@given(RETURNS, st.sampled_from([BB, KK, BK, KB]))
def test_a_return_that_is_not_above_0_has_no_ratio(returns, pair):
    """The reason names it; the difference is there, and so is p."""
    found = split({**returns, pair: [-value for value in returns[pair]]})
    assert {part.value for part in (found.ratio.eta, found.ratio.ruler, found.ratio.noise)} == {None}
    assert "is not above 0" in found.ratio.eta.note
    assert found.total.ruler.value is not None
    assert (found.ratio.p is None) == (len(returns[BB]) == 1)


def test_a_seed_without_which_a_return_is_negative_takes_the_interval():
    """Two negative means would have a ratio that looks like any other."""
    eta = split({pair: [9.0, -1.0, -1.0] for pair in (BB, KK, BK, KB)}).ratio.eta
    assert (eta.value, eta.low) == (1.0, None)
    assert "without one of the seeds" in eta.note


def test_without_the_other_rewards_nothing_is_split():
    """The reason stands where the parts would be."""
    found = split_returns({BB: [1.0, 2.0], KK: [2.0, 4.0]}, (0, 1), swaps_of((0, 1)), "B was given up")
    assert not found.is_split
    assert (found.ratio.eta.value, found.ratio.ruler.note) == (2.0, "B was given up")
    assert found.total.change.value == 1.5
    assert found.total.behaviour.note == "B was given up"


@given(RETURNS)
def test_noise_of_a_mean_lies_around_1(returns):
    """From four seeds on."""
    noise = split(returns).ratio.noise
    assume(noise.value is not None)
    assert noise.low <= 1.0 <= noise.high


@pytest.mark.parametrize(
    ("proposed", "told"),
    [
        (
            4.0,
            "An episode is paid 4.00 with K and 1.00 with B: 4.00 times as much. Rescaling alone (the ruler): x 2.00.",
        ),
        (
            -4.0,
            "An episode is paid -4.00 with K and 1.00 with B: a change of -5.00. Rescaling alone (the ruler): -2.50.",
        ),
    ],
)
def test_the_number_in_words(proposed, told):
    """A ratio where it is one, else a difference."""
    returns = {BB: [1.0], BK: [2.0], KB: [2.0], KK: [proposed]}
    assert return_sentence(Names("B", "K"), split(returns)).startswith(told)
