"""Vector registers and compilation by numba; nothing here depends on poses.

What calls what::

    trigonometry                                            cosines and sines in lanes
         |
        jit                                                 the decorators of all compiled functions
         |
         +------------+
         |            |
      lanes         cache                                   vectors; compiled functions on disk, and a message where
         |                                                  compilation takes long
     lanes_llvm                                             what numba writes for lanes

`shared` makes a named tuple of arrays one address; `signatures` has numba's types, spelled out.

What is compiled with what
--------------------------
numba compiles a function into each of its callers, and these into theirs, and optimises it each time. So large
functions are called *by address*: they are compiled once, for the types that they spell out. A function has no entry
points but those that it needs (`jit`): one for Python takes longer to compile than most functions. numba compiles a
function again for each literal integer or flag that it is called with, so constants are ``np.int64(1)`` where that
matters. A named tuple of many arrays, such as `pose.tree.Tree`, is one address (`shared`): it is some two hundred
numbers, which every call would copy. What `lanes` has is not compiled at all: numba writes its instructions into the
caller (`lanes_llvm`), like its own operators.

Public in numba are `njit` and `numba.extending`, which are used where they suffice. Beyond them, `lanes_llvm` and
`shared` use numba's tools for LLVM (`numba.core.cgutils`), `jit` its calling convention, and `cache` its events and
its files of compiled functions.

Lanes
-----
A kernel is written once, with the `rows` of `lanes`. On arrays of shape (n, lanes) it computes as many poses at once as
fill a vector register, on arrays of shape (n,) one. Lanes never mix: a distance does not depend on the other poses in
its register, nor on the number of threads. (In a path lanes are the poses of the path itself; see `path.energy`.)
"""
