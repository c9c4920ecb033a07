"""Dry friction in joints, solved together with the motion that it slows down."""

import numpy as np

from harness.arrays import Float

SWEEPS = 100
STILL = 1e-10
"""A sweep that changes no joint's speed by more is the last, [rad/s] or [m/s]."""


class DryFriction:
    """The impulses of dry friction in the joints of one arm; by projected Gauss-Seidel, as contact solvers do it."""

    def __init__(self, most: Float) -> None:
        """Rest.

        Args:
            most: The largest impulse of each joint, (dof,), [N m s] or [N s].
        """
        self._most = most.tolist()
        self.forget()

    def forget(self) -> None:
        """Start the next search anew."""
        self._impulses = [0.0] * len(self._most)

    @property
    def impulses(self) -> Float:
        """Those found last, which slow a joint with a positive speed where they are positive, (dof,), a new array."""
        return np.array(self._impulses)

    def slow(self, qvel: Float, mobility: Float) -> Float:
        """The joints' speeds after the friction: 0 where it can hold a joint still, else nearer to 0.

        Args:
            qvel: The speeds without it, (dof,), [rad/s] or [m/s].
            mobility: What an impulse at one joint does to the speeds of all, symmetric, (dof, dof).
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
