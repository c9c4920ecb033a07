"""Built-in metrics: how well a robot behaves, whatever it was paid."""

import harness


@harness.hookimpl
def register_metrics(register: harness.Register) -> None:
    """Announce the built-in metrics."""
    here = "harness_plugins.metrics"
    register("success_rate", f"{here}.success_rate:SuccessRate", summary="share of episodes that reach the target")
    register("final_distance", f"{here}.final_distance:FinalDistance", summary="distance left when an episode ends")
    register("closest_distance", f"{here}.closest_distance:ClosestDistance", summary="how near an episode comes")
    register("steps_to_target", f"{here}.steps_to_target:StepsToTarget", summary="steps of the episodes that reach it")
    register("path_ratio", f"{here}.path_ratio:PathRatio", summary="length of the way to the target over the line")
    register("smoothness", f"{here}.smoothness:Smoothness", summary="how jerky the joints move")
    register("ground_hits", f"{here}.ground_hits:GroundHits", summary="share of episodes that end on the ground")
