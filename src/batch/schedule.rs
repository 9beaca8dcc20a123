//! Which job comes next, and with how many threads.
