"""Boards drawn as photographs show them, uneven, wavy, full of pores, and pictures of anything else."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage
from skimage import data

from jaxtex.core.colour import srgb_to_linear
from jaxtex.core.errors import InputError
from jaxtex.fitting.wood import WoodFit, fit_wood

Array = NDArray[np.float64]

SHAPE = 256, 320
BROWN = np.array([0.55, 0.33, 0.17])


def lay(turn: float) -> tuple[Array, Array]:
    v, u = np.indices(SHAPE) + 0.5 - np.array(SHAPE).reshape(2, 1, 1) / 2
    return u * np.cos(turn) + v * np.sin(turn), v * np.cos(turn) - u * np.sin(turn)


def shade_rings(level: Array, widths: Array, rng: np.random.Generator) -> tuple[Array, Array]:
    """Lightness of rings of so many widths, and which ring each place belongs to: late wood begins softly and ends
    sharply."""
    edges = level.min() - 1 + np.append(0.0, np.cumsum(widths))
    ring = np.interp(level, edges, np.arange(len(edges)))
    depth = 0.45 * rng.uniform(0.8, 1.2, len(edges))[ring.astype(int)]
    return 1 - depth * (ring % 1) ** 3, ring


def draw_streaks(points: Array, turn: float, length: int) -> Array:
    """Points drawn out along the grain."""
    steps = np.arange(-2 * length, 2 * length + 1)
    moved = [
        np.exp(-0.5 * (step / length) ** 2)
        * ndimage.shift(points, (step * np.cos(turn), -step * np.sin(turn)), order=1, mode="wrap")
        for step in steps
    ]
    return np.sum(moved, axis=0)


def light_up(tone: Array) -> Array:
    """The board under a lamp that stands to its lower right, as a linear picture."""
    down, right = (np.linspace(0, 1, n) for n in SHAPE)
    return np.clip(tone * (0.7 + 0.5 * right[None] + 0.3 * down[:, None]), 0, 1)[..., None] * BROWN


def draw_board(degrees: float, *, spacing: float = 16.0, seed: int = 0, closed: bool = False) -> tuple[Array, Array]:
    """A board, straight-grained or with rings that are ``closed``, its axis turned by so much from upright, and its
    rings (H, W)."""
    rng, turn = np.random.default_rng(seed), np.radians(degrees)
    across, along = lay(turn)
    level = across + 5 * np.cos(along / 40) + 3 * np.cos(along / 28 + across / 60)
    if closed:
        level = np.hypot(across + 20 + 4 * np.cos(along / 40), 0.25 * (along - 10)) + 2 * np.cos(across / 25)
    tone, ring = shade_rings(level, spacing * rng.uniform(0.6, 1.4, 99), rng)
    fibres = draw_streaks(rng.normal(size=SHAPE), turn, 10)
    pores = draw_streaks((rng.random(SHAPE) < 0.004).astype(float), turn, 3)
    tone *= (1 + 0.05 * fibres / fibres.std()) * (1 - 0.5 * pores / pores.max())
    return light_up(tone + rng.normal(0, 0.02, SHAPE)), ring


def draw_end_grain(pith: tuple[float, float], *, spacing: float = 9.0, seed: int = 0) -> Array:
    """The end of a trunk: rings a little out of round, and bright rays across them."""
    rng = np.random.default_rng(seed)
    v, u = np.indices(SHAPE) + 0.5
    x, y = u - pith[0], v - pith[1]
    radius, turn = np.hypot(x, y), np.arctan2(y, x)
    tone, _ = shade_rings(
        radius + 3 * np.sin(3 * turn) * radius / (radius + 30), spacing * rng.uniform(0.7, 1.3, 99), rng
    )
    rays = np.zeros(SHAPE)
    for toward in rng.uniform(-np.pi, np.pi, 90):
        aside = np.abs(np.angle(np.exp(1j * (turn - toward)))) * radius
        rays = np.maximum(rays, np.exp(-0.5 * (aside / 0.8) ** 2) * (radius > rng.uniform(0, 80)))
    return light_up(tone * (1 + 0.2 * rays) + rng.normal(0, 0.04, SHAPE))


def pith_of(fit: WoodFit) -> Array:
    """Where the axis meets the picture, (x, y) in pixels from its corner."""
    assert float(fit.wood.tilt) > 0, "the axis does not meet the picture"
    turn, across = float(fit.wood.rotation), float(fit.wood.center[0])
    along = float(fit.wood.center[1]) / np.sin(float(fit.wood.tilt))
    middle = np.array([SHAPE[1] / 2, SHAPE[0] / 2])
    return middle + across * np.array([np.cos(turn), np.sin(turn)]) + along * np.array([-np.sin(turn), np.cos(turn)])


def turn_apart(a: float, b: float) -> float:
    return abs((a - b + 90) % 180 - 90)


@pytest.fixture(scope="module")
def board() -> Array:
    return draw_board(70.0)[0]


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("degrees", [0, 25, 90, 135, 178])
def test_a_board_is_read(degrees: float, seed: int) -> None:
    photo, ring = draw_board(degrees, seed=seed)
    fit = fit_wood(photo)
    assert fit.ok, fit.reason
    assert turn_apart(np.degrees(float(fit.wood.rotation)), degrees) < 5.0
    assert np.ptp(fit.rings) == pytest.approx(np.ptp(ring), rel=0.1)
    # Straight rings bend around no axis.
    assert not fit.determined["center"]
    assert not fit.determined["tilt_deg"]
    assert fit.determined["rotation_deg"]
    assert fit.standard_errors["tilt_deg"] is None
    assert fit.standard_errors["center"] == [None, None]


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1])
def test_its_rings_are_those_drawn(seed: int) -> None:
    photo, ring = draw_board(40.0, seed=seed)
    fit = fit_wood(photo)
    # Counted from anywhere, and either way.
    seen, drawn = fit.rings[::4, ::4].ravel(), ring[::4, ::4].ravel()
    sense = np.sign(np.polyfit(drawn, seen, 1)[0])
    aside = sense * seen - drawn
    assert (np.abs(aside - np.median(aside)) < 0.5).mean() > 0.9
    light, dark = photo[fit.mask].mean(), photo[~fit.mask].mean()
    assert light > 1.1 * dark
    assert fit.iou[1] > fit.iou[0]
    assert fit.clear.mean() > 0.9


@pytest.mark.slow
@pytest.mark.parametrize("degrees", [90.0, 10.0])
def test_closed_rings_are_followed_around(degrees: float) -> None:
    photo, ring = draw_board(degrees, closed=True)
    fit = fit_wood(photo)
    assert fit.ok, fit.reason
    assert turn_apart(np.degrees(float(fit.wood.rotation)), degrees) < 5.0
    seen, drawn = fit.rings[::4, ::4].ravel(), ring[::4, ::4].ravel()
    assert abs(np.corrcoef(seen, drawn)[0, 1]) > 0.95
    # The model's own rings close as well, there where they do.
    middle = np.unravel_index(ring.argmin(), ring.shape)
    ends = [
        (middle[0] + s * 70 * np.cos(np.radians(degrees)), middle[1] - s * 70 * np.sin(np.radians(degrees)))
        for s in (-1, 1)
    ]
    inside = fit.rings[middle]
    beyond = [fit.rings[round(y), round(x)] for y, x in ends]
    assert min(abs(each - inside) for each in beyond) > 0.5
    assert np.sign(beyond[0] - inside) == np.sign(beyond[1] - inside)


@pytest.mark.slow
@pytest.mark.parametrize("pith", [(160.0, 128.0), (101.3, 150.8), (250.0, 70.0)])
def test_the_pith_of_end_grain_is_found(pith: tuple[float, float]) -> None:
    fit = fit_wood(draw_end_grain(pith))
    assert fit.ok, fit.reason
    np.testing.assert_allclose(pith_of(fit), pith, atol=0.03 * SHAPE[1])
    assert float(fit.wood.tilt) == pytest.approx(np.pi / 2, abs=0.1)
    assert float(fit.wood.ring_spacing) == pytest.approx(9.0, rel=0.15)


@pytest.mark.slow
def test_where_the_pith_is_told_its_error_is_told() -> None:
    """An error that is as good as none says that the pith lies exactly there."""
    off, told = [], []
    for seed, pith in enumerate([(160.0, 128.0), (101.3, 150.8)]):
        fit = fit_wood(draw_end_grain(pith, seed=seed))
        assert fit.determined["center"]
        off += list(pith_of(fit) - pith)
        told += fit.standard_errors["center"]
    assert np.sqrt(np.mean(np.square(off))) < 3 * np.sqrt(np.mean(np.square(told)))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["brick", "gravel"])
def test_other_pictures_are_no_wood(name: str) -> None:
    picture = srgb_to_linear(getattr(data, name)() / 255).reshape(256, 2, 256, 2).mean(axis=(1, 3))
    fit = fit_wood(picture)
    assert not fit.ok
    assert fit.reason
    assert fit.mask.shape == fit.rings.shape == (256, 256)


@pytest.mark.parametrize("noise", [0.0, 1e-4])
def test_a_flat_card_is_no_wood(noise: float) -> None:
    card = 0.4 + noise * np.random.default_rng(0).normal(size=(96, 96))
    fit = fit_wood(card)
    assert not fit.ok
    assert "one lightness" in fit.reason
    assert not any(fit.determined[name] for name in ("center", "tilt_deg", "rotation_deg", "ring_spacing"))


@pytest.mark.slow
@pytest.mark.parametrize(
    "held",
    [
        {"rotation_deg": 68.0},
        {"ring_spacing": 15.0, "early_fraction": 0.55},
        {"tilt_deg": 3.0},
        {"xc": 300.0, "yc": -40.0},
        {"xc": -250.0, "yc": 20.0, "tilt_deg": 5.0, "rotation_deg": 71.0, "ring_spacing": 16.5, "early_fraction": 0.7},
    ],
    ids=lambda held: "-".join(held),
)
def test_what_is_held_is_kept_exactly(board: Array, held: dict[str, float]) -> None:
    fit = fit_wood(board, fix=held)
    wood = fit.wood
    values = {
        "xc": wood.center[0],
        "yc": wood.center[1],
        "tilt_deg": np.degrees(wood.tilt),
        "rotation_deg": np.degrees(wood.rotation),
        "ring_spacing": wood.ring_spacing,
        "early_fraction": wood.early_fraction,
    }
    for name, value in held.items():
        # As exactly as single precision has it.
        assert float(values[name]) == pytest.approx(value, rel=1e-6), name


@pytest.mark.slow
@pytest.mark.parametrize("middle", [(180.0, 120.0), (151.3, 140.9)])
def test_the_pith_is_where_the_user_says(middle: tuple[float, float]) -> None:
    fit = fit_wood(draw_end_grain((165.0, 130.0)), ellipse_center=middle)
    np.testing.assert_allclose(pith_of(fit), middle, atol=1e-3)


REFUSED: list[tuple[dict[str, Any], str]] = [
    ({"fix": {"mortar": 3.0}}, "mortar: no such parameter"),
    ({"fix": {"tilt": 3.0}}, "tilt: no such parameter"),
    ({"fix": {"tilt_deg": 90.5}}, "tilt_deg is 90.5; give degrees from 0 to 90"),
    ({"fix": {"tilt_deg": -1.0}}, "tilt_deg is -1"),
    ({"fix": {"rotation_deg": 181.0}}, "rotation_deg is 181"),
    ({"fix": {"ring_spacing": 0.0}}, "ring_spacing is 0"),
    ({"fix": {"ring_spacing": np.inf}}, "ring_spacing is inf"),
    ({"fix": {"early_fraction": 1.0}}, "early_fraction is 1"),
    ({"fix": {"xc": np.nan}}, "xc is nan"),
    ({"ellipse_center": (-1.0, 5.0)}, "not in the picture"),
    ({"ellipse_center": (5.0, 257.0)}, "not in the picture"),
    ({"ellipse_center": (np.nan, 5.0)}, "not in the picture"),
    ({"ellipse_center": (5.0, 5.0), "fix": {"yc": 3.0}}, "say the same"),
    ({"mask": np.zeros((4, 4), bool)}, "mask has shape"),
    ({"mask": np.ones(SHAPE, bool)}, "mask"),
]


@pytest.mark.parametrize(("options", "said"), REFUSED, ids=lambda each: each if isinstance(each, str) else "")
def test_what_cannot_be_held_is_refused(board: Array, options: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        fit_wood(board, **options)
