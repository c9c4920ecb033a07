"""What a reward pays for, found without training anything."""
