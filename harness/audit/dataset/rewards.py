"""What pays the steps of a data set: its own columns, functions of plugin files, and an arm's rewards."""

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from harness.errors import Unscored, UsageError
from harness.record.dataset.dataset import Dataset, Piece, each_row, leaves
from harness.recorder.column import as_number
from harness.recorder.sealed import ReadOnlyDict
from harness.recorder.trial import Guarded
from harness.registry.choice import choose
from harness.registry.registry import Registry
from harness.reward import MissingField, Paid, Reward, Steps
from harness.reward.given import Before, Given, Now, zeros_of
from harness.reward.steps import steps_type
from harness.score.places import JOINTS_DEG, ArmPay, ArmPlaces, fields_read, parse_places

OfPiece: TypeAlias = Callable[[Piece], Paid]
"""What a reward pays the steps of a piece, (steps,), and its terms. It is given the pieces in their order.

One that needs what was seen after a step leaves out the last of the piece, where nothing is known of that.
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


def as_recorded(name: str) -> OfPiece:
    """What was recorded under a name: also of the last step, whatever was seen after it."""
    return lambda piece: Paid(piece.rewards[name])


class _StepByStep:
    """A reward of a step of an environment, asked about one step after the other.

    A step has what is recorded. What was told before the first one of an episode, by its reset, is not.
    """

    def __init__(self, reward: Guarded) -> None:
        self._reward = reward
        self._before: Any = None

    def __call__(self, piece: Piece) -> Paid:
        if piece.first == 0:
            self._before = None
            if callable(reset := getattr(self._reward, "reset", None)):
                reset()
        for part in (*leaves(piece.observations), *leaves(piece.actions), *piece.infos.values()):
            part.setflags(write=False)
        seen, unseen = piece.seen, Unseen()
        if not any(part.size for part in leaves(piece.observations)):
            seen, unseen = len(piece), Unseen(NOT_SEEN)
            observations = iter([unseen] * (len(piece) + 1))
        else:
            observations = each_row(piece.observations)
        paid, observed = list[list[float]](), next(observations)
        for row, action in enumerate(each_row(piece.actions)):
            info = ReadOnlyDict({key: values[row] for key, values in piece.infos.items()})
            if self._before is None:
                before = _AtStart._make((observed, zeros_of(action)))
            else:
                before = Before._make((observed, *self._before))
            self._before, observed = (action, info), next(observations, unseen)
            step = Now._make((observed, action, info, before))
            if row < seen:
                paid.append(self._reward(step))
            elif (last := self._without_next(step, unseen)) is not None:
                paid.append(last)
        if unseen.looked_at and seen == len(piece):  # and went on
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


def step_by_step(name: str, given: Given) -> OfPiece:
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


def of_arm(reward: Reward, places: ArmPlaces) -> OfPiece:
    """An arm's reward, by where the end effector and the target stand in an observation.

    It pays all steps of a piece at once, unless it remembers something. Beside distances it may read ``action``,
    ``end_effector``, ``target``, and ``qpos`` where the places name joints.
    """
    pay, needed = ArmPay(reward), fields_read(reward)

    def paid(piece: Piece) -> Paid:
        far, seen = places.distances(piece.observations), piece.seen
        more = places.fields(piece.observations, needed)
        if "action" in needed and isinstance(piece.actions, np.ndarray):
            acted = np.asarray(piece.actions[:seen], np.float64).reshape(seen, -1)
            more["action"] = np.concatenate([np.zeros((1, acted.shape[1])), acted])
        with np.errstate(all="ignore"):  # what is not finite is refused by whoever asked
            try:
                if piece.first == 0:
                    pay.begin(far[0], {name: values[:1] for name, values in more.items()})
                if not seen:
                    return Paid(np.empty(0))
                return pay.pay(far[1:], {name: values[1:] for name, values in more.items()})
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
    dataset: Dataset, registry: Registry, names: Sequence[str], places: ArmPlaces | None, labelled: bool = True
) -> dict[str, OfPiece]:
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
    there = dataset.facts.rewards
    found: dict[str, OfPiece] = {}
    for name in names or (*there, *functions):
        if name in functions:
            found[name] = step_by_step(name, functions[name].make())
        elif name in there:
            found[name] = as_recorded(name)
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
        untold = not (dataset.facts.success or labelled)
        raise UsageError(
            f"{dataset.facts.name} has no recorded reward{', and nothing says which episodes succeeded' * untold}: "
            "give functions with --plugin FILE, or --reward NAME with --places MAP"
            f"{'; and labels with --labels episodes.csv, or --success KEY' * untold}.{f' {broken}' if broken else ''}"
        )
    return found


def given_rewards(rewards: Mapping[str, Any], places: ArmPlaces | None) -> dict[str, OfPiece]:
    """Rewards that Python gives: those of a step, see `harness.reward.given`, and those of an arm.

    Raises:
        UsageError: An arm's reward has no map of places.
    """
    found: dict[str, OfPiece] = {}
    for name, given in rewards.items():
        if not hasattr(given, "initial_carry"):
            found[name] = step_by_step(name, given)
        elif places is None:
            raise UsageError(f"The reward {name!r} needs places='end_effector=0:3,target=3:6'")
        else:
            found[name] = of_arm(given, places)
    return found
