"""Built-in metrics. They say how well a robot behaves, no matter which reward paid it."""

import harness


@harness.hookimpl
def register_metrics(register: harness.Register) -> None:
    """Announce the built-in metrics."""
    here = "harness_plugins.metrics"
    register("success_rate", f"{here}.outcomes:SuccessRate", summary="share of episodes that reach the target")
    register("final_distance", f"{here}.outcomes:FinalDistance", summary="distance left when an episode ends")
    register("closest_distance", f"{here}.outcomes:ClosestDistance", summary="how near an episode comes")
    register("steps_to_target", f"{here}.outcomes:StepsToTarget", summary="steps, of successful episodes only")
    register(
        "path_ratio",
        f"{here}.movement:PathRatio",
        summary="path over straight line, of successful episodes only",
    )
    register("smoothness", f"{here}.movement:Smoothness", summary="how jerky the joints move")
    register("ground_hits", f"{here}.outcomes:GroundHits", summary="share of episodes that end on the ground")
    register("obstacle_hits", f"{here}.outcomes:ObstacleHits", summary="share of episodes that end at an obstacle")
    register("time_to_target", f"{here}.outcomes:TimeToTarget", summary="time to the target, a failure: horizon")
    register("spl", f"{here}.movement:Spl", summary="success weighted by how direct the path is")
    register("optimality", f"{here}.movement:Optimality", summary="steps of the arm's kinematics over the policy's")
    register("sparc", f"{here}.movement:Sparc", summary="how smooth the end effector moves, however long it takes")
    register("timeouts", f"{here}.outcomes:Timeouts", summary="share of episodes that run out of time")
    register("work", f"{here}.movement:Work", summary="mechanical work of an episode, at least")
