//! Contact: what is near, what touches, and the forces of it.
