"""Records what several rewards pay for the steps of any Gymnasium environment, while a learner trains in it."""
