def still(step):
    """Minus what moves: only costs, so the sooner it falls the better."""
    _, speed, angle, turning = (abs(float(it)) for it in step.observation)
    return -0.1 - speed - angle - turning
