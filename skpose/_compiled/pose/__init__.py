"""A pose and its distances: tree, forward kinematics, Jacobian, encode and measure, loops over pairs, nearest.

What calls what, from the loops over poses at the top to one frame at the bottom::

    candidates
       |
    nearest, loops, pair                                    searches; the loops over poses and over pairs; one pair
          |
     +----+----+
     |         |
  encode    measure      chart     jacobian                 a pose -> its code; codes -> distances; coordinates in
     |         |           |          |                     which joints turn freely; derivatives of the positions
     +--step --+           |          |                     joint positions in lanes, from step to step
          |                |          |
          +---- forward ---+----------+                     orientations of all frames
                   |
    rotation, tree, signatures                              quaternions; the arrays, and their types for numba

The skeleton as compiled code sees it
-------------------------------------
A `Tree` holds *frames* and *joints*. A frame is a coordinate system with one to three degrees of freedom (dofs):
angles, or the rotation vector of a ball joint. A joint is a point at a fixed offset from its parent joint, measured in
one of the frames. Rigid bones need no frame of their own, and bones that start at one joint may share one.
`skpose.kinematics._tree` chooses the axes of every frame so that its dofs are rotations about z, y and x in that order,
or the last one or two of these: a frame is ``H = H_parent · Rz · Ry · Rx`` whichever order the file has, and no
compiled code branches on axes. The constant rotation between two frames goes into the zeros of their angles (`shift`).
What is left of it, if anything, is a frame without dofs between the two: a constant rotation about one axis. A ball
joint takes constant rotations before and after it into its quaternion.

The curve without trigonometry
------------------------------
The straight line in angle space, sampled at n = 0 … N, adds δ = (b − a)/N to the angles at each step. The cosines and
sines of θ/2N are stored for every pose. Those of δ/2 follow for a pair by the subtraction formulas, and those of each
sample from the last one by the addition formulas. So a pair costs no trigonometry; the error is 1e-14 after ten steps.
The formulas take 1 − cos δ = 2 sin² δ/2 instead of cos δ, whose rounding would make the frames grow or shrink from step
to step. A difference that is wrapped, b − a ∓ 2π, changes δ by ∓ 2π/N. The two end poses are computed once per pose and
not once per pair, so a pair costs N − 1 forward kinematics.

A ball joint turns along a great circle of unit quaternions, q = q_a … q_b. With φ the angle between the two, q_{n+1} −
q_n = q_n − q_{n−1} − κ q_n, κ = 2 − 2 cos(φ/N). What the first step needs, κ and sin(φ/N)/sin φ, are polynomials in 1 −
cos φ = ‖q_b − q_a‖²/2 (`tree.slerp_series`), so this costs no trigonometry either. Quaternions are kept times √2, which
saves the twos when they rotate a vector. Where a and b are half a turn apart there are two great circles; the signs of
the quaternions, which `rotation.canonical` makes the same for all numbers of one rotation, choose.

What a step leaves out
----------------------
A *leaf* is a frame at the end of the tree that holds one joint: there the joint's offset is rotated, a vector, and not
the frame. Of a frame's rotation only two rows are stored, since the third is their cross product. Joints fixed to the
root do not move. A ball joint's axes are chosen so that the joint it carries lies along x, or so that the axes of the
next frame need no constant rotation. Frames with the same number of dofs stand together in *batches*, so that the
processor meets the same instructions again and again.

Two stages
----------
A metric is a pair of functions. Its *encode* writes the code of a pose: all that the metric needs of it. Its *measure*
computes the distances from one encoded pose to others. The loops over poses and over pairs exist once (`loops`,
`nearest` and `candidates` for searches, `warping` for motions) and take the two as arguments.
"""
