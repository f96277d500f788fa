"""Poses at given positions of the joints.

What calls what::

    frames                                                  the poses of a sequence, each from the one before
       |
     start                                                  the first guess of a frame, by the root's orientation
       |
     step                                                   the search for the pose of a frame
       |
     energy                                                 energy, gradient and Hessian of a pose, and the equations
                                                            of a step
"""
