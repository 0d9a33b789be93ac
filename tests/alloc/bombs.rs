//! Mesh files that ask for far more memory or work than they hold: each is refused, or read, within fifty times its
//! size and 100 MB, and within ten seconds.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use canopy_fem::mesh::MeshFile;
use canopy_fem::mesh::read::file_from_bytes;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;
use std::time::Instant;

/// [byte] peak memory for each byte of a file, and for any file
const PER_BYTE: usize = 50;
const ANY: usize = 100_000_000;
/// [s] most time for a file, also on a busy machine
const LONGEST: f64 = 10.0;

/// Reads every bomb, and shows its size, peak memory and time.
pub fn defuse() {
    for (name, ending, bytes) in bombs() {
        let wanted = MeshFile { edge: Some(1e-3), ..MeshFile::plain("") };
        let profiler = dhat::Profiler::builder().testing().build();
        let start = Instant::now();
        let read = file_from_bytes(&wanted, Path::new(&format!("bomb.{ending}")), &bytes);
        let seconds = start.elapsed().as_secs_f64();
        let peak = dhat::HeapStats::get().max_bytes;
        drop(profiler);
        let answer = read.map_or_else(|error| error.to_string(), |read| format!("{} nodes", read.mesh.nodes.len()));
        let short: String = answer.chars().take(90).collect();
        println!("{name}: {} bytes, peak {:.1} MB, {seconds:.2} s: {short}", bytes.len(), peak as f64 / 1e6);
        assert!(peak <= PER_BYTE * bytes.len() + ANY, "{name} takes {peak} bytes for {}", bytes.len());
        assert!(seconds < LONGEST, "{name} takes {seconds} s");
    }
}

fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    encoder.write_all(bytes).and_then(|()| encoder.finish()).expect("memory")
}

/// A compressed array of zeros: blocks of a megabyte.
fn zeros(megabytes: u64) -> Vec<u8> {
    let block = zlib(&vec![0; 1 << 20]);
    let mut array: Vec<u8> = [megabytes, 1 << 20, 0].iter().flat_map(|n| n.to_le_bytes()).collect();
    (0..megabytes).for_each(|_| array.extend((block.len() as u64).to_le_bytes()));
    (0..megabytes).for_each(|_| array.extend(&block));
    array
}

fn vtu(fields: &str, points: &str, count: usize, appended: &[u8]) -> Vec<u8> {
    let head = format!(
        "<VTKFile type=\"UnstructuredGrid\" byte_order=\"LittleEndian\" header_type=\"UInt64\" \
         compressor=\"vtkZLibDataCompressor\"><UnstructuredGrid><FieldData>{fields}</FieldData><Piece NumberOfPoints=\"{count}\" \
         NumberOfCells=\"0\"><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" {points}/></Points></Piece>\
         </UnstructuredGrid><AppendedData encoding=\"raw\">_"
    );
    [head.as_bytes(), appended, b"</AppendedData></VTKFile>"].concat()
}

