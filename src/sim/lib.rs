//! Simulated flights and an IMU whose noise is exactly known.
