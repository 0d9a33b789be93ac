//! Tables of the guide that are made from the program: its materials, and its numbers of the field.

use crate::pages::folder;
use canopy_fem::case::materials::shipped;
use canopy_fem::case::schema::Material;
use canopy_fem::format_number::figures;
use canopy_fem::mesh::parachute::CanopyType;
use std::collections::BTreeMap;
use std::fmt::Write;

/// The table between two comments of a page is as it was made just now; `GUIDE_WRITE` makes it so.
fn is_kept(page: &str, mark: &str, made: &str) {
    let path = folder().join(page);
    let text = std::fs::read_to_string(&path).expect("the page");
    let (begin, end) = (format!("<!-- {mark} -->\n"), format!("<!-- end of {mark} -->\n"));
    let from = text.find(&begin).expect("the mark") + begin.len();
    let to = text.find(&end).expect("the other mark");
    let made = format!("\n{made}\n");
    if std::env::var_os("GUIDE_WRITE").is_some() {
        std::fs::write(&path, format!("{}{made}{}", &text[..from], &text[to..])).expect("the page is written");
        return;
    }
    assert_eq!(text[from..to], made, "{page} is out of date: GUIDE_WRITE=1 cargo test --test guide writes it anew");
}

/// Which groups of numbers are assumed.
fn assumed(sources: &BTreeMap<String, String>) -> String {
    let groups = sources.iter().filter(|(_, source)| source.contains("assumed")).map(|(group, _)| group.as_str());
    groups.filter(|group| !["damping", "drag"].contains(group)).collect::<Vec<_>>().join(", ")
}

#[test]
fn the_table_of_materials_is_that_of_the_file() {
    let mut cloths =
        "| cloth | what it is | E t [kN/m] | g/m² | strength [kN/m] | assumed |\n|---|---|---|---|---|---|\n"
            .to_owned();
    let mut lines =
        "| line | what it is | EA [kN] | g/m | strength [kN] | diameter [mm] | assumed |\n|---|---|---|---|---|---|---|\n"
            .to_owned();
    let of = |value: Option<f64>, unit: f64| value.map_or("–".to_owned(), |value| figures(value / unit, 3));
    for (name, material) in shipped() {
        let written = match material {
            Material::Cloth(c) => {
                let about = c.about.as_deref().unwrap_or_default();
                let [stiffness, mass] =
                    [(c.modulus * c.thickness, 1e3), (c.areal_density, 1e-3)].map(|(v, u)| of(Some(v), u));
                let strength = of(c.strength, 1e3);
                writeln!(cloths, "| `{name}` | {about} | {stiffness} | {mass} | {strength} | {} |", assumed(&c.sources))
            }
            Material::Line(l) => {
                let about = l.about.as_deref().unwrap_or_default();
                let [ea, mass] = [(l.axial_rigidity, 1e3), (Some(l.linear_density), 1e-3)].map(|(v, u)| of(v, u));
                let [strength, diameter] = [(l.strength, 1e3), (l.diameter, 1e-3)].map(|(v, u)| of(v, u));
                let assumed = assumed(&l.sources);
                writeln!(lines, "| `{name}` | {about} | {ea} | {mass} | {strength} | {diameter} | {assumed} |")
            }
        };
        written.expect("a row");
    }
    let rest = "Dashpots of 1 ms and drag coefficients of 1.1 are assumed for all.\n";
    is_kept("materials.md", "materials", &format!("{cloths}\n{lines}\n{rest}"));
}

#[test]
fn the_table_of_types_is_that_of_the_program() {
    let mut table =
        "| `type` | CD0 | n | exponent | Dp/D0 | Cx | lines [D0] |\n|---|---|---|---|---|---|---|\n".to_owned();
    let none = || "none found".to_owned();
    let number = |value: Option<f64>| value.map_or_else(none, |value| figures(value, 4));
    let range = |range: Option<[f64; 2]>| match range {
        Some([low, high]) if low == high => figures(low, 4),
        Some([low, high]) => format!("{}–{}", figures(low, 4), figures(high, 4)),
        None => none(),
    };
    for kind in CanopyType::ALL {
        let n = kind.numbers();
        let (cd, dp) = (range(n.drag_coefficient), range(n.projected_diameter));
        let [constant, exponent, cx, lines] =
            [n.filling_constant, n.exponent, n.opening_force, n.line_length].map(number);
        writeln!(table, "| `{kind}` | {cd} | {constant} | {exponent} | {dp} | {cx} | {lines} |").expect("a row");
    }
    is_kept("parachutes.md", "types", &table);
}
