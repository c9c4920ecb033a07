"""Built-in formats of logs."""

import harness


@harness.hookimpl
def register_logs(register: harness.Register) -> None:
    """Announce the built-in formats."""
    register(
        "monitor",
        "harness_plugins.logs.monitor:Monitor",
        summary="stable-baselines3's Monitor and Gymnasium's old one: monitor.csv, a row is an episode",
    )
    register(
        "minari",
        "harness_plugins.logs.minari:Minari",
        summary="Minari: episodes in HDF5, a folder or minari:NAME, a row is a step",
    )
    register(
        "lerobot",
        "harness_plugins.logs.lerobot:LeRobot",
        summary="LeRobot 2.0 to 3.0: episodes in Parquet, a row is a step",
    )
    register(
        "d4rl",
        "harness_plugins.logs.d4rl:D4RL",
        summary="D4RL: one HDF5 file of many episodes, a row is a step",
    )
    register(
        "robomimic",
        "harness_plugins.logs.robomimic:Robomimic",
        summary="robomimic: demonstrations in HDF5, a row is a step",
    )
