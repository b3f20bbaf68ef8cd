"""Forward models: ``eqx.Module`` values evaluated at one point, lifted by ``vmap``."""
