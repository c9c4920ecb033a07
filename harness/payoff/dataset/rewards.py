"""What pays the steps of a data set: its own columns, functions of plugin files, and an arm's rewards.

What asks functions, and what knows arms, is loaded only where one pays.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from harness.errors import UsageError
from harness.log import Log, Rows
from harness.log.log import REWARD
from harness.payoff.dataset.steps import Payer
from harness.record.dataset.open_dataset import dataset_facts
from harness.registry.choice import Registry, choose
from harness.reward import Paid

if TYPE_CHECKING:
    from harness.score.places import ArmPlaces


@dataclass(frozen=True)
class Recorded:
    """What was recorded under a name: also of the last step, whatever was seen after it."""

    name: str

    def __call__(self, rows: Rows) -> Paid:
        """The pay of some steps."""
        return Paid(rows[f"{REWARD}{self.name}"])


def rewards_of(
    dataset: Log, registry: Registry, names: Sequence[str], places: "ArmPlaces | None", labelled: bool = True
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
    facts, there = dataset_facts(dataset), dataset.rewards
    found: dict[str, Payer] = {}
    for name in names or (*there, *functions):
        if name in functions:
            found |= given_rewards({name: functions[name].make()}, places)
        elif name in there:
            found[name] = Recorded(name)
        else:
            choice = choose(registry, "rewards", name)
            found |= given_rewards({choice.label: choice.build(registry, "rewards")}, places)
    if not found:
        broken = " ".join(registry.broken_files())
        untold = not (facts.success or labelled)
        raise UsageError(
            f"{facts.name} has no recorded reward{', and nothing says which episodes succeeded' * untold}: "
            "give functions with --plugin FILE, or --reward NAME with --places MAP"
            f"{'; and labels with --labels episodes.csv, or --success KEY' * untold}.{f' {broken}' if broken else ''}"
        )
    return found


def given_rewards(rewards: Mapping[str, Any], places: "ArmPlaces | None") -> dict[str, Payer]:
    """Rewards as objects: those of a step, see `harness.reward.given`, and those of an arm.

    Raises:
        UsageError: An arm's reward has no map of places.
    """
    found: dict[str, Payer] = {}
    for name, given in rewards.items():
        if not hasattr(given, "initial_carry"):
            from harness.payoff.dataset.step_by_step import step_by_step

            found[name] = step_by_step(name, given)
        elif places is None:
            raise UsageError(
                f"The reward {name} is paid by the distance from the end effector to the target: say where they stand "
                "in the observation, --places end_effector=0:3,target=3:6"
            )
        else:
            from harness.payoff.dataset.arm_pay import of_arm

            found[name] = of_arm(given, places)
    return found
