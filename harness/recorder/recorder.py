"""What both wrappers share: the columns, what is done when one fails, the files, and the calls that an env gets.

The calls are kept with a checksum of each answer. With them the same calls can be given to a new env,
`harness.recorder.retake`, and the checksums tell whether it answers as the recorded one did.
"""

import os
import sys
import warnings
import zlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from gymnasium import Space
from gymnasium.spaces import Box, Discrete, MultiBinary, MultiDiscrete
from gymnasium.vector import VectorEnv

from harness.arrays import Float
from harness.errors import StorageError, UsageError, reason_of
from harness.eta.laws import may_be_flag, require_direction
from harness.record.parts import Rows
from harness.record.recording.facts import (
    FILE_REWARD,
    MOST_ACTION_NUMBERS,
    ActionFacts,
    Failure,
    TrainingFacts,
    log_column,
)
from harness.record.recording.recording_writer import RecordingWriter
from harness.recorder.column import Column, made_columns, source_of
from harness.recorder.env_facts import Asked, env_facts, normalises, versions_of
from harness.recorder.guard import Asking, Guard, Raised
from harness.recorder.trial import FIRST_STEPS, Finding, Trial
from harness.recorder.watched import start_watching
from harness.recorder.wrapped import tell_wrapped_pay
from harness.reward.given import OWN
from harness.text import print_visible, visible

FEWEST = 9
"""Fewer episodes than these hint at nothing, whatever they are; see `harness.results.under_way.hint_of`."""
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


def action_of(numbers: Float, facts: ActionFacts) -> Any:
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


Place: TypeAlias = tuple[int, int, int]
"""Env, episode, step."""


