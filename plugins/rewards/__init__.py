"""Built-in rewards."""

import harness

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
