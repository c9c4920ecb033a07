"""The world of one episode: a simulator, a task and a reward as a Gymnasium environment."""
