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
# # From a picture of a plank to the wood it was cut from
#
# Section 3 of L. Lefebvre and P. Poulin, *Analysis and Synthesis of Structural Textures* (Graphics Interface 2000),
# turns a picture of wood into a solid: rings of early and late wood around the axis of a trunk, cut by a plank. The
# solid can then be cut again, anywhere and in any direction. This notebook draws planks, fits them back, and looks at
# what a picture of a plank tells about the trunk, and what it cannot tell.
#
# All pictures here are generated, so that the truth is known.

# %%
import jax
import jax.numpy as jnp
import matplotlib.pyplot as plt
import numpy as np

import jaxtex as jt
from jaxtex.core.colour import linear_to_srgb
from jaxtex.fitting.wood import fit_wood

plt.rcParams |= {"figure.dpi": 100, "axes.titlesize": 10, "image.interpolation": "nearest"}
size = 256


def show(*pictures, titles=(), height=3.2, **options):
    """Pictures side by side, without ticks."""
    ratios = [picture.shape[1] / picture.shape[0] for picture in pictures]
    extent = (height * sum(ratios), height + 0.3)
    _, axes = plt.subplots(1, len(pictures), figsize=extent, width_ratios=ratios, squeeze=False, layout="constrained")
    for axis, picture, title in zip(axes[0], pictures, [*titles] + [""] * len(pictures), strict=False):
        axis.imshow(np.clip(picture, 0, 1) if picture.ndim == 3 else picture, **({"cmap": "gray"} | options))
        axis.set(title=title, xticks=[], yticks=[])
    return axes[0]


def photograph(wood):
    """The plank's face in linear light, a pixel to each of the model's."""
    bands = jt.render_wood(wood, across=size, size=(size, size))
    return np.concatenate([band.base_colour for band in bands])


# %% [markdown]
# ## The model (section 3.1)
#
# A point of the plank is turned by `rotation`, leant by `tilt`, and has then a distance from the axis at `center`. The
# distance in ring spacings decides between early wood (light, grown in spring) and late wood. In the paper a plank that
# is cut along the trunk has tilt 0, and end grain has 90 degrees; in between, the axis pierces the plank and rings are
# ellipses.

# %%
planks = {
    "Along the trunk": {"center": (-70, 30), "tilt": 0.02},
    "Leaning by 8°": {"center": (-40, 14), "tilt": np.radians(8)},
    "Leaning by 40°": {"center": (-20, 10), "tilt": np.radians(40)},
    "End grain": {"center": (-20, 10), "tilt": np.pi / 2},
}
cut = [jt.make_wood(ring_spacing=14, rotation=0.4, **plank) for plank in planks.values()]
show(*(linear_to_srgb(photograph(wood)) for wood in cut), titles=planks, height=2.6)
plt.show()

# %% [markdown]
# ## From the picture back to the numbers
#
# `fit_wood` has nothing but the pixels of the second plank. It finds a mask of early wood (the paper's threshold),
# looks for places where the axis may be, follows the rings from there, and ends with least squares of the rendered
# mask against the observed one.

# %%
truth = cut[1]
fit = fit_wood(photograph(truth))
print("wood:", fit.ok)
names = {
    "tilt": "tilt_deg",
    "rotation": "rotation_deg",
    "ring_spacing": "ring_spacing",
    "early_fraction": "early_fraction",
}
print(f"{'':16} {'drawn':>9} {'fitted':>9}   standard error")
for field, name in names.items():
    values = [float(getattr(wood, field)) for wood in (truth, fit.wood)]
    if name.endswith("_deg"):
        values = np.degrees(values)
    print(f"{name:16} {values[0]:9.3f} {values[1]:9.3f} ± {fit.standard_errors[name]:.4f}")
for axis, name in enumerate(("xc", "yc")):
    values = [float(wood.center[axis]) for wood in (truth, fit.wood)]
    print(f"{name:16} {values[0]:9.3f} {values[1]:9.3f} ± {fit.standard_errors['center'][axis]:.4f}")

# %%
titles = ["The picture", "Mask of early wood", "The fitted wood"]
show(linear_to_srgb(photograph(truth)), fit.mask, linear_to_srgb(photograph(fit.wood)), titles=titles)
plt.show()
print(f"masks agree: {fit.iou[0]:.1%}")

# %% [markdown]
# ## What the gradient sees
#
# The rendered plank has a derivative with respect to every number. Where the axis moves sideways, all rings do; where
# it moves away from the plank, or the tilt grows, the tips of the ellipses do; where the spacing grows, rings move the
# further the more of them lie inside. That these pictures differ is why the picture tells one number from the other;
# forward mode gives each in one sweep.


# %%
def early(field, value, index=()):
    """Early wood (size, size) of the second plank with one of its numbers changed."""
    given = {name: getattr(truth, name) for name in ("center", "tilt", "rotation", "ring_spacing")}
    given[field] = jnp.asarray(given[field]).at[index].set(value) if index else value
    leaves = {name: getattr(truth, name) for name in truth.__dataclass_fields__}
    wood = jt.Wood(**leaves | given)
    side = jnp.arange(size) + 0.5 - size / 2
    return jax.vmap(lambda v: jax.vmap(lambda u: wood.early_on_plank(jnp.stack([u, v]), blur=1.0))(side))(side)


