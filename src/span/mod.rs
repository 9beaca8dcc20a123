//! Directed integer edges and a row frame → sorted spans per row; interval algebra.
