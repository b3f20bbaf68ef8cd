"""The errors a caller can do something about.

Every error that a file, an option or an argument can cause is a `ValueError`: it is raised before any computing starts
and says what was wrong, where, and what to do. The command line prints it as one line and exits with 2. Results that
are merely bad (a fit that did not converge, a picture that shows no tiling) are values, never errors.
"""


class InputError(ValueError):
    """Something handed in from outside (a file, an option, a picture) cannot be used.

    Examples:
        >>> raise InputError("wall.png: holds no pixels (0 x 0); save the picture again")
        Traceback (most recent call last):
        jaxtex.core.errors.InputError: wall.png: holds no pixels (0 x 0); save the picture again
    """
