//! Windows, injection, labels, split, trainer, regressors.
