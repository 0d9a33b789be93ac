//! The statements by which the formats of meshes place, move, join, include, repeat and make nodes, elements and sets,
//! as their manuals list them, each in a small file: read right, refused by its name, or left out with a note.

use canopy_fem::mesh::MeshFile;
use canopy_fem::mesh::read::{Imported, file_from_bytes};
use std::path::Path;

/// What becomes of a file.
enum Outcome {
    /// nodes, triangles, lines, bounds [m] and groups; and words of a note, unless they are empty
    Read([usize; 3], [[f64; 2]; 3], &'static [&'static str], &'static str),
    /// words of the refusal
    Refused(&'static str),
}

use Outcome::{Read, Refused};

/// The unit square of eight triangles.
const SQUARE: Outcome = Read([9, 8, 0], FLAT, &[], "");
const FLAT: [[f64; 2]; 3] = [[0.0, 1.0], [0.0, 1.0], [0.0, 0.0]];

/// The square without groups that every file has, and with a note.
const fn noted(words: &'static str) -> Outcome {
    Read([9, 8, 0], FLAT, &[], words)
}

const fn grouped(groups: &'static [&'static str]) -> Outcome {
    Read([9, 8, 0], FLAT, groups, "")
}

/// Nodes of the square, counted from 1, and its triangles.
fn nodes() -> impl Iterator<Item = (usize, [f64; 3])> {
    (0..9_u8).map(|i| (usize::from(i) + 1, [0.5 * f64::from(i % 3), 0.5 * f64::from(i / 3), 0.0]))
}

fn triangles() -> Vec<[usize; 3]> {
    let quads = [1, 2, 4, 5].map(|a| [a, a + 1, a + 4, a + 3]);
    quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect()
}

fn check(ending: &str, rows: &[(&str, String, Outcome)]) {
    for (name, text, outcome) in rows {
        check_bytes(ending, name, text.as_bytes(), outcome);
    }
}

fn check_bytes(ending: &str, name: &str, bytes: &[u8], outcome: &Outcome) {
    check_with(&MeshFile::plain(""), ending, name, bytes, outcome);
}

fn check_with(wanted: &MeshFile, ending: &str, name: &str, bytes: &[u8], outcome: &Outcome) {
    let read = file_from_bytes(wanted, Path::new(&format!("mesh.{ending}")), bytes);
    match (read, outcome) {
        (Ok(Imported { mesh, notes, .. }), Read([nodes, triangles, lines], bounds, groups, words)) => {
            let sides = canopy_fem::mesh::Topology::new(&mesh).expect("a mesh");
            let found =
                (0..mesh.edges.len()).filter(|e| sides.edge_kind(*e) == canopy_fem::mesh::EdgeKind::Line).count();
            assert_eq!(
                [mesh.nodes.len(), mesh.triangles.len(), found],
                [*nodes, *triangles, *lines],
                "{name}: {notes:?}"
            );
            for (axis, [low, high]) in bounds.iter().enumerate() {
                let all = || mesh.nodes.iter().map(|node| node[axis]);
                let least = all().fold(f64::INFINITY, f64::min);
                let most = all().fold(f64::NEG_INFINITY, f64::max);
                let near = (least - low).abs() < 1e-6 && (most - high).abs() < 1e-6;
                assert!(near, "{name}: {least} to {most} along axis {axis}, not {low} to {high}");
            }
            for group in *groups {
                let (group, members) = group.split_once(": ").expect("a name and members");
                let found = mesh.groups.get(group).map(canopy_fem::mesh::Group::describe);
                assert_eq!(found.as_deref(), Some(members), "{name}: group {group} of {:?}", mesh.groups.keys());
            }
            assert!(words.is_empty() || notes.iter().any(|note| note.contains(words)), "{name}: {notes:?}");
        }
        (Err(error), Refused(words)) => {
            let text = error.to_string();
            assert!(text.contains(words) && text.split_whitespace().count() > 5, "{name}: {text}");
        }
        (Ok(read), Refused(words)) => panic!("{name} is read, not refused with \"{words}\": {:?}", read.notes),
        (Err(error), Read(..)) => panic!("{name} is refused: {error}"),
    }
}

fn inp_nodes(from: usize) -> String {
    nodes().map(|(n, [x, y, z])| format!("{}, {x}, {y}, {z}\n", n + from)).collect()
}

fn inp_square() -> String {
    let lines = (1..).zip(triangles()).map(|(n, [a, b, c])| format!("{n}, {a}, {b}, {c}\n"));
    format!("*NODE\n{}*ELEMENT, TYPE=S3\n{}", inp_nodes(0), lines.collect::<String>())
}

