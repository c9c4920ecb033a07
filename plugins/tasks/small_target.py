"""The reach task with a smaller target."""

from typing import Annotated

from pydantic import Field, PositiveFloat
from pydantic.dataclasses import dataclass

from harness.task import ReachTask


@dataclass(frozen=True)
class SmallTarget(ReachTask):
    """The task `fd100-reach` with a target of 1 cm instead of 5 cm.

    Under a reward that pays almost nothing for the last centimetres, the arm stops beside the target.
    """

    epsilon: Annotated[
        PositiveFloat, Field(description="distance within which the target is reached, NOTE eq. 20 [m]")
    ] = 0.01
