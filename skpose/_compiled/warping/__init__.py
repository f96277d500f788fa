"""Whole motions: dynamic time warping.

What calls what::

    within                                                  the least sum of a part of a motion
       |
     paths                                                  the least sum of two motions, and its path
"""
