"""One module per command; each has `run(arguments)`, which prints and returns what was wrong, a line each."""
