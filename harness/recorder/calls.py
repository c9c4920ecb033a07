"""The calls that a recorded env gets, and a checksum of each of its answers.

With them the same calls can be given to a new env, `harness.recorder.retake`, and the checksums tell whether it answers
as the recorded one did.
"""

import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from gymnasium import Space
from gymnasium.spaces import Box, Discrete, MultiBinary, MultiDiscrete
from numpy.typing import NDArray

from harness.arrays import Float
from harness.record.recording.facts import MOST_ACTION_NUMBERS, ActionFacts

NO_SEED = -1
NO_RESET = (NO_SEED, 0)
"""Before a step in the middle of an episode."""
LARGEST_EXACT = 2**53
"""A recording holds its numbers as 64-bit floats, which hold every whole number up to this one."""
CHECKED = 16
UNCHECKED = -1
"""In place of a checksum."""
PYTHON_TYPES: Mapping[str, type] = {"python int": int, "python float": float, "python bool": bool}
TYPES = {"python int": np.dtype(np.int64), "python float": np.dtype(np.float64), "python bool": np.dtype(np.bool_)}
"""How NumPy holds them."""


def action_facts(space: Space[Any]) -> ActionFacts | None:
    """How actions of a space are recorded; None if they are not: they are no numbers, or too many."""
    if not isinstance(space, Box | Discrete | MultiBinary | MultiDiscrete):
        return None
    facts = ActionFacts(tuple(int(length) for length in space.shape or ()))
    return facts if 0 < facts.size <= MOST_ACTION_NUMBERS else None


class Calls:
    """Notes the calls of one env or of a batch, and makes rows of numbers of them, many at once.

    From where the same calls cannot be given to another env, `ActionFacts.problem`, only zeros are noted.

    Attributes:
        facts: What is known of the actions so far.
    """

    def __init__(self, facts: ActionFacts, num_envs: int, tell: Callable[[ActionFacts], None]) -> None:
        """Nothing is noted yet.

        Args:
            facts: What is known of the actions.
            num_envs: How many envs there are.
            tell: Called when more is known of the actions.
        """
        self._tell = tell
        self._begun: list[tuple[int, int] | None] = [None] * num_envs
        self._was_seeded = [False] * num_envs
        self._marks: list[tuple[int, int, int, int]] = []
        self._know(facts)

    def note_reset(self, env: int, seed: object, options: object) -> None:
        """Note that an env was reset: with a seed, or to go on with what its generator draws next."""
        if options is not None:
            self._note_problem("its env was reset with options")
        if seed is None:
            seeded, resets = self._begun[env] or NO_RESET
            self._begun[env] = seeded, resets + 1
        elif isinstance(seed, int | np.integer) and 0 <= seed <= LARGEST_EXACT:
            self._begun[env], self._was_seeded[env] = (int(seed), 0), True
        else:
            self._note_problem(f"its env was reset with the seed {seed!r}")

    def mark(self, env: int, row: int, observation: Any) -> None:
        """Sum up an answer, and note what was reset before it.

        It is done in some steps only, since an env that has answered otherwise once hardly ever comes back: in every
        `CHECKED`-th step of an episode, the first one among them, and in the last one.

        Args:
            env: Whose step it was.
            row: How many steps came before it since `take`.
            observation: The answer.
        """
        begun, self._begun[env] = self._begun[env], None
        if begun is not None and not self._was_seeded[env]:
            self._note_problem("its env was not reset with a seed")
        if not self.facts.problem:
            self._marks.append((row, *(begun or NO_RESET), checksum(observation)))

    def take(self, actions: Any) -> Float:
        """The numbers of steps, (steps, 3 + action_size): of all that came since this was last asked.

        In a row stand the seed and the number of resets before the step, the answer's checksum, and the action.

        Args:
            actions: As they were given, at least one: a list, or an array of them.
        """
        rows = np.zeros((len(actions), 3 + self.facts.size))
        rows[:, :3] = *NO_RESET, UNCHECKED
        for row, *told in self._marks:
            rows[row, :3] = told
        self._marks = []
        is_one = isinstance(actions, np.ndarray) or (len({*map(type, actions)}) == 1 and not np.shape(actions[0]))
        good = sum(map(self._is_known, actions[:1])) * len(actions) if is_one else sum(map(self._is_known, actions))
        kind = TYPES.get(self.facts.type) or np.dtype(self.facts.type or float)
        numbers = np.asarray(actions[:good], kind).reshape(good, self.facts.size)
        if kind.kind in "iu" and (large := (np.abs(numbers) > LARGEST_EXACT).any(1)).any():
            self._note_problem(f"an action is beyond {LARGEST_EXACT:,}")
            good = int(large.argmax())
        rows[:good, 3:] = numbers[:good]
        return rows

    def _is_known(self, action: Any) -> bool:
        """Whether an action is of the type and shape of those before it; once one is not, no other is."""
        if self.facts.problem:
            return False
        told = type_of_action(action)
        if not told:
            self._note_problem(f"an action was given as a {type(action).__qualname__}")
        elif not self.facts.type:
            self._know(replace(self.facts, type=told))
        elif told != self.facts.type:
            self._note_problem(f"actions were given as {self.facts.type} and as {told}")
        if np.shape(action) != self.facts.shape:
            self._note_problem(f"an action has the shape {np.shape(action)}, not {self.facts.shape}")
        return not self.facts.problem

    def _note_problem(self, problem: str) -> None:
        """The first one stays."""
        if not self.facts.problem:
            self._know(replace(self.facts, problem=problem))

    def _know(self, facts: ActionFacts) -> None:
        self.facts = facts
        self._tell(facts)


def type_of_action(action: Any) -> str:
    """The type as `ActionFacts` names it; empty if actions of that type are not recorded."""
    if isinstance(action, np.ndarray | np.generic):
        kind = action.dtype
        return kind.name if kind.kind in "biuf" and kind.itemsize <= 8 else ""
    return next((name for name, python in PYTHON_TYPES.items() if type(action) is python), "")


def action_of(numbers: NDArray[np.float64], facts: ActionFacts) -> Any:
    """The action that numbers of its shape tell of, in the type in which it was given."""
    if facts.type in PYTHON_TYPES:
        return PYTHON_TYPES[facts.type](np.asarray(numbers).item())
    array = np.reshape(numbers, facts.shape).astype(facts.type)
    return array if facts.shape else array[()]


def checksum(observation: Any, begun: int = 0) -> int:
    """CRC-32 of an observation: of an array, a number or a text, and of such in dicts, lists and tuples."""
    if isinstance(observation, Mapping):
        for key, inner in observation.items():
            begun = checksum(inner, zlib.crc32(str(key).encode(), begun))
        return begun
    if isinstance(observation, Sequence) and not isinstance(observation, str | bytes):
        for inner in observation:
            begun = checksum(inner, begun)
        return begun
    if isinstance(observation, str):
        return zlib.crc32(observation.encode(), begun)
    array = np.asarray(observation)
    return begun if array.dtype.hasobject else zlib.crc32(array.tobytes(), begun)