/// Abaqus Keywords Reference Guide.
#[test]
fn abaqus() {
    let with = |text: &str| inp_square() + text;
    let part = |instances: &str| {
        let square = inp_square().replace("TYPE=S3", "TYPE=S3, ELSET=Cloth");
        format!(
            "*PART, NAME=P\n{square}*NSET, NSET=hem\n1,2,3\n*END PART\n*ASSEMBLY, NAME=A\n{instances}*END ASSEMBLY\n"
        )
    };
    let rows = [
        (
            "*INSTANCE",
            part("*INSTANCE, NAME=i, PART=P\n*END INSTANCE\n"),
            grouped(&["Cloth: 8 triangles", "hem: 3 nodes"]),
        ),
        (
            "*INSTANCE, translation",
            part("*INSTANCE, NAME=i, PART=P\n1, 2, 3\n*END INSTANCE\n"),
            Read([9, 8, 0], [[1.0, 2.0], [2.0, 3.0], [3.0, 3.0]], &["Cloth: 8 triangles"], ""),
        ),
        (
            "*INSTANCE, translation and rotation",
            part("*INSTANCE, NAME=i, PART=p\n1, 0, 0\n1,0,0, 1,1,0, -90.\n*END INSTANCE\n"),
            Read([9, 8, 0], [[1.0, 1.0], [0.0, 1.0], [0.0, 1.0]], &[], ""),
        ),
        (
            "*INSTANCE, two",
            part(
                "*INSTANCE, NAME=a, PART=P\n*END INSTANCE\n*INSTANCE, NAME=b, PART=P\n2,0,0\n*END INSTANCE\n\
                  *NSET, NSET=ends, INSTANCE=b\n1, 2\n*NSET, NSET=ends\na.3, b.hem\n*ELSET, ELSET=one, INSTANCE=a\nCloth\n",
            ),
            Read(
                [18, 16, 0],
                [[0.0, 3.0], [0.0, 1.0], [0.0, 0.0]],
                &["a.Cloth: 8 triangles", "b.hem: 3 nodes", "ends: 4 nodes", "one: 8 triangles"],
                "",
            ),
        ),
        (
            "*INSTANCE with a mesh of its own",
            format!(
                "*PART, NAME=P\n*END PART\n*ASSEMBLY\n*INSTANCE, NAME=i, PART=P\n0,0,5\n{}*END INSTANCE\n",
                inp_square()
            ),
            Read([9, 8, 0], [[0.0, 1.0], [0.0, 1.0], [5.0, 5.0]], &[], ""),
        ),
        (
            "*PART, two without *INSTANCE",
            part("").replace("*ASSEMBLY", "*PART, NAME=Q\n*END PART\n*ASSEMBLY"),
            Refused("no *INSTANCE"),
        ),
        ("*INCLUDE", with("*INCLUDE, INPUT=more.inp\n"), Refused("*INCLUDE")),
        ("*NODE, INPUT", with("*NODE, INPUT=nodes.inp\n"), Refused("another file")),
        ("*IMPORT", with("*IMPORT, STEP=1\n"), Refused("*IMPORT")),
        (
            "*NODE, SYSTEM=C",
            "*NODE, SYSTEM=C\n1,1,0,0\n2,1,90,0\n3,0,0,0\n*ELEMENT, TYPE=S3\n1,1,2,3\n".into(),
            Read([3, 1, 0], FLAT, &[], ""),
        ),
        (
            "*NODE, SYSTEM=S",
            "*NODE, SYSTEM=S\n1,1,0,0\n2,1,0,90\n3,0,0,0\n*ELEMENT, TYPE=S3\n1,1,2,3\n".into(),
            Read([3, 1, 0], [[0.0, 1.0], [0.0, 0.0], [0.0, 1.0]], &[], ""),
        ),
        (
            "*SYSTEM",
            "*SYSTEM\n1,0,0, 1,1,0\n0,0,0\n".to_owned() + &inp_square() + "*SYSTEM\n",
            Read([9, 8, 0], [[0.0, 1.0], [0.0, 1.0], [0.0, 0.0]], &[], ""),
        ),
        (
            "*NGEN and *ELGEN",
            "*NODE\n1,0,0,0\n3,1,0,0\n4,0,.5,0\n6,1,.5\n7,0,1\n9,1,1\n*NGEN, NSET=n\n1,3,1\n4,6\n7,9\n\
             *ELEMENT, TYPE=S4\n1,1,2,5,4\n*ELGEN, ELSET=c\n1,2,1,1,2,3,2\n"
                .into(),
            grouped(&["c: 8 triangles", "n: 9 nodes"]),
        ),
        ("*NGEN, LINE=C", with("*NGEN, LINE=C\n1,3,1,9\n"), Refused("*NGEN")),
        ("*NCOPY", with("*NCOPY, CHANGE NUMBER=100, OLD SET=n, SHIFT\n1,0,0\n\n"), Refused("*NCOPY")),
        ("*NFILL", with("*NFILL\nA, B, 3, 10\n"), Refused("*NFILL")),
        ("*NMAP", with("*NMAP, NSET=n, TYPE=RECTANGULAR\n"), Refused("*NMAP")),
        ("*ELCOPY", with("*ELCOPY, ELEMENT SHIFT=100, OLD SET=c, SHIFT NODES=100\n"), Refused("*ELCOPY")),
        ("*IMPERFECTION", with("*IMPERFECTION, FILE=buckle, STEP=1\n1, 1.\n"), Refused("*IMPERFECTION")),
        ("*SYMMETRIC MODEL GENERATION", with("*SYMMETRIC MODEL GENERATION, REVOLVE\n"), Refused("*SYMMETRIC MODEL")),
        ("*MODEL CHANGE", with("*STEP\n*MODEL CHANGE, REMOVE\n1,\n"), Refused("*MODEL CHANGE")),
        ("*MPC", with("*MPC\nTIE, 1, 2\n"), Refused("*MPC")),
        ("*EQUATION", with("*EQUATION\n2\n1,1,1.,2,1,-1.\n"), Refused("*EQUATION")),
        ("*TIE", with("*TIE, NAME=t\na, b\n"), Refused("*TIE")),
        ("*COUPLING", with("*COUPLING, REF NODE=1, SURFACE=s\n"), Refused("*COUPLING")),
        ("*RIGID BODY", with("*RIGID BODY, REF NODE=1, ELSET=c\n"), Refused("*RIGID BODY")),
        ("*EMBEDDED ELEMENT", with("*EMBEDDED ELEMENT\nc\n"), Refused("*EMBEDDED ELEMENT")),
        ("*PARAMETER", with("*PARAMETER\na = 1\n"), Refused("*PARAMETER")),
        (
            "*NSET of a mixed line",
            with("*NSET, NSET=A\n1,2\n*NSET, NSET=B\nA, 5\n"),
            grouped(&["A: 2 nodes", "B: 3 nodes"]),
        ),
        (
            "*NSET in other case",
            with("*NSET, NSET=Hem\n1,2\n*Nset, nset=HEM\n3\n*NSET,NSET=All\nhem\n"),
            grouped(&["All: 3 nodes", "Hem: 3 nodes"]),
        ),
        ("*NSET, GENERATE", with("*NSET, NSET=g, GENERATE\n1, 9, 2\n"), grouped(&["g: 5 nodes"])),
        (
            "*NSET, ELSET",
            with("*ELSET, ELSET=e\n1\n*NSET, NSET=n, ELSET=e\n"),
            grouped(&["e: 1 triangle", "n: 3 nodes"]),
        ),
        ("*NSET that is not there", with("*NSET, NSET=n\nnone\n"), Refused("no set \"none\"")),
        (
            "continued keyword",
            inp_square().replace("TYPE=S3", "TYPE=S3,\n ELSET=Cloth"),
            grouped(&["Cloth: 8 triangles"]),
        ),
        ("blank fields", inp_square().replace("1, 0, 0, 0\n", "1,,,\n"), SQUARE),
        (
            "line element",
            with("*NODE\n10,0,0,-1\n*ELEMENT, TYPE=PIPE31, ELSET=l\n20,1,10\n"),
            Read([10, 8, 1], [[0.0, 1.0], [0.0, 1.0], [-1.0, 0.0]], &["l: 1 edge"], ""),
        ),
        ("second order", with("*ELEMENT, TYPE=S8R\n9,1,2,3,4,5,6,7,8\n"), Refused("S8R")),
        (
            "material",
            with("*MATERIAL, NAME=m\n*DENSITY\n1.\n*SHELL SECTION, ELSET=c\n1.\n*STEP\n*STATIC\n*END STEP\n"),
            SQUARE,
        ),
        ("unknown keyword", with("*NOVEL THING\n1,2\n"), noted("*NOVEL THING (line 20)")),
    ];
    check("inp", &rows);
}

