//! Sections of a file, and the numbers in them.

use std::borrow::Cow;
use std::io::BufRead as _;

/// A section: its name without the sign, and what stands between its lines.
pub(super) struct Sections<'a>(Vec<(&'a str, &'a [u8])>);

/// A line, and what follows it.
fn line(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let end = bytes.iter().position(|byte| *byte == b'\n')?;
    Some((bytes[..end].trim_ascii(), &bytes[end + 1..]))
}

/// Where a mark begins.
fn find(bytes: &[u8], mark: &[u8]) -> Option<usize> {
    let mut from = 0;
    // The first byte is rare, so that this is fast where whole windows would not be.
    loop {
        let passed = bytes.get(from..)?.skip_until(mark[0]).ok().filter(|passed| *passed > 0)?;
        from += passed;
        if bytes[from - 1..].starts_with(mark) {
            return Some(from - 1);
        }
    }
}

impl<'a> Sections<'a> {
    /// All sections in their order. What a section holds is not searched for others.
    pub(super) fn of(bytes: &'a [u8]) -> Result<Self, String> {
        let mut rest = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let mut sections = Vec::new();
        while let Some((title, after)) = line(rest) {
            rest = after;
            let Some(name) = title.strip_prefix(b"$").and_then(|name| std::str::from_utf8(name).ok()) else { continue };
            // Version 1 ends $NOD with $ENDNOD.
            let ends = [format!("$End{name}"), format!("$END{name}")];
            let end = ends.iter().find_map(|end| find(rest, end.as_bytes()));
            let end = end.ok_or_else(|| format!("is cut off: ${name} has no end"))?;
            sections.push((name, &rest[..end]));
            rest = line(&rest[end..]).map_or(&[][..], |(_, after)| after);
        }
        Ok(Sections(sections))
    }

    pub(super) fn get(&self, name: &str) -> Option<&'a [u8]> {
        self.0.iter().find(|(known, _)| *known == name).map(|(_, body)| *body)
    }

    pub(super) fn need(&self, name: &str) -> Result<&'a [u8], String> {
        self.get(name).ok_or_else(|| format!("has no ${name} section"))
    }
}

/// Numbers of a section, from text or from little-endian binary.
pub(super) enum Numbers<'a> {
    Text(std::str::SplitAsciiWhitespace<'a>),
    Binary(&'a [u8]),
}

impl<'a> Numbers<'a> {
    pub(super) fn of(body: &'a [u8], binary: bool) -> Result<Self, String> {
        if binary {
            return Ok(Self::Binary(body));
        }
        let text = std::str::from_utf8(body).map_err(|_| "has a section that is not text".to_owned())?;
        Ok(Self::Text(text.split_ascii_whitespace()))
    }

    /// The count on the first line, which is text in version 2, and the numbers after it.
    pub(super) fn counted(body: &'a [u8], binary: bool) -> Result<(u64, Self), String> {
        let (first, rest) = line(body).ok_or("ends too early")?;
        let text: Cow<'_, str> = String::from_utf8_lossy(first);
        let count = text.trim().parse().map_err(|_| format!("\"{text}\" is not a count"))?;
        Ok((count, Self::of(rest, binary)?))
    }

    fn text<T: std::str::FromStr>(words: &mut std::str::SplitAsciiWhitespace<'_>) -> Result<T, String> {
        let word = words.next().ok_or("ends too early")?;
        word.parse().map_err(|_| format!("\"{word}\" is not a number that is expected here"))
    }

    fn bytes<const N: usize>(rest: &mut &[u8]) -> Result<[u8; N], String> {
        let (head, tail) = rest.split_first_chunk::<N>().ok_or("ends too early")?;
        *rest = tail;
        Ok(*head)
    }

    /// A whole number of 4 bytes.
    pub(super) fn int(&mut self) -> Result<i32, String> {
        match self {
            Self::Text(words) => Self::text(words),
            Self::Binary(rest) => Self::bytes(rest).map(i32::from_le_bytes),
        }
    }

    /// A label of 4 bytes.
    pub(super) fn tag(&mut self) -> Result<u64, String> {
        match self {
            Self::Text(words) => Self::text(words),
            Self::Binary(rest) => Self::bytes(rest).map(u32::from_le_bytes).map(u64::from),
        }
    }

    /// A count or a label of 8 bytes.
    pub(super) fn size(&mut self) -> Result<u64, String> {
        match self {
            Self::Text(words) => Self::text(words),
            Self::Binary(rest) => Self::bytes(rest).map(u64::from_le_bytes),
        }
    }

    pub(super) fn real(&mut self) -> Result<f64, String> {
        match self {
            Self::Text(words) => Self::text(words),
            Self::Binary(rest) => Self::bytes(rest).map(f64::from_le_bytes),
        }
    }

    /// Refuses more numbers than the counts of the section say.
    pub(super) fn at_end(&mut self, name: &str) -> Result<(), String> {
        let more = match self {
            Self::Text(words) => words.next().is_some(),
            Self::Binary(rest) => !rest.trim_ascii().is_empty(),
        };
        if more { Err(format!("has more in ${name} than its counts say")) } else { Ok(()) }
    }
}
