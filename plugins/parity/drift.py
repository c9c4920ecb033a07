"""How far two tracks of the same motion are apart, over time."""

from dataclasses import dataclass

import numpy as np

from harness.arrays import Float

from .track import Track


@dataclass(frozen=True, eq=False)
class Drift:
    """Distance of tips and joints of two tracks.

    Attributes:
        tip: (rows, episodes), [m].
        joint: That of the joint farthest off, (rows, episodes), [rad]; of a slide the share of its range, as of a turn.
    """

    tip: Float
    joint: Float

    @property
    def max_tip_error_m(self) -> float:
        """Over all episodes and rows, [m]."""
        return float(self.tip.max())

    @property
    def mean_tip_error_m(self) -> float:
        """Over all episodes and rows but the first, where nobody has moved yet, [m]."""
        return float(self.tip[1:].mean())

    @property
    def max_joint_error_rad(self) -> float:
        """Over all episodes, rows and joints, [rad]."""
        return float(self.joint.max())

    def curves(self) -> dict[str, Float]:
        """Over the episodes at each row, the start included: (rows,) each."""
        return {
            "max_tip_error_m": self.tip.max(axis=1),
            "mean_tip_error_m": self.tip.mean(axis=1),
            "max_joint_error_rad": self.joint.max(axis=1),
        }


def drift_between(first: Track, second: Track, per_radian: Float | float = 1.0) -> Drift:
    """How far two tracks of one motion are apart; `per_radian` is that of `harness.robot.Robot`, (dof,)."""
    tip = np.linalg.norm(first.tip - second.tip, axis=-1)
    return Drift(np.asarray(tip), (np.abs(first.qpos - second.qpos) / per_radian).max(axis=-1))
