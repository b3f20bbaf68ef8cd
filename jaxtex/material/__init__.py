"""From a fitted model to a material: what its tiles look like, maps of it at any resolution, files and pictures."""
