"""Steps of one env, or of a batch, as they came, from which rows are made many at once.

A step keeps what cannot be had later: copies that nobody can write into, and what functions say that cannot wait. Made
for many steps together, a row takes a third of the time. `harness.recorder.computing.may_wait` says which functions can
be asked so late, and say the same.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from math import isfinite
from time import monotonic
from typing import Any, NamedTuple

import numpy as np
from gymnasium import Space

from harness.arrays import Float
from harness.errors import SimulationDiverged, reason_of
from harness.recorder.column import Column, are_numbers
from harness.recorder.computing import bound
from harness.recorder.guard import FAILURES, Asking, Raised
from harness.recorder.parts import info_of, items_of, with_items
from harness.recorder.recorder import CHECKED, Calls, Place, Recorder, differs
from harness.recorder.sealed import ReadOnlyDict
from harness.recorder.trial import FIRST_STEPS
from harness.reward.given import Before, Now, Untold, told_under, zeros_of
from harness.reward.reward import is_finite, require_finite
from harness.reward.terms import paid_twice, paid_twice_text

ROWS_AT_ONCE = 256
KEYS = 4
"""Numbers at the beginning of a row that say which step it is: time, env, episode, step."""
NAN = float("nan")
NOTHING = ReadOnlyDict()
NUMBERS = frozenset({float, int, bool, np.float64, np.float32, np.int64, np.int32, np.bool_})


class Seen:
    """Values in their order: arrays of one type and shape as bytes, of which no view can be written into; or sealed."""

    def __init__(self, seal: Callable[[Any], Any]) -> None:
        self._seal, self._kept = seal, list[Any]()
        self._dtype: Any = None
        self._shape: tuple[int, ...] = ()

    def add(self, value: Any) -> None:
        """Keep a copy."""
        is_array = type(value) is np.ndarray
        if is_array and not self._kept and value.size and value.shape and not value.dtype.hasobject:
            self._dtype, self._shape = value.dtype, value.shape
        if is_array and value.dtype is self._dtype and value.shape == self._shape:
            self._kept.append(value.tobytes())
            return
        if self._dtype is not None:
            self._kept, self._dtype = [*self.last(len(self._kept))], None
        self._kept.append(self._seal(value))

    def last(self, count: int) -> Any:
        """The last ones, or all if there are fewer: an array of them, or else a list."""
        kept = self._kept[-count:]
        if self._dtype is None:
            return kept
        return np.frombuffer(b"".join(kept), self._dtype).reshape(len(kept), *self._shape)

    def at(self, place: int) -> Any:
        """The one at a place."""
        value = self._kept[place]
        return value if self._dtype is None else np.frombuffer(value, self._dtype).reshape(self._shape)

    def forget(self) -> None:
        """Keep the last one alone."""
        self._kept = self._kept[-1:]


class Rows(NamedTuple):
    """Steps, and what the env answered: of one env, of the envs of a batch that took one, or of several such."""

    envs: Any
    episodes: Any
    steps: Any
    paid: Any
    terminated: Any
    truncated: Any

    def place(self, row: int) -> Place:
        """The step of a row, for messages."""
        return int(self.envs[row]), int(self.episodes[row]), int(self.steps[row])


class Taken:
    """Steps that have no row yet.

    Attributes:
        time: Of the first of them.
        paid: What the reward that pays the learner said of the last step, (num_envs,); 0 for an env that was reset.
        last: The numbers of the last row, of all columns and then of their terms.
        reads: Whether anything reads what envs tell.
    """

    def __init__(self, recorder: Recorder, num_envs: int, spaces: tuple[Space[Any], Space[Any]] | None = None) -> None:
        """No step is taken yet.

        Args:
            recorder: Writes.
            num_envs: How many envs there are.
            spaces: Of the observations and actions of one env of a batch; None for a single env.
        """
        self._recorder, self._guard, self.columns = recorder, recorder.guard, recorder.columns
        self._num_envs, self._spaces = num_envs, spaces
        self.time, self._due, self.at = recorder.next_time, 0.0, (0, 0, 0)
        self.paid: Any = NAN
        self.last: list[float] = []
        self._are_finite = True  # all numbers of the steps so far
        self._seen, self._actions = Seen(self._guard.seal), Seen(self._guard.seal)
        self._told: list[Any] = []  # beside each observation that was seen what the env told with it
        self._bound: dict[Column, list[Any]] = {}
        self._summed = set[Column]()  # of whose terms is known whether one is the sum of the others
        self._clear()
        recorder.taken = self

    def _clear(self) -> None:
        """Begin anew, and note which functions are asked at once, and which later."""
        self._ticks: list[tuple[Any, ...]] = []
        self._befores: list[int] = []
        self._said: dict[Column, list[Any]] = {}
        self._count = 0
        left = [column for column in self.columns if not column.given_up]
        self._each = self.tried < FIRST_STEPS or self._recorder.is_strict
        is_soon = self._each or self._guard.is_open
        pays = self._recorder.pays
        if pays is not None and pays.is_own and self._spaces is None:
            pays = None  # what one env pays itself is known without asking
        self._at_once = [it for it in left if it is pays or (it.measures and (is_soon or not it.waits))]
        self._later = [it for it in left if it not in self._at_once]
        is_alone = self._spaces is None and self._recorder.trial is None and self._at_once == [pays]
        self._alone = pays if is_alone and pays is not None and pays.measures else None
        self.reads = any(it.reads_info for it in left)
        for column in self._later:
            if column.waits and column not in self._bound:
                self._bound[column] = bound(column.parts)

    @property
    def tried(self) -> int:
        """Steps that were taken since the recording was begun or goes on."""
        return self.time + len(self._ticks) - self._recorder.next_time

    def start(self, observation: Any, told: Mapping[str, Any]) -> None:
        """Keep what there is before the next step, if it is not what came after the last one."""
        self._seen.add(observation)
        self._told.append(self._guard.seal(told) if self.reads else NOTHING)
        self._check_info(told)

    @property
    def told_last(self) -> Mapping[str, Any]:
        """What was told last."""
        return self._told[-1] if self._told else NOTHING

    def begin(self, envs: list[int], episodes: Any, seed: Any = None, options: object = None) -> None:
        """Note that these envs were reset, and start their episodes; without a seed they go on drawing."""
        recorder, calls = self._recorder, self._recorder.calls
        recorder.note_seed(seed)
        for env in envs:
            one = seed[env] if isinstance(seed, Sequence) else None if seed is None else seed + env
            if calls is not None:
                calls.note_reset(env, one, options)
        for column in [it for it in self.columns if it.remembers]:
            mask = np.zeros(self._num_envs, bool)
            mask[envs] = True
            for env in envs[:1] if column.batched else envs:
                given = [mask] if column.batched else []
                if not column.given_up:
                    recorder.restart(column, 0 if given else env, (env, episodes[env], 0), *given)
        if recorder.trial is not None:
            recorder.trial.begin(self.columns)

    def take(self, tick: tuple[Any, ...], action: Any, observation: Any, info: Mapping[str, Any], ended: bool) -> None:
        """Take a step.

        Args:
            tick: The fields of `Rows`: of one env, or (envs that took a step,) each.
            action: As it was given.
            observation: After the step.
            info: What was told of it.
            ended: Whether it ended an episode.
        """
        self._actions.add(action)
        self._befores.append(len(self._told) - 1)
        self._seen.add(observation)
        self._told.append(self._guard.seal(info) if info and self.reads else NOTHING)
        recorder, calls = self._recorder, self._recorder.calls
        if calls is not None and (self._spaces is not None or ended or not tick[2] % CHECKED):
            self._mark(calls, tick, observation)
        self._ticks.append(tick)
        if info:
            self._check_info(info)
        self._count += 1 if self._spaces is None else len(tick[0])
        if self._alone is not None:
            self._ask_alone(self._alone)
        elif self._at_once:
            self.paid = np.zeros(self._num_envs)
            for column, numbers in self._ask(self._at_once, len(self._ticks) - 1).items():
                self._said.setdefault(column, []).extend(numbers)
        if self._count >= ROWS_AT_ONCE or self._each or monotonic() >= self._due:
            self.make()
        if recorder.trial is not None:
            if self.tried == FIRST_STEPS:
                recorder.end_trial(self.at)
            elif ended:
                self.end_episode()

    def _mark(self, calls: Calls, tick: tuple[Any, ...], observation: Any) -> None:
        """Sum up the answers that are checked."""
        if self._spaces is None:
            calls.mark(0, self._count, observation)
            return
        envs, _, steps, _, terminated, truncated = tick
        rows = np.flatnonzero(terminated | truncated | (steps % CHECKED == 0)).tolist()
        items = items_of(self._spaces[0], observation) if rows else []
        for row in rows:
            calls.mark(int(envs[row]), self._count + row, items[envs[row]])

    def end_episode(self) -> None:
        """Ask again about the first one."""
        if self.tried:
            self._recorder.end_episode(self.at)

    def end(self) -> None:
        """Make rows of all, and ask once more about the first steps, which a memory may show late."""
        self.make()
        if self.tried:
            self._recorder.end_all(self.at)

    def _rows(self, first: int) -> Rows:
        """From a tick on."""
        parts = zip(*self._ticks[first:], strict=True)
        return Rows._make(parts if self._spaces is None else map(np.concatenate, parts))

    def _flat(self, parts: Sequence[Any], first: int) -> Any:
        """By row what is given by tick: of a batch for each env, of which only those that took a step have a row."""
        if self._spaces is None:
            return parts
        envs = [tick[0] for tick in self._ticks[first:]]
        if all(isinstance(it, np.ndarray) for it in parts):
            return np.concatenate([it if len(of) == len(it) else it[of] for it, of in zip(parts, envs, strict=True)])
        return [it[env] for it, of in zip(parts, envs, strict=True) for env in of]

    def _by_env(self, space: Space[Any] | None, batches: Sequence[Any], first: int) -> list[Any]:
        """By row what a batch was given, or gave; without a space what it told."""
        envs = range(self._num_envs)
        if space is None:
            split: list[Any] = [[info_of(it, env) for env in envs] if it else [NOTHING] * len(envs) for it in batches]
        else:
            split = [it if isinstance(it, np.ndarray) else items_of(space, it) for it in batches]
        rows = self._flat(split, first)
        if isinstance(rows, np.ndarray):
            rows.setflags(write=False)
        return list(rows)

    def _steps(self, first: int, batched: bool, of_step: bool) -> list[Asking]:
        """What functions are called with about the steps from a tick on."""
        places, ticks = self._befores[first:], self._ticks[first:]
        seen = list(self._seen.last(len(self._told) - places[0]))
        actions = list(self._actions.last(len(ticks) + 1))
        before, after = [seen[it - places[0]] for it in places], [seen[it - places[0] + 1] for it in places]
        parts = [before, actions[-len(ticks) :], after, [self._told[it + 1] for it in places]]
        if of_step:
            acted = [actions[0], *actions][-len(ticks) - 1 : -1]
            parts += [list(map(self._acted, acted, ticks)), [self._told[it] for it in places]]
            ends = self._ends(first, batched)
        if self._spaces is not None and not batched:
            space, acts = self._spaces
            kinds = (space, acts, space, None, acts, None)
            parts = [self._by_env(kind, it, first) for kind, it in zip(kinds, parts, strict=False)]
        if not of_step:
            return list(zip(*parts, strict=True))
        before, actions, after, infos, *acted = parts
        thens = map(Before._make, zip(before, *acted, strict=True))
        return [(Now._make(it),) for it in zip(after, actions, infos, *ends, thens, strict=True)]

    def _ends(self, first: int, batched: bool) -> Any:
        """Whether steps terminated an episode, and truncated it: of a batch the envs that were reset did not."""
        if not batched:
            return [list(map(bool, flags)) for flags in self._rows(first)[4:]]
        made = np.zeros((2, len(self._ticks) - first, self._num_envs), bool)
        for place, tick in enumerate(self._ticks[first:]):
            made[:, place, tick[0]] = tick[4:]
        made.setflags(write=False)
        return made

    def _acted(self, action: Any, tick: tuple[Any, ...]) -> Any:
        """The action before a step: before the first one of an episode zeros."""
        envs, _, steps, *_ = tick
        if self._spaces is None:
            return action if steps else zeros_of(action)
        begun, space = envs[steps == 0].tolist(), self._spaces[1]
        if not begun:
            return action
        zeros = items_of(space, zeros_of(action))
        return self._guard.seal(with_items(space, action, {env: zeros[env] for env in begun}))

    def _ask(self, columns: Sequence[Column], first: int) -> dict[Column, Any]:
        """By column the numbers of the steps from a tick on, (rows, 1 + terms): fewer rows where it failed."""
        recorder, rows, found = self._recorder, self._rows(first), {}
        known: dict[tuple[bool, bool], list[Asking]] = {}
        for column in [it for it in columns if not it.given_up and len(rows.paid)]:
            steps: list[Asking] = []
            if column.is_own:
                values = rows.paid
            elif column.key is not None:
                told = [self._value_of(self._told[it + 1], column.key) for it in self._befores[first:]]
                values = self._flat(told, first)
            else:
                form = column.batched, column.takes_step
                steps = known.get(form) or known.setdefault(form, self._steps(first, *form))
                values = self._answers(column, steps, rows, first)
            numbers = self._numbers(column, values, rows, steps)
            if recorder.trial is not None and steps and not column.given_up and (column.batched or not rows.envs[0]):
                answer: Any = float(numbers[0][0])
                if column.batched:
                    answer = np.full(self._num_envs, NAN)
                    answer[rows.envs] = [it[0] for it in numbers]
                if not recorder.try_again(column, steps[0], answer, rows.place(0)):
                    continue
            found[column] = numbers
            if column is recorder.pays and column in self._at_once:
                self.paid[list(rows.envs)] = [it[0] for it in numbers]
        return found

    def _ask_alone(self, column: Column) -> None:
        """Ask the reward that pays one env about its last step, in a third of the time."""
        before, action, after, told = self._seen.at(-2), self._actions.at(-1), self._seen.at(-1), self._told[-1]
        step: Asking = before, action, after, told
        if column.takes_step:
            acted = self._acted(self._actions.at(-2) if self.tried > 1 else action, self._ticks[-1])
            ends = map(bool, self._ticks[-1][4:])
            step = (Now(after, action, told, *ends, Before(before, acted, self._told[-2])),)
        answer: Any = None
        try:
            if column.is_watched or self._guard.is_open:
                (answer,) = self._guard.ask(column.measures, [step], True)
                for generator in self._guard.drew.values():
                    self._recorder.note_draw(column, generator, self._ticks[-1][:3])
            else:
                answer = column.measures[0](*step)
            numbers = [column.numbers(answer)]
        except FAILURES as error:
            answer = Raised(error) if answer is None else answer
            numbers = self._numbers(column, [answer], self._rows(len(self._ticks) - 1), [step])
        self.paid = numbers[0]
        self._said.setdefault(column, []).extend(numbers)

    def _answers(self, column: Column, steps: list[Asking], rows: Rows, first: int) -> Any:
        """By row what the functions of a column say, or `Raised`."""
        recorder, of = self._recorder, column.measures
        functions = of * len(steps) if len(of) == 1 else [of[env] for env in rows.envs]
        answers = self._guard.ask(functions, steps, column is recorder.pays, column.is_watched)
        for place, generator in self._guard.drew.items():
            recorder.note_draw(column, generator, rows.place(place))
        return self._flat([self._of_batch(column, it) for it in answers], first) if column.batched else answers

    def _of_batch(self, column: Column, answer: Any) -> Any:
        """The same for each env, of what was said of all of them."""
        try:
            if isinstance(answer, Raised):
                raise answer.error
            return column.batch(answer, self._num_envs)
        except FAILURES as error:
            return [Raised(error)] * self._num_envs

    def _value_of(self, told: Mapping[str, Any], key: str) -> Any:
        """What one env, or each of a batch, told under a key of info."""
        if self._spaces is None:
            return _told_by(told, key)
        mask = told.get(f"_{key}")
        values = told.get(key) if mask is None or mask.all() else None
        if isinstance(values, np.ndarray) and values.shape == (self._num_envs,) and values.dtype.kind in "biuf":
            return values
        return [_told_by(info_of(told, env), key) for env in range(self._num_envs)]

    def _numbers(self, column: Column, values: Any, rows: Rows, steps: Sequence[Asking]) -> Any:
        """The numbers of a column by row, (rows, 1 + terms); where it fails it is given up, and they end.

        Args:
            column: Of these.
            values: By row what was told or returned.
            rows: Of these.
            steps: What a function was called with; about a batch at once, or about each env.
        """
        if len(values) > 1 and not column.terms:
            values = _packed(values)
        if isinstance(values, np.ndarray) and (values.ndim == 2 or not column.terms) and are_numbers(values):
            return values.reshape(len(values), -1)
        found: list[list[float]] = []
        for row, value in enumerate(values):
            try:
                if isinstance(value, Raised):
                    raise value.error
                found.append(column.numbers(_returned(column, value) if column.batched else value))
            except FAILURES as error:
                ended = rows.terminated[row] or rows.truncated[row]
                if isinstance(error, Untold) and column.may_be_untold and not ended:
                    found.append([NAN])
                    continue
                step = steps[row * len(steps) // len(values)] if steps else ()
                reason = self._guard.reason(column.measures[0], step, error) if steps else reason_of(error)
                self._recorder.give_up(column, rows.place(row), reason, error)
                break
        return found

    def make(self) -> None:
        """Make rows of what was taken, and write them."""
        if not self._ticks:
            return
        rows, count = self._rows(0), len(self._ticks)
        try:
            self._check(rows.paid)
            for column, known in self._bound.items():
                if column in self._later and not column.given_up and bound(column.parts) != known:
                    reason = "a name that it reads was given another value, so two rewards would stand under one name"
                    self._recorder.give_up(column, rows.place(0), reason)
            if len(rows.paid):
                self._write(rows, self._said | self._ask(self._later, 0))
                self.at = rows.place(-min(len(rows.paid), self._num_envs))
        finally:
            self.time += count
            self._clear()
            self._actions.forget()
            self._seen.forget()
            del self._told[:-1]
            self._due = self._recorder.due

    def _check_info(self, info: Mapping[str, Any]) -> None:
        """See at once whether what was told is finite: it may not be kept."""
        with suppress(OverflowError):  # a large whole number
            if NUMBERS.issuperset(map(type, info.values())) and isfinite(sum(info.values())):
                return
        if self._are_finite and not is_finite(info):
            self._note({"info": info}, self.tried)

    def _check(self, paid: Any) -> None:
        """See whether the other numbers of steps are."""
        count = len(self._ticks)
        seen, actions = self._seen.last(len(self._told)), self._actions.last(count)
        if not self._are_finite or all(is_finite(_packed(it)) for it in (seen, actions, paid)):
            return
        for number, (place, tick) in enumerate(zip(self._befores, self._ticks, strict=True)):
            fields = {"observation": seen[place + 1], "action": actions[number], "pay": tick[3]}
            for step, told in ((number, {"observation": seen[place]}), (number + 1, fields)):
                if self._are_finite and not is_finite(told):
                    self._note(told, self.tried - count + step)

    def _note(self, fields: Mapping[str, Any], step: int) -> None:
        """Tell the first number that is not: the training goes on, whose learner may be meant to see it."""
        self._are_finite = False
        try:
            require_finite(fields, step, "" if self._spaces is None else " (the first number behind a name: which env)")
        except SimulationDiverged as error:
            self._recorder.note(f"{error}. The training goes on: a learner may turn all of its weights to NaN by that")

    def _write(self, rows: Rows, found: Mapping[Column, Any]) -> None:
        recorder, columns, count = self._recorder, self.columns, len(rows.paid)
        if not self.time:
            recorder.learn_terms()
        at = KEYS + len(columns)
        made = np.full((count, at + sum(len(column.terms or ()) for column in columns) + 2), NAN)
        times = range(self.time, self.time + len(self._ticks))
        made[:, 0] = times if self._spaces is None else self._flat([np.full(self._num_envs, it) for it in times], 0)
        made[:, 1], made[:, 2], made[:, 3] = rows[:3]
        for index, column in enumerate(columns):
            width, numbers = len(column.terms or ()), found.get(column, ())
            if width > 1 and len(numbers) >= FIRST_STEPS and column not in self._summed:
                self._summed.add(column)
                if twice := paid_twice(dict(zip(column.terms or (), np.asarray(numbers)[:, 1:].T, strict=True))):
                    recorder.note(f"{column.noun}: {paid_twice_text(twice, len(numbers))}")
            if len(numbers):
                made[: len(numbers), [KEYS + index, *range(at, at + width)]] = numbers
            at += width
        made[:, -2], made[:, -1] = rows.terminated, rows.truncated
        if recorder.undirected:
            recorder.learn_direction(made[:, KEYS:], self.time)
        if recorder.trained is not None:
            said, paid = made[:, KEYS + columns.index(recorder.trained)], np.asarray(rows.paid, float)
            for row in np.flatnonzero(differs(said, paid))[:1].tolist():
                recorder.tell_paid_otherwise(said[row], float(paid[row]), rows.place(row))
        self.last = made[-1, KEYS:-2].tolist()
        if recorder.calls is not None:
            actions = self._actions.last(len(self._ticks))
            if self._spaces is not None:
                actions = self._flat([*actions], 0)
            made = np.hstack([made, recorder.calls.take(actions)])
        recorder.write(made)


def _packed(values: Any) -> Any:
    """An array of them where they are plain numbers."""
    is_plain = not isinstance(values, np.ndarray) and NUMBERS.issuperset(map(type, values))
    return np.array(values, np.float64) if is_plain else values


def _returned(column: Column, numbers: Float) -> Any:
    """Numbers of one env as its function would have returned them."""
    return dict(zip(column.terms, numbers[1:].tolist(), strict=True)) if column.terms else numbers[0]


def _told_by(info: Mapping[str, Any], key: str) -> Any:
    try:
        return told_under(info, key)
    except Untold as error:
        return Raised(error)
