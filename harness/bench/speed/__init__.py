"""How fast plugins are beside what they are built on: an engine alone, a library alone, the environments of others."""
