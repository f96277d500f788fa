"""The command line: a module for each command, and the studies that two of them run."""
