//! Drawing exchange .dxf in text: faces, lines, polylines (open, closed, meshes of faces, grids), arcs, ellipses,
//! splines, meshes, and blocks where they are inserted. Closed ones are outlines, also those of lines and arcs end to
//! end. Layers are groups. Corners at one place become one node.
//!
//! Source: Autodesk, "DXF Reference". Read by hand: the crate `dxf` brings decoders of pictures and a calendar along.

mod chains;
mod curves;
mod draw;
mod entity;

use super::cells::Cells;
use super::statements::Meaning::{Nothing, Read};
use super::statements::{LeftOut, Statements};
use super::text::{number, text};
use crate::MeshFile;
use entity::Entity;
use nalgebra::Matrix4;
use std::collections::HashMap;

/// What is done with the entities of a drawing; others are left out, and counted by their kinds.
const ENTITIES: Statements = Statements {
    mark: "",
    list: &[
        (
            Read,
            &[
                "3DFACE",
                "LINE",
                "LWPOLYLINE",
                "POLYLINE",
                "VERTEX",
                "SEQEND",
                "CIRCLE",
                "ARC",
                "ELLIPSE",
                "SPLINE",
                "MESH",
                "SOLID",
                "TRACE",
                "INSERT",
            ],
        ),
        (
            Nothing,
            &[
                "",
                "SECTION",
                "ENDSEC",
                "EOF",
                "POINT",
                "TEXT",
                "MTEXT",
                "ATTDEF",
                "ATTRIB",
                "DIMENSION",
                "*DIMENSION",
                "LARGE_RADIAL*",
                "VIEWPORT",
                "LEADER",
                "MULTILEADER",
                "MLEADER",
                "TOLERANCE",
                "IMAGE",
                "WIPEOUT",
                "RTEXT",
                "ACAD_TABLE",
                "LIGHT",
                "SUN",
                "CAMERA",
                "SECTIONOBJECT",
                "GEOPOSITIONMARKER",
                "OLE*",
                "RAY",
                "XLINE",
                "*UNDERLAY",
                "ARCALIGNEDTEXT",
            ],
        ),
    ],
};

/// Most points that curves may have.
const MOST_CURVED: usize = 500_000;
/// Blocks in blocks, at most.
const DEEPEST: usize = 16;
/// Most values that the entities of inserted blocks may have.
const MOST_INSERTED: usize = 1_000_000;

pub(super) fn read(bytes: &[u8], wanted: &MeshFile) -> Result<Cells, String> {
    if bytes.starts_with(b"AutoCAD Binary DXF") {
        return Err("is a binary DXF file; save it as text".to_owned());
    }
    let text = text(bytes);
    let drawing = Drawing::of(&text)?;
    let unit = drawing.unit();
    // [1/file unit] What an edge is in the drawing.
    let scale = wanted.scale.or(unit.map(|(_, length)| length)).unwrap_or(1.0);
    let chord = wanted.edge.map_or(f64::INFINITY, |edge| edge / scale);
    let mut file = File { cells: Cells::of_corners(), chord, ..File::default() };
    file.cells.unit = unit;
    for entity in &drawing.entities {
        file.add(entity, &drawing).map_err(|why| format!("line {}: {why}", entity.line))?;
    }
    file.end_polyline()?;
    if wanted.edge.is_some() {
        file.close_chains();
    }
    file.add_open();
    file.cells.notes.extend(file.left.note());
    Ok(file.cells)
}

/// A drawing as it stands in the file.
#[derive(Default)]
struct Drawing<'a> {
    /// `$INSUNITS`, the unit of lengths
    units: i64,
    blocks: HashMap<&'a str, Block<'a>>,
    entities: Vec<Entity<'a>>,
}

#[derive(Default)]
struct Block<'a> {
    head: Entity<'a>,
    entities: Vec<Entity<'a>>,
}

impl<'a> Drawing<'a> {
    fn of(text: &'a str) -> Result<Self, String> {
        let mut drawing = Drawing::default();
        let (mut section, mut variable) = ("", "");
        let mut block: Option<Block<'a>> = None;
        let mut entity = Entity::default();
        let mut lines = text.lines();
        let mut at = 0;
        while let (Some(code), Some(value)) = (lines.next(), lines.next()) {
            at += 2;
            let code: i32 = number(Some(code.trim())).map_err(|why| format!("line {}: {why}", at - 1))?;
            let value = value.trim();
            match code {
                0 => {
                    let done = std::mem::replace(&mut entity, Entity { kind: value, line: at, values: Vec::new() });
                    match (section, done.kind) {
                        ("BLOCKS", "BLOCK") => block = Some(Block { head: done, entities: Vec::new() }),
                        ("BLOCKS", "ENDBLK") => {
                            let whole = block.take().unwrap_or_default();
                            drawing.blocks.insert(whole.head.text(2), whole);
                        }
                        ("BLOCKS", _) => block.iter_mut().for_each(|block| block.entities.push(done.clone())),
                        ("ENTITIES", _) => drawing.entities.push(done),
                        _ => {}
                    }
                }
                2 if entity.kind == "SECTION" => section = value,
                9 if section == "HEADER" => variable = value,
                70 if section == "HEADER" && variable == "$INSUNITS" => drawing.units = number(Some(value))?,
                _ if section == "ENTITIES" || section == "BLOCKS" => entity.values.push((code, value)),
                _ => {}
            }
        }
        Ok(drawing)
    }