fn k_square() -> String {
    let nodes = nodes().map(|(n, [x, y, z])| format!("{n:8}{x:16.8}{y:16.8}{z:16.8}       0       0\n"));
    let shells = (1..).zip(triangles()).map(|(n, [a, b, c])| format!("{n:8}{:8}{a:8}{b:8}{c:8}{c:8}\n", 1));
    format!("*KEYWORD\n*NODE\n{}*ELEMENT_SHELL\n{}", nodes.collect::<String>(), shells.collect::<String>())
}

/// LS-DYNA Keyword User's Manual, volume I.
#[test]
fn ls_dyna() {
    let with = |text: &str| k_square() + text + "*END\njunk 1 2\n";
    let cards = |option: &str, card: &str| {
        let text = k_square().replace("*ELEMENT_SHELL", &format!("*ELEMENT_SHELL{option}"));
        let (head, shells) = text.split_once(&format!("{option}\n")).expect("shells");
        let shells: String = shells.lines().map(|line| format!("{line}\n{card}\n")).collect();
        format!("{head}{option}\n{shells}")
    };
    let set = |kind: &str, lines: &str| with(&format!("*SET_{kind}\n         1\n{lines}"));
    let rows = [
        ("*END", with(""), grouped(&["part 1: 8 triangles"])),
        ("*INCLUDE", with("*INCLUDE\nother.k\n"), Refused("*INCLUDE")),
        ("*INCLUDE_TRANSFORM", with("*INCLUDE_TRANSFORM\nother.k\n"), Refused("*INCLUDE_TRANSFORM")),
        ("*DEFINE_TRANSFORMATION alone", with("*DEFINE_TRANSFORMATION\n         1\nTRANSL           1.0\n"), SQUARE),
        ("*NODE_TRANSFORM", with("*NODE_TRANSFORM\n         1         1\n"), Refused("*NODE_TRANSFORM")),
        ("*NODE_MERGE_SET", with("*NODE_MERGE_SET\n         1\n"), Refused("*NODE_MERGE_SET")),
        ("*NODE_SCALAR", with("*NODE_SCALAR\n      99       1\n"), Refused("*NODE_SCALAR")),
        ("*PART_MOVE", with("*PART_MOVE\n         1       1.0\n"), Refused("*PART_MOVE")),
        ("*PART_DUPLICATE", with("*PART_DUPLICATE\n"), Refused("*PART_DUPLICATE")),
        ("*PERTURBATION_NODE", with("*PERTURBATION_NODE\n"), Refused("*PERTURBATION_NODE")),
        ("*CONSTRAINED_NODAL_RIGID_BODY", with("*CONSTRAINED_NODAL_RIGID_BODY\n"), Refused("*CONSTRAINED_NODAL")),
        ("*CONSTRAINED_TIED_NODES_FAILURE", with("*CONSTRAINED_TIED_NODES_FAILURE\n"), Refused("*CONSTRAINED_TIED")),
        ("*CONTACT_TIED_NODES_TO_SURFACE", with("*CONTACT_TIED_NODES_TO_SURFACE\n"), Refused("*CONTACT_TIED")),
        ("*ELEMENT_SOLID", with("*ELEMENT_SOLID\n"), Refused("*ELEMENT_SOLID")),
        ("*ELEMENT_SHELL_THICKNESS", cards("_THICKNESS", "1.0000000000000001.0"), SQUARE),
        ("*ELEMENT_SHELL_BETA", cards("_BETA", "                                              45.0"), SQUARE),
        ("*ELEMENT_SHELL_THICKNESS_OFFSET", cards("_THICKNESS_OFFSET", "             1.0\n             0.1"), SQUARE),
        ("*ELEMENT_SHELL_COMPOSITE", cards("_COMPOSITE", "1"), Refused("_COMPOSITE")),
        (
            "shell of eight nodes",
            with("*ELEMENT_SHELL\n       9       1       1       3       9       7       2       6       8       4\n"),
            Refused("more than 4 nodes"),
        ),
        ("*SET_NODE", set("NODE", "         1         2\n"), grouped(&["node set 1: 2 nodes"])),
        (
            "*SET_NODE_LIST_TITLE",
            with("*SET_NODE_LIST_TITLE\nskirt\n         1\n         1         2\n"),
            grouped(&["skirt: 2 nodes"]),
        ),
        (
            "*SET_NODE_LIST_GENERATE",
            set("NODE_LIST_GENERATE", "         1         6\n"),
            grouped(&["node set 1: 6 nodes"]),
        ),
        (
            "*SET_NODE_LIST_GENERATE_INCREMENT",
            set("NODE_LIST_GENERATE_INCREMENT", "         1         9         2\n"),
            grouped(&["node set 1: 5 nodes"]),
        ),
        (
            "*SET_NODE_COLUMN",
            set("NODE_COLUMN", "         1       5.0\n         2       6.0\n"),
            grouped(&["node set 1: 2 nodes"]),
        ),
        (
            "*SET_NODE_GENERAL",
            set("NODE_GENERAL", "NODE               1         2         3\n"),
            grouped(&["node set 1: 3 nodes"]),
        ),
        ("*SET_NODE_GENERAL, BOX", set("NODE_GENERAL", "BOX                1\n"), Refused("BOX")),
        ("*SET_NODE_ADD", set("NODE_ADD", "         1\n"), Refused("*SET_NODE_ADD")),
        ("*SET_SHELL_LIST", set("SHELL_LIST", "         1         2\n"), grouped(&["shell set 1: 2 triangles"])),
        (
            "*SET_SHELL_GENERATE",
            set("SHELL_LIST_GENERATE", "         1         4\n"),
            grouped(&["shell set 1: 4 triangles"]),
        ),
        ("*SET_PART", set("PART", "         1\n"), grouped(&["part set 1: 8 triangles"])),
        ("*SET_SEGMENT", set("SEGMENT", "         1         2         5         4\n"), noted("*SET_SEGMENT")),
        ("blank fields", k_square().replace("      0.00000000", "                "), SQUARE),
        (
            "full columns",
            k_square().replace("      0.50000000", "-5.000000000E-01").replace("      1.00000000", "-1.000000000E+00"),
            Read([9, 8, 0], [[-1.0, 0.0], [-1.0, 0.0], [0.0, 0.0]], &[], ""),
        ),
        (
            "long=y",
            "*KEYWORD LONG=Y\n*NODE\n".to_owned()
                + &nodes().map(|(n, [x, y, z])| format!("{n:20}{x:20.12}{y:20.12}{z:20.12}\n")).collect::<String>()
                + "*ELEMENT_SHELL\n"
                + &(1..)
                    .zip(triangles())
                    .map(|(n, [a, b, c])| format!("{n:20}{:20}{a:20}{b:20}{c:20}{c:20}\n", 1))
                    .collect::<String>(),
            SQUARE,
        ),
        (
            "commas",
            "*NODE\n1,0,0,0\n2,1,,\n3,,1,\n*ELEMENT_SHELL\n1,1,1,2,3,3\n".into(),
            Read([3, 1, 0], FLAT, &[], ""),
        ),
        (
            "material",
            with("*MAT_FABRIC\n1\n*SECTION_SHELL\n1\n*CONTACT_AIRBAG_SINGLE_SURFACE\n1\n*CONTROL_TERMINATION\n1\n"),
            SQUARE,
        ),
        ("unknown keyword", with("*NOVEL_THING\n1\n"), noted("*NOVEL_THING (line 21)")),
    ];
    check("k", &rows);
}

