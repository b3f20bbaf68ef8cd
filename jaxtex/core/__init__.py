"""The ground all layers stand on: errors, coordinates, colour, resampling, spectra, stepping."""
