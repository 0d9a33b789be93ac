//! An SVG picture as a list of its elements; reading it is also the proof that it is well-formed.

/// An element of a picture.
#[derive(Clone, Debug, Default)]
pub struct Element {
    pub name: String,
    attributes: Vec<(String, String)>,
    /// words in it
    pub text: String,
}

impl Element {
    pub fn get(&self, name: &str) -> &str {
        self.attributes.iter().find(|(n, _)| n == name).map_or("", |(_, v)| v)
    }

    pub fn number(&self, name: &str) -> f64 {
        self.get(name).parse().unwrap_or_else(|_| panic!("{name} of {self:?} is no number"))
    }

    /// Corners of a polyline or polygon, ends of a line, the middle of a circle, the place of a text.
    pub fn points(&self) -> Vec<(f64, f64)> {
        match self.name.as_str() {
            "line" => vec![(self.number("x1"), self.number("y1")), (self.number("x2"), self.number("y2"))],
            "circle" => vec![(self.number("cx"), self.number("cy"))],
            "text" => vec![(self.number("x"), self.number("y"))],
            _ => {
                let pair = |p: &str| {
                    let (x, y) = p.split_once(',').expect("a pair");
                    (x.parse().expect("a number"), y.parse().expect("a number"))
                };
                self.get("points").split_whitespace().map(pair).collect()
            }
        }
    }
}

/// All elements in order. Panics where XML is not well-formed.
pub fn elements(svg: &str) -> Vec<Element> {
    assert!(svg.chars().all(|c| !c.is_control() || c == '\n'), "a character XML has no place for");
    let (mut found, mut open): (Vec<Element>, Vec<usize>) = (Vec::new(), Vec::new());
    let mut rest = svg;
    while let Some(start) = rest.find('<') {
        let words = text(&rest[..start]);
        match open.last() {
            Some(at) => found[*at].text.push_str(words.trim()),
            None => assert_eq!(words.trim(), "", "words outside the picture"),
        }
        let end = rest.find('>').expect("a tag ends");
        let tag = &rest[start + 1..end];
        rest = &rest[end + 1..];
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(found[open.pop().expect("something is open")].name, name, "ends what is open");
            continue;
        }
        let (inner, empty) = tag.strip_suffix('/').map_or((tag, false), |inner| (inner, true));
        let (name, attributes) = inner.split_once(char::is_whitespace).unwrap_or((inner, ""));
        found.push(Element { name: name.to_owned(), attributes: pairs(attributes), text: String::new() });
        if !empty {
            open.push(found.len() - 1);
        }
    }
    assert!(open.is_empty() && rest.trim().is_empty(), "{} elements are not closed", open.len());
    found
}

fn pairs(mut rest: &str) -> Vec<(String, String)> {
    let mut found: Vec<(String, String)> = Vec::new();
    while let Some((name, after)) = rest.split_once('=') {
        let value = after.strip_prefix('"').expect("a quote");
        let (value, after) = value.split_once('"').expect("a quote ends");
        let name = name.trim().to_owned();
        assert!(found.iter().all(|(n, _)| *n != name), "{name} twice");
        found.push((name, text(value)));
        rest = after;
    }
    assert_eq!(rest.trim(), "");
    found
}

/// Words without their escapes.
fn text(escaped: &str) -> String {
    let mut parts = escaped.split('&');
    let mut plain = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (name, rest) = part.split_once(';').expect("an escape ends");
        plain.push(match name {
            "amp" => '&',
            "lt" => '<',
            "gt" => '>',
            "quot" => '"',
            "apos" | "#39" => '\'',
            other => panic!("an unknown escape &{other};"),
        });
        plain.push_str(rest);
    }
    plain
}

/// [px] Left, top, right and bottom of the frames of a picture, in the order they were drawn.
pub fn frames(picture: &[Element]) -> Vec<[f64; 4]> {
    let closed = |p: &[(f64, f64)]| p.len() == 5 && p.first() == p.last();
    let lines = picture.iter().filter(|e| e.name == "polyline" && e.get("stroke") == "#333333").map(Element::points);
    lines.filter(|p| closed(p)).map(|p| [p[0].0, p[0].1, p[2].0, p[2].1]).collect()
}

/// Marks in a frame: one middle each. A cross is two lines, an upright cross two polylines at one place.
pub fn marks(picture: &[Element], [left, top, right, bottom]: [f64; 4]) -> Vec<(f64, f64)> {
    let within =
        |p: &(f64, f64)| (left - 8.0..=right + 8.0).contains(&p.0) && (top - 8.0..=bottom + 8.0).contains(&p.1);
    let coloured = picture.iter().filter(|e| matches!(e.name.as_str(), "line" | "polyline"));
    let coloured = coloured.filter(|e| e.get("stroke") != "#E2E2E2" && e.get("stroke") != "#333333");
    let mut found: Vec<(f64, f64)> = Vec::new();
    for points in coloured.map(Element::points).filter(|p| p.len() == 2 && p.iter().all(within)) {
        let at = (f64::midpoint(points[0].0, points[1].0), f64::midpoint(points[0].1, points[1].1));
        if found.iter().all(|f| (f.0 - at.0).abs().max((f.1 - at.1).abs()) > 10.0) {
            found.push(at);
        }
    }
    found
}

/// A logarithmic axis read back from its powers of ten.
pub fn axis(picture: &[Element], anchor: &str, of: fn((f64, f64)) -> f64) -> impl Fn(f64) -> f64 {
    let power = |text: &str| -> Option<f64> {
        let digits = text.strip_prefix("10")?.chars().map(|c| match c {
            '⁻' => Some('-'),
            c => "⁰¹²³⁴⁵⁶⁷⁸⁹".chars().position(|d| d == c).and_then(|d| char::from_digit(d as u32, 10)),
        });
        digits.collect::<Option<String>>()?.parse().ok()
    };
    let texts = picture.iter().filter(|e| e.name == "text" && e.get("text-anchor") == anchor);
    let ticks: Vec<(f64, f64)> = texts.filter_map(|e| Some((power(&e.text)?, of(e.points()[0])))).collect();
    let ((first, a), (last, b)) = (ticks[0], *ticks.last().expect("ticks"));
    move |at| 10f64.powf(first + (at - a) * (last - first) / (b - a))
}
