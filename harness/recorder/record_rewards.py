"""`harness.RecordRewards`: for one Gymnasium environment."""

import copy
import os
import weakref
from collections.abc import Callable, Collection, Mapping
from typing import Any, SupportsFloat, TypeVar

import gymnasium
import numpy as np
from gymnasium.envs.registration import EnvSpec

from harness.eta.interval import Bounds
from harness.eta.manner import Acted
from harness.log.log import is_countable
from harness.recorder.env_facts import LEARNERS, Asked, OnError
from harness.recorder.recorder import Recorder, action_facts
from harness.recorder.sealed import CONSTANT
from harness.recorder.taken import NUMBERS, Taken
from harness.reward.given import Given

Observation = TypeVar("Observation")
Action = TypeVar("Action")


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
        self._taken, self._columns, self._horizon = Taken(self._recorder, 1), self._recorder.columns, horizon
        self._episode, self._step = int(self._recorder.next_episodes[0]), 0
        weakref.finalize(self, self._recorder.close)

    @property
    def spec(self) -> EnvSpec | None:  # type: ignore[override] # a property there too, behind a declaration
        """The env's own: an env that is made of it is not recorded."""
        return self.env.spec

    @property
    def recorded(self) -> dict[str, float]:
        """What was recorded of the last step, by column, as ``behaviour_success``; NaN where nothing was."""
        self._taken.make()
        terms = [name for column in self._columns for name in column.term_columns]
        return dict(zip((*(column.name for column in self._columns), *terms), self._taken.last, strict=False))

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
        self._recorder.note_start(observation)
        self._taken.end_episode()
        self._taken.start(observation, info)
        self._episode, self._step = self._episode + (self._step > 0), 0
        self._taken.begin([0], [self._episode], seed, options)
        return observation, info

    def step(self, action: Action) -> tuple[Observation, SupportsFloat, bool, bool, dict[str, Any]]:
        """Take a step, and record it."""
        observation, paid, terminated, truncated, info = self.env.step(action)
        step, self._step = self._step, self._step + 1
        if self._step == self._horizon and not (terminated or truncated):
            truncated = True
            self._recorder.note_cut()
        pay = paid if type(paid) in CONSTANT else self._kept(paid)
        tick = 0, self._episode, step, pay, terminated, truncated
        self._taken.take(tick, action, observation, info, terminated or truncated)
        pays = self._recorder.pays
        if pays is not None and pays.is_own:
            if not (type(pay) in NUMBERS and is_countable(pay)):
                self._taken.make()  # which raises, unless it is a number of another kind
            paid = float(pay)
        elif pays is not None:
            paid = float(self._taken.paid[0])
        return observation, paid, terminated, truncated, info

    def _kept(self, paid: Any) -> Any:
        """A copy of what the env pays; 0 if it is no number but several."""
        if np.ndim(paid):
            self._recorder.give_up_pay(paid, (0, self._episode, self._step - 1))
            return 0.0
        return copy.copy(paid)

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
            self._taken.end()
        finally:
            self._recorder.close()
