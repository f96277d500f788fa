"""Docstrings of public objects are whole, as numpydoc validates them: parameters (PR), returns (RT), sections (GL).

All codes of these three groups hold but GL01: numpydoc 1.8 wants the first line empty, and ours begin there.
Three things are held otherwise. A result that a function returns has attributes, and no parameters that a user
gives. A method of a subclass says what differs, and the public base class has its parameters and returns. A callable
that a class lists among its attributes is no method.
"""

import importlib
import inspect
from pathlib import Path

import pytest
from numpydoc.docscrape import NumpyDocString
from numpydoc.validate import validate

import skpose

PACKAGES = sorted(path.parent.name for path in Path(skpose.__file__).parent.glob("[!_]*/__init__.py"))
NOT_DOCUMENTED = {"PR01", "RT01"}  # parameters, returns


def public_objects():
    """Return all public functions and classes by their full names, each once."""
    found = {}
    for name in PACKAGES:
        module = importlib.import_module(f"skpose.{name}")
        found |= {f"{module.__name__}.{public}": getattr(module, public) for public in module.__all__}
    return {name: value for name, value in found.items() if callable(value)}


def public_members(cls):
    """Return the methods and properties of a class that are written here, each with the class that has it."""
    found = {}
    for owner in reversed([base for base in cls.__mro__ if base.__module__.startswith("skpose")]):
        for name, value in vars(owner).items():
            is_ours = not type(value).__module__.startswith(("sklearn", "collections"))  # set_fit_request; named fields
            if not name.startswith("_") and is_ours and (callable(value) or hasattr(value, "__get__")):
                found[name] = owner
    return found


def attributes(cls):
    """Return the names that a class and its bases list as attributes."""
    listed = [NumpyDocString(inspect.getdoc(base) or "")["Attributes"] for base in cls.__mro__]
    return {name for attributes in listed for attribute in attributes for name in attribute.name.split(", ")}


def is_result(cls):
    """Return whether the public parameters of a class are listed as its attributes, all of them."""
    parameters = {name for name in inspect.signature(cls).parameters if not name.startswith("_")}
    return bool(parameters) and parameters <= attributes(cls)


def errors(name, elsewhere):
    """Return "name: code message" for each error of an object; `elsewhere` are codes that are held otherwise."""
    return [
        f"{name}: {code} {message}"
        for code, message in validate(name)["errors"]
        if code[:2] in ("PR", "RT", "GL") and code not in {"GL01", *elsewhere}
    ]


@pytest.mark.slow
def test_docstrings_are_whole():
    objects, found = public_objects(), []
    for name, value in objects.items():
        if not inspect.isclass(value):
            found += errors(name, set())
            continue
        found += errors(name, {"PR01"} if is_result(value) else set())
        for member, owner in public_members(value).items():
            bases = [base for base in owner.__mro__[1:] if base in objects.values() and member in vars(base)]
            is_described = bases or member in attributes(value)
            found += errors(f"{name}.{member}", NOT_DOCUMENTED if is_described else set())
    assert objects
    assert not found, "\n" + "\n".join(found)
