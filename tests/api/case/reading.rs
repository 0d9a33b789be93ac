//! Text, encoding, syntax: nothing a file can hold may bring the program down.

use std::path::{Path, PathBuf};

use canopy_fem::case::fingerprint::Fingerprint;
use canopy_fem::case::spec::RowEvery;
use canopy_fem::case::{Case, CaseError};
use proptest::prelude::*;

use super::common::{BASE, text_with};

fn message(text: &str) -> String {
    text_with(text, &[]).expect_err("refused").to_string()
}

/// Bytes as a file.
fn file(bytes: &[u8]) -> Result<Case, CaseError> {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("case.json");
    std::fs::write(&path, bytes).expect("written");
    Case::from_file(&path, &[])
}

/// Each text that is no case says where and what to do.
#[test]
fn syntax_errors_name_place_and_remedy() {
    let deep = format!("{}1{}", "[".repeat(100_000), "]".repeat(100_000));
    for (text, words) in [
        ("", "the file is empty"),
        (" // only a comment\n", "the file is empty"),
        ("{\"a\": 1,,}", "keys in double quotes"),
        ("[1,,]", "a number, \"text\""),
        ("{\"a\": 1", "ends too early"),
        ("{\"a\": NaN}", "NaN and Infinity are not JSON"),
        ("{\"a\": 1e999}", "at most 1.797e308"),
        ("{\"a\": 1, \"b\": 2, \"a\": 3}", "\"a\" is given twice"),
        ("{} {}", "nothing may follow"),
        ("{\"a\" 1}", "expected `:`"),
        ("{'a': 1}", "double quotes"),
        (deep.as_str(), "128 levels"),
        ("{} /* open", "never closed"),
    ] {
        let message = message(text);
        assert!(message.contains(words), "{words}: {message}");
    }
    assert!(message("{\n  \"a\": 1,\n  \"a\": 2\n}").contains(" --> base.json:3:3\n"), "the second key");
    assert!(message("{\n\n /* x").contains(" --> base.json:3:2\n"), "line and column of the comment");
}

/// What editors write into JSON with comments: the place of a schema, and commas behind the last entry. Neither changes
/// a run.
#[test]
fn a_schema_and_trailing_commas_are_read() {
    let plain = text_with(BASE, &[]).expect("good");
    let rest = BASE.trim().strip_prefix('{').and_then(|rest| rest.strip_suffix('}')).expect("an object");
    let text = format!("{{\"$schema\": \"./case.schema.json\", {rest},\n}}");
    let case = text_with(&text, &[]).expect("good");
    assert_eq!(case.file().schema.as_deref(), Some("./case.schema.json"));
    let print = |case: &Case| Fingerprint::of(case.problem()).expect("numbers");
    assert_eq!(print(&case).digest(), print(&plain).digest());
    let message = message(&text.replace("\"./case.schema.json\"", "3"));
    assert!(message.contains("/$schema: 3"), "{message}");
}

/// A case that is JSON but no object is a fault of the root.
#[test]
fn a_case_is_an_object() {
    for text in ["[]", "3", "null", "\"case\""] {
        let error = text_with(text, &[]).expect_err("refused");
        assert_eq!(error.faults().len(), 1, "{text}: {error}");
        assert_eq!(error.faults()[0].pointer, "");
    }
}

/// UTF-8 with a byte order mark is read; other encodings, folders and missing files say what they are.
#[test]
fn encodings_and_files() {
    file(&[b"\xEF\xBB\xBF", BASE.as_bytes()].concat()).expect("a byte order mark of UTF-8 is harmless");
    let utf16: Vec<u8> = [0xFF, 0xFE].into_iter().chain(BASE.bytes().flat_map(|b| [b, 0])).collect();
    let error = file(&utf16).expect_err("UTF-16").to_string();
    assert!(error.contains("UTF-16: save it as UTF-8"), "{error}");
    let error = file(b"{\"name\": \"\xE4\"}").expect_err("Latin 1");
    assert!(matches!(error, CaseError::NotUtf8 { offset: 10, .. }), "{error}");
    assert!(matches!(Case::from_file(Path::new("/no/such.json"), &[]), Err(CaseError::Read { .. })));
    assert!(matches!(Case::from_file(Path::new(env!("CARGO_MANIFEST_DIR")), &[]), Err(CaseError::Read { .. })));
}

/// Comments are read over, and a relative mesh path counts from the case file, not from the working folder.
#[test]
fn comments_and_relative_paths() {
    let folder = tempfile::tempdir().expect("folder");
    std::fs::write(folder.path().join("square.obj"), "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n").expect("written");
    let text = r#"{ // a triangle
        "name": "obj", /* its mesh: */ "system": {"network": {"mesh": {"file": "square.obj"}, "mass": {"nodal": 1}}},
        "time": {"end": 1, "step": 0.1, "method": "rk4"} }"#;
    let path = folder.path().join("case.json");
    std::fs::write(&path, text).expect("written");
    let case = Case::from_file(&path, &[]).expect("good");
    assert_eq!(case.problem().name, "obj");
}