fn bdf_square() -> String {
    let nodes = nodes().map(|(n, [x, y, z])| format!("GRID,{n},,{x},{y},{z}\n"));
    let faces = (1..).zip(triangles()).map(|(n, [a, b, c])| format!("CTRIA3,{n},1,{a},{b},{c}\n"));
    nodes.chain(faces).collect()
}

/// MSC Nastran Quick Reference Guide.
#[test]
fn nastran() {
    let head = "SOL 101\nCEND\nTITLE = a, b\nSET 1 = 1,2\nSUBCASE 1\nBEGIN BULK\n";
    let with = |text: &str| format!("{head}{}{text}ENDDATA\njunk\n", bdf_square());
    let line = |entry: &str| with(&format!("GRID,10,,0.,0.,-1.\n{entry}\n"));
    let hung = || Read([10, 8, 1], [[0.0, 1.0], [0.0, 1.0], [-1.0, 0.0]], &["property 2: 1 edge"], "");
    let rows = [
        ("ENDDATA", with(""), grouped(&["property 1: 8 triangles"])),
        ("no BEGIN BULK", bdf_square(), SQUARE),
        ("tabs", with("").replacen("GRID,1,,0,0,0", "GRID\t1\t\t0.\t0.\t0.", 1), SQUARE),
        ("GRDSET of a system", with("GRDSET,,1\n"), Refused("GRDSET")),
        ("GRDSET of supports", with("GRDSET,,,,,,,345\n"), SQUARE),
        ("GRID in a system", with("GRID,10,1,0.,0.,0.\n"), Refused("system 1")),
        ("CORD2R that is not used", with("CORD2R,1,0,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\n"), SQUARE),
        ("INCLUDE", with("INCLUDE 'more.bdf'\n"), Refused("INCLUDE")),
        ("replication", with("GRID,20,,0.,0.,0.\n=,*(1),=,*(1.),==\n=(3)\n"), Refused("replicat")),
        ("SPOINT", with("SPOINT,99\n"), Refused("SPOINT")),
        ("BEGIN SUPER", with("BEGIN SUPER=1\n"), Refused("superelements")),
        ("SEBULK", with("SEBULK,1\n"), Refused("SEBULK")),
        ("CBUSH", line("CBUSH,9,2,1,10"), hung()),
        ("CELAS1", line("CELAS1,9,2,1,1,10,1"), hung()),
        ("CVISC", line("CVISC,9,2,1,10"), hung()),
        ("CROD", line("CROD,9,2,1,10"), hung()),
        ("CELAS2", line("CELAS2,9,1.+3,1,1,10,1"), Read([10, 8, 1], [[0.0, 1.0], [0.0, 1.0], [-1.0, 0.0]], &[], "")),
        ("CELAS1 to the ground", with("CELAS1,9,2,1,1\n"), noted("neither lines nor faces")),
        ("CELAS3", with("CELAS3,9,2,1,3\n"), Refused("CELAS3")),
        ("CONM2", with("CONM2,9,1,,1.\n"), noted("neither lines nor faces")),
        ("RBE2", with("RBE2,9,1,123,2,3\n"), Refused("RBE2")),
        ("RBE3", with("RBE3,9,,1,123,1.,123,2,3\n"), Refused("RBE3")),
        ("RBAR", with("RBAR,9,1,2,123456\n"), Refused("RBAR")),
        ("RROD", with("RROD,9,1,2\n"), Refused("RROD")),
        ("MPC", with("MPC,1,1,1,1.,2,1,-1.\n"), Refused("MPC")),
        ("CWELD", with("CWELD,9,1\n"), Refused("CWELD")),
        ("CBEAM3", with("CBEAM3,9,1,1,2,3\n"), Refused("CBEAM3")),
        ("CQUAD8", with("CQUAD8,9,1,1,3,9,7,2,6\n,8,4\n"), Refused("CQUAD8")),
        ("CHEXA", with("CHEXA,9,1\n"), Refused("CHEXA")),
        ("properties", with("PSHELL,1,1,.001\nMAT1,1,1.+9,,.3\nSPC1,1,123,1\nPARAM,POST,-1\nEIGRL,1\n"), SQUARE),
        ("SET1", with("SET1,1,1,2\n"), noted("SET1")),
        ("unknown entry", with("NOVEL,1\n"), noted("NOVEL (line 24)")),
    ];
    check("bdf", &rows);
}

