"""How courses follow each other in the bonds that masons have names for."""

from typing import Any


def bond_pattern(bond: str, *, header: float = 0.5) -> dict[str, Any]:
    """The arguments of `make_tiling` that make a named bond.

    Args:
        bond: `stack`: head joints in line; `running`: each course half a tile on; `english`: courses of stretchers and
            courses of headers by turns; `flemish`: stretchers and headers by turns in every course.
        header: pitch of a header in units of a stretcher's. Headers sit in the middle of stretchers; in an English
            bond, where it is not 0.5, only at the origin.

    Raises:
        ValueError: for raking and irregular bonds, which are whatever their offsets are.

    Examples:
        >>> from jaxtex.models.tiling import make_tiling
        >>> make_tiling(tile_width=90.0, tile_height=30.0, **bond_pattern("flemish")).course_lengths.tolist()
        [[1.0, 0.5]]
    """
    patterns: dict[str, dict[str, Any]] = {
        "stack": {},
        "running": {"offset": 0.5},
        "english": {"course_lengths": [[1.0], [header]], "course_offsets": [0.0, 0.5 * header]},
        "flemish": {"course_lengths": [[1.0, header]], "course_offsets": [0.0, 0.5 * (1.0 + header)]},
    }
    if bond not in patterns:
        raise ValueError(f"bond {bond!r} has no pattern of its own; these have: {', '.join(patterns)}")
    return {"bond": bond, **patterns[bond]}
