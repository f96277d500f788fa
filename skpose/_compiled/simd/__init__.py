"""Vector registers and compilation: all that is private to numba and llvmlite; knows no pose.

What calls what::

    trigonometry, copying                                   cosines and sines in lanes; copies of arrays
              |
             jit                                            the decorators of all compiled functions
              |
       +------+-----+-----------+----------+
       |            |           |          |
    lanes_llvm  by_address   fallback    cache              what numba writes for lanes; functions with an address of
       |            |           |                           their own; which compiler; compiled functions on disk
     lanes          |        compiler  shared, kept         vectors; numba's passes, fewer; named tuples as one address,
       |            |           |          |                and tuples that stay in memory
       |            |       announce       |                a message where compilation takes long
       |            |           |          |
       +------------+- private -+----------+                numba's and llvmlite's private parts

`signatures` has numba's types, spelled out.

What is compiled with what
--------------------------
A function is compiled into each of its callers, and these into theirs. So large functions are called *by address*: they
are compiled once, for the types that they spell out (`signatures`). Only what has an address is optimised and becomes
machine code, with all internal functions that it calls (`compiler`). A function has no entry points but those that it
needs (`jit`): one for Python takes longer to compile than most functions here. And a named tuple of many arrays, such
as `pose.tree.Tree`, is one address (`shared`): it is some two hundred numbers, which every call would copy. What
`lanes` has is not compiled at all: numba writes its instructions into the caller (`lanes_llvm`), as it does with its
own operators.

Lanes
-----
A kernel is written once, with the `rows` of `lanes`. On arrays of shape (n, lanes) it computes as many poses at once as
fill a vector register, on arrays of shape (n,) one. Lanes never mix: a distance does not depend on the other poses in
its register, nor on the number of threads. (In a path lanes are the poses of the path itself; see `path.energy`.)
"""
