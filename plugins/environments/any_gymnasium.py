"""Any environment that Gymnasium knows by an id."""

import json
from collections.abc import Mapping
from typing import Annotated, Any

import gymnasium
from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.environment import AnyEnv, Measure
from harness.errors import UsageError

OWN = "own"


@dataclass(frozen=True)
class AnyGymnasium:
    """What ``gymnasium.make(id)`` makes. Its rewards are what it pays, ``own``, and numbers that it tells in ``info``.

    An id behind a colon, as in ``id=(my_package:My-v0)``, has Python import the package that registers it.
    """

    id: Annotated[str, Field(min_length=1, description="the env's id, as Pendulum-v1")]
    pays: Annotated[
        str, Field(description="keys of info that are rewards too, with + between: reward_forward+reward_ctrl")
    ] = ""
    tells: Annotated[
        str, Field(description="keys of info that say what the robot does, with + between: success+distance")
    ] = ""
    lower: Annotated[str, Field(description="those of `tells` of which less is better, with + between")] = ""
    made_with: Annotated[
        str, Field(description="arguments of the env, with + between: frame_skip=4+reset_noise_scale=0.1")
    ] = ""

    @property
    def lower_is_better(self) -> frozenset[str]:
        """See `harness.environment.lower_is_better`."""
        return frozenset(_split(self.lower))

    def make(self) -> AnyEnv:
        """See `harness.environment.Environment`."""
        try:
            return gymnasium.make(self.id, **self._arguments())
        except (gymnasium.error.Error, ImportError, TypeError) as error:
            raise UsageError(f"gymnasium.make('{self.id}') fails: {error}") from error

    def rewards(self, env: AnyEnv) -> Mapping[str, Measure]:
        """See `harness.environment.Environment`."""
        return {OWN: OWN, **{key: key for key in _split(self.pays)}}

    def behaviour(self, env: AnyEnv) -> Mapping[str, Measure]:
        """See `harness.environment.Environment`."""
        return {key: key for key in _split(self.tells)}

    def _arguments(self) -> dict[str, Any]:
        found = {}
        for part in _split(self.made_with):
            key, equals, value = part.partition("=")
            if not (key and equals and value):
                raise UsageError(f"made_with={self.made_with}: '{part}' is malformed: write name=value+name=value")
            found[key] = _value_of(value)
        return found


def _split(text: str) -> list[str]:
    return [part.strip() for part in text.split("+") if part.strip()]


def _value_of(text: str) -> Any:
    """A number, true or false as JSON has them; else the text."""
    try:
        return json.loads(text)
    except ValueError:
        return text
