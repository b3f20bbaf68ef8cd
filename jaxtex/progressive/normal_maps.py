"""Normals that turn with the things that they are of."""

import numpy as np
import numpy.typing as npt


def is_signed(normals: npt.ArrayLike) -> bool:
    """Whether a map of normals holds numbers from -1 to 1 as they are; else they are written as 0 to 1. That reading is
    taken in which lengths come nearer to 1.

    Args:
        normals: floats, [row, col, 3].

    Examples:
        >>> is_signed([[[0.0, 0.0, 1.0]]]), is_signed([[[0.5, 0.5, 1.0]]])
        (True, False)
    """
    vectors = np.asarray(normals, np.float32)

    def miss(read: npt.NDArray[np.float32]) -> float:
        return float(np.median(np.abs(np.linalg.norm(read, axis=-1) - 1)))

    return miss(vectors) <= miss(2 * vectors - 1)


def turn_normals(normals: npt.ArrayLike, orientation: npt.ArrayLike) -> npt.NDArray[np.float32]:
    """Directions of a texture that is made of turned pieces, from those that stand in the pieces.

    Args:
        normals: [row, col, 3]: x right, y up, z out of the picture (OpenGL's), of any length.
        orientation: radians by which things are turned, clockwise as seen, [row, col].

    Returns:
        Unit vectors, float32 [row, col, 3]; straight out of the picture where a length is 0.

    Raises:
        ValueError: arrays of another form.

    Examples:
        >>> turn_normals([[[0.6, 0.0, 0.8]]], [[0.5 * np.pi]]).round(3) + 0.0  # what looked right looks down
        array([[[ 0. , -0.6,  0.8]]], dtype=float32)
    """
    vectors, angles = np.asarray(normals, np.float32), np.asarray(orientation, np.float32)
    if vectors.ndim != 3 or vectors.shape[2] != 3 or angles.shape != vectors.shape[:2]:
        raise ValueError(
            f"normals of shape {vectors.shape}, orientation {angles.shape}: give [row, col, 3], [row, col]"
        )
    x, y, z = np.moveaxis(vectors, -1, 0)
    cosine, sine = np.cos(angles), np.sin(angles)
    turned = np.stack([cosine * x + sine * y, cosine * y - sine * x, z], axis=-1)
    lengths = np.linalg.norm(turned, axis=-1, keepdims=True)
    outwards = np.broadcast_to(np.array([0, 0, 1], np.float32), turned.shape).copy()
    return np.divide(turned, lengths, out=outwards, where=lengths > 0)
