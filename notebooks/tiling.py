# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # From a photograph of a wall to a model of it
#
# L. Lefebvre and P. Poulin, *Analysis and Synthesis of Structural Textures* (Graphics Interface 2000), turn a
# photograph of a tiled surface into a procedural texture with six parameters: the tiles' width and height, the
# direction of the courses, the thickness of the mortar, the number of tiles and the offset from one course to the
# next. This notebook walks through section 2 of their paper, figure by figure, on a photograph of a brick wall that
# scikit-image ships, and then goes on where the paper stops: the model is differentiable, so what the paper extracts
# is only where a fit begins.
#
# Two things differ from the paper's pictures. This wall was photographed obliquely and lies on its side: its courses
# run downwards and converge. And nobody clicks: the mask, which the paper's user makes by hand, is found.

# %%
import jax
import jax.numpy as jnp
import matplotlib.pyplot as plt
import numpy as np
from skimage import data

import jaxtex as jt
from jaxtex.core.colour import linear_to_srgb, srgb_to_linear

plt.rcParams |= {"figure.dpi": 100, "axes.titlesize": 10, "image.interpolation": "nearest"}


def show(*pictures, titles=(), height=3.6):
    """Pictures side by side, without ticks."""
    ratios = [picture.shape[1] / picture.shape[0] for picture in pictures]
    size = (height * sum(ratios), height + 0.3)
    _, axes = plt.subplots(1, len(pictures), figsize=size, width_ratios=ratios, squeeze=False, layout="constrained")
    for axis, picture, title in zip(axes[0], pictures, [*titles] + [""] * len(pictures), strict=False):
        axis.imshow(np.clip(picture, 0, 1) if picture.ndim == 3 else picture, cmap="gray")
        axis.set(title=title, xticks=[], yticks=[])


# %% [markdown]
# Pictures are linear light inside jaxtex; `srgb_to_linear` undoes the encoding of the file. (`jt.read_image` does it
# for files.)

# %%
photo = srgb_to_linear(data.brick() / 255).astype(np.float32)[..., None]
size = photo.shape[1], photo.shape[0]
show(linear_to_srgb(photo), titles=["The photograph"])

# %% [markdown]
# ## The mask
#
# "We start by segmenting the color texture into a binary mask", white on tiles and black on joints. The paper offers
# tools for that: thresholds, edge detectors, morphology. They are all here, as functions and as `jaxtex mask ...`.
# This wall is easy for the first of them, a threshold in the valley of the histogram, with the specks removed after;
# `jt.auto_mask` does without being told that the joints are the light part.

# %%
by_threshold = jt.remove_small_regions(jt.threshold_mask(photo, joints="light"), 60)
mask = jt.auto_mask(photo)
show(linear_to_srgb(photo), by_threshold, mask, titles=["Photograph", "Threshold, specks removed", "Found by itself"])

# %% [markdown]
# ## Height and direction: the spectrum (figure 3)
#
# The Fourier transform of the mask shows the lines of the courses as a row of bright points through the centre. The
# nearest bright point $(\hat x, \hat y)$ gives the height of the courses and their direction, equations 1 and 2 of
# the paper:
#
# $$\mathrm{height} = \frac{N}{\sqrt{\hat x^2 + \hat y^2}}, \qquad
#   \mathrm{angle} = \arctan \frac{\hat x}{\hat y}$$
#
# where $N$ is the picture's size and $(\hat x, \hat y)$ is counted from the centre of the spectrum. (The paper prints
# $R/(2\sqrt{\cdot})$ with $2R = N$, a quarter of this; but what repeats $k$ times in a picture of $N$ pixels is $N/k$
# high.)
#
# Perspective smears the points into streaks, because courses that are far away are narrower. The transform is taken
# here of a window in the middle of the picture, where the courses are of about one width.

