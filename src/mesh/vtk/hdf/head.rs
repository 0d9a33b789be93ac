//! The part of a VTKHDF file that precedes the first frame: its groups, what does not change, and data sets without
//! rows.

use super::super::cells::{Cells, VtuError};
use super::super::encode::{CellTable, Width, little_endian};
use super::super::write::{FixedArrays, Snapshot, Values, bytes, right};
use super::super::{Compression, Precision, VtuFormat};
use super::filters::pack;
use super::header::{Header, Kind, Layout, NOWHERE, SUPERBLOCK, Shape, superblock};
use super::link_name;
use super::tree::{Chunk, Tree, node_bytes, single};

/// [-] rows of a chunk of the lists with a number for each step
pub(super) const STEPS: usize = 64;

/// What does not change in a run.
#[derive(Clone, Copy, Debug)]
pub struct HdfScene<'a> {
    /// the cells
    pub cells: &'a Cells<'a>,
    /// arrays that all frames have
    pub fixed: &'a FixedArrays<'a>,
    /// digits and compression
    pub format: VtuFormat,
    /// a frame with all arrays, whose numbers do not matter
    pub frame: &'a Snapshot<'a>,
}

/// A data set with rows for every step.
#[derive(Clone, Debug)]
pub(super) struct Growing {
    pub(super) shape: Shape,
    pub(super) tree: Tree,
    /// where the file has the number of its rows
    pub(super) rows_at: u64,
    /// where it has the address of the root of its tree
    pub(super) root_at: u64,
}

/// The lists with a number for each step.
#[derive(Clone, Debug)]
pub(super) struct Lists {
    /// times, first rows on points, first rows on cells
    pub(super) stored: [Growing; 3],
    /// the last chunk of each
    pub(super) last: [u64; 3],
    /// where the numbers of rows of lists are whose numbers are all the same
    pub(super) same_rows_at: [u64; 2],
    /// where the number of steps is
    pub(super) steps_at: u64,
}

/// The part of a file that precedes the first frame.
pub(super) struct Head {
    pub(super) image: Vec<u8>,
    pub(super) cells: usize,
    pub(super) arrays: Vec<Growing>,
    pub(super) lists: Lists,
}

/// Builds the head of a file, from its start to its end.
struct Builder {
    image: Vec<u8>,
}

impl Builder {
    fn put(&mut self, bytes: &[u8]) -> u64 {
        let at = self.image.len() as u64;
        self.image.extend_from_slice(bytes);
        self.image.resize(self.image.len().next_multiple_of(8), 0);
        at
    }

    /// A group with links; the address of its header.
    fn group(&mut self, links: &[(String, u64)]) -> u64 {
        let mut header = Header::group();
        links.iter().for_each(|(name, at)| header.link(name, *at));
        self.put(&header.bytes(1))
    }

    /// A data set that does not change; in one piece where the filters do not make it smaller.
    fn fixed(&mut self, kind: Kind, components: Option<usize>, numbers: &[u8]) -> Result<u64, VtuError> {
        let shape = Shape { kind, components, rows: 1 };
        let rows = numbers.len() / shape.row_bytes();
        let shape = Shape { rows, ..shape };
        let [mut shuffled, mut packed] = [Vec::new(), Vec::new()];
        let left_out = pack(numbers, shape.row_bytes(), &mut shuffled, &mut packed)?;
        let layout = if packed.len() + node_bytes(shape) < numbers.len() {
            let chunk = Chunk { at: self.put(&packed), length: packed.len() as u32, left_out };
            Layout::Chunks { tree: self.put(&single(shape, chunk)), packed: true }
        } else {
            Layout::Whole { at: self.put(numbers) }
        };
        let (header, _) = Header::data(shape, rows as u64, layout, None);
        Ok(self.put(&header.bytes(1)))
    }

