//! Accel-ProNet and Gyro-ProNet: configuration, modules, weights, streaming inference.
