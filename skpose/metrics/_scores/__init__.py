"""Scores of predicted poses and motions: numpy in, a number out, which says what was computed.

| module                                    |                                                                      |
|-------------------------------------------|----------------------------------------------------------------------|
| `_score`                                  | the number, with its signature, its unit and how much was counted    |
| `_points`                                 | positions that the user gives, as frames of joints, some unseen      |
| `_align`                                  | roots, and Procrustes alignment                                      |
| `_mpjpe`, `_pck`, `_acceleration`, `_dtw` | scores of positions                                                  |
| `_angles`, `_geodesic`, `_npss`           | scores of angles, of rotations and of spectra                        |
| `_signature`                              | "PA-MPJPE|mm|scale" as a call, and back                              |
| `_scorer`                                 | scorers for scikit-learn                                             |

The package imports from the rest of skpose, and of that only `skpose.metrics.__init__` imports from it.
"""
