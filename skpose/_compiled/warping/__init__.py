"""Whole motions: dynamic time warping."""
