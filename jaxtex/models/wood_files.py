"""What a model file of wood holds; `jaxtex.models.files` reads and writes it.

The format is described, key by key, by the JSON Schema `wood-1.json` beside this module.
"""

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from jaxtex.models.envelope import SourceImage, plain, schema_of
from jaxtex.models.wood import Wood, canonical_pose, make_wood
from jaxtex.models.wood_detail import Displacement, Fibres

_FIELD = ("cosines", "extent", "middle")
_PLAIN = ("center", "ring_spacing", "early_fraction", "early_rgb", "late_rgb", "turbulence_rms", "turbulence_frequency")


@dataclasses.dataclass(frozen=True, eq=False)
class WoodFile:
    """What a model file of wood holds.

    Attributes:
        wood: the model; read from a file, its leaves are NumPy arrays in double precision.
        image: the photograph. Its middle is the plank's point (0, 0).
        determined: by a parameter's name, whether the photograph tells it.
        report: how the fit went: `ok`, `reason`, `iou`, `start` (see `wood_parameters`), `standard_errors`, and
            whatever else the fit reports, as plain values.
        seed: of the turbulence, as `make_wood` takes it, and of all other random choices.
        versions: of the software that wrote the file; by default of the software that runs.
    """

    wood: Wood
    image: SourceImage
    determined: Mapping[str, bool]
    report: Mapping[str, Any]
    seed: int = 0
    versions: Mapping[str, str] | None = None


def canonical_wood(wood: Wood) -> Wood:
    """Write wood in the form that model files hold: the plank is unchanged everywhere, in turbulence too.

    `tilt` is in [0, pi/2] and `rotation` in [0, pi). The trunk is mirrored to that end, and its turbulence with it;
    fibres are as fine as before, but lie elsewhere.

    Returns:
        Wood whose leaves are NumPy arrays in the precision they had.

    Examples:
        >>> turned = canonical_wood(make_wood(ring_spacing=20.0, center=(30.0, 4.0), rotation=4.0, tilt=-0.5))
        >>> turned.center.tolist(), round(float(turned.rotation), 4), turned.tilt.tolist()
        ([-30.0, 4.0], 0.8584, 0.5)
    """
    tilt, rotation, mirror = canonical_pose(float(wood.tilt), float(wood.rotation))
    changed: dict[str, Any] = {
        "center": wood.center * mirror[:2],
        "tilt": tilt,
        "rotation": rotation,
        "waves": wood.waves * mirror[None, :],
    }
    exact = dataclasses.replace(wood, **changed)
    return jax.tree.map(lambda leaf, given: np.asarray(leaf, np.asarray(given).dtype), exact, wood)


def wood_parameters(wood: Wood) -> dict[str, Any]:
    """The named parameters of wood as they stand in a model file: canonical, angles in degrees, plain numbers.

    Examples:
        >>> parameters = wood_parameters(make_wood(ring_spacing=20.0, tilt=-0.5))
        >>> parameters["ring_spacing"], round(parameters["tilt_deg"], 4)
        (20.0, 28.6479)
    """
    written = canonical_wood(wood)
    values = {name: getattr(written, name) for name in _PLAIN}
    # Twelve digits behind the point, so that radians and back give the same number; what rounding takes out of the
    # range, it is brought back into.
    angles = {
        "tilt_deg": min(round(math.degrees(written.tilt), 12), 90.0),
        "rotation_deg": min(round(math.degrees(written.rotation), 12), math.nextafter(180.0, 0.0)),
    }
    detail: dict[str, Any] = {"gradation": written.gradation} if written.gradation > 0 else {}
    if written.fibres is not None:
        detail["fibres"] = {name: getattr(written.fibres, name) for name in ("contrast", "width", "pores")}
    if written.displacement is not None:
        field = written.displacement
        detail["displacement"] = {
            **{name: getattr(field, name) for name in _FIELD},
            "turn_deg": round(math.degrees(field.turn), 12),
        }
    return plain({"center": values.pop("center"), **angles, **values, **detail})


