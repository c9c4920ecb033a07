"""A target that has to be met more closely."""

from typing import Annotated

from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.reach import Positive, ReachTask


@dataclass(frozen=True)
class SmallTarget(ReachTask):
    """As `fd100-reach`, but within 1 cm of the target in place of 5 cm.

    A reward that pays next to nothing for the last centimetres leaves the arm beside the target here.
    """

    epsilon: Annotated[Positive, Field(description="the target is reached within this distance, NOTE eq. 20 [m]")] = (
        0.01
    )
