"""Points, sizes and colours as people type them."""

import pytest

from jaxtex.cli.values import parse_colour, parse_point, parse_size
from jaxtex.core.errors import InputError


@pytest.mark.parametrize(
    ("word", "point"), [("3,4", (3, 4)), ("0.5,.25", (0.5, 0.25)), (" 7. , -2 ", (7, -2)), ("+1,1", (1, 1))]
)
def test_points(word: str, point: tuple[float, float]) -> None:
    assert parse_point("--at", word) == point


@pytest.mark.parametrize("word", ["", "3", "3 4", "3,4,5", "a,b", "nan,1", "1e3,2", "3;4"])
def test_no_points(word: str) -> None:
    with pytest.raises(InputError, match=f"--at: '{word}' is no point; write x,y"):
        parse_point("--at", word)


@pytest.mark.parametrize(("word", "size"), [("640x480", (640, 480)), ("640X480", (640, 480)), ("08×9", (8, 9))])
def test_sizes(word: str, size: tuple[int, int]) -> None:
    assert parse_size("--size", word) == size


@pytest.mark.parametrize("word", ["", "640", "640x", "0x5", "5x0", "-5x5", "1.5x2", "640x480x3"])
def test_no_sizes(word: str) -> None:
    with pytest.raises(InputError, match=f"--size: '{word}' is no size; write WIDTHxHEIGHT"):
        parse_size("--size", word)


@pytest.mark.parametrize("word", ["#FF0033", "ff0033", "#f03", "F03"])
def test_colours(word: str) -> None:
    assert parse_colour("--colour", word) == pytest.approx((1, 0, 0.2))


@pytest.mark.parametrize("word", ["", "#", "red", "#ff00", "#ff00330", "#gg0000", "1,0,0"])
def test_no_colours(word: str) -> None:
    with pytest.raises(InputError, match=f"--colour: '{word}' is no colour"):
        parse_colour("--colour", word)