/// The command's example is a good case, named as asked, and nothing is overwritten by chance.
#[test]
fn init_writes_a_good_case_once() {
    use canopy_fem::cli::init::{InitArgs, InitError, Template, write};
    let folder = tempfile::tempdir().expect("folder");
    let args =
        |name: &str, force| InitArgs { name: Some(name.to_owned()), template: Template::default(), list: false, force };
    let path = write(&args("my-canopy", false), folder.path()).expect("written");
    assert_eq!(path, folder.path().join("my-canopy.json"));
    let case = Case::from_file(&path, &[]).expect("the example is good");
    assert_eq!(case.problem().name, "my-canopy");
    assert!(case.warnings().is_empty(), "{:?}", case.warnings());
    std::fs::write(&path, "mine").expect("written");
    assert!(matches!(write(&args("my-canopy", false), folder.path()), Err(InitError::Exists { .. })));
    assert_eq!(std::fs::read_to_string(&path).expect("read"), "mine");
    write(&args("my-canopy.json", true), folder.path()).expect("forced");
    for name in ["", "../x", ".x", "a b", "-x", "a\"b", "a/b"] {
        assert!(matches!(write(&args(name, true), folder.path()), Err(InitError::Name { .. })), "{name}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    /// A cut-off case is refused, never a panic, wherever the cut is.
    #[test]
    fn a_truncated_case_is_refused(cut in 0..BASE.len() - 1) {
        prop_assert!(Case::from_text(BASE[..cut].to_owned(), "cut", PathBuf::new(), &[]).is_err());
    }

    /// Whatever byte stands anywhere, reading ends with a case or an error.
    #[test]
    fn a_changed_byte_never_panics(at in 0..BASE.len(), byte: u8) {
        let mut bytes = BASE.as_bytes().to_vec();
        bytes[at] = byte;
        if let Err(error) = file(&bytes) {
            prop_assert!(!error.to_string().is_empty());
        }
    }

    /// A number is the double nearest to its decimal digits, so that a case written by a program runs to the same bits.
    /// serde_json does so with its feature `float_roundtrip` only.
    #[test]
    fn numbers_are_read_exactly(mantissa in 1.0..10.0_f64, exponent in -30..0_i32) {
        let step: f64 = format!("{mantissa}e{exponent}").parse().expect("a number");
        let text = format!("{step:e}");
        let case = text_with(BASE, &[("time.end", text.as_str()), ("time.step", text.as_str())]).expect("good");
        prop_assert_eq!(case.problem().time.step.fixed().map(f64::to_bits), Some(step.to_bits()));
    }

    /// Extreme numbers anywhere a number stands give a case or faults; what is built holds finite masses and springs.
    #[test]
    fn extreme_numbers_never_panic(which in 0..18_usize, value in prop_oneof![
        Just("0"), Just("-0.0"), Just("-1"), Just("1e308"), Just("-1e308"), Just("5e-324"), Just("1e-160"), Just("1e160"),
        Just("18446744073709551615"), Just("-9223372036854775808"), Just("4294967295"), Just("0.5")
    ]) {
        const KEYS: [&str; 18] = [
            "time.step", "time.end", "system.network.mass.areal_density", "system.network.mass.nodal",
            "system.network.springs.0.stiffness", "system.network.springs.0.rest_scale",
            "system.network.springs.0.rest_length", "system.network.springs.0.linear_density",
            "system.network.mesh.explicit.nodes.1.0", "system.network.mesh.explicit.nodes.4.2",
            "system.network.mesh.explicit.springs.0.0", "system.network.mesh.explicit.triangles.0.0",
            "system.network.supports.0.on.ids.0", "output.frames.every", "output.history.every",
            "system.network.springs.0.dashpot.axial.per_strain", "system.network.springs.0.dashpot.relative.time",
            "system.network.damping.rayleigh.mass",
        ];
        if let Ok(case) = text_with(BASE, &[(KEYS[which], value)]) {
            let canopy_fem::case::spec::SystemSpec::Network(network) = &case.problem().system else {
                return Err(TestCaseError::fail("not a network"));
            };
            prop_assert!(network.mass.iter().all(|m| m.is_finite()));
            for group in &network.springs {
                prop_assert!(group.stiffness.given().iter().all(|k| k.is_normal() && *k > 0.0));
                prop_assert!(group.rest_length.iter().all(|l0| *l0 == 0.0 || (l0.is_normal() && *l0 > 0.0)));
            }
            prop_assert!(case.problem().output.history_every != RowEvery::Steps(0));
        }
    }
}
