"""The command line: options, commands, and the studies that two of them run."""
