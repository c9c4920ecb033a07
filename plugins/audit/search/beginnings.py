"""What a search begins from: scripts, policies of people, what trainings have done."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium.spaces import Discrete

from harness.arrays import Ints
from harness.authoring.commands import TRAINING_RECORDING, facts_of, flat_observation, import_file, recordings_in
from harness.env import kinematics_policy, why_not_kinematics
from harness.errors import UsageError, reason_of
from harness.log import ACTION, BEHAVIOUR, REWARD, SUCCESS
from harness.motion import MoveJ
from harness.payoff import SCRIPTS, plan_actions
from harness.policy import CARD, Policy, load_policy
from harness.record import POLICY, Store, read_recording
from harness.registry import read_given
from harness.task import goal_of

from .arm_world import ArmWorld
from .world import Act, Actions, World

MOST_POLICIES, MOST_SEQUENCES = 12, 8
"""The most policies of a folder, and the most episodes of a recording: the best paid, the last ones, successes."""


@dataclass(frozen=True, eq=False)
class Beginning:
    """A behaviour to begin from: actions or a policy.

    Attributes:
        made_by: What it comes from, in words: ``script creep``.
        actions: Of one episode, of any length; None for a policy.
        act: A policy; None for actions.
        start: The start that the actions were made for; None for any.
    """

    made_by: str
    actions: Actions | None = None
    act: Act | None = None
    start: int | None = None


def scripts_of(world: ArmWorld, starts: Ints) -> list[Beginning]:
    """The scripted movements of an arm from each start, but the random one; and what its own kinematics do.

    None where a task asks for more than points, or its actions are of another kind: scripts move joints.
    """
    arm, found = world.arm, list[Beginning]()
    if not why_not_kinematics(arm.task, arm.robot):
        found.append(Beginning("inverse kinematics", act=acting(world, kinematics_policy(arm.task, arm.robot))))
    if goal_of(arm.task, arm.robot) is not None or not isinstance(arm.task.motion(arm.robot), MoveJ):
        return found
    qpos, target = world.places(starts)
    for script in SCRIPTS[:-1]:
        planned = plan_actions(script, arm.robot, arm.task, qpos, target, np.random.default_rng(0))
        decided = planned[:: arm.task.decision_period].swapaxes(0, 1)
        found += [Beginning(f"script {script}", it, start=int(at)) for it, at in zip(decided, starts, strict=True)]
    return found


def policies_of(world: World, policies: Mapping[str, Act]) -> list[Beginning]:
    """Policies that somebody wrote, by name: from an observation, as the env gives it, to an action.

    Raises:
        UsageError: One cannot be called.
    """
    found = list[Beginning]()
    for name, policy in policies.items():
        noun = f"policies: {name!r}"
        if not callable(policy):
            raise UsageError(f"{noun} is {policy!r}: give a function from an observation to an action")
        found.append(Beginning(f"policy {name}", act=_checked(world, policy, noun)))
    return found


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
        return Beginning(f"policy {name}", act=_checked(world, function, f"--policy {text}"))
    folder = next((it for it in (Path(text), Path(text) / POLICY) if (it / CARD).is_file()), None)
    if folder is None:
        raise UsageError(
            f"--policy {text}: write FILE.py:NAME for a function of an observation, or the folder of a policy or a cell"
        )
    act = acting(world, load_policy(folder))
    if refused := _why_not(world, act):
        raise UsageError(f"--policy {text} does not act in {world.name}: {refused}")
    return Beginning(f"policy {folder.name if folder.name != POLICY else folder.parent.name}", act=act)


def of_folder(world: World, folder: Path) -> list[Beginning]:
    """Policies of an experiment's finished cells that act in this world, and what recorded trainings have done.

    Raises:
        UsageError: There is nothing of that.
        SchemaError: Something of it is damaged.
    """
    found, recordings = list[Beginning](), sorted(recordings_in(folder))
    if Store.is_experiment(folder):
        store = Store.open(folder)
        done = [cell for cell in store.read_plan().cells if store.examine(cell).status == "done"]
        for cell in done:
            act = acting(world, load_policy(store.cell_folder(cell) / POLICY))
            if not _why_not(world, act):
                found.append(Beginning(f"policy trained with {cell.reward.label}, seed {cell.seed}", act=act))
        recordings = [it for it in recordings if it.name == TRAINING_RECORDING]
    found = found[:MOST_POLICIES]
    for path in recordings:
        found += _of_recording(world, path)
    if not found:
        raise UsageError(
            f"'{folder}' holds no policy and no recorded actions that fit {world.name}: name the folder of an "
            "experiment, or of trainings that harness.RecordRewards recorded, in the same environment or task"
        )
    return found


def acting(world: World, policy: Policy) -> Act:
    """A saved policy as a function of one observation: the one action of each."""
    return lambda seen: policy.act(flat_observation(world.observes, seen)[np.newaxis])[0]


def _checked(world: World, policy: Act, noun: str) -> Act:
    """A policy that somebody wrote; what it does wrong is said to be its fault, and not the environment's."""
    space = world.space

    def act(observed: Any) -> Any:
        try:
            action = policy(observed)
        except Exception as error:  # whatever functions of users raise
            raise UsageError(f"{noun} fails: {reason_of(error)}") from error
        numbers = np.asarray(action)
        fits = numbers.dtype.kind in "biuf" and numbers.size == np.prod(space.shape or ())
        if not fits or (isinstance(space, Discrete) and not space.contains(int(numbers.item()))):
            raise UsageError(f"{noun} gives {action!r}, which is no action of {world.name}: {space}")
        return action

    return act


def _why_not(world: World, act: Act) -> str:
    """Why a policy does not act in a world; empty if it does."""
    try:
        action = act(world.observes.sample())
    except Exception as error:  # sizes that do not fit, in whatever numpy says of it
        return reason_of(error)
    wanted = () if isinstance(world.space, Discrete) else world.space.shape
    return "" if np.shape(action) == wanted else f"its actions have the shape {np.shape(action)}, not {wanted}"


def _of_recording(world: World, path: Path) -> list[Beginning]:
    """The episodes of a recorded training that are best paid, that come last, and the last ones that succeed."""
    log = read_recording(path)
    if ACTION not in log:
        return []
    reward, success = f"{REWARD}{facts_of(log).trained_with}", f"{BEHAVIOUR}{SUCCESS}"
    rows = log.rows([ACTION, "env", "episode", reward, *([success] if success in log else [])])
    order = np.lexsort((rows["episode"], rows["env"]))  # steps of an episode stay in their order
    keys = np.stack([rows["env"], rows["episode"]])[:, order]
    parts = np.split(order, np.flatnonzero(np.any(np.diff(keys) != 0, axis=0)) + 1)
    last = np.array([part[-1] for part in parts])
    best = np.argsort([-np.nansum(rows[reward][part]) for part in parts], kind="stable")[:MOST_SEQUENCES]
    latest = np.argsort(-last)
    done = latest[rows[success][last[latest]] > 0.0] if success in log else latest[:0]
    chosen = dict.fromkeys([*best.tolist(), *latest[:MOST_SEQUENCES].tolist(), *done[:MOST_SEQUENCES].tolist()])
    shape = (-1, *(world.space.shape or ()))
    if int(np.prod(rows[ACTION].shape[1:])) != int(np.prod(shape[1:])):
        return []
    sequences = [rows[ACTION][parts[number]].reshape(shape).astype(world.space.dtype) for number in chosen]
    return [Beginning("recorded training", actions) for actions in sequences]
