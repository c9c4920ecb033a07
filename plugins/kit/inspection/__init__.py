"""``harness check``: what is wrong with a plugin, found in a process that the plugin may end, crash or keep busy."""
