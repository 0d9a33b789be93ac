//! An SVG picture read back as a person would: lines by colour, numbers at the axes, words.

/// A chart's picture.
pub struct Picture {
    /// colour and points [px, to the right and down] of every line
    pub lines: Vec<(String, Vec<(f64, f64)>)>,
    /// colour and four control points [px] of every cubic
    cubics: Vec<(String, [(f64, f64); 4])>,
    /// colours of dashed lines
    pub dashed: Vec<String>,
    /// colour and middle [px] of every stroke of a cross
    strokes: Vec<(String, (f64, f64))>,
    /// words, their place [drawing units] and their anchor
    words: Vec<(String, [f64; 2], String)>,
}

/// From drawing units to the numbers of an axis.
#[derive(Clone, Copy, Debug)]
struct Axis {
    origin: f64,
    unit: f64,
}

impl Picture {
    pub fn read(svg: &str) -> Self {
        assert!(svg.starts_with("<svg ") && svg.trim_end().ends_with("</svg>"));
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "a number that is none");
        Self::part(svg)
    }

    /// The charts of a picture, each from its title on.
    pub fn panels(svg: &str) -> Vec<Self> {
        let starts: Vec<usize> =
            svg.match_indices("<text ").map(|(at, _)| at).filter(|at| title(&svg[*at..])).collect();
        let ends = starts[1..].iter().copied().chain([svg.len()]);
        starts.iter().zip(ends).map(|(start, end)| Self::part(&svg[*start..end])).collect()
    }

    fn part(svg: &str) -> Self {
        let mut picture = Picture {
            lines: Vec::new(),
            cubics: Vec::new(),
            dashed: Vec::new(),
            strokes: Vec::new(),
            words: Vec::new(),
        };
        for tag in svg.split('<') {
            let key = |name: &str| {
                let value = tag.split_once(&format!(" {name}=\"")).and_then(|(_, rest)| rest.split_once('"'));
                value.unwrap_or_else(|| panic!("no {name} in <{tag}")).0.to_owned()
            };
            let pair = |p: &str| p.split_once(',').map(|(x, y)| (number(x), number(y))).expect("a pair");
            if tag.contains(" stroke-dasharray=") {
                picture.dashed.push(key("stroke"));
            }
            if tag.starts_with("path") {
                let (ink, path) = (key("stroke"), key("d"));
                let mut points = Vec::new();
                for piece in path.split(['M', 'C', 'L']).skip(1) {
                    let stops: Vec<_> = piece.split_whitespace().map(pair).collect();
                    if let (&[first, second, end], Some(&start)) = (&stops[..], points.last()) {
                        picture.cubics.push((ink.clone(), [start, first, second, end]));
                    }
                    points.extend(stops.last());
                }
                picture.lines.push((ink, points));
            } else if tag.starts_with("polyline") {
                let points = key("points").split_whitespace().map(pair).collect();
                picture.lines.push((key("stroke"), points));
            } else if tag.starts_with("line ") {
                let middle = |ends: [&str; 2]| ends.iter().map(|end| number(&key(end))).sum::<f64>() / 2.0;
                picture.strokes.push((key("stroke"), (middle(["x1", "x2"]), middle(["y1", "y2"]))));
            } else if tag.starts_with("text") {
                let words = tag.split_once('>').expect("an end").1.trim().to_owned();
                picture.words.push((words, [number(&key("x")), number(&key("y"))], key("text-anchor")));
            }
        }
        picture
    }

    pub fn says(&self, words: &str) -> bool {
        self.words.iter().any(|(w, ..)| w == words)
    }

    /// All words in order.
    pub fn words(&self) -> Vec<&str> {
        self.words.iter().map(|(w, ..)| w.as_str()).collect()
    }

    /// Lines of a colour in the units of the axes. Samples in the legend have two points and are left out.
    pub fn curves(&self, color: &str) -> Vec<Vec<(f64, f64)>> {
        let (x, y) = (self.axis("middle", 0), self.axis("end", 1));
        let of_color = self.lines.iter().filter(|(c, points)| c == color && points.len() > 2);
        of_color.map(|(_, points)| points.iter().map(|p| (x.value(p.0), y.value(p.1))).collect()).collect()
    }

    /// A third of the way along each cubic of a colour, in the units of the axes.
    pub fn between(&self, color: &str) -> Vec<(f64, f64)> {
        let (x, y) = (self.axis("middle", 0), self.axis("end", 1));
        let share = [8.0, 12.0, 6.0, 1.0].map(|part| part / 27.0);
        let at = |stops: &[(f64, f64); 4]| {
            let sum = |of: fn(&(f64, f64)) -> f64| stops.iter().map(of).zip(share).map(|(v, s)| v * s).sum::<f64>();
            (x.value(sum(|p| p.0)), y.value(sum(|p| p.1)))
        };
        self.cubics.iter().filter(|(c, _)| c == color).map(|(_, stops)| at(stops)).collect()
    }

    /// Middles of the crosses of a colour in the units of the axes, each once a stroke.
    pub fn crosses(&self, color: &str) -> Vec<(f64, f64)> {
        let (x, y) = (self.axis("middle", 0), self.axis("end", 1));
        let of_color = self.strokes.iter().filter(|(c, _)| c == color);
        of_color.map(|(_, at)| (x.value(at.0), y.value(at.1))).collect()
    }

    /// The vertical axis as it is if it is logarithmic: numbers at its ticks, and their places [px].
    pub fn log_ticks(&self) -> Vec<(f64, f64)> {
        let numbers = self.words.iter().filter(|(_, _, anchor)| anchor == "end");
        numbers.filter_map(|(words, at, _)| Some((written(words)?, at[1]))).collect()
    }

    /// An axis from the numbers written along it that lie farthest apart.
    fn axis(&self, anchor: &str, direction: usize) -> Axis {
        let numbers = self.words.iter().filter(|(_, _, a)| a == anchor);
        let numbers: Vec<(f64, f64)> =
            numbers.filter_map(|(words, at, _)| Some((written(words)?, at[direction]))).collect();
        let (first, last) = (numbers.first().expect("numbers"), numbers.last().expect("numbers"));
        let unit = (last.0 - first.0) / (last.1 - first.1);
        Axis { origin: first.0 - unit * first.1, unit }
    }
}

impl Axis {
    fn value(self, at: f64) -> f64 {
        self.origin + self.unit * at
    }
}

fn title(text: &str) -> bool {
    text.split_once('>').is_some_and(|(tag, _)| tag.contains("font-size=\"160\""))
}

/// A number at an axis; "5·10⁶" and "10⁻³" are, too.
fn written(words: &str) -> Option<f64> {
    let whole =
        words.strip_prefix("10").filter(|power| !power.is_empty() && !power.is_ascii()).map(|power| ("1", power));
    let Some((mantissa, power)) = whole.or(words.split_once("·10")) else { return words.parse().ok() };
    let digit = |c: char| {
        if c == '⁻' {
            Some('-')
        } else {
            "⁰¹²³⁴⁵⁶⁷⁸⁹".chars().zip('0'..).find(|(s, _)| *s == c).map(|d| d.1)
        }
    };
    format!("{mantissa}e{}", power.chars().map(digit).collect::<Option<String>>()?).parse().ok()
}

fn number(text: &str) -> f64 {
    text.parse().unwrap_or_else(|_| panic!("{text} is no number"))
}
