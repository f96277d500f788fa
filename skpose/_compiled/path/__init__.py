"""Paths between poses: energy, normal equations, the trust region.

What calls what::

    exponential    kept_paths                               logarithms; geodesics from a pose that moves
         |             |
         +------+------+
                |
            geodesic                                        a path between two poses, its length; the pose nearest to
                |                                           mean positions
            minimiser                                       a trust region
                |
         block_cholesky                                     its steps
                |
        normal_equations                                    gradient and Hessian
                |
             energy                                         the energy of a path, eight poses at once

The coordinates of a path are those of `pose.chart`. Apart from these, `family` finds paths in a matrix of similarities,
for motions.
"""
