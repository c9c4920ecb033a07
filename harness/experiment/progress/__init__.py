"""What is told of cells while they run, and what is written as they end."""
