"""Built-in environments."""

import harness

harness_api = 2


@harness.hookimpl
def register_environments(register: harness.Register) -> None:
    """Announce the built-in environments."""
    here = "harness_plugins.environments"
    register(
        "gymnasium",
        f"{here}.any_gymnasium:AnyGymnasium",
        summary="any id of Gymnasium, paid by its own reward and by numbers that it tells: gymnasium:id=Pendulum-v1",
        extra="gymnasium",
    )
    register(
        "inverted-double-pendulum",
        f"{here}.inverted_double_pendulum:InvertedDoublePendulum",
        summary="two poles on a cart, paid as versions 4 and 5 of Gymnasium's environment pay",
        requires=["mujoco", "imageio", "packaging"],
        extra="gymnasium",
    )
    register(
        "fetch-reach",
        f"{here}.fetch_reach:FetchReach",
        summary="a Fetch arm reaches a point, paid sparse or dense",
        requires=["gymnasium_robotics", "mujoco"],
        extra="robotics",
    )
    register(
        "meta-world",
        f"{here}.meta_world:MetaWorld",
        summary="a task of Meta-World, paid by the first or second version of its reward, or by the first scaled down",
        requires=["metaworld", "mujoco"],
        extra="metaworld",
    )
    register(
        "unity",
        f"{here}.unity:Unity",
        summary="a program built with Unity's ML-Agents, or Unity's editor, paid by its own reward and by an arm's",
        requires=["mlagents_envs"],
        extra="unity",
    )
