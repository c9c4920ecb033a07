"""The one place that calls a stranger's function of a step.

What it is given it cannot spoil, what it draws from a generator that everybody shares the training does not notice, and
where it does not return, it is ended.
"""

import ctypes
import math
import pickle
import random
import struct
import sys
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from harness.errors import HarnessError, one_line, reason_of
from harness.recorder.limit import LONGEST_TRIAL, call, look_on
from harness.recorder.sealed import Sealer, writable
from harness.reward.given import STEP_PARTS, Untold

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


Function: TypeAlias = Callable[..., Any]
Asking: TypeAlias = tuple[Any, ...]
"""The arguments of a call, sealed: see `harness.reward.given.arguments`; or what a ``reset`` takes."""


@dataclass(frozen=True)
class Raised:
    """In place of an answer.

    Attributes:
        error: What the function raised.
    """

    error: BaseException


class Guard:
    """Asks functions about steps.

    Attributes:
        drew: Of the functions that were asked last, by their place: which generator they drew from.
        longest: What each may compute for one step, [s].
    """

    def __init__(self) -> None:
        look_on()
        self._sealer, self._chance, self.longest = Sealer(), Chance(), LONGEST_TRIAL
        self.seal = self._sealer.seal
        """Makes what functions are given: a copy that nobody can write into."""
        self.drew: dict[int, str] = {}

    def ask(
        self,
        functions: Sequence[Function],
        steps: Iterable[Asking],
        pays: Collection[int] = (),
        is_watched: bool = True,
    ) -> list[Any]:
        """What each function says of its step, or `Raised`.

        Args:
            functions: They are asked in this order, and do not notice one another.
            steps: One for each, sealed by `seal`.
            pays: Places of those that pay the learner: what they draw is part of the training, and nobody ends them.
            is_watched: Whether one of them might draw, or not return: unless all of them only compute, see
                `harness.recorder.computing.only_computes`.
        """
        if not is_watched and not self._sealer.is_open:
            self.drew = {}
            return _answers(functions, steps)
        answers, drew = list[Any](), dict[int, str]()
        # A tensor that shares its memory with an array writes into it, read-only or not.
        own = self._sealer.own if self._sealer.is_open or "torch" in sys.modules else None
        self.drew = drew
        mark = self._chance.mark()
        for place, (function, step) in enumerate(zip(functions, steps, strict=False)):
            given = step if own is None else own(step)
            try:
                answers.append(function(*given) if place in pays else call(function, given, self.longest))
            except (Exception, SystemExit) as error:  # whatever functions of users raise
                answers.append(Raised(error))
            if moved := self._chance.moved(mark):
                drew[place] = moved
                if place in pays:
                    mark = self._chance.mark()
                else:
                    self._chance.put_back(mark)
        return answers

    def answer(self, function: Function, step: Asking, is_watched: bool = True) -> Any:
        """What one function says of a step.

        Raises:
            Exception: Whatever it raises; TimeoutError if it does not return.
        """
        (found,) = self.ask([function], [step], is_watched=is_watched)
        if isinstance(found, Raised):
            raise found.error if isinstance(found.error, Exception) else RuntimeError(one_line(found.error))
        return found

    def reason(self, function: Function, step: Asking, error: BaseException) -> str:
        """Why it failed, in one line. If it writes into what it is given, that is the reason.

        Args:
            function: It is asked once more, with copies that it may write into.
            step: As it was given.
            error: What it raised.
        """
        if isinstance(error, Untold):
            return str(error)
        if isinstance(error, HarnessError) or not isinstance(error, TypeError | ValueError | AttributeError):
            return reason_of(error)
        given = tuple(map(writable, step))
        self.ask([lambda *_: function(*given)], [step])
        names, *both = _NAMES[len(step)], *map(_parts, (step, given))
        for name, before, after in zip(names, *both, strict=True):
            if not same(before, after):
                instead = (
                    f"change a copy, `dict({name})`"
                    if name.endswith("info")
                    else f"write `{name} / 2` for `{name} /= 2`"
                )
                return f"it writes into its {name}, which others read too: {instead} ({one_line(error)})"
        return one_line(error)


_NAMES = {4: ("observation", "action", "next_observation", "info"), 1: STEP_PARTS}
"""What the parts of a step are called, by the number of arguments that a function takes."""


def _parts(step: Asking) -> tuple[Any, ...]:
    if len(step) == 1:
        (now,) = step
        return *now[:-1], *now.before
    return step


def _answers(functions: Sequence[Function], steps: Iterable[Asking]) -> list[Any]:
    answers = list[Any]()
    for function, step in zip(functions, steps, strict=False):
        try:
            answers.append(function(*step))
        except (Exception, SystemExit) as error:  # whatever functions of users raise
            answers.append(Raised(error))
    return answers


def same(one: Any, other: Any) -> bool:
    """Whether two values are equal at any depth; NaN is equal to NaN. What cannot be compared counts as equal."""
    try:
        if isinstance(one, dict):
            return one.keys() == other.keys() and all(same(one[k], other[k]) for k in one)
        if isinstance(one, list | tuple):
            return len(one) == len(other) and all(map(same, one, other))
        if isinstance(one, np.ndarray):
            return np.array_equal(one, other, equal_nan=one.dtype.kind in "fc")
        is_plain = getattr(type(one), "__eq__", None) is object.__eq__  # it is equal to nothing else
        if is_plain and hasattr(one, "__dict__"):
            return type(one) is type(other) and same(vars(one), vars(other))
        equal = pickle.dumps(one) == pickle.dumps(other) if is_plain else bool(one == other)
        return equal or (isinstance(one, float) and math.isnan(one) and math.isnan(other))
    except Exception:  # whatever objects of users raise
        return True
