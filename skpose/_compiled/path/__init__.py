"""Paths between poses: charts, energy, normal equations, the trust region, elimination order."""
