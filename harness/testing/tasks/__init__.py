"""What a task must satisfy."""
