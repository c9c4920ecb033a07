"""What the algorithms of stable-baselines3 share: their training, and the policies that it yields.

Authors of other algorithms may use the names in `__all__` too. docs/authoring.md says what each name is, and what it
promises. Importing this package imports neither torch nor the library. They are imported when a name is first used.
"""

from typing import TYPE_CHECKING

from harness.face import face_of

if TYPE_CHECKING:
    from .callback import ProgressCallback as ProgressCallback
    from .policies import policy_from as policy_from
    from .training import train as train
    from .vec_env import VecEnvAdapter as VecEnvAdapter
    from .watch_callback import WatchCallback as WatchCallback
else:
    __all__, __getattr__ = face_of(__name__)

SOURCES = ("harness_plugins.sb3", "harness_plugins.torch_state")
"""The modules that the algorithms use besides their own. They count in the algorithms' hash."""
