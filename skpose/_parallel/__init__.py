"""Where work runs and how far it is: threads, processes and clusters, progress, checkpoints."""
