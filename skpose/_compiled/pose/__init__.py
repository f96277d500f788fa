"""A pose and its distances: tree, forward kinematics, Jacobian, encode and measure, loops over pairs, nearest."""
