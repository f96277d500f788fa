"""Signatures are readable where users see them: in `help`, in notebooks, in an editor."""

import importlib
import inspect
from pathlib import Path

import numpy.typing

import skpose

PACKAGES = sorted(path.parent.name for path in Path(skpose.__file__).parent.glob("[!_]*/__init__.py"))
LONGEST = 130  # characters of a parameter, which is a line and a bit


def public_callables():
    """All public functions, classes and methods, by their names."""
    for module in [skpose, *(importlib.import_module(f"skpose.{name}") for name in PACKAGES)]:
        for name in module.__all__:
            value = getattr(module, name)
            if callable(value):
                yield f"{module.__name__}.{name}", value
            methods = vars(value) if inspect.isclass(value) else ()
            for method in methods:
                if not method.startswith("_") and callable(getattr(value, method)):
                    yield f"{module.__name__}.{name}.{method}", getattr(value, method)


def test_parameters_are_short_and_have_no_private_types_of_numpy():
    signatures = {name: inspect.signature(value) for name, value in public_callables()}
    assert len(signatures) > 150
    assert "ArrayLike" in str(signatures["skpose.inverse_kinematics"])
    for name, signature in signatures.items():
        returned = inspect.formatannotation(signature.return_annotation)
        for text in [*map(str, signature.parameters.values()), returned]:
            assert len(text) <= LONGEST, f"{name}: {text}"
            assert "numpy._typing" not in text, f"{name}: {text}, import ArrayLike from skpose._typing"
            assert "_Buffer" not in text, f"{name}: {text}, import ArrayLike from skpose._typing"


def test_the_stand_in_has_the_name_of_what_it_stands_for():
    annotation = inspect.signature(skpose.pose_distances).parameters["X"].annotation
    assert hasattr(numpy.typing, annotation.__name__)
    assert f"{annotation.__module__}.{annotation.__name__}" == "numpy.typing.ArrayLike"
