//! Parachutes under the air laws of a free stream, which fly them wrongly: warned of. Under the air in their canopies:
//! not.

use crate::common::parachute::Parachute;
use serde_json::{Value, json};

use super::program::program;
use super::warnings::{lines, warnings, with};

/// A parachute on its lines: the laws of the free stream close it, or hold it far too well; the air in its canopy is
/// nothing to warn of.
#[test]
fn a_parachute_under_a_law_of_the_free_stream_is_warned_of() {
    let small = Parachute { gores: 8, rings: 4, line_segments: 2, nominal_diameter: 2.0, line_length: 2.0 };
    let mut good = small.case(1.74, 4.0, 6.0);
    for rule in good["system"]["network"]["springs"].as_array_mut().expect("rules") {
        rule["dashpot"] = json!({"axial": {"time": 2e-5}});
    }
    assert_eq!(warnings(&good), (vec![], String::new()));
    let aero = |law: Value| {
        with(&good, &[("/system/network/aero", json!({"law": law})), ("/system/network/initial", Value::Null)])
    };
    let (codes, texts) = warnings(&aero(json!({"pressure_coefficient": {"cp": 1.2}})));
    assert_eq!(codes, ["closing-canopy"], "{texts}");
    assert!(texts.contains("aero.canopy"), "{texts}");
    let (codes, texts) = warnings(&aero(json!({"permeable": {"a": 1.6e6, "b": 4.8e5, "thickness": 1e-4}})));
    assert_eq!(codes, ["air-pressure", "closing-canopy"], "{texts}");
}

/// A cavity is experimental, and says so; a case can acknowledge it by its code.
#[test]
fn a_cavity_is_warned_of() {
    let small = Parachute { gores: 8, rings: 4, line_segments: 2, nominal_diameter: 2.0, line_length: 2.0 };
    let mut case = small.case(1.74, 4.0, 6.0);
    for rule in case["system"]["network"]["springs"].as_array_mut().expect("rules") {
        rule["dashpot"] = json!({"axial": {"time": 2e-5}});
    }
    let canopy = &mut case["system"]["network"]["aero"]["canopy"];
    canopy["table"] = Value::Null;
    canopy["cavity"] = json!({"inflow": 0.4, "outer_pressure_coefficient": -0.6});
    let (codes, texts) = warnings(&case);
    assert_eq!(codes, ["experimental-model"], "{texts}");
    assert!(texts.contains("opening loads") && texts.contains("\"schedule\""), "{texts}");
}

/// A C-9 (28 gores, D0 8.534 m, lines of 0.9 D0, 90.7 kg) in calm air. A pressure coefficient of 1.2 lets its skirt
/// close, and the load falls at about 40 m/s; as permeable cloth, measured, it falls at 0.5 m/s. The true speed is
/// 5.8 m/s. Both are warned of by `check` and by `solve`, with their codes; the air in its canopy is not.
#[test]
fn a_c9_under_a_law_of_the_free_stream_is_warned_of_by_check_and_solve() {
    let c9 = Parachute { gores: 28, rings: 8, line_segments: 2, nominal_diameter: 8.534, line_length: 7.681 };
    let mut good = c9.case(1.79, 90.7, 5.8);
    for rule in good["system"]["network"]["springs"].as_array_mut().expect("rules") {
        rule["dashpot"] = json!({"axial": {"time": 2e-5}});
    }
    good["time"] = json!({"end": 1e-3, "method": "newmark", "step": 1e-3});
    let still = good["system"]["network"]["aero"]["canopy"].clone();
    let closing = "no support holds the cloth of 420 triangles";
    let laws = [
        (
            json!({"law": {"pressure_coefficient": {"cp": 1.2, "air_density": 1.225}}}),
            vec![("closing-canopy", closing)],
        ),
        (
            json!({"law": {"permeable": {"a": 1.599e6, "b": 4.805e5, "thickness": 1e-4}}}),
            vec![("air-pressure", "times the dynamic pressure"), ("closing-canopy", closing)],
        ),
        (json!({"canopy": still}), vec![]),
    ];
    let folder = tempfile::tempdir().expect("a folder");
    let starts = [good["system"]["network"]["initial"].clone(), Value::Null];
    for ((aero, expected), start) in laws.iter().flat_map(|law| starts.iter().map(move |start| (law, start))) {
        let case = with(&good, &[("/system/network/aero", aero.clone()), ("/system/network/initial", start.clone())]);
        let checked = program(folder.path(), &case, &["check"]);
        let solved = program(folder.path(), &case, &["solve", "--force"]);
        assert_eq!((checked.status, solved.status), (Some(0), Some(0)), "{}{}", checked.stderr, solved.stderr);
        for said in [lines(&checked.stdout), lines(&solved.stderr)] {
            assert_eq!(said.len(), expected.len(), "{said:?}");
            for (code, words) in expected {
                let found = said.iter().find(|line| line.ends_with(&format!("[{code}]")));
                assert!(found.is_some_and(|line| line.contains(words)), "no {code} with \"{words}\" in {said:?}");
            }
        }
    }
}
