"""Built-in formats of logs."""

import harness


@harness.hookimpl
def register_logs(register: harness.Register) -> None:
    """Announce the built-in formats."""
    register("cell", "harness.record.cell_log:CellLog", summary="what a cell of an arm leaves: trace.parquet")
    register(
        "recording", "harness_plugins.logs.recording:Recording", summary="steps of a training, by harness.RecordRewards"
    )
    register(
        "table",
        "harness_plugins.logs.table:Table",
        summary="episodes or curves in CSV or JSON: Monitor, progress.csv, W&B's and TensorBoard's exports, own tables",
    )
    register(
        "evaluations",
        "harness_plugins.logs.evaluations:Evaluations",
        summary="stable-baselines3's EvalCallback: evaluations.npz, a row is an episode of an evaluation",
    )
    register(
        "tensorboard",
        "harness_plugins.logs.tensorboard:TensorBoard",
        summary="a folder of TensorBoard's event files, by tags of SB3, CleanRL, ML-Agents, rsl_rl, RLlib and others",
        requires=("tensorboard",),
        extra="tensorboard",
    )
    register("steps-csv", "harness.score.csv_steps:StepsCsv", summary="CSV with a column 'reward', a row for each step")
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