def wood_from_parameters(parameters: Mapping[str, Any], *, seed: int) -> Wood:
    """The wood of named parameters as they stand in a model file, and the turbulence of a seed.

    Returns:
        Wood whose leaves are NumPy arrays in double precision.

    Raises:
        ValueError: they are no wood.
    """
    with jax.enable_x64():
        fine = {name: jnp.asarray(value, float) for name, value in parameters.get("fibres", {}).items()}
        wood = make_wood(
            **{name: parameters[name] for name in _PLAIN},
            tilt=math.radians(parameters["tilt_deg"]),
            rotation=math.radians(parameters["rotation_deg"]),
            gradation=parameters.get("gradation", 0.0),
            fibres=Fibres(**fine) if fine else None,
            displacement=_displacement_of(parameters.get("displacement")),
            seed=seed,
        )
        return jax.tree.map(np.asarray, wood)


def _displacement_of(values: Mapping[str, Any] | None) -> Displacement | None:
    if values is None:
        return None
    if len({len(row) for row in values["cosines"]}) > 1:
        raise ValueError("displacement.cosines has rows of several lengths; they must all be as long")
    turn = jnp.asarray(math.radians(values["turn_deg"]))
    return Displacement(**{name: jnp.asarray(values[name], float) for name in _FIELD}, turn=turn)


def wood_schema() -> dict[str, Any]:
    """The JSON Schema of model files of wood."""
    return schema_of("wood")


def list_parameters(wood: Wood) -> dict[str, tuple[Any, str]]:
    """What there is to read of wood: value and title of each named parameter, those of fibres as `fibres.contrast`.

    Examples:
        >>> list_parameters(make_wood(ring_spacing=20.0))["ring_spacing"]
        (20.0, 'From ring to ring')
    """
    described = wood_schema()["$defs"]["parameters"]["properties"]
    values = wood_parameters(wood)
    values.pop("displacement", None)  # a field, not a number
    fine = values.pop("fibres", {})
    listed = {name: (value, described[name]["title"]) for name, value in values.items()}
    titles = described["fibres"]["properties"]
    return listed | {f"fibres.{name}": (value, titles[name]["title"]) for name, value in fine.items()}


def wood_content(file: WoodFile) -> dict[str, Any]:
    """What is wood's own in a model file's document.

    Raises:
        ValueError: the wood cannot be written.
    """
    if not all(np.isfinite(leaf).all() for leaf in jax.tree.leaves(file.wood)):
        raise ValueError("the wood holds numbers that are not finite")
    parameters = wood_parameters(file.wood)
    if parameters["turbulence_rms"] > 0 and file.seed >= 0:
        drawn, written = wood_from_parameters(parameters, seed=file.seed), canonical_wood(file.wood)
        _check_turbulence(drawn, written, file.seed)
    return {"parameters": parameters, "determined": file.determined, "report": file.report}


def wood_from_document(document: Mapping[str, Any]) -> WoodFile:
    """The file of a document that is as its schema has it.

    Raises:
        ValueError: its parameters are no wood.
    """
    seed = int(document["seed"])
    return WoodFile(
        wood=wood_from_parameters(document["parameters"], seed=seed),
        image=SourceImage(**document["image"]),
        determined=document["determined"],
        report=document["report"],
        seed=seed,
        versions=document.get("versions"),
    )


def _check_turbulence(drawn: Wood, written: Wood, seed: int) -> None:
    """A file keeps but the seed of the turbulence: who reads it must see the same wood."""
    for name in ("waves", "phases"):
        one, other = getattr(drawn, name), getattr(written, name)
        if one.shape != other.shape or not np.allclose(one, other, atol=1e-5):
            raise ValueError(
                f"in canonical form, the wood's turbulence is not that of seed {seed}; "
                f"take wood_from_parameters(wood_parameters(wood), seed={seed})"
            )
