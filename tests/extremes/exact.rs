//! Extremes whose answer is known.
