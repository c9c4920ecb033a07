"""A measure of a ship that shall dock."""

lower_is_better = ["distance"]


def distance(step):
    """From the ship to the dock."""
    return float((step.observation["position"] ** 2).sum() ** 0.5)
