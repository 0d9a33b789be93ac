//! The text of mesh files, whatever program wrote it.

use std::borrow::Cow;

/// The text of a file without a byte-order mark, its lines ended by "\n" or "\r\n". UTF-16 needs its mark; bytes that
/// are no UTF-8 are taken as Latin-1.
pub(super) fn text(bytes: &[u8]) -> Cow<'_, str> {
    let wide = |bytes: &[u8], unit: fn([u8; 2]) -> u16| {
        String::from_utf16_lossy(&bytes.as_chunks().0.iter().map(|pair| unit(*pair)).collect::<Vec<_>>())
    };
    let text = match bytes {
        [0xff, 0xfe, rest @ ..] => Cow::Owned(wide(rest, u16::from_le_bytes)),
        [0xfe, 0xff, rest @ ..] => Cow::Owned(wide(rest, u16::from_be_bytes)),
        [0xef, 0xbb, 0xbf, rest @ ..] | rest => match std::str::from_utf8(rest) {
            Ok(text) => Cow::Borrowed(text),
            Err(_) => Cow::Owned(rest.iter().copied().map(char::from).collect()),
        },
    };
    if text.contains('\r') && !text.contains('\n') { Cow::Owned(text.replace('\r', "\n")) } else { text }
}

/// A number of a word, with its reason if it is none.
pub(super) fn number<T: std::str::FromStr>(word: Option<&str>) -> Result<T, String> {
    let word = word.ok_or("a number is missing")?;
    word.parse().map_err(|_| format!("\"{word}\" is not a number that is expected here"))
}

/// Three coordinates.
pub(super) fn point<'a>(words: &mut impl Iterator<Item = &'a str>) -> Result<[f64; 3], String> {
    Ok([number(words.next())?, number(words.next())?, number(words.next())?])
}

/// A real number as Fortran writes it: `1.5-3` is 1.5e-3, and `1.D2` is 100.
pub(super) fn real(word: &str) -> Result<f64, String> {
    let plain = word.to_ascii_uppercase().replace('D', "E");
    let sign = plain.char_indices().skip(1).find(|(at, c)| "+-".contains(*c) && !plain[..*at].ends_with('E'));
    let text = sign.map_or(plain.clone(), |(at, _)| format!("{}E{}", &plain[..at], &plain[at..]));
    text.parse().map_err(|_| format!("\"{word}\" is not a number"))
}

/// A whole number, which Fortran may write as `12.`.
pub(super) fn label(word: &str) -> Result<u64, String> {
    let plain = word.strip_suffix('.').unwrap_or(word);
    plain.parse().map_err(|_| format!("\"{word}\" is not a number that is expected here"))
}
