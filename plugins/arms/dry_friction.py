"""Dry friction in joints, solved together with the motion that it slows down."""

import numpy as np

from harness import Float

SWEEPS = 100
STILL = 1e-10
"""The sweeps end when one changes no joint's speed by more than this, [rad/s] or [m/s]."""


class DryFriction:
    """The impulses of dry friction in the joints of one arm, by projected Gauss-Seidel as in contact solvers."""

    def __init__(self, most: Float) -> None:
        """Start with impulses of 0.

        Args:
            most: The largest impulse of each joint, (dof,), [N m s] or [N s].
        """
        self._most = most.tolist()
        self.forget()

    def forget(self) -> None:
        """Let the next search start with impulses of 0."""
        self._impulses = [0.0] * len(self._most)

    @property
    def impulses(self) -> Float:
        """The impulses found last, (dof,), [N m s] or [N s], a new array. A positive one reduces a joint's speed."""
        return np.array(self._impulses)

    def slow(self, qvel: Float, mobility: Float) -> Float:
        """The joints' speeds with friction, (dof,): 0 where it can hold a joint still, else nearer to 0.

        Args:
            qvel: The speeds without friction, (dof,), [rad/s] or [m/s].
            mobility: How much an impulse of 1 at one joint changes the speeds of all joints, symmetric, (dof, dof).
        """
        impulses, rows = self._impulses, mobility.tolist()
        speeds: list[float] = (qvel - mobility @ impulses).tolist()
        for _ in range(SWEEPS):
            change = 0.0
            for joint, (row, most) in enumerate(zip(rows, self._most, strict=True)):
                needed = impulses[joint] + speeds[joint] / row[joint]
                impulse = min(max(needed, -most), most)
                step, impulses[joint] = impulse - impulses[joint], impulse
                if step:
                    speeds = [speed - step * share for speed, share in zip(speeds, row, strict=True)]
                    change = max(change, abs(step * row[joint]))
            if change <= STILL:
                break
        return np.array(speeds)
