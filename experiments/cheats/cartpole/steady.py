def steady(step):
    """0.1 a step, and a change of direction costs 1. So it is cheaper to fall than to balance."""
    return {"alive": 0.1, "change": -1.0 * float(step.action != step.before.action)}
