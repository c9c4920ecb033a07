"""The replay of an experiment in the browser, while it goes on."""
