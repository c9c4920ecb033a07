"""What the algorithms of stable-baselines3 share: their training, and the policies that it yields.

Authors of other algorithms may use the names in `__all__` too. docs/authoring.md says what each name is, and what it
promises. Importing this package imports neither torch nor the library. They are imported when a name is first used.
"""

from typing import TYPE_CHECKING

from harness.authoring.face import lazy_names

if TYPE_CHECKING:
    from .callback import ProgressCallback
    from .policies import categorical, deterministic, gaussian, greedy, squashed_gaussian
    from .training import train
    from .vec_env import VecEnvAdapter
    from .watch_callback import WatchCallback

__all__ = [
    "ProgressCallback",
    "VecEnvAdapter",
    "WatchCallback",
    "categorical",
    "deterministic",
    "gaussian",
    "greedy",
    "squashed_gaussian",
    "train",
]

SOURCES = ("harness_plugins.sb3", "harness_plugins.torch_state", "harness_plugins.episode_means")
"""The modules that the algorithms use besides their own. They count in the algorithms' hash."""

_POLICIES = ("categorical", "deterministic", "gaussian", "greedy", "squashed_gaussian")
_HOMES = {
    **dict.fromkeys(_POLICIES, "harness_plugins.sb3.policies"),
    "ProgressCallback": "harness_plugins.sb3.callback",
    "VecEnvAdapter": "harness_plugins.sb3.vec_env",
    "WatchCallback": "harness_plugins.sb3.watch_callback",
    "train": "harness_plugins.sb3.training",
}
"""Names that were given up. They are kept for one minor version."""

__getattr__ = lazy_names("harness_plugins.sb3", _HOMES)
