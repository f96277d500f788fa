"""All compiled code, in rooms: forward kinematics in vector registers, the metrics, geodesics, the loops over pairs.

A room imports from those below it, and each opens with a diagram of what calls what in it::

    metrics, neighbors, motions    geodesics, motions    kinematics    motions    cluster
            |                          |                     |            |         |
            |                         path                inverse      warping  graph_shift
            |                          |                     |            |         |
            +----------- pose ---------+---------------------+------------+         |
                          |                                                         |
                         simd ------------------------------------------------------+

`simd`: vector registers, and compilation by numba, whose private parts are used nowhere else; it knows no pose.
`pose`: a skeleton as arrays, a pose and its distances. `path`: paths between poses, and geodesics. `inverse`: poses at
given positions of the joints. `warping`: whole motions.

Two files compile elsewhere: `skpose.metrics._pose_metric` one function for each skeleton, which calls `pose.loops`, and
`_own` the functions of a user's metric. Every
function here is plain Python, decorated. With the environment variable ``NUMBA_DISABLE_JIT=1`` it runs as such, slowly,
for a debugger or for coverage. Compiled functions are cached on disk, keyed by a digest of this folder (`simd.jit`).
"""
