"""Numbers made of spectra: photometric, colorimetric."""
