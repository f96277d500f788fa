"""All compiled code: forward kinematics in vector registers, the metrics, geodesics, the loops over pairs.

A package imports from those below it, and each opens with a diagram of what calls what in it::

    metrics, neighbors, motions    geodesics, motions    kinematics    motions    cluster
            |                          |                     |            |         |
            |                         path                inverse      warping  graph_shift
            |                          |                     |            |         |
            +----------- pose ---------+---------------------+------------+         |
                          |                                                         |
                         simd ------------------------------------------------------+

`simd`: vector registers, and compilation by numba; it does not depend on poses.
`pose`: a skeleton as arrays, a pose and its distances. `path`: paths between poses, and geodesics. `inverse`: poses at
given positions of the joints. `warping`: whole motions.

Two files compile elsewhere: `skpose.metrics._pose_metric` one function for each skeleton, which calls `pose.pair`, and
`_own` the functions of a user's metric. Every function here is plain Python, decorated. With the environment variable
``NUMBA_DISABLE_JIT=1`` it runs as such, slowly, for a debugger or for coverage. Compiled functions are cached on disk,
keyed by a digest of this folder (`simd.jit`), in files that several processes may write at a time (`simd.cache`).

Glossary
--------
| word         | meaning                                                                                          |
|--------------|--------------------------------------------------------------------------------------------------|
| internal     | a function that is compiled into its callers: it has no address                                   |
| by address   | a function that is compiled once, for one signature; its callers call an external symbol          |
| first class  | a function that is an argument of a compiled one (numba's first-class functions)                  |
| lane         | one number of a vector register; a group of lanes is what one register holds                      |
| frame, dof   | a coordinate system that turns with a joint; one of its one to three degrees of freedom           |
| leaf         | a frame that carries no other one, and one joint                                                  |
| code         | the numbers of a pose that a metric needs, as its *encode* writes them                            |
"""
