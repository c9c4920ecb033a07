"""Generators that a process shares: each way of drawing is seen, and put back to the bit."""

import random

import numpy as np
import pytest

from harness.recorder import guard
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


@pytest.fixture(params=[True, False])
def in_memory(request, monkeypatch):
    """Whether the states are read in memory, or asked for."""
    ways = [guard._numpy, guard._python, guard._torch, guard._is_torch_known]
    monkeypatch.setattr(guard, "IN_MEMORY", request.param)
    for way in ways:
        way.cache_clear()
    yield request.param
    for way in ways:
        way.cache_clear()


@pytest.mark.usefixtures("states")
def test_draw_is_seen_and_put_back(subtests, in_memory):
    """To the bit."""
    for case, (whose, draw) in DRAWS.items():
        with subtests.test(case):
            chance, before = Chance(), _now()
            mark = chance.mark()
            assert [isinstance(state, bytes) for _, state in mark[:1]] == [not in_memory]
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


TORCH_DRAWS = {
    "normal": lambda torch: torch.randn(1),
    "kept normal": lambda torch: torch.randn(1),
    "kept normal of double precision": lambda torch: torch.randn(3, dtype=torch.float64),
    "many": lambda torch: torch.rand(5_000),
    "as many as its words": lambda torch: torch.randint(2**31, (624,)),
    "seed": lambda torch: torch.manual_seed(3),
}


@pytest.mark.usefixtures("in_memory")
def test_torch_is_watched_where_it_is_imported(subtests):
    """Its default generator."""
    torch = pytest.importorskip("torch")
    assert guard._is_torch_known() is guard.IN_MEMORY
    with torch.random.fork_rng():
        for case, draw in TORCH_DRAWS.items():
            with subtests.test(case):
                chance = Chance()
                mark, before = chance.mark(), torch.get_rng_state()
                drawn = draw(torch)
                assert chance.moved(mark) == "torch"
                chance.put_back(mark)
                assert chance.moved(mark) == ""
                assert torch.equal(torch.get_rng_state(), before)
                assert case == "seed" or torch.equal(draw(torch), drawn)


def test_place_in_memory_that_is_another_is_not_used(monkeypatch):
    """The mutants: a layout of torch that does not hold what it draws, or not what it keeps."""
    pytest.importorskip("torch")
    for name, size in (("TORCH_SIZE", 1000), ("TORCH_SIZE", 2500)):
        guard._is_torch_known.cache_clear()
        with monkeypatch.context() as patch:
            patch.setattr(guard, name, size)
            assert not guard._is_torch_known()
    guard._is_torch_known.cache_clear()
