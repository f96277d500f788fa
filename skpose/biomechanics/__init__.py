"""Movements of people in the words of those who measure them: angles of joints, symmetry, gait."""
