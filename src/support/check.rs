//! Whether anything is printed in air.
