"""`harness.RecordRewards`: for one Gymnasium environment."""

import os
import weakref
from collections.abc import Callable, Collection, Mapping
from itertools import repeat
from math import isfinite
from typing import Any, SupportsFloat, TypeVar

import gymnasium
from gymnasium.envs.registration import EnvSpec
from numpy import float64, ndarray

from harness.errors import reason_of
from harness.eta.interval import Bounds
from harness.eta.manner import Acted
from harness.recorder.calls import CHECKED, action_facts
from harness.recorder.column import as_number
from harness.recorder.env_facts import LEARNERS, Asked, OnError
from harness.recorder.guard import Asking, Raised
from harness.recorder.recorder import Recorder, differs
from harness.recorder.trial import FIRST_STEPS
from harness.reward.given import Before, Given, Now, Untold, told_under, zeros_of

Observation = TypeVar("Observation")
Action = TypeVar("Action")

NAN = float("nan")
KEYS = 4
"""Numbers at the beginning of a row that say which step it is: time, env, episode, step."""


class RecordRewards(gymnasium.Wrapper[Observation, Action, Observation, Action]):
    """Records what several rewards pay for each step of an env, and changes nothing of the env.

    The learner is paid by the env itself; with `pay`, by the reward that it is trained with, in its place. A reward, or
    a measure of behaviour, is one of these:

    * a function whose one argument is called ``step``. It reads ``step.observation`` after the step, ``step.action``
      and ``step.info``, and under ``step.before`` what each was before: in the first step of an episode an action of
      zeros, and the info of the reset. All that it is given are copies, which it cannot write into.
    * a function of (observation, action, next_observation, info). `observation` is what the env returned before the
      step.
    * an object that can be called as one of these and has ``reset()``, for one with a memory: ``reset()`` is called
      when an episode starts. The env gets a deep copy of its own.
    * a key of `info`, as ``"distance"``, or ``"reward.forward"`` of a dict in it. In a step that does not end an
      episode, a measure of behaviour may be missing there; the step then has NaN.
    * ``"own"``, what the env pays.

    A function returns one finite number. That of a reward may also return a dict of terms, ``{"reach": 1.0, "effort":
    -0.1}``, whose sum is paid, or (total, dict). A reward may be given as its terms, too: ``{"forward":
    "reward_forward", "effort": function}``. Each term is recorded as ``reward/NAME/TERM``. A reward pays the same terms
    in every step.

    One that raises, returns something else than a finite number, or whose key is missing is given up: one warning names
    it with episode and step, it is NaN from that step on, and everything else goes on.

    Steps are written every 4 seconds or sooner, and when the env is closed, is garbage, or Python ends. The folder can
    be read at any time, by `harness.record.recording.recorded_training.read_recording`.
    """

    def __init__(
        self,
        env: gymnasium.Env[Observation, Action],
        path: str | os.PathLike[str],
        *,
        trained_with: str,
        rewards: Mapping[str, Given],
        behaviour: Mapping[str, Given] | None = None,
        lower_is_better: Collection[str] = (),
        higher_is_better: Collection[str] = (),
        bounds: Mapping[str, Bounds] | None = None,
        seed: int | None = None,
        evaluation: bool = False,
        pay: bool = False,
        number: int = 0,
        resume: bool = False,
        on_error: OnError = "warn",
        learners: Collection[str] = LEARNERS,
        horizon: int | None = None,
        acted: Acted = "",
        after: int = 0,
        steps_asked: int = 0,
        episodes_asked: int = 0,
        watch: bool = False,
    ) -> None:
        """Check what was given, and start the recording.

        Args:
            env: What the learner trains in.
            path: A folder for this training; it is made.
            trained_with: Name of the reward that the env pays, one of `rewards`; or ``"own"``, which is then recorded
                beside them under this name.
            rewards: By name, at least one.
            behaviour: Measures of what the robot does, by name; reports judge it by the first.
            lower_is_better: Names of measures of which less is better, such as a distance.
            higher_is_better: Names of those of which more is, such as a height. A measure that is 0 or 1 needs neither.
            bounds: By name of a measure, the least and the greatest value that it can have: ``(0.0, math.inf)`` of a
                distance. No interval in a report leaves them; a measure that is 0 or 1 in every episode needs none.
            seed: Of the training: reports compare trainings of one seed. By default the first that the env is reset
                with.
            evaluation: A finished policy acts, and nothing is trained: `trained_with` and `seed` are then those of the
                training that the policy comes from; see `harness.recorder.evaluate_policy`.
            pay: Pay the learner the reward `trained_with`, and not what the env pays. Where it fails, that is an error.
                Wrappers that normalise or transform what is paid then stand outside of this one.
            number: Of this env among several that record one training into one path, each with a number of its own.
            resume: Go on with the recording in `path`, if there is one, after what it has. Otherwise a path that
                holds one is refused. Rewards, measures and env have to be the same as before.
            on_error: ``"warn"``, or ``"raise"`` to stop the training where a reward or a measure fails.
            learners: Modules of learning libraries; the version of each is noted where something has imported it.
            horizon: Steps after which an episode is cut, if the env has not ended it: the step is truncated then. The
                recording counts such episodes. None: only the env ends episodes.
            acted: Of an evaluation: ``"deterministic"``, ``"stochastic"``, or ``"random"`` for actions that no policy
                chose; empty where that is not known.
            after: Of an evaluation before the training ended: environment steps of training before it.
            steps_asked: Environment steps that the whole training is to take, over all envs that record into `path`.
                Reports tell of a training that took fewer, and do not compare it. 0: not known.
            episodes_asked: The same of an evaluation: its episodes.
            watch: Show it while it goes on: ``harness watch`` in another process, which says its address. It ends with
                the recording. Of several envs that record into `path` number 0 starts it.

        Raises:
            UsageError: Something of that cannot be used, or `path` holds another recording.
            SchemaError: The recording to go on with is damaged.
            StorageError: The folder cannot be written.
        """
        super().__init__(env)
        asked = Asked(
            path, trained_with, rewards, behaviour or {}, lower_is_better, seed, evaluation, pay, number, resume,
            on_error, bounds=bounds or {}, learners=learners, horizon=horizon,
            acted=acted, after=after, steps_asked=steps_asked, episodes_asked=episodes_asked, watch=watch,
            higher_is_better=higher_is_better,
        )  # fmt: skip
        self._recorder = Recorder(env, asked, num_envs=1, actions=action_facts(env.action_space))
        self._columns, self._guard = self._recorder.columns, self._recorder.guard
        self._calls, self._horizon = self._recorder.calls, horizon
        self._seal = self._guard.seal if self._recorder.looks else None
        self._find_asked()
        self._pays = None if self._recorder.pays is None else KEYS + self._recorder.pays
        self._before: Asking = (None, None, None)
        self._now: Asking | None = None
        self._has_terms = self._recorder.with_terms != ()
        self._terms: dict[int, list[float]] = {}  # by index of a column, what its terms paid last
        self._tried = 0  # steps about which functions are asked again
        self._row: list[Any] = []
        self._time, self._episode, self._step = self._recorder.next_time, int(self._recorder.next_episodes[0]), 0
        weakref.finalize(self, self._recorder.close)

    @property
    def spec(self) -> EnvSpec | None:  # type: ignore[override] # a property there too, behind a declaration
        """The env's own: an env that is made of it is not recorded."""
        return self.env.spec

    @property
    def recorded(self) -> dict[str, float]:
        """What was recorded of the last step, by column, as ``behaviour_success``; NaN where nothing was."""
        terms = [name for index in self._recorder.with_terms or () for name in self._columns[index].term_columns]
        names = [*(column.name for column in self._columns), *terms]
        return dict(zip(names, self._row[KEYS:], strict=False)) if self._row else {}

    @property
    def functions(self) -> dict[str, Callable[..., Any]]:
        """The functions that this env is measured with, by name: its own copies of those with a memory, as they are.

        A reward that remembers something beyond its ``reset()``, as how many steps a training has had, goes on from
        there where it is given to `harness.evaluate_policy`.
        """
        return {column.name.partition("_")[2]: column.measures[0] for column in self._columns if column.measures}

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Start an episode."""
        observation, info = self.env.reset(seed=seed, options=options)
        self._recorder.note_seed(seed)
        self._recorder.note_start(observation)
        if self._calls is not None:
            self._calls.note_reset(0, seed, options)
        self._end_episode()
        if self._seal:
            self._before = self._seal(observation), None, self._seal(info)
        self._episode, self._step = self._episode + (self._step > 0), 0
        for column in self._columns:
            if column.remembers and not column.given_up:
                self._recorder.restart(column, 0, (0, self._episode, 0))
        self._find_asked()
        if self._recorder.trial is not None:
            self._recorder.trial.begin(self._columns)
        return observation, info

    def step(self, action: Action) -> tuple[Observation, SupportsFloat, bool, bool, dict[str, Any]]:
        """Take a step, and record it."""
        observation, paid, terminated, truncated, info = self.env.step(action)
        if self._step + 1 == self._horizon and not (terminated or truncated):
            truncated = True
            self._recorder.note_cut()
        self._row = row = self._record(action, observation, paid, terminated, truncated, info)
        if self._pays is not None:
            paid = row[self._pays]
        return observation, paid, terminated, truncated, info

    def close(self) -> None:
        """Write what is left, and close the env."""
        try:
            self.finish()
        finally:
            super().close()

    def note(self, line: str) -> None:
        """Tell something that whoever reads the recording has to know, and write it down."""
        self._recorder.note(line)

    def finish(self) -> None:
        """Write what is left, and leave the env open; what comes later is not recorded."""
        try:
            if self._tried:
                self._recorder.end_all((0, self._episode, max(self._step - 1, 0)))
        finally:
            self._recorder.close()

    def _record(
        self,
        action: Action,
        observation: Observation,
        paid: SupportsFloat,
        terminated: bool,
        truncated: bool,
        info: dict[str, Any],
    ) -> list[Any]:
        """Record a step; returns its row: `KEYS` numbers that say which step it is, a number for each column, flags."""
        seal, told = self._seal, [NAN] * len(self._columns)
        given: Asking = ()
        if type(paid) is ndarray and paid.ndim:
            self._recorder.give_up_pay(paid, (0, self._episode, self._step))
            self._find_asked()
            paid = NAN
        if seal is not None:  # functions cannot spoil what they are given
            action, observation, info = seal(action), seal(observation), seal(info)
            given = self._before[0], action, observation, info
        for index, key in self._read:  # before any function runs
            value: Any = paid if key is None else info[key] if key in info else _told_under(info, key)
            is_known = type(value) is float and isfinite(value) and index not in self._terms  # mostly a call less
            told[index] = value if is_known else self._number(index, value, given, terminated or truncated)
        if self._asked:
            self._ask(told, given)
        if self._recorder.undirected:
            self._recorder.learn_direction([told], self._time)
        if self._has_terms:
            told += self._terms_of_step()
        row: list[Any] = [self._time, 0, self._episode, self._step, *told]
        trained = self._recorder.trained
        if trained is not None and differs(told[trained], paid):
            self._recorder.tell_paid_otherwise(told[trained], float(paid), (0, self._episode, self._step))
        row += (terminated, truncated)
        if self._calls is not None:
            self._calls.note_step(0, action, observation, terminated or truncated or self._step % CHECKED == 0)
        self._recorder.add(row)
        if seal is not None:
            self._before, self._now = (observation, action, info), None
        self._time, self._step = self._time + 1, self._step + 1
        if self._recorder.trial is not None:
            self._tried += 1
            if self._tried == FIRST_STEPS:
                self._recorder.end_trial((0, self._episode, self._step - 1))
                self._find_asked()
            elif terminated or truncated:
                self._end_episode()
        return row

    def _terms_of_step(self) -> list[float]:
        """What the terms of all rewards have paid for the step; those of a reward that was given up are NaN."""
        if self._recorder.with_terms is None:
            self._recorder.learn_terms()
        self._has_terms = bool(self._recorder.with_terms)
        terms, found = self._terms, list[float]()
        for index in self._recorder.with_terms or ():
            column = self._columns[index]
            found += [NAN] * len(column.terms or ()) if column.given_up else terms[index]
        return found

    def _ask(self, told: list[Any], given: Asking) -> None:
        """Ask the functions about a step, and put their numbers into their places."""
        steps = map(self._forms(given).__getitem__, self._of_step) if self._of_step else repeat(given)
        answers = self._guard.ask(self._functions, steps, self._places_paid, self._is_watched)
        asked, drew, trial = self._asked, self._guard.drew, self._recorder.trial
        terms = self._terms
        for index, value in zip(asked, answers, strict=True):
            is_known = type(value) is float and isfinite(value) and index not in terms  # mostly a call less
            told[index] = value if is_known else self._number(index, value, given)
        at = 0, self._episode, self._step
        for place, generator in drew.items():
            self._recorder.note_draw(self._columns[asked[place]], generator, at)
        for index in asked if trial is not None else ():
            column = self._columns[index]
            if not column.given_up:
                self._recorder.try_again(column, self._forms(given)[column.takes_step], told[index], at)
            if column.given_up:
                told[index] = NAN
                self._find_asked()

    def _forms(self, given: Asking) -> tuple[Asking, Asking]:
        """What functions of four arguments are given of a step, and what functions of a step are."""
        if self._now is None:
            _, action, observation, info = given
            seen, last, told = self._before
            before = Before._make((seen, last if self._step else zeros_of(action), told))
            self._now = (Now._make((observation, action, info, before)),)
        return given, self._now

    def _number(self, index: int, value: Any, given: Asking, is_needed: bool = True) -> float:
        """A number that is finite; NaN for what is not, which is given up unless it need not be told."""
        try:
            if type(value) is float64:  # what most envs pay
                value = value.item()
            if isinstance(value, Raised):
                raise value.error
            if not (isinstance(value, dict | tuple) or self._columns[index].terms):
                return as_number(value)
            number, *self._terms[index] = self._columns[index].numbers(value)
            return number
        except (Exception, SystemExit) as error:  # whatever rewards of users raise
            column = self._columns[index]
            if not isinstance(error, Untold) or is_needed or not column.may_be_untold:
                form = self._forms(given)[column.takes_step] if column.measures else ()
                reason = self._guard.reason(column.measures[0], form, error) if form else reason_of(error)
                self._recorder.give_up(column, (0, self._episode, self._step), reason, error)
                self._find_asked()
        return NAN

    def _end_episode(self) -> None:
        """See `Recorder.end_episode`; nothing while no step was taken."""
        if self._step and self._recorder.trial is not None:
            self._recorder.end_episode((0, self._episode, self._step - 1))
            self._find_asked()

    def _find_asked(self) -> None:
        """Note which columns are read, with the key of info, None for what the env pays; and which are asked."""
        left = [(index, column) for index, column in enumerate(self._columns) if not column.given_up]
        self._read = [(index, column.key) for index, column in left if not column.measures]
        self._asked = [index for index, column in left if column.measures]
        self._is_watched = any(column.is_watched for _, column in left)
        self._functions = [column.measures[0] for _, column in left if column.measures]
        of_step = [column.takes_step for _, column in left if column.measures]
        self._of_step = of_step if any(of_step) else []
        pays = self._recorder.pays
        self._places_paid = (self._asked.index(pays),) if pays in self._asked else ()


def _told_under(info: Mapping[str, Any], key: str) -> Any:
    try:
        return told_under(info, key)
    except Untold as error:
        return Raised(error)
