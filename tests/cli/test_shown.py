"""What commands show of what is installed: a line that one types, and what stands in the answer."""

import pytest

SHOWN = {
    "describe fd100-reach": (
        *("S, the state: 28 numbers", "A, the actions: MoveJ", "T, the transition", "R, the reward", "s_j6-accel"),
    ),
    "describe fd100-reach:epsilon=0.02": ("epsilon = 0.02 m",),
    "describe unity-reach": (
        *("next target", "NOTE eq. 19 differs: +1, and the episode ends", "S, the state: 19 numbers"),
    ),
    "describe fd100-pose": (
        "the pose error is at most epsilon = 0.02 m",
        "S, the state: 37 numbers",
        "goal 9 numbers the target's x and y axis",
    ),
    "describe fd100-moving": ("the distance is at most epsilon = 0.05 m for 10 steps in a row",),
    "describe arp": ("arp", "k1 = 1, k2 = 2", "1.5", "NOTE and ARP are the sources that docs/sources.md names."),
    "describe baseline": ("baseline",),
    "describe mujoco": ("mujoco",),
    "describe success_rate": ("success_rate",),
    "describe processes": ("processes",),
    "describe fd100": ("fd100", "joint2 800 10 25 25 29000 1920", "latency 0.01 s, weight compensated"),
    "describe gymnasium": ("has to be given", "made_with"),
    "describe gymnasium:id=CartPole-v1": (
        *("(4,), float32) what the env observed", "action Discrete(2) what the policy did"),
    ),
    "describe gymnasium:id=No-Such-v0": ("What a reward may read is not known: gymnasium.make('No-Such-v0') fails",),
    "describe ppo": ("In an environment, ppo stands for ppo:gamma=0.99.",),
    "describe table": ("log format table: ", "A row is a point. Its example has the columns time, reward/recorded, "),
    "describe rewards": ("baseline", "accelerated reward policy"),
    "describe commands": (" export ",),
    "audit --reward baseline --episodes 6 --budget 0": (
        *("creep paid most", " finish ", " hover ", " oscillate ", " hold ", " random "),
        "Not finishing pays more than finishing: creep earns",
        "no simulator: joints move exactly as commanded",
    ),
    "audit --reward arp:k2=2 --episodes 6 --budget 0": (
        *("bounded no", "scale-free no", "potential-based no", "all distances times 2", "EPIC distance 0."),
        "DARD distance 0.",
    ),
    "new-plugin --help": ("algorithm", "command", "environment", "executor", "log", "metric", "reward", "task"),
}
"""By the line."""
NOT_SHOWN = {
    "describe random": "docs/sources.md",
    "describe ppo:gamma=0.9": "In an environment",
    "describe ppo:preset=unity": "In an environment",
    "describe": "NOTE",
    "describe rewards": "simulators",
    "describe commands": "report--",
    "eta --help": "minari",
}
"""What does not belong there."""


@pytest.mark.parametrize("line", [*SHOWN, *NOT_SHOWN])
def test_what_is_shown(harness, line):
    """Status 0; how wide the columns are does not count."""
    answer = harness(line)
    out = " ".join(answer.out.split())
    assert (answer.status, answer.err) == (0, "")
    assert [it for it in SHOWN.get(line, ()) if it not in out] == []
    assert NOT_SHOWN.get(line, "?!") not in out
