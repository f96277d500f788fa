"""A tuple that is kept in memory for as long as the process lives, and its address as all that compiled code holds.

A compiled function with many arrays as its constants takes a second to compile. One with an address takes a tenth of
that. The address is of this process only: numba does not cache a function on disk that has one, nor what calls it.
"""

from collections.abc import Callable
from typing import Any

from numba import types
from numba.extending import lower_builtin, models, register_model, typeof_impl

from skpose._compiled.simd.private import AbstractTemplate, impl_ret_borrowed, infer_global, intp_t, ir, signature


class Kept:
    """The address of a tuple that `keep` has stored; without compilation, the tuple."""

    def __init__(self, address: Any):
        self.address = address


class _KeptType(types.Dummy):
    def __init__(self, address: int):
        self.address = address
        super().__init__(f"Kept({address})")


register_model(_KeptType)(models.OpaqueModel)


@typeof_impl.register(Kept)
def _type_of(kept: Kept, _: Any) -> _KeptType:
    return _KeptType(kept.address)


def keep(values: Any) -> Any:
    """Store a tuple for good, in compiled code; return its address."""
    return values


def address_of(kept: Kept) -> Any:
    """Return the address in a `Kept`, a constant of compiled code."""
    return kept.address


@infer_global(keep)
class _Keeping(AbstractTemplate):
    def generic(self, args: tuple, kws: dict) -> Any:
        return signature(types.intp, *args)


@lower_builtin(keep, types.Any)
def _keep(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    layout = context.get_value_type(sig.args[0])
    size = context.get_constant(types.uintp, context.get_abi_sizeof(layout))
    address = builder.ptrtoint(context.nrt.allocate(builder, size), intp_t)
    context.nrt.incref(builder, sig.args[0], args[0])
    builder.store(args[0], builder.inttoptr(address, ir.PointerType()))
    return address


class Layout:
    """The type of a tuple that is kept, as `kept_at` takes it; it is made when it is needed first."""

    def __init__(self, numba_type: Callable[[], Any]):
        self.numba_type = numba_type


class _LayoutType(types.Dummy):
    def __init__(self, kind: Any):
        self.kind = kind
        super().__init__(f"Layout({kind})")


register_model(_LayoutType)(models.OpaqueModel)


@typeof_impl.register(Layout)
def _type_of_layout(layout: Layout, _: Any) -> _LayoutType:
    return _LayoutType(layout.numba_type())


def kept_at(address: Any, layout: Layout) -> Any:
    """Return the tuple of this type that is kept at an address."""
    return address


@infer_global(kept_at)
class _Getting(AbstractTemplate):
    def generic(self, args: tuple, kws: dict) -> Any:
        return signature(args[1].kind, types.intp, args[1])


@lower_builtin(kept_at, types.intp, _LayoutType)
def _kept_at(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    start = builder.inttoptr(args[0], ir.PointerType())
    value = builder.load(start, typ=context.get_value_type(sig.return_type))
    return impl_ret_borrowed(context, builder, sig.return_type, value)


@infer_global(address_of)
class _Address(AbstractTemplate):
    def generic(self, args: tuple, kws: dict) -> Any:
        return signature(types.intp, *args)


@lower_builtin(address_of, _KeptType)
def _address(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    pointer = context.add_dynamic_addr(builder, sig.args[0].address, "skpose")
    return builder.ptrtoint(pointer, intp_t)
