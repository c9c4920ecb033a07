class success:  # noqa: N801
    """Whether the pole has stood for 475 steps or more."""

    def reset(self):
        """Begin an episode."""
        self.steps = 0

    def __call__(self, step):
        """Look at a step."""
        self.steps += 1
        return self.steps >= 475
