"""An example plugin: soft actor-critic by sbx."""
