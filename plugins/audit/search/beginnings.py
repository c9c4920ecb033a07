"""What a search begins from beside scripts: policies of people, what trainings have done."""

from collections import Counter
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium.spaces import Discrete

from harness.errors import UsageError, reason_of
from harness.experiment.environments.spaces import rows_of
from harness.log.log import ACTION, BEHAVIOUR, REWARD, SUCCESS, episode_rows
from harness.policy import load_policy
from harness.record import POLICY, Store, read_recording
from harness.record.folder import CARD, TRAINING_RECORDING
from harness.record.recording.facts import facts_of
from harness.record.recording.recorded_training import recordings_in
from harness.registry import read_given
from harness.registry.plugin_module import import_file

from .world import Act, Beginning, World

MOST_POLICIES, MOST_SEQUENCES = 12, 8
"""The most policies of a folder, and the most episodes of a recording: the best paid, the last ones, successes."""


def policy_of(world: World, name: str, policy: Act) -> Beginning:
    """A policy that somebody wrote: from an observation, as the env gives it, to an action.

    Raises:
        UsageError: It cannot be called.
    """
    noun = f"policies: {name!r}"
    if not callable(policy):
        raise UsageError(f"{noun} is {policy!r}: give a function from an observation to an action")
    return _checked(world, name, policy, noun)


def policy_named(world: World, text: str) -> Beginning:
    """What ``--policy`` says: ``FILE.py:NAME``, a function of an observation; or the folder of a saved policy.

    Raises:
        UsageError: There is none, or it does not act in this world.
    """
    path, colon, name = text.rpartition(":")
    if colon and path.endswith(".py"):
        (file,) = read_given([path])
        function = getattr(import_file(file), name, None)  # type: ignore[arg-type] # a file was read
        if not callable(function):
            raise UsageError(f"--policy {text}: '{path}' has no function '{name}'")
        return _checked(world, name, function, f"--policy {text}")
    folder = next((it for it in (Path(text), Path(text) / POLICY) if (it / CARD).is_file()), None)
    if folder is None:
        raise UsageError(
            f"--policy {text}: write FILE.py:NAME for a function of an observation, or the folder of a policy or a cell"
        )
    act, refused = _saved(world, folder)
    if refused:
        raise UsageError(f"--policy {text} does not act in {world.name}: {refused}")
    return Beginning(f"policy {folder.name if folder.name != POLICY else folder.parent.name}", act=act)


def of_folder(world: World, folder: Path) -> tuple[list[Beginning], list[str]]:
    """Policies of an experiment's finished cells that act in this world, and what recorded trainings have done.

    Returns:
        They, and a line on those from which no search begins, if there are some.

    Raises:
        UsageError: There is nothing of that.
        SchemaError: Something of it is damaged.
    """
    found, recordings, refused = list[Beginning](), sorted(recordings_in(folder)), Counter[str]()
    if Store.is_experiment(folder):
        store = Store.open(folder)
        done = [cell for cell in store.read_plan().cells if store.examine(cell).status == "done"]
        for cell in done:
            act, why = _saved(world, store.cell_folder(cell) / POLICY)
            if why:
                refused[why] += 1
            else:
                found.append(Beginning(f"policy trained with {cell.reward.label}, seed {cell.seed}", act=act))
        recordings = [it for it in recordings if it.name == TRAINING_RECORDING]
    found = found[:MOST_POLICIES]
    for path in recordings:
        try:
            found += _of_recording(world, path)
        except UsageError as error:
            refused[str(error)] += 1
    left_out = ", ".join(f"{count} ({why})" for why, count in refused.items())
    if not found:
        raise UsageError(
            f"'{folder}' holds no policy and no recorded actions that fit {world.name}; there is "
            f"{left_out or 'nothing'}. Name the folder of an experiment, or of trainings that harness.RecordRewards "
            "recorded, in the same environment or task"
        )
    told = f"Of the policies and recorded trainings in '{folder}' the search leaves out {left_out}."
    return found, [told] * bool(left_out)


def _saved(world: World, folder: Path) -> tuple[Act, str]:
    """A saved policy as a function of one observation, and why it does not act in a world; empty if it does."""
    policy, rows = load_policy(folder), rows_of(world.observes)

    def act(observed: Any) -> Any:
        return policy.act(rows.batch(observed))[0]

    wanted = () if isinstance(world.space, Discrete) else world.space.shape
    try:
        shape = np.shape(act(world.observes.sample()))
    except Exception as error:  # sizes that do not fit, in whatever numpy says of it
        return act, reason_of(error)
    return act, "" if shape == wanted else f"its actions have the shape {shape}, not {wanted}"


def _checked(world: World, name: str, policy: Act, noun: str) -> Beginning:
    """A policy that somebody wrote; what it does wrong is said to be its fault, and not the environment's."""

    def act(observed: Any) -> Any:
        try:
            action = policy(observed)
        except Exception as error:  # whatever functions of users raise
            raise UsageError(f"{noun} fails: {reason_of(error)}") from error
        with suppress(Exception):  # whatever a space raises of what is not in it
            return _fitting(world, action)
        raise UsageError(f"{noun} gives {action!r}, which is no action of {world.name}: {world.space}")

    return Beginning(f"policy {name}", act=act)


def _fitting(world: World, action: Any) -> Any:
    """An action of somebody's as the world has it.

    Raises:
        ValueError: It is none.
    """
    taken, space = np.asarray(world.written(action)), world.space
    fits = taken.dtype.kind in "biuf" and taken.size == np.prod(space.shape or ())
    if not fits or (isinstance(space, Discrete) and not space.contains(int(taken.item()))):
        raise ValueError(f"{action!r} is not in {space}")
    return taken


def _of_recording(world: World, path: Path) -> list[Beginning]:
    """The episodes of a recorded training that are best paid, that come last, and the last ones that succeed.

    Raises:
        UsageError: It does not hold its actions, or they are none of this world.
    """
    log = read_recording(path)
    facts = facts_of(log)
    problem = facts.actions.problem if facts.actions else "it does not hold its actions"
    if problem:  # from there on only zeros are noted
        raise UsageError(problem)
    reward, success = f"{REWARD}{facts.trained_with}", f"{BEHAVIOUR}{SUCCESS}"
    rows = log.rows([ACTION, "env", "episode", reward, *([success] if success in log else [])])
    parts = episode_rows(rows["env"], rows["episode"])
    last = np.array([part[-1] for part in parts])
    best = np.argsort([-np.nansum(rows[reward][part]) for part in parts], kind="stable")[:MOST_SEQUENCES]
    latest = np.argsort(-last)
    done = latest[rows[success][last[latest]] > 0.0] if success in log else latest[:0]
    chosen = dict.fromkeys([*best.tolist(), *latest[:MOST_SEQUENCES].tolist(), *done[:MOST_SEQUENCES].tolist()])
    shape = (-1, *(world.space.shape or ()))
    try:
        sequences = [np.array([_fitting(world, it) for it in rows[ACTION][parts[number]]]) for number in chosen]
        return [Beginning("recorded training", [it.reshape(shape).astype(world.space.dtype)]) for it in sequences]
    except Exception as error:  # whatever a space raises of actions of another one
        raise UsageError(f"its actions are none of {world.space}") from error
