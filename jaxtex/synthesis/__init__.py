"""From a picture of a texture to more of it."""
