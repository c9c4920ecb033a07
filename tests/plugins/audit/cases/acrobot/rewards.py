"""A reward for two links of which the free end shall swing above a line; 500 steps at most."""


def high(step):
    """How high the end is above its lowest place. Hacked: the line ends the pay, and swinging below it goes on."""
    c1, s1, c2, s2, _, _ = (float(it) for it in step.observation)
    return 2.0 - c1 - (c1 * c2 - s1 * s2)
