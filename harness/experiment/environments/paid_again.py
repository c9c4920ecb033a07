"""Recorded trainings paid by rewards that were written later: those of an experiment's cells, or wherever they lie."""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import gymnasium

from harness.environment import AnyEnv, Environment
from harness.errors import HarnessError, UsageError, one_line
from harness.experiment.environments.plan import columns_of
from harness.files.plain import Plain
from harness.log.log import BEHAVIOUR, REWARD
from harness.record.recording.facts import TrainingFacts, facts_of
from harness.record.recording.recorded_training import (
    read_facts,
    read_recording,
    recorder_numbers,
)
from harness.record.store import Store
from harness.recorder.column import source_of
from harness.recorder.env_facts import Columns, env_facts
from harness.recorder.retake import Retake
from harness.recorder.sealed import Walk
from harness.registry.choice import BY_ID, Choice, Registry, choose, parse
from harness.registry.spec import unknown_name
from harness.reward.given import Given
from harness.score.weighted_recordings import recordings_of

ID, CLASS, KWARGS, WRAPPERS, HORIZON = "id", "class", "kwargs", "wrappers", "max_episode_steps"
"""Keys of what a recording tells of its env."""
BATCHES = ("gymnasium.vector.sync_vector_env.SyncVectorEnv", "gymnasium.vector.async_vector_env.AsyncVectorEnv")
"""Classes of envs that are made of single envs."""
OF_BATCH = ("num_envs", "vectorization_mode", "vector_kwargs", "wrappers")
"""Arguments of the env that say how a batch is made of single envs."""


@dataclass(frozen=True)
class Paid(Plain):
    """What became of one recording.

    Attributes:
        folder: Of the recording.
        names: Of the rewards and measures that were computed; without any, it had them all before.
        steps: How many steps they say something of.
        failed: A line for each that failed in the middle.
        refused: Why nothing was computed; empty if something was, or nothing was missing.
    """

    folder: Path
    names: tuple[str, ...] = ()
    steps: int = 0
    failed: tuple[str, ...] = ()
    refused: str = ""


@dataclass(frozen=True)
class PayAgain:
    """Pays recordings by rewards that were written later, and measures them by such measures.

    Attributes:
        registry: The plugins. All functions of plugin files are used if no name is given.
        names: Of the rewards and measures to compute: of functions, or of an environment that has them now.
        task: An environment that makes the envs of recordings that lie loose; None to make them by the ids in the
            recordings.
        tell: Called with the folder and the number of steps done.
    """

    registry: Registry
    names: Sequence[str] = ()
    task: str | None = None
    tell: Callable[[Path, int], None] = field(default=lambda folder, steps: None)

    def run(self, folder: Path) -> Iterator[Paid]:
        """Pay every recording in a folder, at any depth, or those of an experiment's done cells.

        What goes wrong with one recording is told, and the others go on.

        Raises:
            UsageError: No reward is given, a name is not known, or no recording is there.
        """
        functions = [it.name for it in self.registry.functions]
        if not (self.names or functions):
            told = " ".join(self.registry.broken_files())
            raise UsageError(f"No reward is given: name a file of functions with --plugin.{f' {told}' if told else ''}")
        found = self._places(folder)
        if not found:
            raise UsageError(f"'{folder}' has no recording of a finished training")
        self._refuse_unknown(*next(iter(found.items())))
        self._refuse_other_code(found)
        for path, task in found.items():
            try:
                yield self._pay(path, task)
            except HarnessError as error:
                yield Paid(path, refused=str(error))
            except OSError as error:
                yield Paid(path, refused=f"'{path}' cannot be written: {error.strerror or error}")

    def walks(self, path: Path, task: Choice | None) -> Iterator[tuple[int, list[Walk]]]:
        """What was seen and done in a recording: see `harness.recorder.retake.Retake.walks`.

        Args:
            path: Its folder.
            task: The environment in which it was made, if that is known.

        Raises:
            UsageError: An env cannot be made, or answers otherwise.
        """
        make, _ = self._made_by(facts_of(read_recording(path)), task, path)
        yield from Retake(make, lambda env: Columns({}, {})).walks(path)

    def _places(self, folder: Path) -> dict[Path, Choice | None]:
        """The recordings, each with the environment in which it was made, if that is known."""
        if self.task is not None and Store.is_experiment(folder):
            raise UsageError("--task does not go with an experiment, whose cells say where they trained: leave it out")
        task = None if self.task is None else choose(self.registry, "environments", self.task)
        return {path: cell.task if cell else task for path, cell in recordings_of(folder).items()}

    def _pay(self, path: Path, task: Choice | None) -> Paid:
        log = read_recording(path)
        facts, steps = facts_of(log), len(log)
        make, columns = self._made_by(facts, task, path)
        with closing(make()) as env:
            later = self._missing(facts, columns(env))
        if not later.names:
            return Paid(path)

        def again(env: AnyEnv) -> Columns:
            return _chosen(columns(env), later.rewards, later.behaviour)

        failed = Retake(make, again, lambda steps: self.tell(path, steps)).score(path)
        return Paid(path, (*later.rewards, *later.behaviour), steps, failed)

    def _made_by(
        self, facts: TrainingFacts, task: Choice | None, path: Path
    ) -> tuple[Callable[[], AnyEnv], Callable[[AnyEnv], Columns]]:
        """How an env like the recorded one is made, and what is recorded of it."""
        place = task or Choice(BY_ID, ((ID, str(facts.spec.get(ID))),))
        environment: Environment = place.build(self.registry, "environments")

        def make() -> AnyEnv:
            with place.blamed(self.registry, "environments", "an env was made"):
                return environment.make() if task else _env_of(path, facts)

        return make, lambda env: columns_of(environment, env, self.registry, self._of_arm.values())

    def _missing(self, facts: TrainingFacts, columns: Columns) -> Columns:
        """What is asked for and the recording does not have: at all, by other code, or not to its end."""
        rewards, measures = columns.rewards, columns.behaviour
        return _chosen(
            columns,
            [it for it in self._asked if _is_missing(facts, f"{REWARD}{it}", rewards.get(it))],
            [it for it in self._asked if _is_missing(facts, f"{BEHAVIOUR}{it}", measures.get(it))],
        )

    @cached_property
    def _of_arm(self) -> Mapping[str, Choice]:
        """Those of the names that are of an arm's rewards and of no function."""
        functions, known = {it.name for it in self.registry.functions}, self.registry.typed_names("rewards")
        asked = [name for name in self.names if parse(name)[0] in known and name not in functions]
        return {name: choose(self.registry, "rewards", name) for name in asked}

    @property
    def _asked(self) -> Sequence[str]:
        labels = [self._of_arm[name].label if name in self._of_arm else name for name in self.names]
        return labels or [it.name for it in self.registry.functions]

    def _refuse_unknown(self, path: Path, task: Choice | None) -> None:
        """Raise UsageError if a name is none of a function, and none of the environment of a recording."""
        if not set(self._asked).difference(it.name for it in self.registry.functions):
            return
        make, columns = self._made_by(facts_of(read_recording(path)), task, path)
        with closing(make()) as env:
            known = columns(env)
        for name in self._asked:
            if name not in {*known.rewards, *known.behaviour}:
                raise UsageError(unknown_name("reward or measure", name, {*known.rewards, *known.behaviour}))

    def _refuse_other_code(self, paths: Iterable[Path]) -> None:
        """Raise UsageError if a function has the name of a reward that trained with other code."""
        now = {name: it.make() for name, it in self.registry.functions_of("reward").items() if name in self._asked}
        for path in paths:
            for number in recorder_numbers(path):
                facts = read_facts(path, number)
                taken = facts.trained_with
                if taken in now and _differs(facts, f"{REWARD}{taken}", now[taken]):
                    raise UsageError(
                        f"The reward '{taken}' trained '{path}' with other code than it has now: give the new one "
                        "another name, or leave it out with --reward"
                    )


