"""The one place that calls a stranger's function of a step.

What it is given it cannot spoil, what it draws from a generator that everybody shares the training does not notice, and
where it does not return, it is ended.
"""

import ctypes
import pickle
import random
import struct
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, TypeAlias

import numpy as np

from harness.errors import HarnessError, one_line, reason_of
from harness.recorder.limit import LONGEST_TRIAL, call, look_on
from harness.recorder.sealed import Sealer, writable
from harness.reward.given import STEP_PARTS, Untold

WORDS = struct.Struct("=625I")
"""A Mersenne Twister: its words, and its place among them, which follows or precedes them."""
GAUSS = struct.Struct("=i4xd")
"""Whether NumPy keeps a second normal number for the next call, and that number."""
PROBE = 0.1234567890123
TORCH_AT, TORCH_SIZE = 80, 2544
"""Where PyTorch's generator for the processor holds its words and what it keeps for the next call, [bytes]."""
IN_MEMORY = sys.implementation.name == "cpython"


@dataclass(frozen=True)
class _Generator:
    """One that a process shares.

    Attributes:
        name: As messages call it.
        get: Its state.
        put: Makes a state its own.
    """

    name: str
    get: Callable[[], Any]
    put: Callable[[Any], object]


Mark: TypeAlias = list[tuple[_Generator, Any]]


class Chance:
    """Notes the states of what a process draws from, says whether they were moved, and puts them back."""

    def mark(self) -> Mark:
        """The states."""
        found = [_numpy(np.random.mtrand._rand._bit_generator), _python(), *map(_torch, _torch_generators())]
        return [(generator, generator.get()) for generator in found]

    def moved(self, mark: Mark) -> str:
        """The one whose state is not that of `mark`, as messages name it; empty if there is none."""
        for generator, state in mark:
            if generator.get() != state:
                return generator.name
        return ""

    def put_back(self, mark: Mark) -> None:
        """Make the states those of `mark`."""
        for generator, state in mark:
            generator.put(state)


def _in_memory(at: int, size: int) -> memoryview:
    """What stands at an address, to be read and written in a fraction of the time."""
    return memoryview((ctypes.c_ubyte * size).from_address(at)).cast("B")


def _write(*parts: tuple[memoryview, bytes]) -> None:
    for view, kept in parts:
        view[:] = kept


@cache
def _numpy(bits: Any) -> _Generator:
    """The generator behind ``numpy.random.rand`` and the like, which draws from `bits`."""
    if IN_MEMORY and isinstance(bits, np.random.MT19937) and (at := _gauss_offset()) >= 0:
        words = _in_memory(bits.ctypes.state_address, WORDS.size)
        gauss = _in_memory(id(np.random.mtrand._rand) + at, GAUSS.size)  # of what np.random.seed seeds
        _, key, *rest = np.random.get_state()
        if [*WORDS.unpack(words), *GAUSS.unpack(gauss)] == [*key, *rest]:
            return _Generator(
                "numpy.random",
                lambda: (words.tobytes(), gauss.tobytes()),
                lambda state: _write((words, state[0]), (gauss, state[1])),
            )
    return _Generator(
        "numpy.random",
        lambda: pickle.dumps(np.random.get_state(legacy=False)),
        lambda state: np.random.set_state(pickle.loads(state)),
    )


@cache
def _gauss_offset() -> int:
    """Where in a ``RandomState`` the kept normal number stands, found in one of our own; -1 if it is not found."""
    probe = np.random.RandomState(0)
    probe.set_state({**probe.get_state(legacy=False), "has_gauss": 1, "gauss": PROBE})
    whole = ctypes.string_at(id(probe), type(probe).__basicsize__)
    at = whole.find(struct.pack("=d", PROBE)) - 8
    return at if at >= 0 and GAUSS.unpack_from(whole, at) == (1, PROBE) else -1


@cache
def _python() -> _Generator:
    """The generator behind ``random.random`` and the like."""
    shared: Any = vars(random)["_inst"]
    begin = object.__basicsize__
    if IN_MEMORY and type(shared).__basicsize__ >= begin + WORDS.size:
        words = _in_memory(id(shared) + begin, WORDS.size)
        _, (*key, place), _ = random.getstate()
        if WORDS.unpack(words) == (place, *key):

            def put(state: Any) -> None:
                words[:], shared.gauss_next = state

            return _Generator("random", lambda: (words.tobytes(), shared.gauss_next), put)
    return _Generator("random", random.getstate, random.setstate)


def _torch_generators() -> list[Any]:
    """The generator of a torch that something has imported, and those of graphics cards that are in use."""
    torch = sys.modules.get("torch")
    own = getattr(torch, "default_generator", None)
    if torch is None or own is None:  # it is being imported
        return []
    return [own, *(torch.cuda.default_generators if torch.cuda.is_initialized() else ())]


