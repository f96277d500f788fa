"""All that skpose takes from numba's and llvmlite's private parts and cannot do without, each name once.

What it can do without, at a price, is imported where it is used: in `compiler` and `cache`, see `fallback`.
"""

import numba

FITTING = ">=0.62,<0.69"  # versions of numba that were tested, as in pyproject.toml

try:
    from llvmlite import binding, ir
    from numba.core.cgutils import (
        alloca_once,
        alloca_once_value,
        create_struct_proxy,
        false_bit,
        for_range,
        get_or_insert_function,
        global_constant,
        if_unlikely,
        int8_t,
        int32_t,
        intp_t,
        is_not_null,
        is_null,
        memset,
        true_bit,
        voidptr_t,
    )
    from numba.core.compiler import Compiler
    from numba.core.dispatcher import Dispatcher
    from numba.core.imputils import impl_ret_borrowed, impl_ret_new_ref
    from numba.core.typing.npydecl import parse_dtype
    from numba.core.typing.templates import (
        AbstractTemplate,
        AttributeTemplate,
        Signature,
        infer_global,
        make_concrete_template,
        signature,
    )
    from numba.np.arrayobj import populate_array
except ImportError as error:
    raise ImportError(
        f"numba {numba.__version__} lacks a part that skpose needs ({error}): this version of skpose was tested with "
        f"numba{FITTING}; install one of these (pip install 'numba{FITTING}'), or a newer skpose"
    ) from error

__all__ = [
    "AbstractTemplate",
    "AttributeTemplate",
    "Compiler",
    "Dispatcher",
    "Signature",
    "alloca_once",
    "alloca_once_value",
    "binding",
    "create_struct_proxy",
    "false_bit",
    "for_range",
    "get_or_insert_function",
    "global_constant",
    "if_unlikely",
    "impl_ret_borrowed",
    "impl_ret_new_ref",
    "infer_global",
    "int8_t",
    "int32_t",
    "intp_t",
    "ir",
    "is_not_null",
    "is_null",
    "make_concrete_template",
    "memset",
    "parse_dtype",
    "populate_array",
    "signature",
    "true_bit",
    "voidptr_t",
]
