//! Arrays of numbers of VTK's files.

use std::str::FromStr;

/// Types of numbers, by their sizes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Type {
    Signed(usize),
    Unsigned(usize),
    Single,
    Double,
}

impl Type {
    /// [byte] size of a number
    pub(super) fn size(self) -> usize {
        match self {
            Type::Signed(size) | Type::Unsigned(size) => size,
            Type::Single => 4,
            Type::Double => 8,
        }
    }

    pub(super) fn is_whole(self) -> bool {
        matches!(self, Type::Signed(_) | Type::Unsigned(_))
    }
}

/// The numbers of `N` bytes each.
fn each<const N: usize, T>(bytes: &[u8], big_endian: bool, number: impl Fn([u8; N]) -> T) -> Vec<T> {
    let words = bytes.as_chunks().0.iter();
    let turned = |word: &[u8; N]| std::array::from_fn(|i| word[N - 1 - i]);
    if big_endian {
        words.map(|word| number(turned(word))).collect()
    } else {
        words.map(|word| number(*word)).collect()
    }
}

/// Places, three numbers each; `None` if numbers are left over.
pub(super) fn places(bytes: &[u8], kind: Type, big_endian: bool) -> Option<Vec<[f64; 3]>> {
    fn of<const N: usize>(bytes: &[u8], big_endian: bool, number: impl Fn([u8; N]) -> f64) -> Option<Vec<[f64; 3]>> {
        let turned = |word: [u8; N]| if big_endian { std::array::from_fn(|i| word[N - 1 - i]) } else { word };
        let (threes, []) = bytes.as_chunks().0.as_chunks::<3>() else { return None };
        Some(threes.iter().map(|three| three.map(|word| number(turned(word)))).collect())
    }
    match kind {
        Type::Double => of(bytes, big_endian, f64::from_le_bytes),
        Type::Single => of(bytes, big_endian, |b| f32::from_le_bytes(b).into()),
        _ => places_of(&Numbers::of_bytes(bytes, kind, big_endian).reals()),
    }
}

/// The same for numbers.
pub(super) fn places_of(numbers: &[f64]) -> Option<Vec<[f64; 3]>> {
    let (threes, []) = numbers.as_chunks() else { return None };
    Some(threes.to_vec())
}

/// The numbers of an array.
#[derive(Clone, Debug, PartialEq)]
pub enum Numbers {
    /// whole ones
    Whole(Vec<i64>),
    /// others
    Real(Vec<f64>),
}

impl Numbers {
    pub(super) fn of_bytes(bytes: &[u8], kind: Type, big_endian: bool) -> Self {
        match kind {
            Type::Signed(1) => Numbers::Whole(each(bytes, big_endian, |b| i8::from_le_bytes(b).into())),
            Type::Signed(2) => Numbers::Whole(each(bytes, big_endian, |b| i16::from_le_bytes(b).into())),
            Type::Signed(4) => Numbers::Whole(each(bytes, big_endian, |b| i32::from_le_bytes(b).into())),
            Type::Unsigned(1) => Numbers::Whole(each(bytes, big_endian, |b| u8::from_le_bytes(b).into())),
            Type::Unsigned(2) => Numbers::Whole(each(bytes, big_endian, |b| u16::from_le_bytes(b).into())),
            Type::Unsigned(4) => Numbers::Whole(each(bytes, big_endian, |b| u32::from_le_bytes(b).into())),
            Type::Signed(_) | Type::Unsigned(_) => Numbers::Whole(each(bytes, big_endian, i64::from_le_bytes)),
            Type::Single => Numbers::Real(each(bytes, big_endian, |b| f32::from_le_bytes(b).into())),
            Type::Double => Numbers::Real(each(bytes, big_endian, f64::from_le_bytes)),
        }
    }

    /// Of words; at most so many.
    pub(super) fn of_words<'a>(words: impl Iterator<Item = &'a str>, kind: Type, most: usize) -> Result<Self, String> {
        fn all<'a, T: FromStr>(words: impl Iterator<Item = &'a str>, most: usize) -> Result<Vec<T>, String> {
            let number = |word: &str| word.parse().map_err(|_| format!("has \"{word}\" where a number is expected"));
            words.take(most.saturating_add(1)).map(number).collect()
        }
        let numbers =
            if kind.is_whole() { Numbers::Whole(all(words, most)?) } else { Numbers::Real(all(words, most)?) };
        if numbers.len() > most {
            Err("is damaged: an array has more numbers than it should".to_owned())
        } else {
            Ok(numbers)
        }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Numbers::Whole(list) => list.len(),
            Numbers::Real(list) => list.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// As real numbers.
    pub fn reals(self) -> Vec<f64> {
        match self {
            Numbers::Whole(list) => list.into_iter().map(|n| n as f64).collect(),
            Numbers::Real(list) => list,
        }
    }

    /// As whole numbers.
    pub fn whole(self) -> Vec<i64> {
        match self {
            Numbers::Whole(list) => list,
            Numbers::Real(list) => list.into_iter().map(|x| x as i64).collect(),
        }
    }
}
