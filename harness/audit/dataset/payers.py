"""What pays the steps of a data set: its own columns, functions of plugin files, and an arm's rewards."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from harness.arrays import Float
from harness.errors import UsageError
from harness.record.dataset.dataset import Dataset, Piece, each_row, leaves, take_rows
from harness.recorder.column import as_number
from harness.recorder.trial import Guarded
from harness.registry.choice import choose
from harness.registry.registry import Registry
from harness.reward import Reward
from harness.score.places import JOINTS_DEG, ArmPay, ArmPlaces, parse_places


class Payer(Protocol):
    """Pays the pieces of a data set in their order."""

    def pay(self, piece: Piece) -> Float:
        """What it pays the steps of a piece, (steps,).

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


@dataclass(frozen=True)
class Recorded:
    """What was recorded.

    Attributes:
        name: Of the recorded reward.
    """

    name: str

    def pay(self, piece: Piece) -> Float:
        """The column."""
        return piece.rewards[self.name]  # also of the last step, whatever was seen after it


@dataclass(frozen=True)
class Stepwise:
    """A function of (observation, action, next_observation, info).

    Attributes:
        function: It; with ``reset()`` if it remembers something of the episode.
    """

    function: Any

    def pay(self, piece: Piece) -> Float:
        """One step after the other."""
        if piece.first == 0 and callable(reset := getattr(self.function, "reset", None)):
            reset()
        for part in (*leaves(piece.observations), *leaves(piece.actions), *piece.infos.values()):
            part.setflags(write=False)
        count, paid = piece.seen, np.empty(len(piece))
        infos = piece.infos.items()
        if not any(part.size for part in leaves(piece.observations)):
            return self._without_seeing(piece)
        seen, done = each_row(piece.observations), each_row(piece.actions)
        before = next(seen)
        for row, after in enumerate(seen):
            info = {key: values[row] for key, values in infos}
            paid[row] = number_or_nan(self.function(before, next(done), after, info))
            before = after
        if count == len(piece):
            return paid
        last = self._without_next(before, take_rows(piece.actions, count), {key: it[count] for key, it in infos})
        paid[count:] = np.nan if last is None else last
        return paid[:count] if last is None else paid

    def _without_seeing(self, piece: Piece) -> Float:
        """What it pays by actions and infos alone.

        Raises:
            LookupError: It looks at an observation.
        """
        paid = np.empty(len(piece))
        for row, action in enumerate(each_row(piece.actions)):
            unseen = Unseen("it looks at an observation, and the observations of this data set hold no numbers")
            info = {key: values[row] for key, values in piece.infos.items()}
            paid[row] = number_or_nan(self.function(unseen, action, unseen, info))
            if unseen.looked_at:  # and went on
                unseen[0]
        return paid

    def _without_next(self, observation: Any, action: Any, info: Mapping[str, Any]) -> float | None:
        """What it pays a step after which nothing was seen; None of a function that looks at what came then."""
        unseen = Unseen()
        try:
            paid = number_or_nan(self.function(observation, action, unseen, info))
        except Exception:  # whatever it makes of what is not there
            return None
        return None if unseen.looked_at else paid


def number_or_nan(value: Any) -> float:
    """One number; NaN where it is infinite too, since such a step has no pay, whatever the other steps have.

    Raises:
        ValueError: It is of another shape.
        TypeError: It is no number.
    """
    if isinstance(value, np.ndarray) and value.shape == ():
        value = value[()]
    return math.nan if isinstance(value, float | np.floating) and not math.isfinite(value) else as_number(value)


@dataclass
class OfArm:
    """An arm's reward.

    Attributes:
        reward: It.
        places: Where the end effector and the target stand in an observation.
    """

    reward: Reward
    places: ArmPlaces
    _pay: ArmPay = field(init=False)

    def __post_init__(self) -> None:
        self._pay = ArmPay(self.reward)

    def pay(self, piece: Piece) -> Float:
        """All steps of the piece at once, unless the reward remembers something."""
        far = self.places.distances(piece.observations)
        if piece.first == 0:
            self._pay.begin(far[0])
        if not piece.seen:
            return np.empty(0)
        with np.errstate(all="ignore"):  # what is not finite is refused by whoever asked
            return self._pay.pay(far[1:])


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


def payers_of(
    dataset: Dataset, registry: Registry, names: Sequence[str], places: ArmPlaces | None, labelled: bool = True
) -> dict[str, Payer]:
    """What pays the data set, by name.

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
    recorded = dataset.facts.rewards
    found: dict[str, Payer] = {}
    for name in names or (*recorded, *functions):
        if name in functions:
            found[name] = Stepwise(Guarded(functions[name].make(), f"reward '{name}'"))
        elif name in recorded:
            found[name] = Recorded(name)
        else:
            choice = choose(registry, "rewards", name)
            if places is None:
                raise UsageError(
                    f"The reward {choice.label} is paid by the distance from the end effector to the target: say where "
                    "they stand in the observation, --places end_effector=0:3,target=3:6"
                )
            found[choice.label] = OfArm(choice.build(registry, "rewards"), places)
    if not found:
        broken = " ".join(registry.broken_files())
        untold = not (dataset.facts.success or labelled)
        raise UsageError(
            f"{dataset.facts.name} has no recorded reward{', and nothing says which episodes succeeded' * untold}: "
            "give functions with --plugin FILE, or --reward NAME with --places MAP"
            f"{'; and labels with --labels episodes.csv, or --success KEY' * untold}.{f' {broken}' if broken else ''}"
        )
    return found


def given_payers(rewards: Mapping[str, Any], places: ArmPlaces | None) -> dict[str, Payer]:
    """Rewards that Python gives: functions of a step, and rewards of an arm.

    Raises:
        UsageError: An arm's reward has no map of places.
    """
    found: dict[str, Payer] = {}
    for name, given in rewards.items():
        if not hasattr(given, "initial_carry"):
            found[name] = Stepwise(Guarded(given, f"reward '{name}'"))
        elif places is None:
            raise UsageError(f"The reward {name!r} needs places='end_effector=0:3,target=3:6'")
        else:
            found[name] = OfArm(given, places)
    return found
