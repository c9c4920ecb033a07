"""What pays the steps of a data set: its own columns, functions of plugin files, and an arm's rewards."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from harness.audit.dataset.steps import VECTORS, each_row, flat_rows, infos_of, seen_after, vectors_of
from harness.errors import Unscored, UsageError
from harness.log import Log, Rows
from harness.log.log import ACTION, OBSERVATION, REWARD
from harness.record.dataset.open_dataset import facts_of
from harness.recorder.column import as_number
from harness.recorder.sealed import ReadOnlyDict
from harness.recorder.trial import Guarded
from harness.registry.choice import choose
from harness.registry.registry import Registry
from harness.reward import MissingField, Paid, Reward, Steps
from harness.reward.given import Before, Given, Now, zeros_of
from harness.reward.steps import steps_type
from harness.score.places import JOINTS_DEG, ArmPay, ArmPlaces, fields_read, parse_places

Payer: TypeAlias = Callable[[Rows], Paid]
"""What a reward pays some steps of one episode, (steps,), and its terms. It is given all steps in their order.

One that needs what was seen after a step leaves out the last one, where nothing is known of that.
"""


class Unseen:
    """Stands where an observation is not known, and notices a function that looks at it."""

    def __init__(self, told: str = "nothing is known of what came after this step") -> None:
        self.looked_at, self._why = False, told

    def __getattr__(self, name: str) -> Any:
        self._look()

    def __deepcopy__(self, memo: Any) -> "Unseen":
        return self  # to copy is not to look: functions are given copies

    def _look(self, *_: Any) -> Any:
        self.looked_at = True
        raise LookupError(self._why)

    __array__ = __bool__ = __call__ = __contains__ = __float__ = __getitem__ = __index__ = __int__ = _look
    __iter__ = __len__ = __str__ = __repr__ = __neg__ = __abs__ = __eq__ = __ne__ = __lt__ = __le__ = __gt__ = _look
    __ge__ = __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = __truediv__ = __rtruediv__ = _look
    __pow__ = __matmul__ = __rmatmul__ = __hash__ = __format__ = _look


@dataclass(frozen=True)
class Recorded:
    """What was recorded under a name: also of the last step, whatever was seen after it."""

    name: str

    def __call__(self, rows: Rows) -> Paid:
        """Of some steps."""
        return Paid(rows[f"{REWARD}{self.name}"])


class _StepByStep:
    """A reward of a step of an environment, asked about one step after the other.

    A step has what is recorded. What was told before the first one of an episode, by its reset, is not.
    """

    def __init__(self, reward: Guarded) -> None:
        self._reward = reward
        self._before: Any = None

    def __call__(self, rows: Rows) -> Paid:
        if rows["step"][0] <= 1:
            self._before = None
            if callable(reset := getattr(self._reward, "reset", None)):
                reset()
        for values in rows.columns.values():
            values.setflags(write=False)
        count, seen, unseen = len(rows), seen_after(rows), Unseen()
        started, after = (vectors_of(rows.columns, name) for name in VECTORS[:2])
        if isinstance(after, dict) and not after:
            seen, unseen = count, Unseen(NOT_SEEN)
            observed, observations = unseen, iter([unseen] * count)
        else:
            observed, observations = next(each_row(started, 1)), each_row(after, count)
        infos, paid = infos_of(rows.columns), list[list[float]]()
        for row, action in enumerate(each_row(vectors_of(rows.columns, ACTION), count)):
            info = ReadOnlyDict({key: values[row] for key, values in infos.items()})
            if self._before is None:
                before = _AtStart._make((observed, zeros_of(action)))
            else:
                before = Before._make((observed, *self._before))
            now = next(observations)
            self._before, observed = (action, info), now if row < seen else unseen
            step = Now._make((observed, action, info, before))
            if row < seen:
                paid.append(self._reward(step))
            elif (last := self._without_next(step, unseen)) is not None:
                paid.append(last)
        if unseen.looked_at and seen == count:  # and went on
            unseen[0]
        numbers = np.array(paid).reshape(len(paid), 1 + len(self._reward.terms)).T
        return Paid(numbers[0], dict(zip(self._reward.terms, numbers[1:], strict=True)))

    def _without_next(self, step: Steps, unseen: Unseen) -> list[float] | None:
        """What it pays a step after which nothing was seen; None of one that looks at what came then."""
        try:
            paid = self._reward(step)
        except Exception:  # whatever it makes of what is not there
            return None
        return None if unseen.looked_at else paid


NOT_SEEN = "it looks at an observation, and the observations of this data set hold no numbers"
_AtStart = steps_type(("observation", "action"))


def step_by_step(name: str, given: Given) -> Payer:
    """A reward of an environment, see `harness.reward.given`, of this name.

    Raises:
        UsageError: It is none.
    """
    return _StepByStep(Guarded(given, name, number_or_nan))


def number_or_nan(value: Any) -> float:
    """One number; NaN where it is infinite too, since such a step has no pay, whatever the other steps have.

    Raises:
        ValueError: It is of another shape.
        TypeError: It is no number.
    """
    if isinstance(value, np.ndarray) and value.shape == ():
        value = value[()]
    return math.nan if isinstance(value, float | np.floating) and not math.isfinite(value) else as_number(value)


def of_arm(reward: Reward, places: ArmPlaces) -> Payer:
    """An arm's reward, by where the end effector and the target stand in an observation.

    It pays all steps of a piece at once, unless it remembers something. Beside distances it may read ``action``,
    ``end_effector``, ``target``, and ``qpos`` where the places name joints.
    """
    pay, needed = ArmPay(reward), fields_read(reward)

    def paid(rows: Rows) -> Paid:
        seen = seen_after(rows)
        after = vectors_of({name: values[:seen] for name, values in rows.columns.items()}, OBSERVATION)
        with np.errstate(all="ignore"):  # what is not finite is refused by whoever asked
            try:
                if rows["step"][0] <= 1:
                    before = vectors_of({name: values[:1] for name, values in rows.columns.items()}, VECTORS[0])
                    begun = places.fields(before, needed)
                    if "action" in needed:
                        begun["action"] = np.zeros_like(flat_rows(rows, ACTION)[:1])
                    pay.begin(places.distances(before)[0], begun)
                if not seen:
                    return Paid(np.empty(0))
                more = places.fields(after, needed)
                if "action" in needed:
                    more["action"] = flat_rows(rows, ACTION)[:seen]
                return pay.pay(places.distances(after), more)
            except MissingField as error:
                raise Unscored(str(error)) from error

    return paid


def places_of(text: str | None, robot: str | None, registry: Registry) -> ArmPlaces | None:
    """The map of places that a user typed; with a robot, its joints give the end effector.

    Raises:
        UsageError: A robot is named without a map, or one of the two is none.
    """
    if text is None:
        if robot is not None:
            raise UsageError(
                "--robot says where the end effector is if --places says where its joints stand: --places "
                "joints=0:6,target=6:9"
            )
        return None
    if robot is None:
        return parse_places(text)
    from harness.robot.load import load_robot

    arm = load_robot(Path(robot) if Path(robot).exists() else robot, registry)
    places = parse_places(text, arm.end_effector)
    if JOINTS_DEG in places.places and arm.chain.slides.any():
        raise UsageError(f"joints_deg, and robot '{arm.name}' has joints that slide: give joints, in rad and m")
    return places


def rewards_of(
    dataset: Log, registry: Registry, names: Sequence[str], places: ArmPlaces | None, labelled: bool = True
) -> dict[str, Payer]:
    """The rewards that pay a data set, by name.

    Args:
        dataset: It.
        registry: The plugins.
        names: Of functions, of an arm's rewards, or of recorded ones; without any: all that are recorded and all
            functions of plugin files.
        places: Where an arm's end effector and target stand.
        labelled: Whether something else than the data set says which episodes succeeded, or nobody asks.

    Raises:
        UsageError: A name is not known, or an arm's reward has no map of places.
    """
    functions = registry.functions_of("reward")
    facts, there = facts_of(dataset), dataset.rewards
    found: dict[str, Payer] = {}
    for name in names or (*there, *functions):
        if name in functions:
            found[name] = step_by_step(name, functions[name].make())
        elif name in there:
            found[name] = Recorded(name)
        else:
            choice = choose(registry, "rewards", name)
            if places is None:
                raise UsageError(
                    f"The reward {choice.label} is paid by the distance from the end effector to the target: say where "
                    "they stand in the observation, --places end_effector=0:3,target=3:6"
                )
            found[choice.label] = of_arm(choice.build(registry, "rewards"), places)
    if not found:
        broken = " ".join(registry.broken_files())
        untold = not (facts.success or labelled)
        raise UsageError(
            f"{facts.name} has no recorded reward{', and nothing says which episodes succeeded' * untold}: "
            "give functions with --plugin FILE, or --reward NAME with --places MAP"
            f"{'; and labels with --labels episodes.csv, or --success KEY' * untold}.{f' {broken}' if broken else ''}"
        )
    return found


def given_rewards(rewards: Mapping[str, Any], places: ArmPlaces | None) -> dict[str, Payer]:
    """Rewards that Python gives: those of a step, see `harness.reward.given`, and those of an arm.

    Raises:
        UsageError: An arm's reward has no map of places.
    """
    found: dict[str, Payer] = {}
    for name, given in rewards.items():
        if not hasattr(given, "initial_carry"):
            found[name] = step_by_step(name, given)
        elif places is None:
            raise UsageError(f"The reward {name!r} needs places='end_effector=0:3,target=3:6'")
        else:
            found[name] = of_arm(given, places)
    return found
