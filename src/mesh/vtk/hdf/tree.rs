//! The tree of the chunks of a data set that grows at its end: B-trees of version 1, whose nodes are changed in place.
//!
//! Chunk n is the n-th entry of the leaves, which are full except the last, and so are all levels above. So the way to
//! a chunk follows from its number, and a tree can be cut back to what it was.
//!
//! Source: The HDF Group, "HDF5 File Format Specification Version 3.0", section III.A.1.

use super::header::{NODE_ENTRIES, NOWHERE, Shape};
use super::region::{Region, word};
use std::io;

/// Length of what precedes the entries of a node.
const PREFIX: usize = 24;
/// Where a node has the address of the next one.
const RIGHT: usize = 16;
/// Where it has the number of its entries.
const USED: usize = 6;
/// [-] chunks of a tree, at most: the last key of a node, which is above those of all chunks
const MOST_CHUNKS: u64 = 1 << 32;

/// A chunk in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Chunk {
    pub at: u64,
    /// [byte] its length in the file
    pub length: u32,
    /// filters that were left out, by bits
    pub left_out: u32,
}

#[derive(Clone, Debug)]
struct Node {
    at: u64,
    used: usize,
}

/// A tree that grows.
#[derive(Clone, Debug)]
pub(super) struct Tree {
    shape: Shape,
    /// where the file has the address of the root
    root_at: u64,
    /// from the root to the last leaf
    path: Vec<Node>,
    chunks: u64,
}

/// [byte] length of a key of a tree
fn key_bytes(shape: Shape) -> usize {
    8 + 8 * (shape.rank() + 1)
}

/// [byte] length of a node
pub(super) fn node_bytes(shape: Shape) -> usize {
    PREFIX + NODE_ENTRIES * (key_bytes(shape) + 8) + key_bytes(shape)
}

fn entry_at(shape: Shape, entry: usize) -> usize {
    PREFIX + entry * (key_bytes(shape) + 8)
}

/// The key of a chunk by its number.
fn key(shape: Shape, number: u64, chunk: Chunk) -> Vec<u8> {
    let mut key = Vec::new();
    key.extend(chunk.length.to_le_bytes());
    key.extend(chunk.left_out.to_le_bytes());
    key.extend((number * shape.rows as u64).to_le_bytes());
    key.resize(key_bytes(shape), 0);
    key
}

/// An entry and the key above it.
fn entry(shape: Shape, number: u64, chunk: Chunk, child: u64) -> Vec<u8> {
    let none = Chunk { at: 0, length: 0, left_out: 0 };
    [key(shape, number, chunk), child.to_le_bytes().to_vec(), key(shape, MOST_CHUNKS, none)].concat()
}

/// A node with its first entry.
fn node(shape: Shape, level: usize, left: u64, entry: &[u8]) -> Vec<u8> {
    let mut node = b"TREE\x01".to_vec();
    node.extend([level as u8, 1, 0]);
    node.extend(left.to_le_bytes());
    node.extend(NOWHERE.to_le_bytes());
    node.extend(entry);
    node.resize(node_bytes(shape), 0);
    node
}

/// A tree of one chunk, for a data set that does not grow.
pub(super) fn single(shape: Shape, chunk: Chunk) -> Vec<u8> {
    node(shape, 0, NOWHERE, &entry(shape, 0, chunk, chunk.at))
}

impl Tree {
    pub(super) fn new(shape: Shape, root_at: u64) -> Self {
        Self { shape, root_at, path: Vec::new(), chunks: 0 }
    }

    /// Adds a chunk at the end.
    pub(super) fn push(&mut self, chunk: Chunk, region: &mut Region) {
        let (shape, number) = (self.shape, self.chunks);
        let full = self.path.iter().rev().take_while(|node| node.used == NODE_ENTRIES).count();
        if full == self.path.len() {
            self.grow(region);
        }
        // From the leaf upwards to the first node with room, whose entry the new nodes below it become.
        let (levels, mut child) = (self.path.len(), chunk.at);
        for level in 0..levels {
            let Some(last) = self.path.get_mut(levels - 1 - level) else { break };
            let entry = entry(shape, number, chunk, child);
            if last.used < NODE_ENTRIES {
                region.patch(last.at + entry_at(shape, last.used) as u64, &entry);
                last.used += 1;
                region.patch(last.at + USED as u64, &(last.used as u16).to_le_bytes());
                break;
            }
            child = region.append(&node(shape, level, last.at, &entry));
            region.patch(last.at + RIGHT as u64, &child.to_le_bytes());
            *last = Node { at: child, used: 1 };
        }
        self.chunks += 1;
    }

