"""Poses at given positions of the joints."""
