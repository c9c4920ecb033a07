"""Built-in metrics. They say how well a robot behaves, no matter which reward paid it."""

import harness


@harness.hookimpl
def register_metrics(register: harness.Register) -> None:
    """Announce the built-in metrics."""
    here = "harness_plugins.metrics"
    register("success_rate", f"{here}.outcomes:SuccessRate", summary="share of episodes that reach the target")
    register("final_distance", f"{here}.outcomes:FinalDistance", summary="distance left when an episode ends")
    register("closest_distance", f"{here}.outcomes:ClosestDistance", summary="how near an episode comes")
    register("steps_to_target", f"{here}.outcomes:StepsToTarget", summary="of successful episodes only")
    register(
        "path_ratio",
        f"{here}.movement:PathRatio",
        summary="path over straight line, of successful episodes only; 1 is the shortest",
    )
    register("smoothness", f"{here}.movement:Smoothness", summary="how jerky the joints move")
    register("ground_hits", f"{here}.outcomes:GroundHits", summary="share of episodes that end on the ground")
    register("obstacle_hits", f"{here}.outcomes:ObstacleHits", summary="share of episodes that end at an obstacle")
    register(
        "time_to_target",
        f"{here}.outcomes:TimeToTarget",
        summary="mean over all episodes; a failure counts as the whole time limit",
    )
    register("spl", f"{here}.movement:Spl", summary="success times straight line over path; a failure counts 0")
    register(
        "optimality",
        f"{here}.movement:Optimality",
        summary="steps the arm needs at best over those it took; a failure counts 0",
    )
    register("sparc", f"{here}.movement:Sparc", summary="smoothness of the end effector's speed; 0 is the smoothest")
    register("timeouts", f"{here}.outcomes:Timeouts", summary="share of episodes that run out of time")
    register("work", f"{here}.movement:Work", summary="mechanical work of an episode, at least")
