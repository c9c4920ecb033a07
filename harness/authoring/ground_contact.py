"""Whether a robot touches the ground, for simulators whose engine does not report contact."""

from numpy.typing import ArrayLike

from harness.arrays import Float, Mask
from harness.robot import Robot
from harness.robot.ground_clearance import build_solids
from harness.robot.kinematics import link_frames


class GroundContact:
    """The collision shapes of a robot's moving links against the plane z = 0, without an engine.

    The results are exact for boxes, cylinders, capsules, spheres and meshes. Links that no joint moves do not count:
    they may reach into the ground.
    """

    def __init__(self, robot: Robot) -> None:
        """Prepare the shapes, once for any number of poses.

        Args:
            robot: The arm.
        """
        self._chain, self._solids = robot.chain, build_solids(robot.joint_shapes)

    def __call__(self, qpos: ArrayLike) -> Mask:
        """Whether any shape reaches below the ground, shape (n,), a new array; arguments as for `clearance`."""
        return self._solids.touch_ground(link_frames(self._chain, qpos))

    def clearance(self, qpos: ArrayLike) -> Float:
        """Height of the lowest point of all shapes, negative below the ground.

        Args:
            qpos: Joint positions, [rad] or, where a joint slides, [m], shape (n, dof).

        Returns:
            [m], shape (n,), a new array; inf for a robot without shapes.

        Raises:
            UsageError: qpos has another shape.
        """
        return self._solids.lowest(link_frames(self._chain, qpos))
