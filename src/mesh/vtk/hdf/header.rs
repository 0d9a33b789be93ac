//! What an HDF5 file says of its groups and data sets: object headers of version 1, whose fields can be changed in
//! place because they have no checksums, with links as messages of their own.
//!
//! Source: The HDF Group, "HDF5 File Format Specification Version 3.0", sections II, IV.A.1.a and IV.A.2.

/// The address of something that is not there.
pub(super) const NOWHERE: u64 = u64::MAX;
/// Length of the superblock, at the start of the file.
pub(super) const SUPERBLOCK: usize = 104;
/// Where the superblock has the length of the file.
pub(super) const LENGTH_AT: u64 = 44;
/// Where it has the address of the header of the root group.
pub(super) const ROOT_AT: usize = 68;
/// The first bytes of every HDF5 file.
pub(super) const SIGNATURE: [u8; 8] = *b"\x89HDF\r\n\x1a\n";
/// [-] largest number of entries of a node of a tree of chunks, half of which the superblock says
pub(super) const NODE_ENTRIES: usize = 16;

/// Numbers of the messages of a header.
pub(super) mod message {
    pub(in super::super) const DATASPACE: u16 = 0x01;
    pub(in super::super) const LINK_INFO: u16 = 0x02;
    pub(in super::super) const DATATYPE: u16 = 0x03;
    pub(in super::super) const FILL: u16 = 0x05;
    pub(in super::super) const LINK: u16 = 0x06;
    pub(in super::super) const LAYOUT: u16 = 0x08;
    pub(in super::super) const GROUP_INFO: u16 = 0x0a;
    pub(in super::super) const FILTERS: u16 = 0x0b;
    pub(in super::super) const ATTRIBUTE: u16 = 0x0c;
}

/// Numbers of the filters of chunks.
pub(super) mod filter {
    pub(in super::super) const DEFLATE: u16 = 1;
    pub(in super::super) const SHUFFLE: u16 = 2;
}

/// Types of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// eight bytes, real
    F64,
    /// four bytes, real
    F32,
    /// eight bytes, whole, with sign
    I64,
    /// four bytes, whole, with sign
    I32,
    /// a byte, without sign
    U8,
}

impl Kind {
    /// [byte] size of a number
    pub(super) fn size(self) -> usize {
        match self {
            Kind::F64 | Kind::I64 => 8,
            Kind::F32 | Kind::I32 => 4,
            Kind::U8 => 1,
        }
    }

    /// The message that describes it.
    pub(super) fn datatype(self) -> Vec<u8> {
        let size = self.size() as u8;
        let whole = |sign: u8| vec![0x10, sign, 0, 0, size, 0, 0, 0, 0, 0, 8 * size, 0];
        let real = |exponent: [u8; 4], bias: u32| {
            // A leading one that is not stored, little end first, the sign in the last bit.
            let mut text = vec![0x11, 0x20, 8 * size - 1, 0, size, 0, 0, 0, 0, 0, 8 * size, 0];
            text.extend(exponent);
            text.extend(bias.to_le_bytes());
            text
        };
        match self {
            Kind::F64 => real([52, 11, 0, 52], 1023),
            Kind::F32 => real([23, 8, 0, 23], 127),
            Kind::I64 | Kind::I32 => whole(8),
            Kind::U8 => whole(0),
        }
    }

    /// The type that a message describes, if it is one of these.
    pub(super) fn of(datatype: &[u8]) -> Option<Self> {
        let all = [Kind::F64, Kind::F32, Kind::I64, Kind::I32, Kind::U8];
        all.into_iter().find(|kind| datatype.starts_with(&kind.datatype()))
    }
}

/// Numbers of a data set in a row of chunks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Shape {
    pub kind: Kind,
    /// numbers of a row; `None` for a list
    pub components: Option<usize>,
    /// rows of a chunk
    pub rows: usize,
}

impl Shape {
    pub(super) fn row_bytes(self) -> usize {
        self.kind.size() * self.components.unwrap_or(1)
    }

    /// [byte] size of a chunk before its filters
    pub(super) fn chunk_bytes(self) -> usize {
        self.row_bytes() * self.rows
    }

    pub(super) fn rank(self) -> usize {
        1 + usize::from(self.components.is_some())
    }
}

/// How a data set is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Layout {
    /// in one piece
    Whole { at: u64 },
    /// in chunks, found by a tree whose root is at `tree`; compressed or not
    Chunks { tree: u64, packed: bool },
}

/// The messages of a header.
#[derive(Clone, Debug, Default)]
pub(super) struct Header {
    messages: Vec<u8>,
    count: u16,
}

/// Where fields of the header of a data set are, from its start.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Fields {
    /// number of rows
    pub rows: usize,
    /// address of the tree of chunks
    pub tree: usize,
}

/// Length of what precedes the messages of a header.
const PREFIX: usize = 16;

impl Header {
    /// Adds a message; returns where its content begins, from the start of the header.
    fn add(&mut self, number: u16, content: &[u8]) -> usize {
        let length = content.len().next_multiple_of(8);
        self.messages.extend(number.to_le_bytes());
        self.messages.extend((length as u16).to_le_bytes());
        self.messages.extend([0; 4]);
        let at = PREFIX + self.messages.len();
        self.messages.extend(content);
        self.messages.resize(at - PREFIX + length, 0);
        self.count += 1;
        at
    }

    /// A group without links.
    pub(super) fn group() -> Self {
        let mut header = Self::default();
        let nowhere = [0xff; 16];
        header.add(message::LINK_INFO, &[&[0, 0], &nowhere[..]].concat());
        header.add(message::GROUP_INFO, &[0, 0]);
        header
    }

