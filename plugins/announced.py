"""What the harness itself brings: every built-in plugin by its name, and the commands that the core does without."""

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


REWARDS = {
    "aarp": ("aarp:Aarp", "accelerated-and-accelerated: the gain of ARP grows with each improvement in a row"),
    "adaptive": ("adaptive:Adaptive", "the gain follows the progress towards the target; bounded, scale-free"),
    "arp": ("arp:Arp", "accelerated reward policy: baseline with a gain on what it pays and one on what it takes"),
    "baseline": ("baseline:Baseline", "the published Unity project's reward, with which others are compared"),
    "baseline-eq21": ("baseline_eq21:BaselineEq21", "baseline with the conditions as printed, the reverse of its code"),
    "dense": ("dense:Dense", "minus the distance to the target, at every step"),
    "potential": ("potential:Potential", "potential-based shaping: does not change which policy is best"),
    "relative": ("relative:Relative", "how much of the distance a step gains, as a share of that distance"),
    "scaled": ("scaled:Scaled", "null control: another reward times a constant"),
    "shifted": ("shifted:Shifted", "null control: another reward plus a constant"),
    "sparse": ("sparse:Sparse", "nothing: the task's events alone pay"),
}


@harness.hookimpl
def register_rewards(register: harness.Register) -> None:
    """Announce the built-in rewards."""
    for name, (target, summary) in REWARDS.items():
        register(name, f"harness_plugins.rewards.{target}", summary=summary)


@harness.hookimpl
def register_metrics(register: harness.Register) -> None:
    """Announce the built-in metrics."""
    here = "harness_plugins.metrics.episodes"
    register("success_rate", f"{here}:SuccessRate", summary="share of episodes that reach the target")
    register("final_distance", f"{here}:FinalDistance", summary="distance left when an episode ends")
    register("closest_distance", f"{here}:ClosestDistance", summary="how near an episode comes")
    register("steps_to_target", f"{here}:StepsToTarget", summary="of successful episodes only")
    register(
        "path_ratio",
        f"{here}:PathRatio",
        summary="path over straight line, of successful episodes only; 1 is the shortest",
    )
    register("smoothness", f"{here}:Smoothness", summary="how jerky the joints move")
    register("ground_hits", f"{here}:GroundHits", summary="share of episodes that end on the ground")
    register("obstacle_hits", f"{here}:ObstacleHits", summary="share of episodes that end at an obstacle")
    register(
        "time_to_target",
        f"{here}:TimeToTarget",
        summary="mean over all episodes; a failure counts as the whole time limit",
    )
    register("spl", f"{here}:Spl", summary="success times straight line over path; a failure counts 0")
    register(
        "optimality",
        f"{here}:Optimality",
        summary="steps the arm needs at best over those it took; a failure counts 0",
    )
    register("sparc", f"{here}:Sparc", summary="smoothness of the end effector's speed; 0 is the smoothest")
    register("timeouts", f"{here}:Timeouts", summary="share of episodes that run out of time")
    register("work", f"{here}:Work", summary="mechanical work of an episode, at least")


@harness.hookimpl
def register_tasks(register: harness.Register) -> None:
    """Announce the built-in tasks."""
    register(
        "arp-2021",
        "harness_plugins.tasks.unity:Arp2021",
        summary="the published experiment: fixed start and target, joint angles are set",
    )
    register(
        "fd100-reach", "harness.env.reach_task:ReachTask", summary="bring the FD100's end effector to a target in a box"
    )
    worse = "harness_plugins.tasks.worse"
    register("noisy-reach", f"{worse}:NoisyReach", summary="fd100-reach with noise on what is seen and done")
    register("delayed-reach", f"{worse}:DelayedReach", summary="fd100-reach seen 0.1 s late and done 0.1 s late")
    register("cluttered-reach", f"{worse}:ClutteredReach", summary="fd100-reach around obstacles: touching one ends it")
    register("varied-reach", f"{worse}:VariedReach", summary="fd100-reach with another arm in every episode")
    here = "harness_plugins.tasks"
    register("fd100-low", f"{here}.low:Low", summary="targets just above the ground: punishes careless paths")
    register("fd100-moving", f"{here}.moving:Moving", summary="follow a moving target: punishes hurry without control")
    register("fd100-pose", f"{here}.pose:Pose", summary="reach a target in its orientation: more than position counts")
    register(
        "fd100-small-target", f"{here}.small_target:SmallTarget", summary="within 1 cm: the last centimetres count"
    )
    register(
        "unity-reach",
        "harness_plugins.tasks.unity:UnityReach",
        summary="the baseline's Unity task: random start and target, joint angles are set",
    )


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


