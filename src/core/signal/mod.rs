//! Signal processing on one axis: smoothing, spectra, wavelets, window statistics.
