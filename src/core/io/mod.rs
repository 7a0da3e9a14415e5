//! Readers and writers of the formats at the border.
