"""The built-in plugins: simulators, algorithms, rewards, metrics, tasks and more. Entry points register them."""
