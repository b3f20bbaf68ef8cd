"""Progressively-variant textures in the plane: elements that change from place to place.

J. Zhang et al., "Synthesis of Progressively-Variant Textures on Arbitrary Surfaces" (SIGGRAPH 2003), sections 3 and 4.
The way of the data::

    keys, painted maps -> fields        (scale, transition, orientation: one value for each pixel)
    exemplar           -> texton mask   (which pixels belong to elements, and of which type)
    mask, fields       -> mask          (warped, blended: the elements as they are to be)
    exemplar, masks    -> texture       (by `jaxtex.synthesis`: scaled and turned, or guided by masks)
    all of these       -> VaryingTexture, one `.npz`
"""