    /// A data set that grows, to which `links` groups lead; the address of its header.
    fn growing(&mut self, shape: Shape, packed: bool, links: usize) -> (u64, Growing) {
        let layout = Layout::Chunks { tree: NOWHERE, packed };
        let (header, fields) = Header::data(shape, 0, layout, None);
        let at = self.put(&header.bytes(links as u32));
        let (rows_at, root_at) = (at + fields.rows as u64, at + fields.tree as u64);
        (at, Growing { shape, tree: Tree::new(shape, root_at), rows_at, root_at })
    }

    /// A list for all steps of the same number, which is not stored; its address, and where the number of its rows is.
    fn same(&mut self, value: i64, links: usize) -> (u64, u64) {
        let layout = Layout::Chunks { tree: NOWHERE, packed: false };
        let shape = Shape { kind: Kind::I64, components: None, rows: STEPS };
        let (header, fields) = Header::data(shape, 0, layout, Some(value));
        let at = self.put(&header.bytes(links as u32));
        (at, at + fields.rows as u64)
    }
}

/// Names and addresses of the arrays of points, of cells, and of the file as a whole.
type Links = [Vec<(String, u64)>; 3];

impl Head {
    pub(super) fn new(scene: &HdfScene<'_>) -> Result<Self, VtuError> {
        let HdfScene { cells, fixed, format, frame } = *scene;
        let table = CellTable::new(cells, Width::Long)?;
        let counts = [cells.points, table.types.len()];
        let mut to = Builder { image: vec![0; SUPERBLOCK] };
        let number = |n: usize| (n as i64).to_le_bytes();
        let mut mesh = Vec::new();
        for (name, count) in [
            ("NumberOfPoints", counts[0]),
            ("NumberOfCells", counts[1]),
            ("NumberOfConnectivityIds", table.connectivity.len() / 8),
        ] {
            mesh.push((name.to_owned(), to.fixed(Kind::I64, None, &number(count))?));
        }
        mesh.push(("Connectivity".to_owned(), to.fixed(Kind::I64, None, &table.connectivity)?));
        let ends = [&number(0)[..], &table.ends].concat();
        mesh.push(("Offsets".to_owned(), to.fixed(Kind::I64, None, &ends)?));
        mesh.push(("Types".to_owned(), to.fixed(Kind::U8, None, &table.types)?));
        let still = fixed_arrays(&mut to, fixed, counts)?;
        let (arrays, moving) = growing_arrays(&mut to, frame, format, counts, &mut mesh);
        let (lists, steps) = step_lists(&mut to, &still, &moving);
        for (group, name) in ["PointData", "CellData", "FieldData"].into_iter().enumerate() {
            let all: Vec<_> = [&still[group][..], moving.get(group).map_or(&[], |of| of)].concat();
            mesh.push((name.to_owned(), to.group(&all)));
        }
        mesh.push(("Steps".to_owned(), steps));
        let mut header = Header::group();
        header.attribute("Version", &[2], &[2, 2]);
        header.text("Type", "UnstructuredGrid");
        mesh.iter().for_each(|(name, at)| header.link(name, *at));
        let vtk = to.put(&header.bytes(1));
        let root = to.group(&[("VTKHDF".to_owned(), vtk)]);
        let length = to.image.len() as u64;
        to.image[..SUPERBLOCK].copy_from_slice(&superblock(root, length));
        Ok(Self { image: to.image, cells: counts[1], arrays, lists })
    }
}

/// Arrays that all frames have.
fn fixed_arrays(to: &mut Builder, fixed: &FixedArrays<'_>, [points, cells]: [usize; 2]) -> Result<Links, VtuError> {
    let mut links = Links::default();
    if let Some((name, vectors)) = fixed.point_vectors {
        right(name, vectors.len(), points)?;
        links[0].push((link_name(name), to.fixed(Kind::F64, Some(3), &little_endian(vectors.as_flattened()))?));
    }
    for (place, numbers, count) in [(0, fixed.point_numbers, points), (1, fixed.cell_numbers, cells)] {
        let Some((name, numbers)) = numbers else { continue };
        right(name, numbers.len(), count)?;
        links[place].push((link_name(name), to.fixed(Kind::I32, None, &bytes(numbers))?));
    }
    for (name, flags) in fixed.cell_flags {
        right(name, flags.len(), cells)?;
        links[1].push((link_name(name), to.fixed(Kind::U8, None, flags)?));
    }
    for (name, numbers) in fixed.field {
        // One row: VTK takes one of a field for each step.
        links[2].push((link_name(name), to.fixed(Kind::I32, Some(numbers.len().max(1)), &bytes(numbers))?));
    }
    Ok(links)
}

