"""Pictures made of things: taken apart into particles, how these are arranged, and new arrangements of them.

J.-M. Dischler, K. Maritaud, B. Lévy and D. Ghazanfarpour, "Texture particles" (Eurographics 2002). The data's way:
`segmentation` finds the things (by `ground` or `joints`; `picking` and `scissors` take them as a person says), `things`
measures them, `arrangement` learns where each has its neighbours, `seeding` places new ones likewise, under `controls`,
which makes a `composition` that can be edited, and `relaxation` moves them to where they fit better. `grounds` makes
what they lie on, `sprites` cuts them out, and `painting` draws all.
"""
