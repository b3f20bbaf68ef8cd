"""Points, sizes and colours as people type them."""

import pytest

from jaxtex.cli.values import check_seed, parse_assignments, parse_block, parse_colour, parse_point, parse_size
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


@pytest.mark.parametrize("word", ["64x128x256", " 064X128×256 "])
def test_blocks(word: str) -> None:
    assert parse_block("--block", word) == (64, 128, 256)


@pytest.mark.parametrize("word", ["", "64", "64x64", "64x64x0", "1x2x3x4", "-1x2x3"])
def test_no_blocks(word: str) -> None:
    with pytest.raises(InputError, match=f"--block: '{word}' is no block; write DEPTHxHEIGHTxWIDTH"):
        parse_block("--block", word)


@pytest.mark.parametrize("word", ["#FF0033", "ff0033", "#f03", "F03"])
def test_colours(word: str) -> None:
    assert parse_colour("--colour", word) == pytest.approx((1, 0, 0.2))


@pytest.mark.parametrize("word", ["", "#", "red", "#ff00", "#ff00330", "#gg0000", "1,0,0"])
def test_no_colours(word: str) -> None:
    with pytest.raises(InputError, match=f"--colour: '{word}' is no colour"):
        parse_colour("--colour", word)


def test_assignments() -> None:
    words = ["angle_deg=-1.5", " mortar_x = .25 ", "tile_width=1e2"]
    assert parse_assignments("--fix", words) == {"angle_deg": -1.5, "mortar_x": 0.25, "tile_width": 100.0}
    assert parse_assignments("--fix", []) == {}


@pytest.mark.parametrize("word", ["", "a", "=3", "a=", "a=b", "a=nan", "a=1=2", "a b=3", "a:3"])
def test_no_assignments(word: str) -> None:
    with pytest.raises(InputError, match=f"--fix: '{word}' gives no parameter a number; write name=number"):
        parse_assignments("--fix", [word])


def test_a_parameter_is_given_once() -> None:
    with pytest.raises(InputError, match="--fix: a is given twice"):
        parse_assignments("--fix", ["a=1", "a=1"])


@pytest.mark.parametrize(("seed", "known"), [(0, True), (2**32 - 1, True), (-1, False), (2**32, False)])
def test_seeds(seed: int, known: bool) -> None:
    if known:
        assert check_seed(seed) == seed
    else:
        with pytest.raises(InputError, match=f"--seed: {seed} is out of range"):
            check_seed(seed)
