"""The flags of commands as named types, so that a command's signature has one line for each of its flags.

`harness.cli.flags.shared` holds the flags of several commands. A command with many flags has a file of its name here
for those that no other command has. The few flags of any other command stand in its signature.
"""
