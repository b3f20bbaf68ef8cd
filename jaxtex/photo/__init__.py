"""From a photograph to evidence: rectify it, even out its light, make and clean masks.

Everything here takes and gives plain NumPy arrays: pictures as linear float ``[H, W]``, ``[H, W, 1]`` or ``[H, W, 3]``,
masks as bool ``[H, W]`` in which True (white) is tile and False (black) is joint. Each tool stands alone; a person may
hand in a mask of his own at any step (Lefebvre & Poulin, section 2).
"""
