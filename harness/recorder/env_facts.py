"""What is written down of an env beside its steps, its spec and versions, and what a caller asks of the recorder."""

import json
import os
import platform
import sys
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import gymnasium
import numpy as np
import pyarrow as pa
from gymnasium.vector import SyncVectorEnv

import harness
from harness.errors import UsageError
from harness.eta.interval import Bounds, are_bounds
from harness.eta.laws import direction_of
from harness.eta.manner import ACTED, Acted
from harness.log.log import BEHAVIOUR, REWARD, SUCCESS
from harness.recorder.gate import Gate
from harness.reward.given import OWN, Given

LEARNERS = ("stable_baselines3", "sb3_contrib", "sbx", "torch", "jax", "ray")
"""Their versions are noted where something has imported them."""


def env_facts(env: Any) -> dict[str, Any]:
    """Class, id, arguments, horizon and wrappers of an env, single or vector, as JSON has them."""
    one = env.unwrapped.envs[0] if isinstance(env.unwrapped, SyncVectorEnv) else env  # they are all the same
    kind, spec = type(env.unwrapped), env.spec or one.spec
    facts: dict[str, Any] = {"class": f"{kind.__module__}.{kind.__qualname__}", "wrappers": _wrappers(env)}
    if spec is not None:
        facts |= {"id": spec.id, "kwargs": plain(spec.kwargs), "max_episode_steps": spec.max_episode_steps}
    return facts


def _wrappers(env: Any) -> list[str]:
    """Names of their classes, the outermost first, but for the gate, which changes nothing."""
    names = []
    while isinstance(env, (gymnasium.Wrapper, gymnasium.vector.VectorWrapper)):
        names += [] if isinstance(env, Gate) else [type(env).__name__]
        env = env.env
    return names


def normalises(facts: Mapping[str, Any]) -> bool:
    """Whether a wrapper normalises observations by those that it has seen, so that equal starts look different."""
    return any("Normalize" in name for name in facts["wrappers"])


def plain(value: Any) -> Any:
    """`value` as JSON has it; of what JSON has not, the name of its class: no address, no place on a disk."""
    if isinstance(value, dict):
        return {str(key): plain(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(inner) for inner in value]
    if isinstance(value, (np.ndarray, np.generic)):
        return plain(value.tolist())
    try:
        json.dumps(value, allow_nan=False)
    except (TypeError, ValueError):
        return repr(value) if isinstance(value, float) else f"{type(value).__module__}.{type(value).__qualname__}"
    return value


def versions_of(env: Any, learners: Collection[str] = LEARNERS) -> dict[str, str]:
    """The versions of Python, of what records, of the env's package and of those `learners` that are loaded."""
    home = type(env.unwrapped).__module__.partition(".")[0]
    loaded = {name: getattr(sys.modules.get(name), "__version__", None) for name in (home, *learners)}
    return {
        "python": platform.python_version(),
        "fd100-harness": harness.__version__,
        "gymnasium": gymnasium.__version__,
        "numpy": np.__version__,
        "pyarrow": pa.__version__,
        **{name: str(version) for name, version in loaded.items() if version is not None},
    }


@dataclass(frozen=True)
class Columns:
    """What is recorded of each step of one env.

    Attributes:
        rewards: By name.
        behaviour: By name; the measure that decides first.
        lower_is_better: Names of the measures of which less is better.
        higher_is_better: The same of more.
        bounds: By name of a measure, the least and the greatest value that it can have.
    """

    rewards: Mapping[str, Given]
    behaviour: Mapping[str, Given]
    lower_is_better: Collection[str] = ()
    higher_is_better: Collection[str] = ()
    bounds: Mapping[str, Bounds] = field(default_factory=dict)

    @property
    def names(self) -> tuple[str, ...]:
        """What a log calls them: of the rewards, then of the measures."""
        return (*(f"{REWARD}{name}" for name in self.rewards), *(f"{BEHAVIOUR}{name}" for name in self.behaviour))


OnError = Literal["warn", "raise"]


@dataclass(frozen=True)
class Asked:
    """Their arguments; `harness.recorder.record_rewards.RecordRewards` says what each one is.

    Raises:
        UsageError: One of them cannot be used.
    """

    path: str | os.PathLike[str]
    trained_with: str
    rewards: Mapping[str, Given]
    behaviour: Mapping[str, Given]
    lower_is_better: Collection[str]
    seed: int | None
    evaluation: bool
    pay: bool
    number: int
    resume: bool
    on_error: OnError
    batched: Collection[str] = ()
    bounds: Mapping[str, Bounds] = field(default_factory=dict)
    learners: Collection[str] = LEARNERS
    horizon: int | None = None
    acted: Acted = ""
    after: int = 0
    steps_asked: int = 0
    episodes_asked: int = 0
    watch: bool = False
    higher_is_better: Collection[str] = ()

    def __post_init__(self) -> None:
        if self.on_error not in {"warn", "raise"}:
            raise UsageError(f"on_error={self.on_error!r}: it is 'warn' or 'raise'")
        if not isinstance(self.number, int) or self.number < 0:
            raise UsageError(f"number={self.number!r}: recorders of one training are numbered 0, 1, 2 ...")
        if self.horizon is not None and self.horizon < 1:
            raise UsageError(f"horizon={self.horizon!r}: an episode has one step at least; None: it is never cut")
        if self.acted not in ACTED:
            raise UsageError(f"acted={self.acted!r}: it is one of {', '.join(map(repr, ACTED))}")
        if not isinstance(self.after, int) or self.after < 0:
            raise UsageError(f"after={self.after!r}: it is a number of environment steps; 0: all of the training")
        self._require_amounts()
        if (self.acted or self.after) and not self.evaluation:
            raise UsageError("acted and after tell of an evaluation: say evaluation=True too")
        for argument in ("lower_is_better", "higher_is_better", "bounds"):
            for name in getattr(self, argument):
                if name not in self.behaviour:
                    raise UsageError(
                        f"{argument} names {name!r}, which is none of the measures {sorted(self.behaviour)}"
                    )
        for name, given in self.bounds.items():
            if not are_bounds(given):
                raise UsageError(f"bounds of {name!r} are {given!r}: give two numbers, the lower one first")
        if self.trained_with not in {*self.rewards, OWN}:
            raise UsageError(
                f"trained_with={self.trained_with!r} is none of the rewards {sorted(self.rewards)}: name one of them, "
                f'or record what the env pays under this name, rewards={{..., "{self.trained_with}": "{OWN}"}}'
            )

    def _require_amounts(self) -> None:
        for name in ("steps_asked", "episodes_asked"):
            amount = getattr(self, name)
            if not isinstance(amount, int) or isinstance(amount, bool) or amount < 0:
                raise UsageError(f"{name}={amount!r}: it is a whole number; 0: not known")
        if self.steps_asked if self.evaluation else self.episodes_asked:
            raise UsageError("steps_asked goes with a training, and episodes_asked with evaluation=True")

    @property
    def undirected(self) -> str:
        """The measure that decides, the first one, if nobody says which of its values are better; else empty."""
        first = next(iter(self.behaviour), "")
        said = direction_of(first, self.lower_is_better, self.higher_is_better, is_flag=first == SUCCESS)
        return "" if said or self.evaluation else first

    @property
    def all_rewards(self) -> dict[str, Given]:
        """Those given, and under the name ``own`` what the env pays where the learner is trained with that."""
        own = {} if self.trained_with in self.rewards else {OWN: OWN}
        return {**self.rewards, **own}