@harness.hookimpl
def register_executors(register: harness.Register) -> None:
    """Announce the built-in executors."""
    register(
        "processes",
        "harness_plugins.executors.processes:Processes",
        summary="processes of this machine",
    )
    register(
        "ray",
        "harness_plugins.executors.ray:Ray",
        summary="the nodes of a Ray cluster",
        requires=("ray",),
        extra="ray",
    )
    register(
        "slurm",
        "harness_plugins.executors.slurm:Slurm",
        summary="an array of Slurm jobs",
        requires=("submitit",),
        extra="slurm",
    )


@harness.hookimpl
def register_trackers(register: harness.Register) -> None:
    """Announce the built-in trackers."""
    register(
        "tensorboard",
        "harness_plugins.trackers.tensorboard:TensorBoard",
        summary="event files for TensorBoard, in the experiment's folder",
        requires=("tensorboard",),
        extra="tensorboard",
    )
    register(
        "wandb",
        "harness_plugins.trackers.wandb:WandB",
        summary="Weights & Biases, online or offline",
        requires=("wandb",),
        extra="wandb",
    )


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


@harness.hookimpl
def register_commands(register: harness.Register) -> None:
    """Announce the built-in commands, what writes records, and what ``harness watch`` shows beside experiments."""
    register(
        "audit",
        "harness_plugins.audit.command:audit",
        summary="Say what rewards pay for. Trains nothing.",
        heading="Ask more",
    )
    register(
        "check",
        "harness_plugins.kit.inspection.command:check",
        summary="Check whether a plugin or robot keeps the rules of its kind. Each result is a sentence with numbers.",
        heading="For plugin authors",
    )
    register(
        "doctor",
        "harness_plugins.doctor.command:doctor",
        summary="Show what is installed, what is missing, and what works here. "
        "Simulators and environments take a step each.",
        heading="Run and read",
    )
    register(
        "export",
        "harness_plugins.exporters.command:export",
        summary="Write a policy as ONNX model, or trainings as CSV files.",
    )
    register(
        "new-plugin",
        "harness_plugins.kit.new_plugin:new_plugin",
        summary="Write a plugin's package: a working implementation, its tests, a README and a CI workflow.",
        heading="For plugin authors",
    )
    register(
        "parity",
        "harness_plugins.parity.command:parity",
        summary="Drive the same motions through several simulators and show how far they differ. Trains nothing.",
    )
    register(
        "watch",
        "harness_plugins.watch.command:watch",
        summary="Show trainings in the browser while they go on. With success and pay, what runs, answers and films so "
        "far.",
        heading="Run and read",
    )
    register(
        "run--watch",
        "harness_plugins.watch.watch:served",
        summary="Show the trainings of a run in the browser while they go on.",
    )
    register(
        "watch--certificates",
        "harness_plugins.audit.search.out:page_in",
        summary="Show the certificates of a search in the browser.",
    )
    register(
        "report--summary",
        "harness_plugins.committed.records:records",
        summary="Write records: small tables and figures, made to be kept and shared.",
    )
    register(
        "video",
        "harness_plugins.video.command:video",
        summary="Make a film of recorded episodes: the arm, its target, what it is paid.",
        heading="Run and read",
    )
    register(
        "transfer",
        "harness_plugins.transfer.command:transfer",
        summary="Evaluate an experiment's policies in other simulators, and show how much of their success is left.",
        heading="Ask more",
    )


@harness.hookimpl
def register_screens(register: harness.Register) -> None:
    """Announce what these commands say of rewards before they train."""
    register(
        "cheats",
        "harness_plugins.audit.screen:Cheats",
        summary="What each reward pays a cheat: scripted movements of an arm, and a search in any environment.",
    )


@harness.hookimpl
def register_sections(register: harness.Register) -> None:
    """Announce what these commands add to a report."""
    register(
        "transfer",
        "harness_plugins.transfer.matrix:TransferSection",
        summary="What policies are worth in other simulators than the one that trained them.",
    )
