"""How the kit tells memory that grows from caches that fill and empty."""

import gc

import pytest

from harness_plugins.kit.memory import PLAYS, require_nothing_kept

STEPS = 100
KEPT = []


@pytest.fixture(autouse=True)
def _forget():
    KEPT.clear()
    yield
    KEPT.clear()


def test_what_keeps_something_in_every_play_is_told():
    """With its size."""
    with pytest.raises(AssertionError, match=r"bytes were kept of 100 steps, .* memory grows without bound"):
        require_nothing_kept(lambda: KEPT.extend(bytes(200) for _ in range(STEPS)), STEPS, "steps")


@pytest.mark.parametrize("sizes", [(0, 50_000, 50_000, 0), (1_000_000, 0)])
def test_cache_that_fills_is_allowed(sizes):
    """Now and then, as those of libraries, with nothing added in the next play; or by the first play."""
    left = iter(sizes)
    require_nothing_kept(lambda: KEPT.append(bytes(next(left))), STEPS, "steps")


def test_it_is_played_no_more_than_it_takes():
    """Twice if nothing is kept, else until the end."""
    calls = []
    require_nothing_kept(lambda: calls.append(0), STEPS, "steps")
    assert len(calls) == 2
    assert gc.get_freeze_count() == 0
    with pytest.raises(AssertionError):
        require_nothing_kept(lambda: calls.append(KEPT.append(bytes(10_000)) or 0), STEPS, "steps")
    assert len(calls) == 2 + 1 + PLAYS