/// Arrays of every frame; the points join the mesh.
fn growing_arrays(
    to: &mut Builder,
    frame: &Snapshot<'_>,
    format: VtuFormat,
    counts: [usize; 2],
    mesh: &mut Vec<(String, u64)>,
) -> (Vec<Growing>, [Vec<(String, u64)>; 2]) {
    let packed = format.compression == Compression::Zlib;
    let real = if format.precision == Precision::F32 { Kind::F32 } else { Kind::F64 };
    let (mut arrays, mut links) = (Vec::new(), [Vec::new(), Vec::new()]);
    let points = Shape { kind: Kind::F64, components: Some(3), rows: counts[0] };
    let (at, growing) = to.growing(points, packed, 1);
    mesh.push(("Points".to_owned(), at));
    arrays.push(growing);
    for (place, list) in [frame.point_data, frame.cell_data].into_iter().enumerate() {
        for array in list {
            let (kind, components) = match array.values {
                Values::Scalars(_) => (real, None),
                Values::Vectors(_) => (real, Some(3)),
                Values::Flags(_) => (Kind::U8, None),
            };
            let shape = Shape { kind, components, rows: counts[place] };
            let (at, growing) = to.growing(shape, packed, 1);
            links[place].push((link_name(array.name), at));
            arrays.push(growing);
        }
    }
    (arrays, links)
}

/// The group of steps: times, and where the rows of a step begin. Lists with the same numbers are one.
fn step_lists(to: &mut Builder, still: &Links, moving: &[Vec<(String, u64)>; 2]) -> (Lists, u64) {
    let list = |kind| Shape { kind, components: None, rows: STEPS };
    let (values_at, values) = to.growing(list(Kind::F64), false, 1);
    let (on_points_at, on_points) = to.growing(list(Kind::I64), false, 1 + moving[0].len());
    let (on_cells_at, on_cells) = to.growing(list(Kind::I64), false, moving[1].len().max(1));
    let still_links = still.iter().map(Vec::len).sum::<usize>();
    let (zeros_at, zero_rows) = to.same(0, 3 + still_links);
    let (ones_at, one_rows) = to.same(1, 1);
    let offsets = |place: usize, at: u64| {
        let moving = moving.get(place).into_iter().flatten().map(move |(name, _)| (name.clone(), at));
        let still = still[place].iter().map(|(name, _)| (name.clone(), zeros_at));
        still.chain(moving).collect::<Vec<_>>()
    };
    let groups = [("Point", on_points_at), ("Cell", on_cells_at), ("Field", zeros_at)];
    let mut links: Vec<(String, u64)> = Vec::new();
    for (place, (name, at)) in groups.into_iter().enumerate() {
        links.push((format!("{name}DataOffsets"), to.group(&offsets(place, at))));
    }
    let named = [
        ("Values", values_at),
        ("PointOffsets", on_points_at),
        ("NumberOfParts", ones_at),
        ("PartOffsets", zeros_at),
        ("CellOffsets", zeros_at),
        ("ConnectivityIdOffsets", zeros_at),
    ];
    links.extend(named.map(|(name, at)| (name.to_owned(), at)));
    let mut header = Header::group();
    let steps_in_header = header.attribute("NSteps", &[], &[0]);
    links.iter().for_each(|(name, at)| header.link(name, *at));
    let at = to.put(&header.bytes(1));
    let lists = Lists {
        stored: [values, on_points, on_cells],
        last: [0; 3],
        same_rows_at: [zero_rows, one_rows],
        steps_at: at + steps_in_header as u64,
    };
    (lists, at)
}
