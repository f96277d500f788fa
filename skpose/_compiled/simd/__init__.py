"""Vector registers and compilation: all that is private to numba and llvmlite; knows no pose."""
