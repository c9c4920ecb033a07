"""Generators that a process shares: each way of drawing is seen, and put back to the bit."""

import random

import numpy as np
import pytest

from harness.recorder.guard import Chance

DRAWS = {
    "numpy": ("numpy.random", np.random.rand),
    "numpy many": ("numpy.random", lambda: np.random.rand(2_000)),
    "numpy as many as its words": ("numpy.random", lambda: np.random.randint(0, 2**32, 624, dtype=np.uint32)),
    "numpy seed": ("numpy.random", lambda: np.random.seed(3)),
    "numpy kept normal": ("numpy.random", np.random.randn),
    "python": ("random", random.random),
    "python kept normal": ("random", random.gauss),
    "python seed": ("random", lambda: random.seed(3)),
}


@pytest.fixture
def states():
    """NumPy's and Python's states, each with a normal number kept for the next call; afterwards as before."""
    kept = np.random.get_state(), random.getstate()
    np.random.seed(1), random.seed(1)
    np.random.randn(), random.gauss()
    yield
    np.random.set_state(kept[0]), random.setstate(kept[1])


def _now():
    name, key, *rest = np.random.get_state()
    return name, key.tolist(), rest, random.getstate()


@pytest.mark.usefixtures("states")
def test_draw_is_seen_and_put_back(subtests):
    """Where the states are read in memory, and where they are asked for."""
    for is_read in [True, False]:
        for case, (whose, draw) in DRAWS.items():
            with subtests.test(case, is_read=is_read):
                chance, before = Chance(), _now()
                assert chance._numpy._words is not None
                assert chance._python._words is not None
                if not is_read:
                    chance._numpy._words = chance._python._words = None
                mark = chance.mark()
                assert chance.moved(mark) == ""
                draw()
                assert chance.moved(mark) == whose
                chance.put_back(mark)
                assert (chance.moved(mark), _now()) == ("", before)


def test_another_generator_in_its_place_is_seen():
    """NumPy lets a program put one there."""
    own = np.random.get_bit_generator()  # type: ignore[attr-defined]
    chance = Chance()
    try:
        np.random.set_bit_generator(np.random.PCG64(1))  # type: ignore[attr-defined]
        mark = chance.mark()
        first = np.random.rand()
        assert chance.moved(mark) == "numpy.random"
        chance.put_back(mark)
        assert np.random.rand() == first
    finally:
        np.random.set_bit_generator(own)  # type: ignore[attr-defined]


def test_torch_is_watched_where_it_is_imported():
    """Its default generator."""
    torch = pytest.importorskip("torch")
    chance = Chance()
    mark, before = chance.mark(), torch.get_rng_state()
    torch.randn(1)
    assert chance.moved(mark) == "torch"
    chance.put_back(mark)
    assert chance.moved(mark) == ""
    assert torch.equal(torch.get_rng_state(), before)
