"""Built-in simulators."""

import harness


@harness.hookimpl
def register_simulators(register: harness.Register) -> None:
    """Announce the built-in simulators."""
    register(
        "dm_control",
        "harness_plugins.simulators.dm_control:DmControl",
        summary="engine MuJoCo: dm_control's Physics and control.Environment, one per arm; moves as mujoco does",
        requires=("dm_control", "mujoco>=3.17"),
        extra="dm-control",
    )
    register(
        "drake",
        "harness_plugins.simulators.drake:Drake",
        summary="engine Drake: its multibody plant and SAP contact solver, every arm in a context of its own",
        requires=("pydrake",),
        extra="drake",
    )
    register(
        "kinematic",
        "harness_plugins.simulators.kinematic:Kinematic",
        summary="no engine, no dynamics: joints exactly where they are driven, many arms at once",
    )
    register(
        "mjx",
        "harness_plugins.simulators.mjx:Mjx",
        summary="engine MuJoCo: the model of mujoco stepped by MJX, compiled by JAX for accelerators; slow on a CPU",
        requires=("mujoco.mjx", "jax"),
        extra="mjx",
    )
    register(
        "mujoco",
        "harness_plugins.simulators.mujoco:Mujoco",
        summary="engine MuJoCo: many arms through mujoco.rollout threads",
        requires=("mujoco>=3.17",),
        extra="mujoco",
    )
    register(
        "physx",
        "harness_plugins.simulators.physx:PhysX",
        summary="engine PhysX, by SAPIEN: every arm in a scene of its own",
        requires=("sapien",),
        extra="physx",
    )
    register(
        "pybullet",
        "harness_plugins.simulators.pybullet:PyBullet",
        summary="engine Bullet: every arm in a physics client of its own",
        requires=("pybullet",),
        extra="pybullet",
    )