def _chosen(columns: Columns, rewards: Collection[str], behaviour: Collection[str]) -> Columns:
    """Those of these names."""
    return Columns(
        {name: columns.rewards[name] for name in rewards},
        {name: columns.behaviour[name] for name in behaviour},
        [it for it in behaviour if it in columns.lower_is_better],
        [it for it in behaviour if it in columns.higher_is_better],
    )


def _is_missing(facts: TrainingFacts, column: str, given: Given | None) -> bool:
    if given is None:
        return False
    failed = any(failure.column == column for failure in facts.failed)
    return failed or column not in facts.numbers or _differs(facts, column, given)


def _differs(facts: TrainingFacts, column: str, given: Given | None) -> bool:
    """Whether a recorded column was computed by other code; False where that is not known."""
    if given is None or column not in facts.sources:
        return False
    then, now = facts.sources[column].sha256, source_of(given).sha256
    return bool(then and now) and then != now


def _env_of(path: Path, facts: TrainingFacts) -> AnyEnv:
    """An env like the one that a recording tells of.

    Raises:
        UsageError: It cannot be made without its author's word; says what to give.
    """
    name = facts.spec.get(ID)
    remedy = "Name an environment that makes it, --task gymnasium:id=... or one of your own by --plugin"
    if not isinstance(name, str) or ":" in name or not isinstance(facts.spec.get(KWARGS, {}), dict):
        raise UsageError(f"'{path}' was recorded in the env {name!r}, which Gymnasium cannot make by itself. {remedy}")
    limit, is_batch = facts.spec.get(HORIZON), facts.spec.get(CLASS) in BATCHES
    given = {key: value for key, value in facts.spec.get(KWARGS, {}).items() if not (is_batch and key in OF_BATCH)}
    try:
        env = gymnasium.make(name, **given, **({} if limit is None else {HORIZON: limit}))
    except Exception as error:  # whatever constructors of envs raise
        raise UsageError(f"'{path}': gymnasium.make('{name}') fails: {one_line(error)}. {remedy}") from error
    now = env_facts(env)
    for what in (CLASS, WRAPPERS):
        if not is_batch and facts.spec.get(what) != now[what]:
            env.close()
            raise UsageError(
                f"'{path}' was recorded in an env of another {what}: {facts.spec.get(what)}, and gymnasium.make gives "
                f"{now[what]}. {remedy}"
            )
    return env
