"""Checks of arguments, one module for each kind of object.

The modules are below `skpose.skeleton`, whose classes use them too, so they recognise a skeleton or a motion by its
attributes. Internal; other packages import the modules.
"""
