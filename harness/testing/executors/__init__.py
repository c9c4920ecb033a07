"""What an executor must satisfy."""
