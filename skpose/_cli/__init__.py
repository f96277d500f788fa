"""The command line: its commands and the studies that they print."""
