"""The factor that several rewards have."""

from typing import Annotated, TypeAlias

from pydantic import Field

from harness.reward import LARGEST_FACTOR

Factor: TypeAlias = Annotated[float, Field(gt=0, le=LARGEST_FACTOR, allow_inf_nan=False)]