class Recorder:
    """Takes steps of an env and writes them.

    Attributes:
        columns: The numbers of a row, in order.
        pays: The column that the learner is paid; None where it is paid by the env.
        trained: The column that the env should pay; None where that is what the env pays, or differed.
        guard: Asks the functions.
        trial: Asks them more than once; None once that is over.
        calls: Notes what each env is told; None where its actions are not recorded.
        undirected: See `Asked`; empty once its measure was neither 0 nor 1.
        is_strict: Whether the user wants errors raised.
        taken: Steps that have no row yet, `harness.recorder.taken.Taken`, of which rows are made before the end.
        next_time: Of the next step.
        next_episodes: Numbers of the next episodes, (num_envs,).
    """

    def __init__(self, env: Any, asked: Asked, num_envs: int, actions: ActionFacts | None) -> None:
        """Start the files.

        Args:
            env: What is recorded.
            asked: What to record.
            num_envs: How many envs there are.
            actions: How actions are recorded; None if they are not.

        Raises:
            UsageError: What was asked for cannot be recorded, or the files hold another recording.
            SchemaError: The recording to go on with is damaged.
            StorageError: The files cannot be written.
        """
        rewards = asked.all_rewards
        recorder = "RecordVectorRewards" if isinstance(env, VectorEnv) else "RecordRewards"
        of_wrappers = tell_wrapped_pay(env, recorder, asked.pay)
        self.columns = made_columns(env, rewards, asked.behaviour, num_envs, frozenset(asked.batched))
        (paid,) = (column for column in self.columns if column.name == f"{FILE_REWARD}{asked.trained_with}")
        self.trained = None if asked.evaluation or asked.pay or paid.is_own else paid
        self.pays, self.guard = paid if asked.pay else None, Guard()
        is_asked = any(column.measures for column in self.columns)
        self.trial: Trial | None = Trial(env, self.guard) if is_asked else None
        self._last_look: Trial | None = None
        self._drew: set[str] = set()
        self._path, self._stopped = Path(asked.path), False
        self.is_strict = asked.on_error == "raise"
        self.taken: Any = None
        facts = TrainingFacts(
            rewards=tuple(rewards),
            trained_with=asked.trained_with,
            behaviour=tuple(asked.behaviour),
            lower_is_better=tuple(name for name in asked.behaviour if name in asked.lower_is_better),
            higher_is_better=tuple(name for name in asked.behaviour if name in asked.higher_is_better),
            pay=asked.pay,
            bounds={name: (float(low), float(high)) for name, (low, high) in asked.bounds.items()},
            evaluation=asked.evaluation,
            seed=asked.seed,
            num_envs=num_envs,
            spec=env_facts(env),
            versions=versions_of(env, asked.learners),
            sources={log_column(column.name): source_of(column.given) for column in self.columns},
            actions=actions,
            horizon=asked.horizon or 0,
            acted=asked.acted,
            after=asked.after,
            asked=asked.steps_asked,
            episodes_asked=asked.episodes_asked,
        )
        self.undirected, self._asked = asked.undirected, asked
        self._sums_starts = asked.evaluation and num_envs == 1 and not normalises(facts.spec)
        try:
            self._writer = RecordingWriter(self._path, facts, asked.number, asked.resume)
        except OSError as error:
            raise StorageError(f"'{asked.path}' cannot be written: {error.strerror or error}") from error
        self._note_given_up(asked.path)
        now = self._writer.facts.actions  # a recording of an older version, which goes on, has none
        self.calls = None if now is None else Calls(now, num_envs, self._note_actions)
        for line in of_wrappers:
            self.note(line)
        self.next_time, self.next_episodes = self._writer.next_time, self._writer.next_episodes
        if self.next_time:
            self._know_terms(self._writer.facts.terms)
        self._page = start_watching(self._path) if asked.watch and not asked.number else None

    def learn_terms(self) -> None:
        """Note which terms the rewards have paid for the first step: they are those of all steps."""
        found = {it.name.removeprefix(FILE_REWARD): it.terms for it in self.columns if it.terms}
        self._know_terms(found)
        if found:
            self._writer.learn_terms(found)

    def _know_terms(self, terms: Mapping[str, tuple[str, ...]]) -> None:
        for column in self.columns:
            is_reward = column.name.startswith(FILE_REWARD)
            column.terms = terms.get(column.name.removeprefix(FILE_REWARD), ()) if is_reward else ()

    def note_seed(self, seed: Any) -> None:
        """Keep the first seed that the env was reset with."""
        facts = self._writer.facts
        if seed is None or facts.seed is not None or facts.seeds:
            return
        several = isinstance(seed, (list, tuple, np.ndarray))
        seeds = tuple(None if one is None else int(one) for one in seed) if several else ()
        first = next((one for one in seeds if one is not None), None) if several else int(seed)
        self._writer.facts = replace(facts, seed=first, seeds=seeds)

    def _note_actions(self, facts: ActionFacts) -> None:
        self._writer.facts = replace(self._writer.facts, actions=facts)

    def note_start(self, observation: Any) -> None:
        """Sum up the first observation of an episode of an evaluation: policies should meet the same."""
        if self._sums_starts:
            starts = checksum(observation, self._writer.facts.starts)
            self._writer.facts = replace(self._writer.facts, starts=starts)

    def note_cut(self) -> None:
        """Count an episode that is cut."""
        self._writer.facts = replace(self._writer.facts, cut=self._writer.facts.cut + 1)

    def give_up(self, column: Column, at: Place, reason: str, error: BaseException | None = None) -> None:
        """Note that a column has failed, and tell it.

        Raises:
            UsageError: The user wants errors raised, or the learner is paid by this reward.
        """
        column.given_up = True
        env, episode, step = map(int, at)
        failure = Failure(log_column(column.name), reason, env=env, episode=episode, step=step)
        self._writer.facts = replace(self._writer.facts, failed=(*self._writer.facts.failed, failure))
        where = f"{column.noun} failed in {_told(at)}: {reason}"
        if column is self.pays:
            raise UsageError(f"{where}. It pays the learner, so the training cannot go on") from error
        self._tell(where, "The training goes on; from this step on it is recorded as NaN", error)

    def note(self, line: str) -> None:
        """Tell, once, something of what goes on being recorded."""
        if line not in self._writer.facts.notes:
            self._writer.facts = replace(self._writer.facts, notes=(*self._writer.facts.notes, line))
            warnings.warn(visible(line), Noted, stacklevel=_depth_of_caller())

    def note_draw(self, column: Column, generator: str, at: Place) -> None:
        """Tell the first time that a function draws from a generator that the whole process shares."""
        if column.name in self._drew:
            return
        self._drew.add(column.name)
        is_paid = column is self.pays
        kept = "It pays the learner, so this is part of the training" if is_paid else "The training does not notice"
        self.note(
            f"{column.noun}: it draws from {generator}, first in {_told(at)}. {kept}, but nobody can compute its "
            "numbers again. Make a generator of its own, `self.rng = numpy.random.default_rng(0)` in reset()"
        )

    def restart(self, column: Column, place: int, at: Place, *given: Any) -> None:
        """Tell a function with a memory that an episode starts."""
        (found,) = self.guard.ask([column.measures[place].reset], [given])
        if self.trial is not None and place == 0:
            self.trial.restarted(column, given)
        if self.guard.drew:
            self.note_draw(column, self.guard.drew[0], at)
        if isinstance(found, Raised):
            self.give_up(column, at, reason_of(found.error), found.error)

    def try_again(self, column: Column, step: Asking, answer: Any, at: Place) -> bool:
        """Ask a function about one of the first steps again; returns whether it goes on, and was not given up."""
        assert self.trial is not None
        found = self.trial.note(column, step, answer, column.name in self._drew)
        if found is not None:
            self.give_up(column, at, found.told)
        return found is None

    def end_episode(self, at: Place) -> None:
        """Ask all functions about the first episode again, if that was not done."""
        if self.trial is not None and not self.trial.has_looked:
            self._take(self.trial.look(self.columns), at)

    def end_trial(self, at: Place) -> None:
        """Ask all functions about the first steps again, if that was not done."""
        if self.trial is not None:
            self._last_look, self.trial = self.trial, None
            self._take(self._last_look.look(self.columns), at)

    def end_all(self, at: Place) -> None:
        """Ask once more when the recording ends: a memory may show late."""
        if self.trial is not None:
            self.end_trial(at)
        elif self._last_look is not None:
            last, self._last_look = self._last_look, None
            self._take(last.look_at_last(self.columns), at)

    def _take(self, findings: Iterable[Finding], at: Place) -> None:
        for found in findings:
            if found.is_wrong:
                self.give_up(found.column, at, found.told)
            else:
                self.note(f"{found.column.noun}: {found.told}")

    def tell_paid_otherwise(self, value: float, paid: float, at: Place) -> None:
        """Note the first step in which the env paid something else than the reward named `trained_with`, and tell it.

        Raises:
            UsageError: The user wants errors raised.
        """
        name, self.trained = self._writer.facts.trained_with, None
        where = f"{_told(at)}: the env paid {paid:.9g}, {name!r} {value:.9g}"
        self._writer.facts = replace(self._writer.facts, paid_otherwise=where)
        self._tell(
            f"the learner is not paid by trained_with={name!r}: {where}",
            f'What it is paid can be recorded too: rewards={{..., "{OWN}": "{OWN}"}}, trained_with="{OWN}"',
        )

    def give_up_pay(self, paid: Any, at: Place) -> None:
        """Give up what the env pays, and tell it, where that is no number a step but a vector, as of MO-Gymnasium.

        Raises:
            UsageError: The user wants errors raised.
        """
        reason = (
            f"the env pays {np.shape(paid)[-1]} numbers a step, and a reward is one. Wrap it in one that adds them up, "
            "as mo_gymnasium.wrappers.LinearReward"
        )
        for column in self.columns:
            if column.is_own and not column.given_up:
                self.give_up(column, at, reason)
        if self.trained is not None:
            self.trained = None
            self._tell(
                f"trained_with={self._writer.facts.trained_with!r} is not what the learner is paid: {reason}", ""
            )

    def learn_direction(self, rows: Iterable[Sequence[float]], time: int) -> None:
        """Ask what is better of the measure that decides, as soon as it can be no flag.

        Args:
            rows: What the columns say of steps.
            time: Of these. After the first ones the training goes on, so that nothing is lost.

        Raises:
            UsageError: Nobody says it in one of the first steps, or the user wants errors raised.
        """
        name = self.undirected
        for row in rows:
            value = row[len(self._asked.all_rewards)]
            if not self.undirected or may_be_flag(value):
                continue
            self.undirected = ""
            try:
                require_direction(name, "", f"give lower_is_better=[{name!r}] or higher_is_better=[{name!r}]")
            except UsageError as error:
                if time < FIRST_STEPS or self.is_strict:
                    raise
                self.note(f"{error}. The training goes on; harness report takes --measure {name}:better=lower too")

    @property
    def due(self) -> float:
        """When rows have to be written, by `time.monotonic`."""
        return self._writer.due

    def write(self, rows: Rows) -> None:
        """Write rows.

        Raises:
            StorageError: They cannot be written, and the user wants errors raised.
        """
        if self._stopped:
            return
        try:
            self._writer.append(rows)
        except OSError as error:
            self._stopped = True
            self._tell(
                f"'{self._path}' cannot be written: {error.strerror or error}", "Nothing more is recorded", error
            )

    def close(self) -> None:
        """Write what is left; what comes later is not recorded.

        Raises:
            OSError: It cannot be written, and that was not told before.
        """
        if not self._writer.is_open:
            return
        was_stopped = self._stopped
        try:
            if self.taken is not None:
                self.taken.make()
            self._stopped = True
            self._writer.close()
            is_training = not (was_stopped or self._asked.evaluation or self._asked.number)
            if is_training and self.taken is not None and self.taken.at[1] >= FEWEST:
                self._tell_hint()
        except OSError:
            if not was_stopped:
                raise
        finally:
            self._end_page()

    def _tell_hint(self) -> None:
        """Say at the end of a training what it hints at."""
        from harness.results.under_way import of_recording  # SciPy is loaded where a training ends

        if told := of_recording(self._path).hint(self._asked.steps_asked):
            print_visible(f"harness: {self._path}: {told}", err=True)

    def _end_page(self) -> None:
        if self._page is not None:
            self._page.terminate()  # forks of this process may hold its standard input, which else would end it
            if self._page.stdin is not None:
                self._page.stdin.close()
            self._page.wait()

    def _note_given_up(self, path: str | os.PathLike[str]) -> None:
        """What had failed when the recording was left stays given up."""
        failed = {failure.column for failure in self._writer.facts.failed}
        for column in self.columns:
            column.given_up = log_column(column.name) in failed
            if column.given_up and column is self.pays:
                self._writer.close()
                raise UsageError(f"'{path}': {column.noun} failed before, and pays the learner: name another path")

    def _tell(self, problem: str, rest: str, error: BaseException | None = None) -> None:
        if self.is_strict:
            kind = StorageError if isinstance(error, OSError) else UsageError
            raise kind(problem) from error
        warnings.warn(visible(f"{problem}. {rest}"), GivenUp, stacklevel=_depth_of_caller())


def _told(at: Place) -> str:
    env, episode, step = at
    return f"env {env}, episode {episode}, step {step}"


def _depth_of_caller() -> int:
    """How many frames above `Recorder._tell` the code stands that stepped the env: the first outside this room."""
    depth, frame = 1, sys._getframe(1)
    while frame.f_back is not None and Path(frame.f_code.co_filename).parent == Path(__file__).parent:
        depth, frame = depth + 1, frame.f_back
    return depth


class GivenUp(UserWarning):
    """Something is not recorded from now on, and the training goes on."""


class Noted(UserWarning):
    """Something that is recorded does not say what one would think."""


def differs(value: Any, paid: Any) -> Any:
    """Whether a reward is another number than what the env paid, by more than float32 loses; not where it is NaN."""
    return abs(value - paid) > 1e-6 + 1e-5 * abs(paid)
