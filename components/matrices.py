"""Tables in a flat vector: a part of it seen as rows and columns, without what numba's reshape needs of its runtime."""

from __future__ import annotations

from typing import TYPE_CHECKING

from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.arrayobj import make_array, populate_array

if TYPE_CHECKING:
    import numpy as np


def _view(typingctx, vector, start, rows, columns):
    """What numba makes of `table`."""
    result = types.Array(types.float64, 2, "C")

    def generate(context, builder, signature, arguments):
        source = make_array(signature.args[0])(context, builder, arguments[0])
        made = make_array(result)(context, builder)
        size = context.get_constant(types.intp, 8)
        populate_array(
            made,
            data=cgutils.gep(builder, source.data, arguments[1]),
            shape=[arguments[2], arguments[3]],
            strides=[builder.mul(arguments[3], size), size],
            itemsize=size,
            meminfo=None,
        )
        return made._getvalue()

    return result(vector, types.int64, types.int64, types.int64), generate


if TYPE_CHECKING:

    def table(vector: np.ndarray, start: int, rows: int, columns: int) -> np.ndarray:
        """The numbers vector[start : start + rows * columns] as an array (rows, columns), row by row, for kernels.

        vector: (n,) contiguous float64. Nothing is copied, and what lies beyond its end is not checked.
        """
        ...
else:
    table = intrinsic(_view)