/// Kratos, "Input data".
#[test]
fn kratos() {
    let nodes: String = nodes().map(|(n, [x, y, z])| format!("{n} {x} {y} {z}\n")).collect();
    let faces = |property: &str| -> String {
        (1..).zip(triangles()).map(|(n, [a, b, c])| format!("{n} {property}{a} {b} {c}\n")).collect()
    };
    let with = |text: &str| format!("Begin Nodes\n{nodes}End Nodes\n{text}");
    let elements = with(&format!("Begin Elements ShellThinElement3D3N\n{}End Elements\n", faces("0 ")));
    let geometries = with(&format!("Begin Geometries Triangle3D3\n{}End Geometries\n", faces("")));
    let part = |list: &str| {
        format!("Begin SubModelPart G\nBegin SubModelPart{list}\n1\n2\nEnd SubModelPart{list}\nEnd SubModelPart\n")
    };
    let rows = [
        ("Elements", elements.clone() + &part("Elements"), grouped(&["G: 2 triangles"])),
        ("Geometries", geometries.clone() + &part("Geometries"), grouped(&["G: 2 triangles"])),
        ("nodes of a part", geometries + &part("Nodes"), grouped(&["G: 2 nodes"])),
        ("Tetrahedra", with("Begin Geometries Tetrahedra3D4\n1 1 2 4 9\nEnd Geometries\n"), Refused("Tetrahedra3D4")),
        ("solid element", with("Begin Elements SmallDisplacementElement3D4N\n1 0 1 2 4 9\n"), Refused("3D4N")),
        (
            "MasterSlaveConstraints",
            elements.clone() + "Begin MasterSlaveConstraints LinearMasterSlaveConstraint\n",
            Refused("MasterSlave"),
        ),
        ("Properties", elements.clone() + "Begin Properties 1\nDENSITY 1\nEnd Properties\n", SQUARE),
        ("unknown block", elements + "Begin Novel\n1\nEnd Novel\n", noted("Begin Novel")),
    ];
    check("mdpa", &rows);
}

fn dxf(entities: &str) -> String {
    drawing("", "", entities)
}

fn drawing(header: &str, blocks: &str, entities: &str) -> String {
    let section = |name: &str, text: &str| format!("0\nSECTION\n2\n{name}\n{text}0\nENDSEC\n");
    let lines = |text: &str| text.split_whitespace().map(|word| format!("{word}\n")).collect::<String>();
    [
        section("HEADER", &lines(header)),
        section("BLOCKS", &lines(blocks)),
        section("ENTITIES", &lines(entities)),
        "0\nEOF\n".into(),
    ]
    .concat()
}

/// Autodesk, "DXF Reference".
#[test]
fn dxf_entities() {
    const FACE: &str = "0 3DFACE 8 sail 10 0 20 0 30 0 11 1 21 0 31 0 12 1 22 1 32 0 13 0 23 1 33 0 ";
    const OPEN: &str = "0 LWPOLYLINE 90 3 70 0 10 0 20 0 10 2 20 0 10 2 20 1 ";
    let faces = |bounds, words| Read([4, 2, 0], bounds, &["sail: 2 triangles"], words);
    let lines = |count, bounds, words| Read([count + 1, 0, count], bounds, &[], words);
    let block = format!("0 BLOCK 2 B 70 0 10 1 20 0 30 0 {FACE} 0 ENDBLK ");
    let inserted = |text: &str| drawing("", &block, &format!("0 INSERT 2 B 8 rig {text} "));
    let rows = [
        ("3DFACE", dxf(FACE), faces(FLAT, "")),
        (
            "SOLID",
            dxf(&FACE.replace("3DFACE", "SOLID").replace("12 1 22 1", "12 0 22 1").replace("13 0 23 1", "13 1 23 1")),
            faces(FLAT, ""),
        ),
        (
            "extrusion that mirrors",
            dxf(&format!("{OPEN} 210 0 220 0 230 -1 ")),
            lines(2, [[-2.0, 0.0], [0.0, 1.0], [0.0, 0.0]], ""),
        ),
        (
            "extrusion along x",
            dxf(&format!("{OPEN} 210 1 220 0 230 0 ")),
            lines(2, [[0.0, 0.0], [0.0, 2.0], [0.0, 1.0]], ""),
        ),
        ("paper space", dxf(&format!("{FACE} {OPEN} 67 1 ")), faces(FLAT, "paper space")),
        ("inches", drawing("9 $INSUNITS 70 1 ", "", FACE), faces([[0.0, 0.0254], [0.0, 0.0254], [0.0, 0.0]], "inches")),
        ("metres", drawing("9 $INSUNITS 70 6 ", "", FACE), faces(FLAT, "")),
        (
            "kilometres",
            drawing("9 $INSUNITS 70 7 ", "", FACE),
            faces([[0.0, 1e3], [0.0, 1e3], [0.0, 0.0]], "kilometres"),
        ),
        (
            "control points of a curve",
            dxf("0 POLYLINE 66 1 70 4 0 VERTEX 10 0 20 0 70 16 0 VERTEX 10 1 20 5 70 16 0 VERTEX 10 0 20 0 70 8 \
                 0 VERTEX 10 1 20 1 70 8 0 VERTEX 10 2 20 0 70 8 0 SEQEND "),
            lines(2, [[0.0, 2.0], [0.0, 1.0], [0.0, 0.0]], ""),
        ),
        ("INSERT", inserted("10 5 20 0 30 2 "), faces([[4.0, 5.0], [0.0, 1.0], [2.0, 2.0]], "")),
        (
            "INSERT, scaled and turned",
            inserted("10 0 20 0 41 2 42 2 50 90 "),
            faces([[-2.0, 0.0], [-2.0, 0.0], [0.0, 0.0]], ""),
        ),
        (
            "INSERT, rows and columns",
            inserted("10 1 20 0 70 2 44 3 71 1 "),
            Read([8, 4, 0], [[0.0, 4.0], [0.0, 1.0], [0.0, 0.0]], &[], ""),
        ),
        ("INSERT of no block", drawing("", "", &format!("{FACE} 0 INSERT 2 none ")), faces(FLAT, "not in the file")),
        ("INSERT alone, of no block", drawing("", "", "0 INSERT 2 none "), Refused("INSERT")),
        ("INSERT of itself", drawing("", "0 BLOCK 2 B 70 0 0 INSERT 2 B 0 ENDBLK ", "0 INSERT 2 B "), Refused("deep")),
        (
            "SPLINE",
            dxf("0 SPLINE 70 8 71 1 40 0 40 0 40 1 40 2 40 2 10 0 20 0 10 1 20 1 10 2 20 0 "),
            lines(2, [[0.0, 2.0], [0.0, 1.0], [0.0, 0.0]], "splines"),
        ),
        (
            "SPLINE of fit points",
            dxf("0 SPLINE 70 8 71 3 11 0 21 0 11 1 21 1 11 2 21 0 "),
            lines(2, [[0.0, 2.0], [0.0, 1.0], [0.0, 0.0]], "splines"),
        ),
        (
            "ELLIPSE, an arc",
            dxf("0 ELLIPSE 10 0 20 0 11 2 21 0 40 0.5 41 0 42 1.5707963267948966 "),
            lines(18, [[0.0, 2.0], [0.0, 1.0], [0.0, 0.0]], "ellipses"),
        ),
        (
            "MESH",
            dxf(
                "0 MESH 8 sail 92 4 10 0 20 0 30 0 10 1 20 0 30 0 10 1 20 1 30 0 10 0 20 1 30 0 93 5 90 4 90 0 90 1 90 2 90 3 94 0 95 0 ",
            ),
            faces(FLAT, ""),
        ),
        ("left out by kind", dxf(&format!("{FACE} 0 HATCH 8 0 0 HATCH 8 0 0 3DSOLID 8 0 ")), faces(FLAT, "2 HATCH")),
        ("text", dxf(&format!("{FACE} 0 TEXT 1 sail 0 POINT 10 9 20 9 ")), faces(FLAT, "")),
        ("solid alone", dxf("0 3DSOLID 8 0 "), Refused("3DSOLID")),
    ];
    check("dxf", &rows);
}

