"""Dynamic time warping of whole motions: `paths` has sums and paths, `within` sums up to a limit."""

# Subject and duration in the message of `simd.announce`.
COMPILES = "distances between motions", "3 to 10 s"
