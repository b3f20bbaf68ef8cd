"""The sRGB transfer function (IEC 61966-2-1), both ways, for NumPy and for JAX arrays.

Inside the library colour is linear light with sRGB primaries; only `jaxtex.io` meets encoded values. The functions use
the array's own namespace, so reading a photograph into NumPy does not import JAX.
"""

from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    import jax
    import numpy as np

ArrayT = TypeVar("ArrayT", "np.ndarray", "jax.Array")


def srgb_to_linear(encoded: ArrayT) -> ArrayT:
    """Decode sRGB values to linear light.

    Args:
        encoded: floating-point values of any shape, 0 to 1 where they are colours. Values outside are carried on by
            the two pieces of the curve as they stand.

    Returns:
        Linear values of the same shape and dtype.

    Examples:
        >>> import numpy as np
        >>> srgb_to_linear(np.array([0.0, 0.5, 1.0])).round(4)
        array([0.    , 0.214, 1.    ])
    """
    xp = encoded.__array_namespace__()
    # The power is taken of values where it is selected only: of the others it could be NaN, and so could its gradient.
    upper = xp.where(encoded > 0.04045, encoded, 1.0)
    return xp.where(encoded > 0.04045, ((upper + 0.055) / 1.055) ** 2.4, encoded / 12.92)


def linear_to_srgb(linear: ArrayT) -> ArrayT:
    """Encode linear light as sRGB values; the inverse of `srgb_to_linear`.

    Args:
        linear: floating-point values of any shape, 0 to 1 where they can be displayed.

    Returns:
        Encoded values of the same shape and dtype.

    Examples:
        >>> import numpy as np
        >>> linear_to_srgb(np.array([0.0, 0.214, 1.0])).round(2)
        array([0. , 0.5, 1. ])
    """
    xp = linear.__array_namespace__()
    upper = xp.where(linear > 0.0031308, linear, 1.0)
    return xp.where(linear > 0.0031308, 1.055 * upper ** (1 / 2.4) - 0.055, linear * 12.92)
