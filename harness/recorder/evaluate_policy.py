"""`harness.evaluate_policy`: a finished policy acts, and what several rewards pay for it is recorded."""

import os
import shutil
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import gymnasium
from filelock import FileLock, Timeout

from harness.errors import StorageError, UsageError
from harness.eta.interval import Bounds
from harness.eta.manner import Acted
from harness.record.cell import EVALUATION_HORIZON
from harness.record.folder import partial_folder, publish
from harness.record.recording.recorded_training import facts_name, is_recording, read_facts, recording_files
from harness.recorder.env_facts import LEARNERS, OnError
from harness.recorder.record_rewards import RecordRewards
from harness.recorder.wrapped import tell_normalisation
from harness.reward.given import Given

EPISODES = 100
FIRST_SEED = 1_000_000_007
"""The seed of the first episode; the next one has the next. Trainings hardly ever use it."""


def evaluate_policy(
    policy: Callable[[Any], Any],
    env: gymnasium.Env[Any, Any] | str,
    path: str | os.PathLike[str],
    *,
    trained_with: str,
    seed: int,
    rewards: Mapping[str, Given],
    behaviour: Mapping[str, Given] | None = None,
    lower_is_better: Collection[str] = (),
    higher_is_better: Collection[str] = (),
    bounds: Mapping[str, Bounds] | None = None,
    episodes: int = EPISODES,
    on_error: OnError = "warn",
    learners: Collection[str] = LEARNERS,
    horizon: int = EVALUATION_HORIZON,
    acted: Acted = "",
    after: int = 0,
    first_seed: int = FIRST_SEED,
) -> None:
    """Record whole episodes of a finished policy; ``harness report`` then judges by them, not by the training.

    Every policy meets the same episodes: the env is reset with the same seeds. Reports say so where its first
    observations differ all the same.

    The folder appears under its name when all episodes are recorded. Until then it grows beside that, as
    ``.name.partial``. What a killed evaluation left there, the next one replaces; reports tell of it, and do not
    compare it.

    Args:
        policy: From an observation to an action; of stable-baselines3
            ``lambda observation: model.predict(observation, deterministic=True)[0]``.
        env: One that was made, which is left open, or the id of one.
        path: A folder for this evaluation, such as one inside that of the training.
        trained_with: The reward that taught the policy.
        seed: Of its training.
        rewards: Those that the training recorded; `trained_with` is one of them.
        behaviour: Its measures.
        lower_is_better: Names of measures of which less is better.
        higher_is_better: Names of those of which more is.
        bounds: The least and the greatest value of measures.
        episodes: How many.
        on_error: As of `RecordRewards`.
        learners: The same.
        horizon: Steps after which an episode that goes on is cut; reports say how many were.
        acted: ``"deterministic"``, ``"stochastic"``, or ``"random"`` for actions that no policy chose: reports show
            what these come to beside the trained policies. Empty where that is not known.
        after: Environment steps of training before it, if the training goes on; 0 for the final policy.
        first_seed: The seed that the env is reset with for the first episode; the next one has the next.

    Raises:
        UsageError: Something of that cannot be used, there is no such env, or `path` holds another recording.
        StorageError: The folder cannot be written.
    """
    if episodes < 1:
        raise UsageError(f"episodes={episodes}: it takes one at least")
    made = _make(env) if isinstance(env, str) else env
    try:
        with _grown_beside(Path(path)) as partial:
            recorded = RecordRewards(
                made,
                partial,
                trained_with=trained_with,
                rewards=rewards,
                behaviour=behaviour,
                lower_is_better=lower_is_better,
                higher_is_better=higher_is_better,
                bounds=bounds,
                seed=seed,
                evaluation=True,
                on_error=on_error,
                learners=learners,
                horizon=horizon,
                acted=acted,
                after=after,
                episodes_asked=episodes,
            )
            try:
                for line in tell_normalisation(made, Path(path), policy):
                    recorded.note(line)
                for number in range(first_seed, first_seed + episodes):
                    (observation, _), ended = recorded.reset(seed=number), False
                    while not ended:
                        observation, _, terminated, truncated, _ = recorded.step(policy(observation))
                        ended = terminated or truncated
            finally:
                recorded.finish()
    finally:
        if made is not env:
            made.close()


@contextmanager
def _grown_beside(path: Path) -> Iterator[Path]:
    """A folder for a recording, which gets its name when the block ends without an error and all was written.

    Raises:
        UsageError: There is a recording under that name, or another process is at work on one.
        StorageError: The folder cannot be written.
    """
    if is_recording(path):
        raise UsageError(f"'{path}' holds a recording already: name another path, or remove it")
    partial = partial_folder(path.absolute())
    with _told(path):
        _clear(path, partial)
    yield partial
    with _told(path):
        if not read_facts(partial).closed:  # it could not be written, which was told
            return
        if not path.exists():
            publish(partial, path)
            return
        for name in sorted(recording_files(partial), key=lambda name: name == facts_name(0)):  # which make it one
            os.replace(partial / name, path / name)
        shutil.rmtree(partial)


@contextmanager
def _told(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise StorageError(f"'{path}' cannot be written: {error.strerror or error}") from error


def _clear(path: Path, partial: Path) -> None:
    """Remove what a killed evaluation has left."""
    if not partial.exists():
        return
    try:
        with FileLock(partial / "recording-0.lock", timeout=0):
            pass
    except Timeout:
        raise UsageError(f"'{path}' is being recorded by another process: name another path, or wait") from None
    shutil.rmtree(partial)


def _make(name: str) -> gymnasium.Env[Any, Any]:
    try:
        return gymnasium.make(name)
    except gymnasium.error.Error as error:
        raise UsageError(f"env='{name}' cannot be made: {error}") from error
