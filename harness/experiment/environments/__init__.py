"""Plans and does cells whose task is any Gymnasium environment."""
