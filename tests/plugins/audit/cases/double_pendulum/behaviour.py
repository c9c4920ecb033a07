class success:  # noqa: N801
    """Whether both poles have stood for 150 steps or more."""

    def reset(self):
        """Begin an episode."""
        self.steps = 0

    def __call__(self, step):
        """Look at a step."""
        self.steps += 1
        return self.steps >= 150
