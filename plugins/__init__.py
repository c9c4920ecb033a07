"""What varies: simulators, algorithms, rewards, metrics, executors. One file each, registered by entry point."""