@cache
def _torch(generator: Any) -> _Generator:
    if generator.device.type == "cpu" and _is_torch_known():
        words = _in_memory(generator._cdata + TORCH_AT, TORCH_SIZE)
        return _Generator("torch", words.tobytes, lambda state: _write((words, state)))
    torch = sys.modules["torch"]
    return _Generator(
        "torch",
        lambda: generator.get_state().numpy().tobytes(),
        lambda state: generator.set_state(torch.frombuffer(bytearray(state), dtype=torch.uint8)),
    )


@cache
def _is_torch_known() -> bool:
    """Whether one of our own shows in memory what it draws, also what it had kept, and can be put back there."""
    torch = sys.modules["torch"]
    probe = torch.Generator()
    if not IN_MEMORY or not hasattr(probe, "_cdata"):
        return False
    words, before = _in_memory(probe._cdata + TORCH_AT, TORCH_SIZE), probe.get_state()
    seen = [words.tobytes()]
    for _ in range(2):
        torch.randn(1, generator=probe)
        seen.append(words.tobytes())
    words[:] = seen[0]
    return len({*seen}) == len(seen) and torch.equal(probe.get_state(), before)


Function: TypeAlias = Callable[..., Any]
FAILURES = (Exception, SystemExit)  # whatever functions of users raise
Asking: TypeAlias = tuple[Any, ...]
"""The arguments of a call, sealed: see `harness.reward.given.arguments`; or what a ``reset`` takes."""


@dataclass(frozen=True)
class Raised:
    """In place of an answer.

    Attributes:
        error: What the function raised.
    """

    error: BaseException


def said(answer: Any) -> Any:
    """An answer of `Guard.ask`.

    Raises:
        Exception: What the function raised in its place.
    """
    if isinstance(answer, Raised):
        raise answer.error if isinstance(answer.error, Exception) else RuntimeError(one_line(answer.error))
    return answer


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

    @property
    def is_open(self) -> bool:
        """Whether functions were given something that they can write into, so that each needs copies of its own."""
        return self._sealer.is_open

    def ask(
        self, functions: Sequence[Function], steps: Sequence[Asking], pays: bool = False, is_watched: bool = True
    ) -> list[Any]:
        """What each function says of its step, or `Raised`.

        Args:
            functions: They are asked in this order, and do not notice one another.
            steps: One for each, sealed by `seal`.
            pays: Whether they pay the learner: what they draw is part of the training, and nobody ends them.
            is_watched: Whether one of them might draw: unless all of them only compute, see
                `harness.recorder.computing.only_computes`. These are asked together, and ended if one does not return.
        """
        answers: list[Any] = []
        self.drew = {}
        if not is_watched and not self.is_open:
            while (done := len(answers)) < len(functions):
                try:
                    self._call(answers.extend, (map(_answer, functions[done:], steps[done:]),), pays)
                except FAILURES as error:
                    if isinstance(error, TimeoutError) and done < len(answers):
                        continue  # it may have been all of them together
                    answers.append(Raised(error))
                    while isinstance(error, TimeoutError) and functions[done] in functions[len(answers) :][:1]:
                        answers.append(answers[-1])
            return answers
        # A tensor that shares its memory with an array writes into it, read-only or not.
        own = self._sealer.own if self.is_open or "torch" in sys.modules else tuple
        mark = self._chance.mark()
        for place, (function, step) in enumerate(zip(functions, steps, strict=True)):
            try:
                answers.append(self._call(function, own(step), pays))
            except FAILURES as error:
                answers.append(Raised(error))
            if moved := self._chance.moved(mark):
                self.drew[place] = moved
                if pays:
                    mark = self._chance.mark()
                else:
                    self._chance.put_back(mark)
        return answers

    def _call(self, function: Function, given: Sequence[Any], pays: bool) -> Any:
        return function(*given) if pays else call(function, given, self.longest)

    def answer(self, function: Function, step: Asking, is_watched: bool = True) -> Any:
        """What one function says of a step.

        Raises:
            Exception: Whatever it raises; TimeoutError if it does not return.
        """
        return said(*self.ask([function], [step], is_watched=is_watched))

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
        given, kept = tuple(map(writable, step)), tuple(map(writable, step))
        self.ask([lambda *_: function(*given)], [step])
        for name, before, after in zip(_NAMES[len(step)], _parts(kept), _parts(given), strict=True):
            if _are_apart(before, after):
                instead = (
                    f"change a copy, `dict({name})`"
                    if name.endswith("info")
                    else f"write `{name} / 2` for `{name} /= 2`"
                )
                return f"it writes into its {name}, which others read too: {instead} ({one_line(error)})"
        return one_line(error)


def _answer(function: Function, step: Asking) -> Any:
    return function(*step)


_NAMES = {4: ("observation", "action", "next_observation", "info"), 1: STEP_PARTS}
"""What the parts of a step are called, by the number of arguments that a function takes."""


def _parts(step: Asking) -> tuple[Any, ...]:
    if len(step) == 1:
        (now,) = step
        return *now[:-1], *now.before
    return step


def _are_apart(one: Any, other: Any) -> bool:
    """Whether two copies of one thing are not the same any more; what cannot be written down counts as the same."""
    try:
        return pickle.dumps(one) != pickle.dumps(other)
    except Exception:  # whatever objects of users raise
        return False