wanted = {"xc": ("center", (0,)), "yc": ("center", (1,)), "tilt": ("tilt", ()), "ring_spacing": ("ring_spacing", ())}
slopes = []
for field, index in wanted.values():
    at = getattr(truth, field)[index]
    slope = jax.jvp(lambda value, field=field, index=index: early(field, value, index), (at,), (jnp.ones_like(at),))[1]
    slopes.append(np.asarray(slope) / np.abs(slope).max())
show(*slopes, titles=[f"d early / d {name}" for name in wanted], height=2.6, cmap="RdBu_r", vmin=-1, vmax=1)
plt.show()

# %% [markdown]
# ## Rings that are displaced (section 3.3)
#
# Rings of real trunks are not circles. The model's turbulence displaces them by a smooth random field, here by 2.5
# pixels, root mean square. The paper measures it from what is left when the rings have been found. Here both are
# estimated together, as a round trunk and a displacement can explain the same rings: the standard errors grow.
#
# What the fit returns as `displacement` is the field itself, by how many pixels each ring lies further out than the
# model's. What of it round rings of another trunk explain as well, they take up.

# %%
turbulent = jt.make_wood(
    ring_spacing=14, rotation=0.4, center=(-40, 14), tilt=np.radians(8),
    turbulence_rms=2.5, turbulence_frequency=1 / 110, seed=3,
)  # fmt: skip
bent = fit_wood(photograph(turbulent))
u, v = np.meshgrid(*[np.arange(size) + 0.5 - size / 2] * 2)
points = jnp.asarray(np.stack([u, v], axis=-1).reshape(-1, 2), jnp.float32)
drawn = jax.vmap(lambda point: turbulent.turbulence(turbulent.to_trunk(point)))(points).reshape(size, size)
show(linear_to_srgb(photograph(turbulent)), titles=["Displaced rings"])
pair = [np.where(bent.clear, each, np.nan) for each in (np.asarray(drawn), bent.displacement)]
pair = [each - np.nanmean(each) for each in pair]
show(*pair, titles=["Displacement drawn", "and measured, where clear"], cmap="RdBu_r", vmin=-6, vmax=6)
plt.show()
print(f"masks agree: {bent.iou[0]:.1%} without the displacement, {bent.iou[1]:.1%} with it")
for name in ("tilt_deg", "ring_spacing"):
    print(f"{name}: ± {fit.standard_errors[name]:.3f} without turbulence, ± {bent.standard_errors[name]:.3f} with it")

# %% [markdown]
# ## What a board does not tell
#
# A photograph of a straight-grained board has uneven rings, fibres and pores. Nothing in it says where the trunk's axis
# is, only which way it runs. Then the fit says so, in `determined`, and gives no standard error; the axis is put just
# beside the board. The board below is drawn that way, not from the model.

# %%
random = np.random.default_rng(0)
edges = np.cumsum(random.uniform(0.6, 1.4, 60) * 16) - 300
level = u + 0.15 * v + 4 * np.cos(v / 40)
ring = np.interp(level, edges, np.arange(60.0))
stretched = np.fft.irfft2(
    np.fft.rfft2(random.normal(size=(size, size)))
    * np.exp(-2 * (np.pi * 12 * (np.fft.fftfreq(size)[:, None] - 0.15 * np.fft.rfftfreq(size))) ** 2),
    (size, size),
)
tone = (1 - 0.45 * (ring % 1) ** 3) * (1 + 0.05 * stretched / stretched.std()) + random.normal(0, 0.02, (size, size))
board = (tone * (0.85 + 0.3 * u / size))[..., None].clip(0, 1) * np.array([0.55, 0.33, 0.17])
read = fit_wood(board)
axes = show(linear_to_srgb(board), read.mask, titles=["A board", "Early wood; and its rings, counted"])
axes[1].contour(
    read.rings, levels=np.arange(np.floor(read.rings.min()), read.rings.max()), colors="tab:red", linewidths=1
)
plt.show()
print(f"rings drawn: {np.ptp(ring):.1f}; counted: {np.ptp(read.rings):.1f}")
for name, known in read.determined.items():
    print(f"{name:22}", "determined" if known else "not to be told from this picture")

# %% [markdown]
# Not all pictures with lines in them are wood. Where nothing runs like grain, the fit says why:

# %%
noise = 0.4 + 0.1 * random.normal(size=(size, size)).clip(-3, 3)
print(fit_wood(noise).reason)

# %% [markdown]
# ## The solid (section 3.6)
#
# The model is a solid: below the photographed face the rings go on. A block of voxels is cut here on the sides that the
# picture did not show; `jt.carve_mesh` colours any mesh in the same way.

# %%
depth = 96
voxels = np.concatenate(list(jt.render_block(bent.wood, shape=(depth, size, size)))).reshape(depth, size, size, 3)
face, side, end = voxels[0], voxels[:, :, -1].swapaxes(0, 1), voxels[:, -1]
show(*map(linear_to_srgb, (face, side)), titles=["The face", "Its right side"])
show(linear_to_srgb(end), titles=["Its lower side"], height=3.2 * depth / size)
plt.show()

# %% [markdown]
# ## Departures from the paper
#
# - Turbulence is given by the displacement that it causes, in pixels, whatever noise makes it. On its picture a fitted
#   plank has the displacement that was seen; beyond it, turbulence as strong and as coarse.
# - Rings have soft edges as wide as the spot that looks at them, so that the picture has a derivative and no aliasing.
# - The axis is found without a click; `ellipse_center` and `fix` hold what the user knows better.
# - On photographs the rings are counted along the grain, uneven as they are.
