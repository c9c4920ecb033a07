import math
import statistics

import numpy as np
import pytest

from harness.record.blocks import Blocks, read_blocks

RNG = np.random.default_rng(7)


def episodes_of(count):
    """Steps and numbers of some episodes: pay, success, one term."""
    return np.arange(1, count + 1) * 50, RNG.normal(1e3, 3.0, (count, 3))


def told_by(count, at_once):
    """The blocks of episodes that are told so many at once, with what was told."""
    steps, numbers = episodes_of(count)
    blocks = Blocks.none(["effort"])
    for begin in range(0, count, at_once):
        blocks = blocks.followed_by(steps[begin : begin + at_once], numbers[begin : begin + at_once])
    return blocks, steps, numbers


@pytest.mark.parametrize("at_once", [1, 7, 10_000])
@pytest.mark.parametrize("count", [1, 63, 64, 65, 129, 1_000])
def test_blocks_are_the_episodes_one_after_the_other(count, at_once):
    """By hand: means and standard deviations of equally many, however they were told."""
    blocks, steps, numbers = told_by(count, at_once)
    size = next(2**k for k in range(20) if count <= 2**k * 64)
    assert len(blocks.listed) == math.ceil(count / size)
    for index, block in enumerate(blocks.listed):
        part = slice(index * size, (index + 1) * size)
        pay = numbers[part, 0].tolist()
        assert (block.episodes, block.steps) == (len(pay), steps[part][-1])
        assert block.pay == pytest.approx(statistics.fmean(pay))
        spread = statistics.stdev(pay) if len(pay) > 1 else math.nan
        assert block.pay_spread == pytest.approx(spread, nan_ok=True)
        assert block.behaviour == pytest.approx(numbers[part, 1].mean())


def test_behaviour_that_nobody_measures_is_nan():
    """And the pay is known all the same."""
    blocks = Blocks.none().followed_by(np.array([10, 20]), np.array([[1.0, math.nan], [3.0, math.nan]]))
    assert blocks.listed[0].pay == 1.0
    assert math.isnan(blocks.listed[1].behaviour)


def test_what_was_told_is_read(tmp_path):
    """To the last bit, NaN too."""
    blocks, _, _ = told_by(200, 200)
    blocks.means[0, 1] = math.nan
    blocks.write(tmp_path)
    found = read_blocks(tmp_path)
    assert found.terms == ("effort",)
    np.testing.assert_array_equal(found.means, blocks.means)
    np.testing.assert_array_equal(found.squares, blocks.squares)
    np.testing.assert_array_equal(found.steps, blocks.steps)


@pytest.mark.parametrize(
    "text",
    ["", "[]", *('{"terms": [], "steps": [1], ' + rest for rest in (
        '"episodes": [1], "means": [], "squares": []}', '"episodes": [0], "means": [[1, 1]], "squares": [[1, 1]]}',
        '"episodes": [1], "means": [[1]], "squares": [[1]]}', '"episodes": [], "means": [[1, 1]], "squares": [[1, 1]]}',
    ))],
)  # fmt: skip
def test_a_damaged_file_tells_nothing(tmp_path, text):
    """A run that goes on after a kill, and who looks, are not stopped by it."""
    (tmp_path / "blocks.json").write_text(text)
    assert read_blocks(tmp_path) is None
    assert read_blocks(tmp_path / "nowhere") is None


def test_a_training_that_goes_on_keeps_what_had_ended():
    """And takes no episode twice."""
    blocks, steps, numbers = told_by(100, 100)
    kept = blocks.until(3_000)
    assert kept.episodes.sum() == 60
    whole = kept.followed_by(steps[60:], numbers[60:])
    np.testing.assert_allclose(whole.means, blocks.means)
