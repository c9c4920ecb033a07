def height(step):
    """How high the free end is above the bar, in links; 1 and above ends the episode."""
    c1, s1, c2, s2, _, _ = (float(it) for it in step.observation)
    return -c1 - (c1 * c2 - s1 * s2)
