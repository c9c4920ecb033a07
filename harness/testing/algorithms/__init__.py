"""What an algorithm must satisfy."""
