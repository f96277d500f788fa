"""Checks of arguments, a module for each kind, with errors that say what to pass instead.

The room stands below `skpose.skeleton`, whose classes check their own arguments here: a skeleton or a motion is
recognised by what its class has (`skeletons.py`, `motions.py`), not by the class. What compares skeletons with each
other, or needs their rest pose, stands with them.

Internal as a whole; other packages import its modules.
"""