    /// Adds a link to the header at an address.
    pub(super) fn link(&mut self, name: &str, to: u64) {
        // The length of the name in two bytes, and the name in UTF-8.
        let mut content = vec![1, 0x11, 1];
        content.extend((name.len() as u16).to_le_bytes());
        content.extend(name.as_bytes());
        content.extend(to.to_le_bytes());
        self.add(message::LINK, &content);
    }

    /// Adds an attribute of whole numbers; returns where they are. An empty shape is one number.
    pub(super) fn attribute(&mut self, name: &str, shape: &[u64], values: &[i64]) -> usize {
        let data: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.any_attribute(name, &Kind::I64.datatype(), shape, &data)
    }

    /// Adds an attribute of text.
    pub(super) fn text(&mut self, name: &str, text: &str) {
        let datatype = [[0x13, 1, 0, 0], (text.len() as u32).to_le_bytes()].concat();
        self.any_attribute(name, &datatype, &[], text.as_bytes());
    }

    fn any_attribute(&mut self, name: &str, datatype: &[u8], shape: &[u64], data: &[u8]) -> usize {
        let space = dataspace(shape, None);
        let mut content = vec![1, 0];
        for length in [name.len() + 1, datatype.len(), space.len()] {
            content.extend((length as u16).to_le_bytes());
        }
        for part in [&[name.as_bytes(), &[0]].concat(), datatype, &space] {
            content.extend(part);
            content.resize(content.len().next_multiple_of(8), 0);
        }
        let data_at = content.len();
        content.extend(data);
        data_at + self.add(message::ATTRIBUTE, &content)
    }

    /// A data set with so many rows, which may grow if it is in chunks of rows.
    pub(super) fn data(shape: Shape, rows: u64, layout: Layout, fill: Option<i64>) -> (Self, Fields) {
        let mut header = Self::default();
        let dims: Vec<u64> = [Some(rows), shape.components.map(|c| c as u64)].into_iter().flatten().collect();
        let most = match layout {
            Layout::Whole { .. } => None,
            Layout::Chunks { .. } => Some(u64::MAX),
        };
        let rows_at = 8 + header.add(message::DATASPACE, &dataspace(&dims, most));
        header.add(message::DATATYPE, &shape.kind.datatype());
        // Space when it is needed; numbers that are not stored are 0, or the given one.
        match fill {
            Some(fill) => header.add(message::FILL, &[&[2, 3, 2, 1, 8, 0, 0, 0][..], &fill.to_le_bytes()].concat()),
            None => header.add(message::FILL, &[2, 3, 2, 1, 0, 0, 0, 0]),
        };
        let mut content = vec![3];
        let mut tree_at = 0;
        match layout {
            Layout::Whole { at } => {
                content.push(1);
                content.extend(at.to_le_bytes());
                content.extend((rows * shape.row_bytes() as u64).to_le_bytes());
            }
            Layout::Chunks { tree, .. } => {
                content.extend([2, shape.rank() as u8 + 1]);
                tree_at = content.len();
                content.extend(tree.to_le_bytes());
                let dims = [Some(shape.rows), shape.components, Some(shape.kind.size())];
                content.extend(dims.into_iter().flatten().flat_map(|dim| (dim as u32).to_le_bytes()));
            }
        }
        tree_at += header.add(message::LAYOUT, &content);
        if let Layout::Chunks { packed: true, .. } = layout {
            header.add(message::FILTERS, &filters(shape.row_bytes()));
        }
        (header, Fields { rows: rows_at, tree: tree_at })
    }

    /// The header for the file, with so many links to it.
    pub(super) fn bytes(&self, links: u32) -> Vec<u8> {
        let mut bytes = vec![1, 0];
        bytes.extend(self.count.to_le_bytes());
        bytes.extend(links.to_le_bytes());
        bytes.extend((self.messages.len() as u32).to_le_bytes());
        bytes.extend([0; 4]);
        bytes.extend(&self.messages);
        bytes
    }
}

fn dataspace(dims: &[u64], most: Option<u64>) -> Vec<u8> {
    let mut space = vec![1, dims.len() as u8, u8::from(most.is_some()), 0, 0, 0, 0, 0];
    space.extend(dims.iter().flat_map(|dim| dim.to_le_bytes()));
    if let Some(most) = most {
        let limits = [most].into_iter().chain(dims.iter().copied().skip(1));
        space.extend(limits.flat_map(u64::to_le_bytes));
    }
    space
}

/// Bytes sorted by their places in a row of so many bytes, then zlib.
fn filters(size: usize) -> Vec<u8> {
    let mut content = vec![1, 2, 0, 0, 0, 0, 0, 0];
    for (number, parameter) in [(filter::SHUFFLE, size as u32), (filter::DEFLATE, 1)] {
        // No name, may be left out for a chunk, one parameter, padding.
        content.extend([number, 0, 1, 1].into_iter().flat_map(u16::to_le_bytes));
        content.extend(parameter.to_le_bytes());
        content.extend([0; 4]);
    }
    content
}

/// The superblock of version 1.
pub(super) fn superblock(root: u64, length: u64) -> Vec<u8> {
    let mut block = SIGNATURE.to_vec();
    // Versions; eight bytes for an address and for a length; sizes of nodes, of which only that of chunks matters.
    block.extend([1, 0, 0, 0, 0, 8, 8, 0, 4, 0, 16, 0, 0, 0, 0, 0, NODE_ENTRIES as u8 / 2, 0, 0, 0]);
    for address in [0, NOWHERE, length, NOWHERE, 0, root] {
        block.extend(address.to_le_bytes());
    }
    block.resize(SUPERBLOCK, 0);
    block
}
