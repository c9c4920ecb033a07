"""Any environment that Gymnasium knows by an id."""

import difflib
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, ClassVar

import gymnasium
import numpy as np
from gymnasium.spaces import Dict
from pydantic import Field
from pydantic.dataclasses import dataclass

from harness import Float
from harness.environment import AnyEnv, GoalReward
from harness.errors import UsageError
from harness.files import require_allowed
from harness.reward import Given

EXAMPLES = {
    "CartPole-v1": (),
    "InvertedPendulum-v5": ("mujoco", "imageio", "packaging"),
    "LunarLander-v3": ("Box2D", "pygame"),
    "ALE/Pong-v5": ("ale_py",),
}
"""An id of each family of environments, and the modules that it takes beside Gymnasium."""
MUJOCO = "gymnasium.envs.mujoco"
"""The module of Gymnasium's own MuJoCo environments."""
OWN, ACHIEVED, DESIRED = "own", "achieved_goal", "desired_goal"


@dataclass(frozen=True)
class AnyGymnasium:
    """The env that ``gymnasium.make(id)`` makes. Its rewards are ``own``, which it pays, and numbers in its ``info``.

    An id may name the package that registers it, as in ``id=(my_package:My-v0)``. Python then imports that package, if
    you typed the id or name the package with ``--allow-import``. It is not imported because a file says so.
    """

    id: Annotated[str, Field(min_length=1, description="id of the environment, such as Pendulum-v1")]
    pays: Annotated[
        str, Field(description="keys of the env's info that are rewards too, joined by +: reward_forward+reward_ctrl")
    ] = ""
    tells: Annotated[
        str, Field(description="keys of the env's info that measure behaviour, joined by +: success+distance")
    ] = ""
    lower: Annotated[str, Field(description="keys in `tells` for which a lower value is better, joined by +")] = ""
    higher: Annotated[str, Field(description="keys in `tells` for which a higher value is better, joined by +")] = ""
    made_with: Annotated[
        str, Field(description="arguments for gymnasium.make, joined by +: frame_skip=4+reset_noise_scale=0.1")
    ] = ""

    later: ClassVar[tuple[str, ...]] = ("higher",)

    @property
    def lower_is_better(self) -> frozenset[str]:
        """See `harness.environment.lower_is_better`."""
        return frozenset(_split(self.lower))

    @property
    def higher_is_better(self) -> frozenset[str]:
        """See `harness.environment.lower_is_better`."""
        return frozenset(_split(self.higher))

    @staticmethod
    def examples() -> Mapping[str, Sequence[str]]:
        """See `harness.environment.examples_of`: an env of each family that Gymnasium knows."""
        return {f"id={name}": modules for name, modules in EXAMPLES.items()}

    @staticmethod
    def knows(name: str) -> bool:
        """Whether a name is an id of Gymnasium, which is then short for this environment."""
        return name in gymnasium.registry

    @staticmethod
    def near(name: str) -> str:
        """What is nearest to a name, to add to a message: ids, or a file of the current folder; empty if nothing is."""
        module = name.partition(":")[0].removesuffix(".py")
        if Path(f"{module}.py") in Path().glob("*.py"):  # a name may be too long for a file
            return (
                f" For {module}.py of this folder type PYTHONPATH=. before harness, and --task "
                f"gymnasium:id={module}:ID with an id that it registers."
            )
        found = [] if name in gymnasium.registry else difflib.get_close_matches(name, gymnasium.registry)
        return f" Ids of Gymnasium: {', '.join(found)}." if found else ""

    def make(self) -> AnyEnv:
        require_allowed(self.id)
        try:
            return gymnasium.make(self.id, **self._arguments())
        except (gymnasium.error.Error, ImportError, TypeError) as error:
            more = f"{_remedy(self.id, error)}{self.near(self.id)}"
            raise UsageError(f"gymnasium.make('{self.id}') fails: {error}{more}") from error

    def rewards(self, env: AnyEnv) -> Mapping[str, Given]:
        return {OWN: OWN, **{key: key for key in _split(self.pays)}}

    def behaviour(self, env: AnyEnv) -> Mapping[str, Given]:
        return {key: key for key in _split(self.tells)}

    def goal_rewards(self, env: AnyEnv) -> Mapping[str, GoalReward]:
        """See `harness.environment.goal_rewards`: what an env with goals pays, by its ``compute_reward``.

        Empty if ``compute_reward`` needs more than the goals, or takes the goals of one step only.
        """
        space, compute = env.observation_space, getattr(env.unwrapped, "compute_reward", None)
        if compute is None or not (isinstance(space, Dict) and {ACHIEVED, DESIRED} <= space.spaces.keys()):
            return {}

        def own(achieved: Float, desired: Float) -> Any:
            return compute(achieved, desired, np.array([{} for _ in achieved]))

        goals = [np.zeros((2, *space[name].shape)) for name in (ACHIEVED, DESIRED)]  # type: ignore[misc] # boxes
        try:
            return {OWN: own} if np.shape(own(*goals)) == (2,) else {}
        except Exception:  # people's functions raise errors of many kinds
            return {}

    def _arguments(self) -> dict[str, Any]:
        found = {}
        for part in _split(self.made_with):
            key, equals, value = part.partition("=")
            if not (key and equals and value):
                raise UsageError(f"made_with={self.made_with}: '{part}' is malformed: write name=value+name=value")
            found[key] = _value_of(value)
        return found


def _remedy(name: str, error: Exception) -> str:
    """What to install where a library is missing, to follow on the message; empty if none is."""
    if not isinstance(error, ImportError | gymnasium.error.DependencyNotInstalled):
        return ""
    spec = gymnasium.registry.get(name)
    if spec is not None and str(spec.entry_point).startswith(MUJOCO):
        return ". pip install 'fd100-harness[gymnasium]'"
    return f". pip install {error.name}" if isinstance(error, ImportError) and error.name else ""


def _split(text: str) -> list[str]:
    return [part.strip() for part in text.split("+") if part.strip()]


def _value_of(text: str) -> Any:
    """The value that `text` has in JSON, such as a number, true or false; else the text itself."""
    try:
        return json.loads(text)
    except ValueError:
        return text