/// Loops of lines and arcs are outlines; chords of arcs are no longer than an edge.
#[test]
fn outlines_of_lines_and_arcs() {
    let wanted = MeshFile { edge: Some(5.0), ..MeshFile::plain("") };
    let lines = "0 LINE 8 s 10 0 20 0 11 1 21 0 0 LINE 8 s 10 1 20 1 11 1 21 0 0 LINE 8 s 10 1 20 1 11 0 21 1 0 LINE 8 s 10 0 20 1 11 0 21 0 ";
    let filled = Read([4, 2, 0], FLAT, &["s: 2 triangles"], "");
    check_with(&wanted, "dxf", "lines", dxf(lines).as_bytes(), &filled);
    let stray = format!("{lines} 0 LINE 8 s 10 0 20 0 11 -1 21 0 ");
    let kept = Read([5, 0, 5], [[-1.0, 1.0], [0.0, 1.0], [0.0, 0.0]], &["s: 5 edges"], "");
    check_with(&wanted, "dxf", "a fork is no outline", dxf(&stray).as_bytes(), &kept);
    let fine = MeshFile { edge: Some(0.05), ..MeshFile::plain("") };
    let circle = dxf("0 CIRCLE 10 0 20 0 40 1 ");
    let area = |wanted: &MeshFile| {
        let mesh = file_from_bytes(wanted, Path::new("a.dxf"), circle.as_bytes()).expect("a disc").mesh;
        let place = |node: u32| nalgebra::Vector3::from(mesh.nodes[node as usize]);
        mesh.triangles.iter().map(|t| t.map(place)).map(|[a, b, c]| 0.5 * (b - a).cross(&(c - a)).norm()).sum::<f64>()
    };
    let [coarse, close] = [&wanted, &fine].map(area);
    let exact = std::f64::consts::PI;
    assert!(exact - close < 0.4 * (exact - coarse) && close < exact, "{coarse} and {close} of {exact} m^2");
}

/// The square as legacy .vtk: what stands before its points, and after its cells.
fn vtk(title: &str, before: &str, after: &str) -> String {
    let points: String = nodes().map(|(_, [x, y, z])| format!("{x} {y} {z}\n")).collect();
    let cells: String = triangles().iter().map(|[a, b, c]| format!("3 {} {} {}\n", a - 1, b - 1, c - 1)).collect();
    format!(
        "# vtk DataFile Version 3.0\n{title}\nASCII\nDATASET UNSTRUCTURED_GRID\n{before}POINTS 9 float\n{points}\
         CELLS 8 32\n{cells}CELL_TYPES 8\n{}{after}",
        "5\n".repeat(8)
    )
}

