"""What a simulator must satisfy."""
