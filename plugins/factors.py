"""The factor that several rewards have."""

from typing import Annotated, TypeAlias

from pydantic import Field

from harness.reward import Pay

Factor: TypeAlias = Annotated[Pay, Field(gt=0)]
