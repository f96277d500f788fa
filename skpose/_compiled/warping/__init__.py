"""Dynamic time warping of whole motions: `paths` has sums and paths, `within` sums up to a limit."""