fn bombs() -> Vec<(&'static str, &'static str, Vec<u8>)> {
    let text = |parts: &dyn Fn(&mut String)| {
        let mut text = String::new();
        parts(&mut text);
        text.into_bytes()
    };
    let fields: String = (0..40)
        .map(|i| format!("<DataArray type=\"UInt8\" Name=\"a{i}\" format=\"appended\" offset=\"0\"/>"))
        .collect();
    let appended = "format=\"appended\" offset=\"0\"";
    let square = "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n*ELEMENT,TYPE=S3,ELSET=E\n1,1,2,3\n";
    let doubled = |line: &str| {
        (0..64).map(|i| line.replace("I", &(i + 1).to_string()).replace("J", &i.to_string())).collect::<String>()
    };
    vec![
        ("fields that share an array", "vtu", vtu(&fields, appended, 3, &zeros(160))),
        ("compressed points", "vtu", vtu("", appended, (2000 << 20) / 24, &zeros(2000))),
        ("points that are not there", "vtu", vtu("", appended, 1 << 50, &zeros(1))),
        ("points that are not there", "vtk", b"# vtk DataFile Version 3.0\nt\nBINARY\nDATASET POLYDATA\nPOINTS 999999999999 double\n".to_vec()),
        ("names of groups", "vtu", {
            let numbers = "1 ".repeat(200_000);
            let name = "n".repeat(100_000);
            let field = format!("<DataArray type=\"Int32\" Name=\"group {name}\" format=\"ascii\">{numbers}</DataArray>");
            vtu(&field, "format=\"ascii\"", 0, b"")
        }),
        ("groups of all faces", "obj", text(&|to| {
            (0..1000).for_each(|i| writeln!(to, "v {i} 0 0\nv {i} 1 0\nv {i} 0 1").unwrap_or_default());
            to.push('g');
            (0..20_000).for_each(|i| write!(to, " g{i}").unwrap_or_default());
            (0..1000).for_each(|i| write!(to, "\nf {} {} {}", 3 * i + 1, 3 * i + 2, 3 * i + 3).unwrap_or_default());
        })),
        ("groups of all points", "obj", text(&|to| {
            (0..3000).for_each(|i| writeln!(to, "v {i} {} 0", i % 2).unwrap_or_default());
            to.push('g');
            (0..20_000).for_each(|i| write!(to, " g{i}").unwrap_or_default());
            (0..3000).for_each(|i| write!(to, "\np {}", i + 1).unwrap_or_default());
            to.push_str("\ng\nl 1 2\n");
        })),
        ("a face of many corners", "obj", text(&|to| {
            let count = 50_000;
            for i in 0..count {
                let (sin, cos) = (f64::from(i) * std::f64::consts::TAU / f64::from(count)).sin_cos();
                let radius = if i % 2 == 0 { 1.0 } else { 0.5 };
                let _ = writeln!(to, "v {} {} 0", radius * cos, radius * sin);
            }
            to.push('f');
            (1..=count).for_each(|i| write!(to, " {i}").unwrap_or_default());
        })),
        ("sets of sets", "inp", (square.to_owned() + "*NSET,NSET=S0,GENERATE\n1,3,2\n" + &doubled("*NSET,NSET=SI\nSJ,SJ\n")).into_bytes()),
        ("many sets of one", "inp", text(&|to| {
            to.push_str(square);
            to.push_str("*NSET,NSET=A\n");
            (0..20_000).for_each(|i| writeln!(to, "{}", 2 * i + 1).unwrap_or_default());
            (0..20_000).for_each(|i| writeln!(to, "*NSET,NSET=B{i}\nA").unwrap_or_default());
        })),
        ("ranges", "inp", text(&|to| {
            to.push_str(square);
            (0..20_000).for_each(|i| writeln!(to, "*NSET,NSET=R,GENERATE\n{},999999999,1", i + 1).unwrap_or_default());
        })),
        ("made elements", "inp", (square.to_owned() + "*ELGEN,ELSET=E\n1,1000000,1,1,1000000,1,1\n").into_bytes()),
        ("instances", "inp", text(&|to| {
            let _ = write!(to, "*PART,NAME=P\n*NODE\n");
            (0..5000).for_each(|i| writeln!(to, "{},{i},{},0", i + 1, i % 2).unwrap_or_default());
            to.push_str("*ELEMENT,TYPE=T3D2\n1,1,2\n*END PART\n*ASSEMBLY\n");
            (0..5000).for_each(|i| writeln!(to, "*INSTANCE,NAME=I{i},PART=P\n*END INSTANCE").unwrap_or_default());
        })),
        ("ranges of a set", "k", b"*NODE\n1,0,0,0\n2,1,0,0\n*ELEMENT_BEAM\n1,1,1,2\n*SET_NODE_LIST_GENERATE\n1\n1,999999999999\n".to_vec()),
        ("parts in parts", "mdpa", text(&|to| {
            (0..50_000).for_each(|_| to.push_str("Begin SubModelPart a\n"));
        })),
        ("records without properties", "ply", b"ply\nformat binary_little_endian 1.0\nelement a 99999999999\nend_header\n".to_vec()),
        ("records that are not there", "ply", b"ply\nformat ascii 1.0\nelement vertex 99999999999\nproperty float x\nend_header\n".to_vec()),
        ("small records", "ply", {
            let head = b"ply\nformat binary_little_endian 1.0\nelement a 1000000\nproperty uchar b\nend_header\n";
            [&head[..], &vec![0; 1_000_000]].concat()
        }),
        ("blocks in blocks", "dxf", text(&|to| {
            to.push_str("0\nSECTION\n2\nBLOCKS\n0\nBLOCK\n2\nB0\n0\nLINE\n11\n1\n0\nENDBLK\n");
            to.push_str(&(0..14).map(|i| format!("0\nBLOCK\n2\nB{}\n{}0\nENDBLK\n", i + 1, format!("0\nINSERT\n2\nB{i}\n").repeat(10))).collect::<String>());
            to.push_str("0\nENDSEC\n0\nSECTION\n2\nENTITIES\n0\nINSERT\n2\nB14\n0\nENDSEC\n");
        })),
        ("rows and columns", "dxf", b"0\nSECTION\n2\nBLOCKS\n0\nBLOCK\n2\nB\n0\nLINE\n11\n1\n0\nENDBLK\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n0\nINSERT\n2\nB\n70\n30000\n71\n30000\n0\nENDSEC\n".to_vec()),
        ("circles", "dxf", text(&|to| {
            to.push_str("0\nSECTION\n2\nENTITIES\n");
            (0..2000).for_each(|i| writeln!(to, "0\nCIRCLE\n10\n{i}\n40\n1e9").unwrap_or_default());
            to.push_str("0\nENDSEC\n");
        })),
        ("a long chain", "dxf", text(&|to| {
            to.push_str("0\nSECTION\n2\nENTITIES\n");
            (0..30_000).for_each(|i| writeln!(to, "0\nLINE\n10\n{i}\n20\n{}\n11\n{}\n21\n{}", i % 2, i + 1, (i + 1) % 2).unwrap_or_default());
            to.push_str("0\nENDSEC\n");
        })),
        ("nodes with two parents", "gltf", gltf((0..40).map(|i| format!("{{\"children\": [{}, {}]}}", i + 1, i + 1)).chain(["{\"mesh\": 0}".to_owned()]), 3)),
        ("a mesh of many nodes", "gltf", {
            let children: Vec<String> = (1..=5000).map(|i| i.to_string()).collect();
            let root = format!("{{\"children\": [{}]}}", children.join(", "));
            gltf([root].into_iter().chain((0..5000).map(|_| "{\"mesh\": 0}".to_owned())), 30_000)
        }),
    ]
}

/// A .gltf of a mesh of so many points.
fn gltf(nodes: impl Iterator<Item = String>, points: usize) -> Vec<u8> {
    let data: Vec<u8> = (0..3 * points).flat_map(|i| (i as f32).sin().to_le_bytes()).collect();
    let (size, data, nodes) = (data.len(), STANDARD.encode(data), nodes.collect::<Vec<_>>().join(", "));
    format!(
        "{{\"asset\": {{\"version\": \"2.0\"}}, \"nodes\": [{nodes}], \"scenes\": [{{\"nodes\": [0]}}], \"meshes\": [{{\"primitives\": \
         [{{\"attributes\": {{\"POSITION\": 0}}}}]}}], \"buffers\": [{{\"byteLength\": {size}, \"uri\": \
         \"data:application/octet-stream;base64,{data}\"}}], \"bufferViews\": [{{\"buffer\": 0, \"byteLength\": {size}}}], \
         \"accessors\": [{{\"bufferView\": 0, \"componentType\": 5126, \"count\": {points}, \"type\": \"VEC3\", \"min\": [-1, -1, -1], \
         \"max\": [1, 1, 1]}}]}}"
    )
    .into_bytes()
}