/// "VTK file formats", and what VTK itself writes beyond it.
#[test]
fn vtk_legacy() {
    const TIME: &str = "FIELD FieldData 1\nTimeValue 1 1 double\n0.5\n";
    const META: &str = "METADATA\nINFORMATION 1\nNAME L2_NORM_RANGE LOCATION vtkDataArray\nDATA 2 0 1.4 \n\n";
    const PARTS: &str = "1 1 2 2 1 1 2 2\n";
    const GROUPS: &[&str] = &["part 1: 4 triangles", "part 2: 4 triangles"];
    let mut rows = vec![
        ("plain", vtk("title", "", ""), SQUARE),
        ("empty title", vtk("", "", ""), SQUARE),
        ("FIELD first", vtk("t", TIME, ""), SQUARE),
        ("FIELD and METADATA first", vtk("t", &format!("{TIME}{META}"), ""), SQUARE),
        ("METADATA after the cells", vtk("t", "", META), SQUARE),
        (
            "FIELD with METADATA between",
            vtk("t", "", &format!("CELL_DATA 8\nFIELD F 2\na 1 8 double\n{PARTS}{META}part 1 8 int\n{PARTS}")),
            grouped(GROUPS),
        ),
        (
            "NULL_ARRAY",
            vtk("t", "", &format!("CELL_DATA 8\nFIELD F 2\nNULL_ARRAY\npart 1 8 int\n{PARTS}")),
            grouped(GROUPS),
        ),
        (
            "strings",
            vtk(
                "t",
                "FIELD F 1\nnames 1 2 string\na%20b\n\n",
                &format!("CELL_DATA 8\nSCALARS part int 1\nLOOKUP_TABLE default\n{PARTS}"),
            ),
            grouped(GROUPS),
        ),
        ("no table of colours", vtk("t", "", &format!("CELL_DATA 8\nSCALARS part int\n{PARTS}")), grouped(GROUPS)),
        (
            "LOOKUP_TABLE",
            vtk(
                "t",
                "",
                &format!("CELL_DATA 8\nSCALARS part int\nLOOKUP_TABLE mine\n{PARTS}LOOKUP_TABLE mine 1\n1 0 0 1\n"),
            ),
            grouped(GROUPS),
        ),
        (
            "all attributes",
            vtk(
                "t",
                "",
                &format!(
                    "POINT_DATA 9\nVECTORS v float\n{}NORMALS n float\n{}TEXTURE_COORDINATES t 2 float\n{}TENSORS t double\n{}\
             COLOR_SCALARS c 3\n{}CELL_DATA 8\nGLOBAL_IDS g vtkIdType\n{PARTS}SCALARS part int 1\n{PARTS}",
                    "0 0 1\n".repeat(9),
                    "0 0 1\n".repeat(9),
                    "0 1\n".repeat(9),
                    "1 0 0 0 1 0 0 0 1\n".repeat(9),
                    "1 0 0\n".repeat(9)
                ),
            ),
            grouped(GROUPS),
        ),
        (
            "part 0",
            vtk("t", "", "CELL_DATA 8\nSCALARS part int 1\nLOOKUP_TABLE default\n0 0 1 1 2 2 2 2\n"),
            grouped(&["part 0: 2 triangles", "part 2: 4 triangles"]),
        ),
        (
            "ghost cells",
            vtk("t", "", "CELL_DATA 8\nFIELD F 1\nvtkGhostType 1 8 unsigned_char\n0 0 0 0 0 0 1 32\n"),
            Read([8, 6, 0], FLAT, &[], "ghost"),
        ),
        (
            "blank and escape in a name",
            vtk("t", "", &format!("CELL_DATA 8\nFIELD F 1\n%20my%20part 1 8 int\n{PARTS}")),
            Read([9, 8, 0], FLAT, &["my part 1: 4 triangles"], "names of groups were changed"),
        ),
        ("image", vtk("t", "", "").replace("UNSTRUCTURED_GRID", "STRUCTURED_POINTS"), Refused("STRUCTURED_POINTS")),
        ("tetrahedra", vtk("t", "", "").replace("\n5\n5\n", "\n10\n5\n"), Refused("Tetra")),
    ];
    const TYPES: [(&str, usize, bool); 14] = [
        ("char", 1, true),
        ("signed_char", 1, true),
        ("unsigned_char", 1, false),
        ("short", 2, true),
        ("unsigned_short", 2, false),
        ("int", 4, true),
        ("unsigned_int", 4, false),
        ("long", 8, true),
        ("unsigned_long", 8, false),
        ("vtkIdType", 4, true),
        ("vtktypeint64", 8, true),
        ("vtktypeuint64", 8, false),
        ("vtktypeint8", 1, true),
        ("vtktypeuint16", 2, false),
    ];
    for (kind, ..) in TYPES {
        rows.push((
            kind,
            vtk("t", "", &format!("CELL_DATA 8\nSCALARS part {kind} 1\nLOOKUP_TABLE default\n{PARTS}")),
            grouped(GROUPS),
        ));
    }
    check("vtk", &rows);
    let latin = [
        &b"# vtk DataFile Version 3.0\nvoil\xe9\n"[..],
        vtk("", "", "").split_once("\n\n").expect("a title").1.as_bytes(),
    ]
    .concat();
    check_bytes("vtk", "Latin-1 title", &latin, &SQUARE);
    for (kind, size, _) in TYPES {
        let mut file = b"# vtk DataFile Version 4.2\nt\nBINARY\nDATASET POLYDATA\nFIELD F 2\nnames 1 1 string\n\xc3abc\nbits 1 9 bit\n\xff\x80\n".to_vec();
        file.extend(b"METADATA\nINFORMATION 0\n\nPOINTS 9 double\n");
        nodes().for_each(|(_, place)| place.iter().for_each(|x| file.extend(x.to_be_bytes())));
        file.extend(b"\nMETADATA\nINFORMATION 0\n\nPOLYGONS 8 32\n");
        triangles().iter().for_each(|t| {
            [3, t[0] - 1, t[1] - 1, t[2] - 1].iter().for_each(|n| file.extend((*n as u32).to_be_bytes()));
        });
        file.extend(format!("\nCELL_DATA 8\nSCALARS part {kind} 1\nLOOKUP_TABLE default\n").into_bytes());
        [1_u64, 1, 2, 2, 1, 1, 2, 2].iter().for_each(|n| file.extend(&n.to_be_bytes()[8 - size..]));
        file.extend(b"\n");
        check_bytes("vtk", &format!("binary {kind}"), &file, &grouped(GROUPS));
    }
}

/// "VTK XML file formats".
#[test]
fn vtk_xml() {
    let array = |kind: &str, name: &str, numbers: &str| {
        format!("<DataArray type=\"{kind}\" Name=\"{name}\" format=\"ascii\">{numbers}</DataArray>")
    };
    let points: String = nodes().map(|(_, [x, y, z])| format!("{x} {y} {z} ")).collect();
    let cells: String = triangles().iter().map(|[a, b, c]| format!("{} {} {} ", a - 1, b - 1, c - 1)).collect();
    let file = |more: &str, data: &str| {
        format!(
            "<?xml version=\"1.0\"?><!-- a > comment --><VTKFile type='UnstructuredGrid' version=\"0.1\"><UnstructuredGrid>\
             <Piece NumberOfPoints=\"9\" NumberOfCells=\"8\"><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" \
             format=\"ascii\">{points}<InformationKey name=\"L2\"><Value index=\"0\">1</Value></InformationKey></DataArray>\
             </Points><Cells>{}{}{}{more}</Cells><CellData>{data}</CellData></Piece></UnstructuredGrid></VTKFile>",
            array("Int64", "connectivity", &cells),
            array("Int64", "offsets", "3 6 9 12 15 18 21 24"),
            array("UInt8", "types", "5 5 5 5 5 5 5 5"),
        )
    };
    let parts = "0 0 1 1 2 2 2 2";
    let rows = [
        ("plain", file("", ""), SQUARE),
        (
            "faces",
            file(&(array("Int64", "faces", "") + &array("Int64", "faceoffsets", "-1 -1 -1 -1 -1 -1 -1 -1")), ""),
            SQUARE,
        ),
        ("part 0", file("", &array("Int32", "part", parts)), grouped(&["part 0: 2 triangles"])),
        ("strings", file("", &array("String", "names", "97 0 98 0")), SQUARE),
        ("a blank in a name", file("", &array("Int32", " part ", parts)), grouped(&["part  2: 4 triangles"])),
        ("ghosts", file("", &array("UInt8", "vtkGhostType", "0 0 0 0 0 0 1 32")), Read([8, 6, 0], FLAT, &[], "ghost")),
        ("image", file("", "").replace("'UnstructuredGrid'", "'ImageData'"), Refused("ImageData")),
    ];
    check("vtu", &rows);
    let list =
        "<VTKFile type=\"Collection\"><Collection><DataSet timestep=\"0\" file=\"a/b_0.vtu\"/></Collection></VTKFile>";
    for ending in ["pvd", "pvtu", "vtm"] {
        check_bytes(ending, ending, list.as_bytes(), &Refused("a/b_0.vtu"));
    }
}

