"""What a reward must satisfy."""
