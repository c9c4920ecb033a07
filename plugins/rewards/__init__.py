"""Built-in rewards."""

import harness

REWARDS = {
    "aarp": ("aarp:Aarp", "accelerated-and-accelerated: the gain of ARP grows with each improvement in a row"),
    "adaptive": ("adaptive:Adaptive", "the gain follows the progress towards the target; bounded, scale-free"),
    "arp": ("arp:Arp", "accelerated reward policy, 'K2': baseline with two gains"),
    "baseline": ("baseline:Baseline", "Type I, the Unity project's reward"),
    "baseline-eq21": ("baseline_eq21:BaselineEq21", "the baseline with its conditions as the NOTE prints them"),
    "dense": ("dense:Dense", "the negative distance"),
    "potential": ("potential:Potential", "potential-based shaping: does not change which policy is best"),
    "relative": ("relative:Relative", "the step's gain relative to the distance, NOTE Table III"),
    "scaled": ("scaled:Scaled", "null control: another reward times a constant"),
    "shifted": ("shifted:Shifted", "null control: another reward plus a constant"),
    "sparse": ("sparse:Sparse", "nothing: the task's events alone pay"),
}


@harness.hookimpl
def register_rewards(register: harness.Register) -> None:
    """Announce the built-in rewards."""
    for name, (target, summary) in REWARDS.items():
        register(name, f"harness_plugins.rewards.{target}", summary=summary)
