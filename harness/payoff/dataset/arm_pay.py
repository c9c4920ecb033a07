"""An arm's reward pays a data set, by where the end effector and the target stand in its observations."""

from pathlib import Path

import numpy as np

from harness.errors import Unscored, UsageError
from harness.log import Rows
from harness.log.log import ACTION, OBSERVATION
from harness.payoff.dataset.steps import VECTORS, Payer, flat_rows, seen_after, vectors_of
from harness.registry.choice import Registry
from harness.reward import Paid, Reward
from harness.reward.reward import is_finite
from harness.reward.steps import ENDS, MissingField
from harness.score.places import JOINTS_DEG, ArmPay, ArmPlaces, fields_read, parse_places


def of_arm(reward: Reward, places: ArmPlaces) -> Payer:
    """An arm's reward, by where the end effector and the target stand in an observation.

    It pays all steps of a piece at once, unless it remembers something. Beside distances it may read ``action``,
    ``end_effector``, ``target``, ``qpos`` where the places name joints, and how a step ended where the data set tells.
    """
    pay, needed, is_lost = ArmPay(reward), fields_read(reward), False

    def paid(rows: Rows) -> Paid:
        nonlocal is_lost
        seen = seen_after(rows)
        after = vectors_of(rows.part(slice(seen)).columns, OBSERVATION)
        told = {**rows.columns, ACTION: flat_rows(rows, ACTION)}
        beside = {name: told[name] for name in (ACTION, *ENDS) if name in needed and name in told}
        with np.errstate(all="ignore"):  # what is not finite is refused by whoever asked
            try:
                if rows["step"][0] <= 1:
                    before = vectors_of(rows.part(slice(1)).columns, VECTORS[0])
                    begun = places.fields(before, needed)
                    begun |= {name: np.zeros_like(values[:1]) for name, values in beside.items()}
                    begin = places.distances(before)
                    is_lost = not is_finite((begin, begun))
                    pay.begin(begin[0], begun)
                if not seen:
                    return Paid(np.empty(0))
                more = places.fields(after, needed) | {name: values[:seen] for name, values in beside.items()}
                distances = places.distances(after)
                found = pay.pay(distances, more)
                is_lost = is_lost or not is_finite((distances, more))
                return Paid(np.full(seen, np.nan)) if is_lost else found
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
    from harness.robot.robot import load_robot

    arm = load_robot(Path(robot) if Path(robot).exists() else robot, registry)
    places = parse_places(text, arm.end_effector)
    if JOINTS_DEG in places.places and arm.chain.slides.any():
        raise UsageError(f"joints_deg, and robot '{arm.name}' has joints that slide: give joints, in rad and m")
    return places
