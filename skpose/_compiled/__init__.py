"""The compiled kernels: turn frames, place joints, encode a pose.

The skeleton as the kernels see it
----------------------------------
A `Tree` holds *frames* and *joints*. A frame is a coordinate system with one to three degrees of freedom (dofs); a
joint is a point at a fixed offset from the joint before it, measured in one of the frames. Rigid bones need no frame
of their own, and bones that start at one joint may share one. `skpose.kinematics._tree` turns every frame so that its dofs are
rotations about z, y and x in that order, the last one or two of these where it has fewer than three: a frame is
``H = H_parent · Rz · Ry · Rx`` whatever the order of axes was in the file, and nothing below branches on axes. What
constant rotation lies between two frames goes into the zeros of their angles (`shift`); the rest of it, if any, is a
frame without dofs between the two, a constant turn about one axis.

Lanes
-----
A kernel is written once, with the `rows` of `skpose._compiled.lanes`. On arrays of shape (n, lanes) it works on as many poses at
once as fill a vector register, on arrays of shape (n,) on one. Lanes never mix: a distance does not depend on its
neighbours in the block, nor on the number of threads.

The curve without trigonometry
------------------------------
The straight line in angle space, sampled at n = 0 … N, adds δ = (b − a)/N to the angles at each step. With the cosines
and sines of θ/2N kept for every pose, those of δ/2 follow for a pair by the subtraction formulas, and those of each
sample from the last by the addition formulas: no trigonometry per pair, error 1e-14 after ten steps. These take
1 − cos δ = 2 sin² δ/2 instead of cos δ, whose rounding would make the frames grow or shrink from step to step. A
difference taken the short way round, b − a ∓ 2π, turns δ by ∓ 2π/N. The two end poses are placed once per pose and not
once per pair, so a pair costs N − 1 forward kinematics.

What a step leaves out
----------------------
A *tip* is a frame that ends the tree and holds one joint: there the joint's offset is turned, a vector, and not the
frame. Of a frame's rotation only two rows are kept, since the third is their cross product. Joints fixed to the root
are not placed again. Frames with equally many dofs stand together in *batches*, so that the processor meets the same
instructions again and again.

Two stages
----------
A metric is a pair of functions. Its *encode* writes down what it needs to know of a pose; its *measure*, in
`skpose._compiled.measure`, takes one encoded pose to others. The loops over poses and over pairs are in `skpose._compiled.loops` and
`skpose._compiled.nearest`.
"""
