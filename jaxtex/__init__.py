"""jaxtex: pictures of a material become something a person can control, by differentiable models in JAX.

The way of the data, one package per step::

    photograph -> photo    (mask: 1 = tile, 0 = joint)
               -> fitting  (start by FFT and scanlines, refined by least squares)
               -> models   (differentiable; evaluated at a point)
               -> material (filled, as maps at any resolution; laid on walls and meshes)
               -> io       (files)

`core` holds the mathematics they share, and `cli` puts them on the command line (`jaxtex --help`). All public names are
flat: `import jaxtex as jt`, then `jt.read_image(...)`. Importing the package is quick: a name brings in its module, and
JAX with it, only when it is first used.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from jaxtex.core.colour import linear_to_srgb as linear_to_srgb
    from jaxtex.core.colour import srgb_to_linear as srgb_to_linear
    from jaxtex.core.errors import InputError as InputError
    from jaxtex.core.pyramids import build_pyramid as build_pyramid
    from jaxtex.core.pyramids import collapse_pyramid as collapse_pyramid
    from jaxtex.fitting.batch import fit_tiling_masks as fit_tiling_masks
    from jaxtex.fitting.floor import FloorFit as FloorFit
    from jaxtex.fitting.floor import FloorPlank as FloorPlank
    from jaxtex.fitting.floor import fit_floor as fit_floor
    from jaxtex.fitting.tiling import TilingFit as TilingFit
    from jaxtex.fitting.tiling import fit_tiling as fit_tiling
    from jaxtex.fitting.wood import WoodFit as WoodFit
    from jaxtex.fitting.wood import fit_wood as fit_wood
    from jaxtex.io.gltf import MaterialImages as MaterialImages
    from jaxtex.io.gltf import write_coloured_glb as write_coloured_glb
    from jaxtex.io.gltf import write_glb as write_glb
    from jaxtex.io.images import Image as Image
    from jaxtex.io.images import read_image as read_image
    from jaxtex.io.images import write_image as write_image
    from jaxtex.io.masks import read_mask as read_mask
    from jaxtex.io.masks import write_mask as write_mask
    from jaxtex.io.meshes import Mesh as Mesh
    from jaxtex.io.meshes import TexturedMesh as TexturedMesh
    from jaxtex.io.meshes import floor_mesh as floor_mesh
    from jaxtex.io.meshes import read_mesh as read_mesh
    from jaxtex.io.meshes import read_textured_mesh as read_textured_mesh
    from jaxtex.io.meshes import wall_mesh as wall_mesh
    from jaxtex.io.meshes import write_mesh as write_mesh
    from jaxtex.io.voxels import read_voxels as read_voxels
    from jaxtex.io.voxels import write_voxels as write_voxels
    from jaxtex.material.adjacent import Layout as Layout
    from jaxtex.material.adjacent import lay_adjacent as lay_adjacent
    from jaxtex.material.adjacent import lay_tiling as lay_tiling
    from jaxtex.material.adjacent import polygon_mesh as polygon_mesh
    from jaxtex.material.appearance import Appearance as Appearance
    from jaxtex.material.appearance import appearance_of as appearance_of
    from jaxtex.material.baking import bake_solid as bake_solid
    from jaxtex.material.export import write_maps as write_maps
    from jaxtex.material.finish import finish_tiling as finish_tiling
    from jaxtex.material.floor import FloorMaps as FloorMaps
    from jaxtex.material.floor import render_floor as render_floor
    from jaxtex.material.interior_files import interiors_of_planks as interiors_of_planks
    from jaxtex.material.interior_files import interiors_of_tiles as interiors_of_tiles
    from jaxtex.material.interior_files import write_interiors as write_interiors
    from jaxtex.material.interiors import Interiors as Interiors
    from jaxtex.material.interiors import measure_interiors as measure_interiors
    from jaxtex.material.maps import Maps as Maps
    from jaxtex.material.maps import render_maps as render_maps
    from jaxtex.material.measure import measure_appearance as measure_appearance
    from jaxtex.material.mismatch import measure_mismatch as measure_mismatch
    from jaxtex.material.mixture import keep_photograph as keep_photograph
    from jaxtex.material.mixture import layer_maps as layer_maps
    from jaxtex.material.mixture import mix_maps as mix_maps
    from jaxtex.material.overlay import draw_overlay as draw_overlay
    from jaxtex.material.packing import pack_maps as pack_maps
    from jaxtex.material.placement import over_photograph as over_photograph
    from jaxtex.material.placement import over_picture as over_picture
    from jaxtex.material.placement import over_plank as over_plank
    from jaxtex.material.planks import PlankInteriors as PlankInteriors
    from jaxtex.material.planks import measure_planks as measure_planks
    from jaxtex.material.preview import shade_maps as shade_maps
    from jaxtex.material.regions import Regions as Regions
    from jaxtex.material.rings import draw_rings as draw_rings
    from jaxtex.material.sheet import Sheet as Sheet
    from jaxtex.material.sheet import lay_photographed_sheet as lay_photographed_sheet
    from jaxtex.material.sheet import lay_sheet as lay_sheet
    from jaxtex.material.solid import carve_solid as carve_solid
    from jaxtex.material.solid import cut_solid as cut_solid
    from jaxtex.material.solid import draw_block as draw_block
    from jaxtex.material.solid import evaluate_solid as evaluate_solid
    from jaxtex.material.tile_wood import Timber as Timber
    from jaxtex.material.wood import WoodMaps as WoodMaps
    from jaxtex.material.wood import carve_mesh as carve_mesh
    from jaxtex.material.wood import render_block as render_block
    from jaxtex.material.wood import render_points as render_points
    from jaxtex.material.wood import render_wood as render_wood
    from jaxtex.models.envelope import SourceImage as SourceImage
    from jaxtex.models.files import TilingFile as TilingFile
    from jaxtex.models.files import load_any as load_any
    from jaxtex.models.files import load_model as load_model
    from jaxtex.models.files import save_model as save_model
    from jaxtex.models.files import tiling_parameters as tiling_parameters
    from jaxtex.models.floor_files import FloorFile as FloorFile
    from jaxtex.models.floor_files import PlacedWood as PlacedWood
    from jaxtex.models.grids import coverage_grid as coverage_grid
    from jaxtex.models.mixture_files import MixedWood as MixedWood
    from jaxtex.models.mixture_files import MixtureFile as MixtureFile
    from jaxtex.models.mixture_files import ModelLayer as ModelLayer
    from jaxtex.models.mixture_files import PhotographLayer as PhotographLayer
    from jaxtex.models.solid import Solid as Solid
    from jaxtex.models.solid import make_solid as make_solid
    from jaxtex.models.tiling import Tiling as Tiling
    from jaxtex.models.tiling import make_tiling as make_tiling
    from jaxtex.models.wood import Wood as Wood
    from jaxtex.models.wood import make_wood as make_wood
    from jaxtex.models.wood_detail import Displacement as Displacement
    from jaxtex.models.wood_detail import Fibres as Fibres
    from jaxtex.models.wood_files import WoodFile as WoodFile
    from jaxtex.models.wood_files import canonical_wood as canonical_wood
    from jaxtex.models.wood_files import wood_from_parameters as wood_from_parameters
    from jaxtex.models.wood_files import wood_parameters as wood_parameters
    from jaxtex.particles.arrangement import learn_arrangement as learn_arrangement
    from jaxtex.particles.composition import Composition as Composition
    from jaxtex.particles.composition import read_composition as read_composition
    from jaxtex.particles.composition import write_composition as write_composition
    from jaxtex.particles.control_files import read_controls as read_controls
    from jaxtex.particles.controls import Control as Control
    from jaxtex.particles.fields import linear_field as linear_field
    from jaxtex.particles.fields import map_field as map_field
    from jaxtex.particles.fields import radial_field as radial_field
    from jaxtex.particles.files import read_particles as read_particles
    from jaxtex.particles.files import write_particles as write_particles
    from jaxtex.particles.grounds import make_ground as make_ground
    from jaxtex.particles.painting import label_composition as label_composition
    from jaxtex.particles.painting import paint_composition as paint_composition
    from jaxtex.particles.picking import pick_particles as pick_particles
    from jaxtex.particles.relaxation import relax_composition as relax_composition
    from jaxtex.particles.scissors import Polygon as Polygon
    from jaxtex.particles.scissors import cut_polygons as cut_polygons
    from jaxtex.particles.scissors import join_things as join_things
    from jaxtex.particles.scissors import label_painted as label_painted
    from jaxtex.particles.scissors import read_polygons as read_polygons
    from jaxtex.particles.seeding import seed_composition as seed_composition
    from jaxtex.particles.segmentation import find_particles as find_particles
    from jaxtex.particles.statistics import compare_statistics as compare_statistics
    from jaxtex.particles.statistics import measure_composition as measure_composition
    from jaxtex.particles.statistics import measure_picture as measure_picture
    from jaxtex.particles.things import Decomposition as Decomposition
    from jaxtex.particles.things import describe_particles as describe_particles
    from jaxtex.photo.automask import auto_mask as auto_mask
    from jaxtex.photo.edges import pyramid_edges as pyramid_edges
    from jaxtex.photo.edges import sobel_edges as sobel_edges
    from jaxtex.photo.illumination import even_out as even_out
    from jaxtex.photo.morphology import close_mask as close_mask
    from jaxtex.photo.morphology import dilate_mask as dilate_mask
    from jaxtex.photo.morphology import erode_mask as erode_mask
    from jaxtex.photo.morphology import open_mask as open_mask
    from jaxtex.photo.morphology import remove_small_regions as remove_small_regions
    from jaxtex.photo.rectify import rectify as rectify
    from jaxtex.photo.segment import colour_mask as colour_mask
    from jaxtex.photo.segment import pick_colours as pick_colours
    from jaxtex.photo.segment import threshold_mask as threshold_mask
    from jaxtex.progressive.blending import Blend as Blend
    from jaxtex.progressive.blending import blend_masks as blend_masks
    from jaxtex.progressive.blending import blend_textures as blend_textures
    from jaxtex.progressive.blending import transition_weights as transition_weights
    from jaxtex.progressive.fields import orientation_field as orientation_field
    from jaxtex.progressive.fields import scale_field as scale_field
    from jaxtex.progressive.fields import transition_field as transition_field
    from jaxtex.progressive.filtering import filter_mask as filter_mask
    from jaxtex.progressive.filtering import filter_mask_steps as filter_mask_steps
    from jaxtex.progressive.key_files import FieldKeys as FieldKeys
    from jaxtex.progressive.key_files import make_field as make_field
    from jaxtex.progressive.key_files import read_keys as read_keys
    from jaxtex.progressive.keys import FieldKey as FieldKey
    from jaxtex.progressive.mask_proposal import propose_texton_mask as propose_texton_mask
    from jaxtex.progressive.masked import mark_elements as mark_elements
    from jaxtex.progressive.masked import synthesise_masked as synthesise_masked
    from jaxtex.progressive.normal_maps import turn_normals as turn_normals
    from jaxtex.progressive.plots import overlay_texton_mask as overlay_texton_mask
    from jaxtex.progressive.plots import plot_orientation as plot_orientation
    from jaxtex.progressive.plots import plot_scalar as plot_scalar
    from jaxtex.progressive.texton_masks import ColourPick as ColourPick
    from jaxtex.progressive.texton_masks import pick_texton_mask as pick_texton_mask
    from jaxtex.progressive.texton_masks import read_texton_mask as read_texton_mask
    from jaxtex.progressive.texton_masks import write_texton_mask as write_texton_mask
    from jaxtex.progressive.varying import VaryingTexture as VaryingTexture
    from jaxtex.progressive.varying import read_varying as read_varying
    from jaxtex.progressive.varying import write_varying as write_varying
    from jaxtex.progressive.warping import displace_elements as displace_elements
    from jaxtex.progressive.warping import grow_mask as grow_mask
    from jaxtex.progressive.warping import warp_mask as warp_mask
    from jaxtex.synthesis.anisometric import Transition as Transition
    from jaxtex.synthesis.anisometric import make_frames as make_frames
    from jaxtex.synthesis.anisometric import sample_sources as sample_sources
    from jaxtex.synthesis.anisometric import synthesise_anisometric as synthesise_anisometric
    from jaxtex.synthesis.ashikhmin import ashikhmin_steps as ashikhmin_steps
    from jaxtex.synthesis.ashikhmin import synthesise_ashikhmin as synthesise_ashikhmin
    from jaxtex.synthesis.coherence import coherence_steps as coherence_steps
    from jaxtex.synthesis.coherence import inpaint_coherence as inpaint_coherence
    from jaxtex.synthesis.coherence import inpaint_steps as inpaint_steps
    from jaxtex.synthesis.coherence import synthesise_coherence as synthesise_coherence
    from jaxtex.synthesis.copying import measure_pieces as measure_pieces
    from jaxtex.synthesis.copying import seam_map as seam_map
    from jaxtex.synthesis.copying import verbatim_share as verbatim_share
    from jaxtex.synthesis.distances import sliced_wasserstein as sliced_wasserstein
    from jaxtex.synthesis.efros_leung import efros_leung_steps as efros_leung_steps
    from jaxtex.synthesis.efros_leung import synthesise_efros_leung as synthesise_efros_leung
    from jaxtex.synthesis.heeger_bergen import TextureStatistics as TextureStatistics
    from jaxtex.synthesis.heeger_bergen import analyse_texture as analyse_texture
    from jaxtex.synthesis.heeger_bergen import synthesise_texture as synthesise_texture
    from jaxtex.synthesis.lapped import lap_patches as lap_patches
    from jaxtex.synthesis.nearest import find_similar as find_similar
    from jaxtex.synthesis.portilla_simoncelli import portilla_simoncelli_distance as portilla_simoncelli_distance
    from jaxtex.synthesis.quilting import quilting_steps as quilting_steps
    from jaxtex.synthesis.quilting import synthesise_quilting as synthesise_quilting
    from jaxtex.synthesis.solid_optimisation import optimise_solid as optimise_solid
    from jaxtex.synthesis.solid_relaxation import relax_solid as relax_solid
    from jaxtex.synthesis.sources import Step as Step
    from jaxtex.synthesis.sources import blend_seams as blend_seams
    from jaxtex.synthesis.sources import copy_sources as copy_sources
    from jaxtex.synthesis.wei_levoy import synthesise_wei_levoy as synthesise_wei_levoy
    from jaxtex.synthesis.wei_levoy import wei_levoy_steps as wei_levoy_steps

__version__ = "0.1.0"

# Public name -> module that defines it, in the order of the way of the data. A name added here is also added to the
# block for type checkers above; tests/test_public.py holds the two to one another.
_PUBLIC = {
    # every complaint about what was handed in
    "linear_to_srgb": "jaxtex.core.colour",
    "srgb_to_linear": "jaxtex.core.colour",
    "InputError": "jaxtex.core.errors",
    # files, linear light inside
    "Image": "jaxtex.io.images",
    "read_image": "jaxtex.io.images",
    "write_image": "jaxtex.io.images",
    "read_mask": "jaxtex.io.masks",
    "write_mask": "jaxtex.io.masks",
    "Mesh": "jaxtex.io.meshes",
    "read_mesh": "jaxtex.io.meshes",
    "write_mesh": "jaxtex.io.meshes",
    "TexturedMesh": "jaxtex.io.meshes",
    "read_textured_mesh": "jaxtex.io.meshes",
    "wall_mesh": "jaxtex.io.meshes",
    "floor_mesh": "jaxtex.io.meshes",
    "MaterialImages": "jaxtex.io.gltf",
    "write_glb": "jaxtex.io.gltf",
    "write_voxels": "jaxtex.io.voxels",
    # photograph -> mask
    "rectify": "jaxtex.photo.rectify",
    "even_out": "jaxtex.photo.illumination",
    "auto_mask": "jaxtex.photo.automask",
    "threshold_mask": "jaxtex.photo.segment",
    "colour_mask": "jaxtex.photo.segment",
    "pick_colours": "jaxtex.photo.segment",
    "sobel_edges": "jaxtex.photo.edges",
    "pyramid_edges": "jaxtex.photo.edges",
    "erode_mask": "jaxtex.photo.morphology",
    "dilate_mask": "jaxtex.photo.morphology",
    "open_mask": "jaxtex.photo.morphology",
    "close_mask": "jaxtex.photo.morphology",
    "remove_small_regions": "jaxtex.photo.morphology",
    # mask -> parameters
    "fit_tiling": "jaxtex.fitting.tiling",
    "TilingFit": "jaxtex.fitting.tiling",
    "fit_tiling_masks": "jaxtex.fitting.batch",
    "fit_wood": "jaxtex.fitting.wood",
    "WoodFit": "jaxtex.fitting.wood",
    "fit_floor": "jaxtex.fitting.floor",
    "FloorFit": "jaxtex.fitting.floor",
    "FloorPlank": "jaxtex.fitting.floor",
    # the model, its mask, its file
    "Tiling": "jaxtex.models.tiling",
    "make_tiling": "jaxtex.models.tiling",
    "Wood": "jaxtex.models.wood",
    "make_wood": "jaxtex.models.wood",
    "Fibres": "jaxtex.models.wood_detail",
    "Displacement": "jaxtex.models.wood_detail",
    "coverage_grid": "jaxtex.models.grids",
    "TilingFile": "jaxtex.models.files",
    "WoodFile": "jaxtex.models.wood_files",
    "FloorFile": "jaxtex.models.floor_files",
    "PlacedWood": "jaxtex.models.floor_files",
    "SourceImage": "jaxtex.models.envelope",
    "load_model": "jaxtex.models.files",
    "save_model": "jaxtex.models.files",
    "load_any": "jaxtex.models.files",
    "MixtureFile": "jaxtex.models.mixture_files",
    "MixedWood": "jaxtex.models.mixture_files",
    "ModelLayer": "jaxtex.models.mixture_files",
    "PhotographLayer": "jaxtex.models.mixture_files",
    "tiling_parameters": "jaxtex.models.files",
    "canonical_wood": "jaxtex.models.wood_files",
    "wood_parameters": "jaxtex.models.wood_files",
    "wood_from_parameters": "jaxtex.models.wood_files",
    # exemplar -> more of it
    "build_pyramid": "jaxtex.core.pyramids",
    "collapse_pyramid": "jaxtex.core.pyramids",
    "analyse_texture": "jaxtex.synthesis.heeger_bergen",
    "TextureStatistics": "jaxtex.synthesis.heeger_bergen",
    "synthesise_texture": "jaxtex.synthesis.heeger_bergen",
    # exemplar -> source map -> texture
    "inpaint_coherence": "jaxtex.synthesis.coherence",
    "Transition": "jaxtex.synthesis.anisometric",
    "make_frames": "jaxtex.synthesis.anisometric",
    "sample_sources": "jaxtex.synthesis.anisometric",
    "synthesise_anisometric": "jaxtex.synthesis.anisometric",
    "synthesise_coherence": "jaxtex.synthesis.coherence",
    "coherence_steps": "jaxtex.synthesis.coherence",
    "inpaint_steps": "jaxtex.synthesis.coherence",
    "synthesise_ashikhmin": "jaxtex.synthesis.ashikhmin",
    "ashikhmin_steps": "jaxtex.synthesis.ashikhmin",
    "synthesise_wei_levoy": "jaxtex.synthesis.wei_levoy",
    "wei_levoy_steps": "jaxtex.synthesis.wei_levoy",
    "synthesise_efros_leung": "jaxtex.synthesis.efros_leung",
    "efros_leung_steps": "jaxtex.synthesis.efros_leung",
    "read_voxels": "jaxtex.io.voxels",
    "write_coloured_glb": "jaxtex.io.gltf",
    "Solid": "jaxtex.models.solid",
    "make_solid": "jaxtex.models.solid",
    "evaluate_solid": "jaxtex.material.solid",
    "carve_solid": "jaxtex.material.solid",
    "bake_solid": "jaxtex.material.baking",
    "cut_solid": "jaxtex.material.solid",
    "draw_block": "jaxtex.material.solid",
    "optimise_solid": "jaxtex.synthesis.solid_optimisation",
    "relax_solid": "jaxtex.synthesis.solid_relaxation",
    "synthesise_quilting": "jaxtex.synthesis.quilting",
    "quilting_steps": "jaxtex.synthesis.quilting",
    "lap_patches": "jaxtex.synthesis.lapped",
    "find_similar": "jaxtex.synthesis.nearest",
    "Step": "jaxtex.synthesis.sources",
    "blend_seams": "jaxtex.synthesis.sources",
    "copy_sources": "jaxtex.synthesis.sources",
    "measure_pieces": "jaxtex.synthesis.copying",
    "seam_map": "jaxtex.synthesis.copying",
    "verbatim_share": "jaxtex.synthesis.copying",
    "sliced_wasserstein": "jaxtex.synthesis.distances",
    "portilla_simoncelli_distance": "jaxtex.synthesis.portilla_simoncelli",
    # things of a picture -> a composition of them
    "learn_arrangement": "jaxtex.particles.arrangement",
    "seed_composition": "jaxtex.particles.seeding",
    "Control": "jaxtex.particles.controls",
    "read_controls": "jaxtex.particles.control_files",
    "linear_field": "jaxtex.particles.fields",
    "map_field": "jaxtex.particles.fields",
    "radial_field": "jaxtex.particles.fields",
    "relax_composition": "jaxtex.particles.relaxation",
    "measure_picture": "jaxtex.particles.statistics",
    "measure_composition": "jaxtex.particles.statistics",
    "compare_statistics": "jaxtex.particles.statistics",
    "Blend": "jaxtex.progressive.blending",
    "blend_masks": "jaxtex.progressive.blending",
    "blend_textures": "jaxtex.progressive.blending",
    "transition_weights": "jaxtex.progressive.blending",
    "filter_mask": "jaxtex.progressive.filtering",
    "filter_mask_steps": "jaxtex.progressive.filtering",
    "displace_elements": "jaxtex.progressive.warping",
    "grow_mask": "jaxtex.progressive.warping",
    "warp_mask": "jaxtex.progressive.warping",
    "orientation_field": "jaxtex.progressive.fields",
    "scale_field": "jaxtex.progressive.fields",
    "transition_field": "jaxtex.progressive.fields",
    "FieldKeys": "jaxtex.progressive.key_files",
    "make_field": "jaxtex.progressive.key_files",
    "read_keys": "jaxtex.progressive.key_files",
    "FieldKey": "jaxtex.progressive.keys",
    "propose_texton_mask": "jaxtex.progressive.mask_proposal",
    "mark_elements": "jaxtex.progressive.masked",
    "synthesise_masked": "jaxtex.progressive.masked",
    "turn_normals": "jaxtex.progressive.normal_maps",
    "overlay_texton_mask": "jaxtex.progressive.plots",
    "plot_orientation": "jaxtex.progressive.plots",
    "plot_scalar": "jaxtex.progressive.plots",
    "ColourPick": "jaxtex.progressive.texton_masks",
    "pick_texton_mask": "jaxtex.progressive.texton_masks",
    "read_texton_mask": "jaxtex.progressive.texton_masks",
    "write_texton_mask": "jaxtex.progressive.texton_masks",
    "VaryingTexture": "jaxtex.progressive.varying",
    "read_varying": "jaxtex.progressive.varying",
    "write_varying": "jaxtex.progressive.varying",
    "find_particles": "jaxtex.particles.segmentation",
    "pick_particles": "jaxtex.particles.picking",
    "Polygon": "jaxtex.particles.scissors",
    "cut_polygons": "jaxtex.particles.scissors",
    "label_painted": "jaxtex.particles.scissors",
    "join_things": "jaxtex.particles.scissors",
    "read_polygons": "jaxtex.particles.scissors",
    "write_particles": "jaxtex.particles.files",
    "read_particles": "jaxtex.particles.files",
    "Decomposition": "jaxtex.particles.things",
    "describe_particles": "jaxtex.particles.things",
    "label_composition": "jaxtex.particles.painting",
    "make_ground": "jaxtex.particles.grounds",
    "paint_composition": "jaxtex.particles.painting",
    "Composition": "jaxtex.particles.composition",
    "read_composition": "jaxtex.particles.composition",
    "write_composition": "jaxtex.particles.composition",
    # model -> material
    "measure_appearance": "jaxtex.material.measure",
    "Appearance": "jaxtex.material.appearance",
    "appearance_of": "jaxtex.material.appearance",
    "finish_tiling": "jaxtex.material.finish",
    "Regions": "jaxtex.material.regions",
    "measure_interiors": "jaxtex.material.interiors",
    "Interiors": "jaxtex.material.interiors",
    "write_interiors": "jaxtex.material.interior_files",
    "interiors_of_tiles": "jaxtex.material.interior_files",
    "measure_planks": "jaxtex.material.planks",
    "PlankInteriors": "jaxtex.material.planks",
    "interiors_of_planks": "jaxtex.material.interior_files",
    "Sheet": "jaxtex.material.sheet",
    "lay_sheet": "jaxtex.material.sheet",
    "lay_photographed_sheet": "jaxtex.material.sheet",
    "Maps": "jaxtex.material.maps",
    "render_maps": "jaxtex.material.maps",
    "pack_maps": "jaxtex.material.packing",
    "Timber": "jaxtex.material.tile_wood",
    "mix_maps": "jaxtex.material.mixture",
    "layer_maps": "jaxtex.material.mixture",
    "keep_photograph": "jaxtex.material.mixture",
    "over_photograph": "jaxtex.material.placement",
    "over_picture": "jaxtex.material.placement",
    "over_plank": "jaxtex.material.placement",
    "lay_tiling": "jaxtex.material.adjacent",
    "lay_adjacent": "jaxtex.material.adjacent",
    "Layout": "jaxtex.material.adjacent",
    "measure_mismatch": "jaxtex.material.mismatch",
    "polygon_mesh": "jaxtex.material.adjacent",
    "WoodMaps": "jaxtex.material.wood",
    "render_wood": "jaxtex.material.wood",
    "render_points": "jaxtex.material.wood",
    "render_block": "jaxtex.material.wood",
    "carve_mesh": "jaxtex.material.wood",
    "FloorMaps": "jaxtex.material.floor",
    "render_floor": "jaxtex.material.floor",
    "write_maps": "jaxtex.material.export",
    "draw_overlay": "jaxtex.material.overlay",
    "draw_rings": "jaxtex.material.rings",
    "shade_maps": "jaxtex.material.preview",
}

__all__ = ["__version__", *_PUBLIC]


def __getattr__(name: str) -> Any:
    if name not in _PUBLIC:
        raise AttributeError(f"module 'jaxtex' has no attribute {name!r}")
    value = getattr(import_module(_PUBLIC[name]), name)
    globals()[name] = value  # the next look-up finds it without coming here
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_PUBLIC})
