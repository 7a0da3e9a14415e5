//! Simple estimators of the deviation of white noise, each a noise model.
