"""Built-in algorithms."""

import harness

SB3 = (
    ("sb3-sac", "sac:Sac", "soft actor-critic"),
    ("her", "her:Her", "soft actor-critic with hindsight experience replay, for environments with goals"),
    ("td3", "td3:Td3", "twin delayed deep deterministic policy gradient"),
    ("ppo", "ppo:Ppo", "proximal policy optimisation, continuous or discrete"),
    ("dqn", "dqn:Dqn", "deep Q-learning for discrete actions"),
    ("ddqn", "ddqn:Ddqn", "double deep Q-learning for discrete actions"),
)


@harness.hookimpl
def register_algorithms(register: harness.Register) -> None:
    """Announce the built-in algorithms."""
    for name, target, summary in SB3:
        register(
            name,
            f"harness_plugins.algorithms.{target}",
            summary=f"{summary}, by stable-baselines3 on the CPU",
            requires=("stable_baselines3", "torch"),
            extra="sb3",
        )
    register(
        "sac-fast",
        "harness_plugins.algorithms.sac_fast:SacFast",
        summary="soft actor-critic by numpy alone, some four times as fast as sb3-sac with the default networks",
        short="sac",
    )
    register(
        "spg",
        "harness_plugins.algorithms.spg:Spg",
        summary="stochastic policy gradient as the ARP paper has it, on the CPU",
        requires=("torch",),
        extra="sb3",
    )
    register("random", "harness_plugins.algorithms.random:Random", summary="acts at random, learns nothing: the floor")
    register(
        "ik",
        "harness_plugins.algorithms.ik:Ik",
        summary="reaches by inverse kinematics, learns nothing: the ceiling",
    )
