"""`harness.RecordRewards`: for one Gymnasium environment."""

import os
import weakref
from collections.abc import Collection, Mapping
from math import isfinite
from typing import Any, SupportsFloat, TypeVar

import gymnasium
from gymnasium.envs.registration import EnvSpec
from numpy import float64, ndarray

from harness.eta.interval import Bounds
from harness.record.recording.facts import Acted
from harness.recorder.asked import Asked, OnError
from harness.recorder.calls import CHECKED, action_facts
from harness.recorder.column import Column, Given, Measure, Untold, as_number
from harness.recorder.env_facts import LEARNERS
from harness.recorder.recorder import Recorder, differs, kept

Observation = TypeVar("Observation")
Action = TypeVar("Action")

NAN = float("nan")
KEYS = 4
"""Numbers at the beginning of a row that say which step it is: time, env, episode, step."""


class RecordRewards(gymnasium.Wrapper[Observation, Action, Observation, Action]):
    """Records what several rewards pay for each step of an env, and changes nothing of the env.

    The learner is paid by the env itself; with `pay`, by the reward that it is trained with, in its place. A reward, or
    a measure of behaviour, is one of these:

    * a function of (observation, action, next_observation, info) that returns one finite number. `observation` is what
      the env returned before the step. Both observations are copies.
    * an object that can be called so and has ``reset()``, for one with a memory: ``reset()`` is called when an episode
      starts. The env gets a deep copy of its own.
    * a key of `info`, as ``"distance"``. In a step that does not end an episode, a measure of behaviour may be missing
      there; the step then has NaN.
    * ``"own"``, what the env pays.

    One that raises, returns something else than a finite number, or whose key is missing is given up: one warning names
    it with episode and step, it is NaN from that step on, and everything else goes on.

    Steps are written every 5 seconds, and when the env is closed, is garbage, or Python ends. The folder can be read at
    any time, by `harness.record.recording.recorded_training.read_recording`.
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
            bounds: By name of a measure, the least and the greatest value that it can have: ``(0.0, math.inf)`` of a
                distance. No interval in a report leaves them; a measure that is 0 or 1 in every episode needs none.
            seed: Of the training: reports compare trainings of one seed. By default the first that the env is reset
                with.
            evaluation: A finished policy acts, and nothing is trained: `trained_with` and `seed` are then those of the
                training that the policy comes from; see `harness.recorder.evaluate_policy`.
            pay: Pay the learner the reward `trained_with`, and not what the env pays. Where it fails, that is an error.
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

        Raises:
            UsageError: Something of that cannot be used, or `path` holds another recording.
            SchemaError: The recording to go on with is damaged.
            StorageError: The folder cannot be written.
        """
        super().__init__(env)
        asked = Asked(
            path, trained_with, rewards, behaviour or {}, lower_is_better, seed, evaluation, pay, number, resume,
            on_error, bounds=bounds or {}, learners=learners, horizon=horizon,
            acted=acted, after=after, steps_asked=steps_asked, episodes_asked=episodes_asked,
        )  # fmt: skip
        self._recorder = Recorder(env, asked, num_envs=1, actions=action_facts(env.action_space))
        self._columns = [(column, _measure_of(column)) for column in self._recorder.columns]
        self._looks, self._calls, self._horizon = self._recorder.looks, self._recorder.calls, horizon
        self._pays = None if self._recorder.pays is None else KEYS + self._recorder.pays
        self._before: Any = None
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
        names = [column.name for column, _ in self._columns]
        return dict(zip(names, self._row[KEYS:], strict=False)) if self._row else {}

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Start an episode."""
        observation, info = self.env.reset(seed=seed, options=options)
        self._recorder.note_seed(seed)
        self._recorder.note_start(observation)
        if self._calls is not None:
            self._calls.note_reset(0, seed, options)
        self._before = kept(observation) if self._looks else None
        self._episode, self._step = self._episode + (self._step > 0), 0
        for column, _ in self._columns:
            if column.remembers and not column.given_up:
                try:
                    column.measures[0].reset()  # type: ignore[attr-defined] # it remembers
                except (Exception, SystemExit) as error:  # whatever rewards of users raise
                    self._recorder.give_up(column, 0, self._episode, 0, error)
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

    def finish(self) -> None:
        """Write what is left, and leave the env open; what comes later is not recorded."""
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
        after: Any = None
        if self._looks:
            seen: Any = observation
            after = seen.copy() if type(seen) is ndarray else kept(seen)  # mostly a call less
        row: list[Any] = [self._time, 0, self._episode, self._step]
        for column, measure in self._columns:
            value: Any = NAN
            if not column.given_up:
                try:
                    value = paid if measure is None else measure(self._before, action, after, info)
                    if type(value) is float64:  # what most envs pay
                        value = value.item()
                    if type(value) is not float or not isfinite(value):  # else a call less
                        value = as_number(value)
                except (Exception, SystemExit) as error:  # whatever rewards of users raise
                    value = NAN
                    if not (isinstance(error, Untold) and column.may_be_untold and not (terminated or truncated)):
                        self._recorder.give_up(column, 0, self._episode, self._step, error)
            row.append(value)
        trained = self._recorder.trained
        if trained is not None and differs(row[KEYS + trained], paid):
            self._recorder.tell_paid_otherwise(row[KEYS + trained], float(paid), 0, self._episode, self._step)
        row += (terminated, truncated)
        if self._calls is not None:
            self._calls.note_step(0, action, observation, terminated or truncated or self._step % CHECKED == 0)
        self._recorder.add(row)
        self._before, self._time, self._step = after, self._time + 1, self._step + 1
        return row


def _measure_of(column: Column) -> Measure | None:
    """How a column is measured; None for what the env pays."""
    if column.is_own:
        return None
    if column.key is None:
        return column.measures[0]
    key = column.key

    def told(observation: Any, action: Any, next_observation: Any, info: Any, /) -> Any:
        if key not in info:
            raise Untold(key, [*info])
        return info[key]

    return told
