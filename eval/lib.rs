//! Open loop, metrics, tables, figures.