/// A .gltf of a triangle, with more keys of its mesh's primitive, nodes, and the file.
fn gltf(primitive: &str, nodes: &str, more: &str) -> String {
    let data = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    format!(
        "{{\"asset\": {{\"version\": \"2.0\"}}, \"nodes\": [{nodes}], \"meshes\": [{{\"name\": \"sail\", \"primitives\": [{{\
         \"attributes\": {{\"POSITION\": 0}}{primitive}}}]}}], \"buffers\": [{{\"byteLength\": 36, \"uri\": \
         \"data:application/octet-stream;base64,{data}\"}}], \"bufferViews\": [{{\"buffer\": 0, \"byteLength\": 36}}], \
         \"accessors\": [{{\"bufferView\": 0, \"componentType\": 5126, \"count\": 3, \"type\": \"VEC3\", \"min\": [0, 0, 0], \
         \"max\": [1, 1, 0]}}]{more}}}"
    )
}

/// Khronos, "glTF 2.0 Specification".
#[test]
fn gltf_scenes() {
    const UPRIGHT: [[f64; 2]; 3] = [[0.0, 1.0], [0.0, 0.0], [0.0, 1.0]];
    let one = ", \"scenes\": [{\"nodes\": [0]}], \"scene\": 0";
    let uses = |name: &str, at: &str| format!("{one}, \"extensions{at}\": [\"{name}\"]");
    let rows = [
        ("y is up", gltf("", "{\"mesh\": 0}", one), Read([3, 1, 0], UPRIGHT, &["sail: 1 triangle"], "turned up")),
        (
            "moved",
            gltf("", "{\"mesh\": 0, \"translation\": [1, 2, 3]}", one),
            Read([3, 1, 0], [[1.0, 2.0], [-3.0, -3.0], [2.0, 3.0]], &[], ""),
        ),
        (
            "the default scene",
            gltf(
                "",
                "{\"mesh\": 0}, {\"mesh\": 0, \"translation\": [5, 0, 0]}",
                ", \"scenes\": [{\"nodes\": [1]}, {\"nodes\": [0]}], \"scene\": 1",
            ),
            Read([3, 1, 0], UPRIGHT, &[], "1 other scenes"),
        ),
        ("no scene", gltf("", "{\"mesh\": 0}", ""), Refused("no scene")),
        (
            "Draco",
            gltf("", "{\"mesh\": 0}", &uses("KHR_draco_mesh_compression", "Required")),
            Refused("KHR_draco_mesh_compression"),
        ),
        (
            "meshopt",
            gltf("", "{\"mesh\": 0}", &uses("EXT_meshopt_compression", "Used")),
            Refused("EXT_meshopt_compression"),
        ),
        (
            "quantization",
            gltf("", "{\"mesh\": 0}", &uses("KHR_mesh_quantization", "Used")),
            Refused("KHR_mesh_quantization"),
        ),
        (
            "instancing",
            gltf("", "{\"mesh\": 0}", &uses("EXT_mesh_gpu_instancing", "Used")),
            Refused("EXT_mesh_gpu_instancing"),
        ),
        ("unknown, needed", gltf("", "{\"mesh\": 0}", &uses("NEW_thing", "Required")), Refused("NEW_thing")),
        (
            "unknown, used",
            gltf("", "{\"mesh\": 0}", &uses("NEW_thing", "Used")),
            Read([3, 1, 0], UPRIGHT, &[], "NEW_thing"),
        ),
        (
            "materials",
            gltf("", "{\"mesh\": 0}", &uses("KHR_materials_unlit", "Used")),
            Read([3, 1, 0], UPRIGHT, &[], ""),
        ),
        (
            "skin",
            gltf("", "{\"mesh\": 0, \"skin\": 0}, {}", &format!("{one}, \"skins\": [{{\"joints\": [1]}}]")),
            Refused("skin"),
        ),
        (
            "two parents",
            gltf("", "{\"mesh\": 0}, {\"children\": [0]}, {\"children\": [0]}", ", \"scenes\": [{\"nodes\": [1, 2]}]"),
            Refused("parents"),
        ),
    ];
    check("gltf", &rows);
    let mirrored = gltf("", "{\"mesh\": 0, \"scale\": [-1, 1, 1]}", one);
    let mesh = file_from_bytes(&MeshFile::plain(""), Path::new("a.gltf"), mirrored.as_bytes()).expect("read").mesh;
    let [a, b, c] = mesh.triangles[0].map(|node| nalgebra::Vector3::from(mesh.nodes[node as usize]));
    // The normal of the file is +z, which is turned to -y.
    assert!((b - a).cross(&(c - a)).y < 0.0, "a mirror turns the winding");
    let up = MeshFile { axes: canopy_fem::mesh::file::Axes::ZUp, ..MeshFile::plain("") };
    check_with(
        &up,
        "gltf",
        "z-up leaves it",
        gltf("", "{\"mesh\": 0}", one).as_bytes(),
        &Read([3, 1, 0], FLAT, &[], ""),
    );
}

/// Quads that are warped by any angle are cut; a face that crosses itself is left out, or refused.
#[test]
fn warped_quads_are_cut() {
    let other = "v 5 0 0\nv 6 0 0\nv 5 1 0\nf 5 6 7\n";
    let quad = |z: f64| format!("v 0 0 0\nv 1 0 {z}\nv 1 1 0\nv 0 1 {z}\nf 1 2 3 4\n{other}");
    for z in [0.0, 0.5, 1.0, 3.0, 30.0] {
        let bounds = [[0.0, 6.0], [0.0, 1.0], [0.0, z]];
        check_bytes("obj", &format!("warped by {z}"), quad(z).as_bytes(), &Read([7, 3, 0], bounds, &[], ""));
    }
    let bow = quad(0.0).replace("f 1 2 3 4", "f 1 2 4 3");
    let left =
        Read([3, 1, 0], [[5.0, 6.0], [0.0, 1.0], [0.0, 0.0]], &[], "1 faces that cross themselves were left out: 0");
    check_bytes("obj", "a bow", bow.as_bytes(), &left);
    let strict = MeshFile { strict: true, ..MeshFile::plain("") };
    check_with(&strict, "obj", "a bow, strict", bow.as_bytes(), &Refused("crosses itself"));
}
