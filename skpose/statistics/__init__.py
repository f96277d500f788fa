"""Statistics of poses: their principal components, regression with poses as targets, tests of two sets."""