    /// A root above the present one, or the first, still without a further entry.
    fn grow(&mut self, region: &mut Region) {
        let none = Chunk { at: 0, length: 0, left_out: 0 };
        let (level, used) = (self.path.len(), usize::from(!self.path.is_empty()));
        let below = self.path.first().map_or(0, |root| root.at);
        let mut root = node(self.shape, level, NOWHERE, &entry(self.shape, 0, none, below));
        if used == 0 {
            root[PREFIX..].fill(0);
        }
        root[USED] = used as u8;
        let at = region.append(&root);
        region.patch(self.root_at, &at.to_le_bytes());
        self.path.insert(0, Node { at, used });
    }

    /// Cuts the tree in the file back to so many chunks, exactly as it was when it had them. Returns where the last
    /// thing that it then needs ends.
    ///
    /// # Errors
    /// Errors of the system, or a tree that is not as this program writes it.
    pub(super) fn cut(&mut self, chunks: u64, region: &mut Region) -> io::Result<u64> {
        (self.chunks, self.path) = (chunks, Vec::new());
        let mut at = word(&region.read(self.root_at, 8)?);
        if chunks == 0 {
            region.patch(self.root_at, &NOWHERE.to_le_bytes());
            return Ok(0);
        }
        let (shape, last) = (self.shape, chunks - 1);
        let damaged = || io::Error::new(io::ErrorKind::InvalidData, "its index is damaged");
        let mut levels = 1;
        while last >= (NODE_ENTRIES as u64).pow(levels) {
            levels += 1;
        }
        let mut image = region.read(at, node_bytes(shape))?;
        while u32::from(image[5]) >= levels {
            at = word(image.get(entry_at(shape, 0) + key_bytes(shape)..).ok_or_else(damaged)?);
            image = region.read(at, node_bytes(shape))?;
        }
        region.patch(self.root_at, &at.to_le_bytes());
        let mut end = 0;
        for level in (0..levels).rev() {
            let used = (last / (NODE_ENTRIES as u64).pow(level)) as usize % NODE_ENTRIES + 1;
            let found = usize::from(image[USED]);
            if !image.starts_with(b"TREE\x01") || u32::from(image[5]) != level || found < used {
                return Err(damaged());
            }
            let (last_entry, rest) = (entry_at(shape, used - 1), entry_at(shape, used));
            let child_at = last_entry + key_bytes(shape);
            let child = word(&image[child_at..]);
            let end_key = entry(shape, 0, Chunk { at: 0, length: 0, left_out: 0 }, 0).split_off(key_bytes(shape) + 8);
            image[USED] = used as u8;
            image[RIGHT..RIGHT + 8].fill(0xff);
            image[rest..].fill(0);
            image[rest..rest + end_key.len()].copy_from_slice(&end_key);
            region.patch(at, &image);
            self.path.push(Node { at, used });
            end = end.max(at + image.len() as u64);
            if level == 0 {
                let length = u64::from(u32::from_le_bytes(std::array::from_fn(|i| image[last_entry + i])));
                return Ok(end.max((child + length).next_multiple_of(8)));
            }
            at = child;
            image = region.read(at, node_bytes(shape))?;
        }
        Ok(end)
    }
}

/// Finds a chunk by the address of the root of its tree and its first row; `None` if it is not there.
///
/// # Errors
/// Errors of the system, or a tree that is damaged.
pub(super) fn find(shape: Shape, root: u64, row: u64, region: &mut Region) -> io::Result<Option<Chunk>> {
    let damaged = || io::Error::new(io::ErrorKind::InvalidData, "its index is damaged");
    let (mut at, mut above) = (root, None);
    loop {
        let image = region.read(at, node_bytes(shape))?;
        let (level, used) = (image[5], usize::from(image[USED]));
        // Levels fall, so that a tree that leads back to itself ends.
        if !image.starts_with(b"TREE\x01") || used > NODE_ENTRIES || above.is_some_and(|above| above <= level) {
            return Err(damaged());
        }
        let first_row = |entry: usize| word(&image[entry_at(shape, entry) + 8..]);
        let Some(entry) = (0..used).rev().find(|entry| first_row(*entry) <= row) else { return Ok(None) };
        let here = entry_at(shape, entry);
        let child = word(&image[here + key_bytes(shape)..]);
        if level == 0 {
            let number = |at: usize| u32::from_le_bytes(std::array::from_fn(|i| image[at + i]));
            let chunk = Chunk { at: child, length: number(here), left_out: number(here + 4) };
            return Ok((first_row(entry) == row).then_some(chunk));
        }
        (at, above) = (child, Some(level));
    }
}
