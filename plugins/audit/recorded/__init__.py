"""What several rewards paid for the same recorded steps, in any environment."""
