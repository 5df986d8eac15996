"""The command line `abradem`: `main` defines the commands, `predict` the command of that name."""
