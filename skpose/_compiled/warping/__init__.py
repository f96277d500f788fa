"""Whole motions: dynamic time warping.

What calls what::

    within    stream                                        the least sum of a part of a motion; of a stream so far
       |         |
       +- paths -+                                                  the least sum of two motions, and its path
"""

# Subject and duration in the message of `simd.announce`.
COMPILES = "distances between motions", "3 to 10 s"
