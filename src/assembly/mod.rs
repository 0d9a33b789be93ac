//! Global sparse assembly of W = cm M + cc C + ck K.

/// Why a pattern cannot be built.
#[derive(Clone, Debug, thiserror::Error, PartialEq, Eq)]
pub enum PatternError {
    /// More nonzeros than 32-bit slots can number.
    #[error(
        "the matrix would hold {nonzeros} entries, more than the 2^32 that can be numbered; use an explicit method or a coarser mesh"
    )]
    TooLarge {
        /// entries counted
        nonzeros: usize,
    },
}

/// The pattern of W and the slots of every element's blocks.
#[derive(Clone, Debug, Default)]
pub struct Assembler {}
