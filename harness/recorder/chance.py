"""The generators of random numbers that a whole process shares: NumPy's, Python's and torch's.

What only looks on may draw from them, and the training must not notice. So their state is noted before each step, and
put back if it was moved. NumPy and Python take 40 microseconds to tell their states. Reading the same bytes where they
stand takes less than one; that this gives the same is tried before it is relied on.
"""

import ctypes
import pickle
import random
import struct
import sys
from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np

WORDS = 624
"""The words of a Mersenne Twister; its place among them follows or precedes them."""
GAUSS = struct.Struct("=i4xd")
"""Whether NumPy keeps a second normal number for the next call, and that number."""
PROBE = 0.1234567890123
Mark: TypeAlias = tuple[Any, ...]
Read: TypeAlias = Callable[[], bytes]


class Chance:
    """Notes the states, says whether they were moved, and puts them back."""

    def __init__(self) -> None:
        self._numpy, self._python = _NumPy(), _Python()

    def mark(self) -> Mark:
        """The states."""
        return self._numpy.mark(), self._python.mark(), _torch_states()

    def moved(self, mark: Mark) -> str:
        """The one whose state is not that of `mark`, as messages name it; empty if there is none."""
        if self._numpy.mark() != mark[0]:
            return "numpy.random"
        if self._python.mark() != mark[1]:
            return "random"
        if mark[2] and _torch_states()[: len(mark[2])] != mark[2]:
            return "torch"
        return ""

    def put_back(self, mark: Mark) -> None:
        """Make the states those of `mark`."""
        self._numpy.put_back(mark[0])
        self._python.put_back(mark[1])
        for generator, state in zip(_torch_generators(), mark[2], strict=False):
            generator.set_state(sys.modules["torch"].frombuffer(bytearray(state), dtype=generator.get_state().dtype))


class _NumPy:
    """The generator behind ``numpy.random.rand`` and the like."""

    def __init__(self) -> None:
        self._shared = np.random.mtrand._rand  # what np.random.seed seeds
        self._bits = self._shared._bit_generator
        self._words, self._gauss = self._ways_to_read()

    def mark(self) -> Any:
        if self._words is None or self._gauss is None or self._shared._bit_generator is not self._bits:
            return pickle.dumps(np.random.get_state(legacy=False))
        return self._words(), self._gauss()

    def put_back(self, mark: Any) -> None:
        if isinstance(mark, bytes):
            np.random.set_state(pickle.loads(mark))
            return
        words, gauss = mark
        *key, place = struct.unpack(f"={WORDS}Ii", words)
        np.random.set_state(("MT19937", np.array(key, np.uint32), place, *GAUSS.unpack(gauss)))

    def _ways_to_read(self) -> tuple[Read | None, Read | None]:
        """How the words and the kept normal number are read; None where that is not known to be right."""
        if sys.implementation.name != "cpython" or not isinstance(self._bits, np.random.MT19937):
            return None, None
        _, key, place, has_gauss, gauss = np.random.get_state()
        words = _reader(self._bits.ctypes.state_address, 4 * WORDS + 4)
        offset = _gauss_offset()
        if words() != np.asarray(key, np.uint32).tobytes() + struct.pack("=i", int(place)) or offset < 0:
            return None, None
        kept = _reader(id(self._shared) + offset, GAUSS.size)
        return (words, kept) if GAUSS.unpack(kept()) == (has_gauss, gauss) else (None, None)


def _gauss_offset() -> int:
    """Where in a ``RandomState`` the kept normal number stands, found in one of our own; -1 if it is not found."""
    probe = np.random.RandomState(0)
    probe.set_state({**probe.get_state(legacy=False), "has_gauss": 1, "gauss": PROBE})
    whole = ctypes.string_at(id(probe), type(probe).__basicsize__)
    at = whole.find(struct.pack("=d", PROBE)) - 8
    return at if at >= 0 and GAUSS.unpack_from(whole, at) == (1, PROBE) else -1


class _Python:
    """The generator behind ``random.random`` and the like."""

    def __init__(self) -> None:
        self._shared: Any = vars(random)["_inst"]
        self._words = self._way_to_read()

    def mark(self) -> Any:
        if self._words is None:
            return random.getstate()
        return self._words(), self._shared.gauss_next

    def put_back(self, mark: Any) -> None:
        if len(mark) == 3:
            random.setstate(mark)
            return
        place, *words = struct.unpack(f"=i{WORDS}I", mark[0])
        random.setstate((3, (*words, place), mark[1]))

    def _way_to_read(self) -> Read | None:
        begin, size = object.__basicsize__, 4 * WORDS + 4
        if sys.implementation.name != "cpython" or type(self._shared).__basicsize__ < begin + size:
            return None
        read = _reader(id(self._shared) + begin, size)
        _, (*words, place), _ = random.getstate()
        return read if read() == struct.pack(f"=i{WORDS}I", place, *words) else None


def _reader(address: int, size: int) -> Read:
    """Reads bytes that stay where they are as long as the process lives."""
    view = memoryview((ctypes.c_ubyte * size).from_address(address)).cast("B")
    return view.tobytes


def _torch_generators() -> list[Any]:
    """The generator of a torch that something has imported, and those of graphics cards that are in use."""
    torch = sys.modules.get("torch")
    own = getattr(torch, "default_generator", None)
    if torch is None or own is None:  # it is being imported
        return []
    return [own, *(torch.cuda.default_generators if torch.cuda.is_initialized() else ())]


def _torch_states() -> list[bytes]:
    return [generator.get_state().numpy().tobytes() for generator in _torch_generators()]