# %%
side = 256
corner = [(length - side) // 2 for length in mask.shape]
window = mask[corner[0] : corner[0] + side, corner[1] : corner[1] + side].astype(float)
taper = np.hanning(side)[:, None] * np.hanning(side)
spectrum = np.abs(np.fft.fftshift(np.fft.fft2((window - window.mean()) * taper)))
fy, fx = np.indices(spectrum.shape) - side // 2
half_plane = (fx > 0) & (np.hypot(fx, fy) > 3)
row, column = np.unravel_index(np.argmax(np.where(half_plane, spectrum, 0)), spectrum.shape)
peak = np.array([column, row]) - side // 2
course_height = side / np.hypot(*peak)
direction = np.degrees(np.arctan2(peak[1], peak[0])) + 90

near = slice(side // 2 - 48, side // 2 + 49)
show(window, -np.log1p(spectrum[near, near]), titles=["Mask, middle", "Negative of its spectrum, and the peak"])
axis = plt.gcf().axes[1]
axis.plot(48 + peak[0], 48 + peak[1], "o", mfc="none", mec="tab:red", ms=12)
axis.plot([48, 48 + peak[0]], [48, 48 + peak[1]], color="tab:red", lw=1)
print(f"peak {peak}: courses of {course_height:.1f} pixels, running at {direction:.1f} degrees")

# %% [markdown]
# `fit_tiling` does the same on maps of likely joints instead of one binary mask, with two refinements: the peak is
# found between bins, and of all oblique views of the plane the one is taken that makes the peak sharpest. So it needs
# no rectified photograph.
#
# ## The fit, in one call
#
# All that follows looks into the result of this one call.

# %%
fit = jt.fit_tiling(photo)
print("a tiling:", fit.ok)
print(f"bond: {fit.tiling.bond}; {fit.rows} courses of {fit.columns} tiles")

# %% [markdown]
# ## Width and offset: scanlines (section 2.2)
#
# "We rotate the mask backward by the angle previously measured in order to align it with the axes of the image", and
# trace scanlines along the courses. The lattice coordinates of the fitted model do that and undo the perspective as
# well. Each row below is one course, averaged over its height: the joints between its bricks stand out as dips. How
# they step from row to row is the offset; where courses are laid freely, each has an offset of its own.

# %%
start = fit.start
w, h = float(start.tile_width), float(start.tile_height)
middle = np.asarray(start.to_lattice(jnp.array([size[0] / 2, size[1] / 2])))
first = round(float(middle[1]) / h) - 3
along = middle[0] + np.linspace(-1.6 * w, 1.6 * w, 500)
within = np.linspace(0.3, 0.7, 9)


def scan(course):
    """The observed mask along one course, averaged across it."""
    q = np.stack(np.meshgrid(along, (course + within) * h), axis=-1).reshape(-1, 2)
    x, y = np.asarray(jax.vmap(start.from_lattice)(jnp.asarray(q))).T
    inside = (x >= 0) & (y >= 0) & (x < size[0]) & (y < size[1])
    values = np.where(inside, fit.mask[y.astype(int).clip(0, size[1] - 1), x.astype(int).clip(0, size[0] - 1)], np.nan)
    return values.reshape(len(within), -1).mean(axis=0)


figure, axis = plt.subplots(figsize=(8, 3.6), layout="constrained")
for number in range(6):
    course = first + number
    axis.fill_between((along - along[0]) / w, 1.25 * number, 1.25 * number + scan(course), color="0.75", lw=0)
    shift = float(start.offset) * course + start.course_offsets[course % len(start.course_offsets)]
    heads = (shift - along[0] / w) % 1 + np.arange(3)
    axis.vlines(heads, 1.25 * number, 1.25 * number + 1, color="tab:red", lw=1)
axis.set(xlabel="along the course, in tile widths", ylabel="course", yticks=[], xlim=(0, 3.2))
axis.set_title("Mask along six courses; red: head joints of the start")
plt.show()

# %% [markdown]
# Some bricks of this wall are halves, so some dips have no red line: the model has one length of brick, and takes the
# lattice that explains most of the joints. The paper takes medians over tiles for the same reason.
#
# ## From the start to the fit
#
# The paper's parameters end here. They are good to about a pixel, as the start below shows; over fifteen courses
# small errors of pitch and direction add up. The model renders a mask that is smooth in every parameter, so least
# squares can move all of them together, perspective included, until the rendered mask lies on the observed one.

# %%
rendered = [np.asarray(jt.coverage_grid(tiling, size[1], size[0])) for tiling in (fit.start, fit.tiling)]


def compare(rendered):
    """Red: joint only in the photograph; cyan: only in the model; black: in both."""
    return np.stack([rendered, fit.mask, fit.mask], axis=-1)


show(fit.mask, *map(compare, rendered), titles=["Observed mask", "Start against it", "Refined against it"])
names = ("tile_width", "tile_height", "angle_deg", "mortar_x", "mortar_y", "offset")
tables = [jt.tiling_parameters(tiling, rows=fit.rows, columns=fit.columns) for tiling in (fit.start, fit.tiling)]
print(f"{'':12} {'start':>9} {'refined':>9}   standard error")
for name in names:
    print(f"{name:12} {tables[0][name]:9.3f} {tables[1][name]:9.3f} ± {fit.standard_errors.get(name, np.nan):.3f}")

# %%
show(linear_to_srgb(jt.draw_overlay(photo, fit.tiling)), titles=["The fitted tiling over the photograph"], height=5.5)

# %% [markdown]
# ## What the gradient sees
#
# Why that works: the soft mask has a derivative with respect to every parameter. Where a parameter grows, pixels at
# the edges of joints turn from tile to joint (blue) or from joint to tile (red). A grain of dirt has no such pattern;
# that is why least squares passes over it. Forward mode gives a whole picture of derivatives at once.

# %%
lattice_view = jt.make_tiling(tile_width=60, tile_height=24, mortar_x=4, mortar_y=4, offset=0.5, angle=0.1)


def derivative(name, rows=120, columns=160):
    """The derivative of every pixel of the mask with respect to one parameter."""

    def mask_of(value):
        leaves = {field: getattr(lattice_view, field) for field in lattice_view.__dataclass_fields__}
        return jt.coverage_grid(jt.Tiling(**leaves | {name: value}), rows, columns, blur=1.0)

    value = getattr(lattice_view, name)
    return jax.jvp(mask_of, (value,), (jnp.ones_like(value),))[1]


figure, axes = plt.subplots(2, 3, figsize=(9, 4.8), layout="constrained")
for axis, name in zip(axes.flat, ("tile_width", "tile_height", "angle", "mortar_x", "mortar_y", "offset"), strict=True):
    picture = np.asarray(derivative(name))
    limit = np.abs(picture).max()
    axis.imshow(picture, cmap="RdBu_r", vmin=-limit, vmax=limit)
    axis.set(title=f"d mask / d {name}", xticks=[], yticks=[])
plt.show()

# %% [markdown]
# ## The material, at any resolution (figure 4)
#
# The model has no pixels, so maps of it can be made at any size. The colour of each brick is the photograph's; joints
# lie deeper than faces by an amount that a photograph does not show and that can be edited in the model file. Courses
# come out horizontal and the perspective is gone. First the whole wall, then three courses of it at eight times the
# photograph's resolution.

# %%
pixels, _ = jt.even_out(photo)
appearance = jt.measure_appearance(pixels, fit.tiling, mask=fit.mask)
report = {"ok": fit.ok, "reason": fit.reason, "iou": fit.iou, "start": tables[0], "standard_errors": {}}
file = jt.TilingFile(fit.tiling, jt.SourceImage(*size, "0" * 64), fit.rows, fit.columns, report, appearance.to_json())


def render(tiles, scale):
    """Maps of so many (columns, rows) of tiles, `scale` times as large as in the photograph."""
    sheet = jt.lay_photographed_sheet(file, tiles=tiles)
    large = tuple(round(scale * side) for side in sheet.natural_size)
    bands = jt.render_maps(sheet, appearance, size=large, key=jax.random.key(0))
    maps = jt.Maps(*map(np.concatenate, zip(*bands, strict=True)))
    return maps, linear_to_srgb(jt.shade_maps(maps, pixel=sheet.width / large[0]))


wall, lit = render((fit.columns, fit.rows), 1)
_, close = render((2, 3), 8)
show(lit, close, titles=["Under a lamp", "Three courses, eight times larger"])

# %%
normal = 0.5 * wall.normal + 0.5
maps = [linear_to_srgb(wall.base_colour), wall.height, normal, np.dstack([wall.roughness] * 3)]
show(*maps, titles=["Base colour", "Height", "Normal", "Roughness"], height=2.6)

# %% [markdown]
# ## Departures from the paper
#
# - The mask is found, not clicked; the paper's tools are there for the cases where that fails.
# - The homography is a parameter, where the paper takes rectified textures.
# - Spectrum and scanlines are where the fit begins, not its end.
# - Joints have two thicknesses; courses may have more than one length of tile, or be shifted freely.
# - The interiors of tiles are, so far, one colour each; the paper fills them with the Heeger-Bergen method.