    /// The unit of the header and its length [m].
    fn unit(&self) -> Option<(&'static str, f64)> {
        Some(match self.units {
            1 => ("inches", 0.0254),
            2 => ("feet", 0.3048),
            3 => ("miles", 1609.344),
            4 => ("millimetres", 1e-3),
            5 => ("centimetres", 1e-2),
            6 => ("metres", 1.0),
            7 => ("kilometres", 1e3),
            8 => ("microinches", 2.54e-8),
            9 => ("mils", 2.54e-5),
            10 => ("yards", 0.9144),
            13 => ("micrometres", 1e-6),
            14 => ("decimetres", 0.1),
            15 => ("decametres", 10.0),
            16 => ("hectometres", 100.0),
            21 => ("US survey feet", 1200.0 / 3937.0),
            _ => return None,
        })
    }
}

#[derive(Default)]
struct File<'a> {
    cells: Cells,
    /// [file unit] longest chord of an arc
    chord: f64,
    /// open lines, which may be part of an outline
    open: Vec<Open>,
    /// the polyline whose vertices follow
    polyline: Option<draw::Polyline>,
    /// where the entities of the open blocks stand; `None` at their own place
    place: Option<Matrix4<f64>>,
    /// layers of the open inserts, which entities on layer 0 get
    layers: Vec<&'a str>,
    inserted: usize,
    /// points on curves
    curved: usize,
    left: LeftOut,
}

/// A line through points that is not closed.
struct Open {
    points: Vec<u64>,
    layer: Vec<String>,
}

impl<'a> File<'a> {
    /// The points of a place in the drawing.
    fn point(&mut self, place: [f64; 3]) -> u64 {
        let placed = self.place.map_or(place, |matrix| matrix.transform_point(&place.into()).coords.into());
        self.cells.points.push(placed);
        self.cells.points.len() as u64 - 1
    }

    fn layer(&self, entity: &Entity<'a>) -> Vec<String> {
        let own = entity.text(8);
        let layer = if own == "0" || own.is_empty() { self.layers.last().copied().unwrap_or_default() } else { own };
        [layer].into_iter().filter(|name| !["", "0"].contains(name)).map(str::to_owned).collect()
    }

    fn add(&mut self, entity: &Entity<'a>, drawing: &Drawing<'a>) -> Result<(), String> {
        if !ENTITIES.admit(entity.kind, entity.line, &mut self.left)? {
            return Ok(());
        }
        if entity.whole(67)? == 1 {
            self.cells.remark("entities in paper space were left out");
            return Ok(());
        }
        if entity.kind == "INSERT" { self.insert(entity, drawing) } else { self.draw(entity) }
    }

    /// Adds the entities of a block, once for each row and column.
    fn insert(&mut self, insert: &Entity<'a>, drawing: &Drawing<'a>) -> Result<(), String> {
        self.end_polyline()?;
        let name = insert.text(2);
        let Some(block) = drawing.blocks.get(name) else {
            self.left.add("INSERT of a block that is not in the file", insert.line);
            return Ok(());
        };
        // Bits of blocks that are other drawings.
        if block.head.whole(70)? & 0b1100 != 0 {
            self.left.add("INSERT of another drawing", insert.line);
            return Ok(());
        }
        if self.layers.len() >= DEEPEST {
            return Err(format!("blocks are inserted in each other more than {DEEPEST} deep"));
        }
        let own = insert.text(8);
        let layer = if own == "0" { self.layers.last().copied().unwrap_or_default() } else { own };
        let outer = self.place;
        let count = |code| Ok::<i64, String>(insert.whole(code)?.max(1));
        let (columns, rows) = (count(70)?, count(71)?);
        self.layers.push(layer);
        for at in (0..rows).flat_map(|row| (0..columns).map(move |column| [column, row])) {
            self.inserted += 1;
            let own = insert.insertion(&block.head, at)?;
            self.place = Some(outer.unwrap_or_else(Matrix4::identity) * own);
            for entity in &block.entities {
                self.inserted += 1 + entity.values.len();
                if self.inserted > MOST_INSERTED {
                    return Err(format!("inserts blocks of more than {MOST_INSERTED} values; explode them"));
                }
                self.add(entity, drawing)?;
            }
            self.end_polyline()?;
        }
        self.layers.pop();
        self.place = outer;
        Ok(())
    }

    /// Adds the open lines that are part of no outline.
    fn add_open(&mut self) {
        for Open { points, layer } in std::mem::take(&mut self.open) {
            self.cells.add_line(&points, false);
            self.cells.name_cells(&layer);
        }
    }
}
