//! What the program says of inputs that people get wrong: every message names what was meant, and none has a number
//! that is not in the case, or a second fault that is none.

use super::program::program_with;
use canopy_fem::case::Case;
use std::path::PathBuf;

/// A sail across the wind.
const SAIL: &str = r#"{"name": "sail", "system": {"network": {
"mesh": {"rectangle": {"width": 1.0, "height": 1.0, "columns": 4, "rows": 4}},
"mass": {"areal_density": 0.05},
"springs": [{"on": "all", "stiffness": 100.0, "slack": "tension-only", "dashpot": {"axial": {"time": 1e-3}}}],
"supports": [{"on": "outer", "fix": "xyz"}],
"gravity": [0, 0, -9.81],
"aero": {"wind": [0, 0, 10], "law": {"pressure_coefficient": {"cp": 1.2, "air_density": 1.225}}}}},
"time": {"end": 0.1, "method": "newmark", "step": 1e-2},
"output": {"frames": {"every": 0.05}, "gauges": [{"name": "g", "of": "reaction", "on": "all"}]}}"#;

/// A parachute that opens.
const CHUTE: &str = r#"{"name": "chute", "system": {"network": {
"mesh": {"parachute": {"type": "flat-circular", "nominal_diameter": 8.5, "gores": 8, "vent_diameter": 0.457,
  "radial_segments": 3, "lines": {"length": 7.21, "segments": 2}, "riser": {"length": 1.0},
  "reefing": {"diameter": 1.2}, "start": "inflated"}},
"mass": {"areal_density": 0.0534, "points": [{"on": {"group": "payload"}, "mass": 90.7}]},
"springs": [{"on": {"group": "cloth"}, "membrane": {"modulus": 4.3e8, "thickness": 1e-4}, "slack": "tension-only"},
  {"on": {"group": "lines"}, "axial_rigidity": 8000.0, "linear_density": 0.006},
  {"on": {"group": "riser"}, "axial_rigidity": 100000.0, "linear_density": 0.1}],
"gravity": [0, 0, -9.81],
"aero": {"canopy": {"on": {"group": "canopy"}, "schedule": {"drag_area": 42.9, "filling_constant": 8, "exponent": 2},
  "law": {"permeable": {"a": 1.6e6, "b": 4.8e5, "thickness": 1e-4}}},
  "altitude": 1000},
"initial": {"velocity": [0, 0, -45.0]}}},
"time": {"end": 0.1, "method": "newmark", "step": 0.002}}"#;

/// The only fault of a case, and its heading.
fn only_fault(text: &str, sets: &[(String, String)]) -> String {
    match Case::from_text(text.to_owned(), "case.json", PathBuf::new(), sets) {
        Ok(_) => panic!("accepted: {text} {sets:?}"),
        Err(error) => {
            let said = error.to_string();
            assert!(error.faults().len() <= 1, "more than one fault: {said}");
            said
        }
    }
}

#[test]
fn the_cases_here_are_right() {
    for text in [SAIL, CHUTE] {
        let case = Case::from_text(text.to_owned(), "case.json", PathBuf::new(), &[]);
        assert!(case.is_ok(), "{}", case.err().map(|error| error.to_string()).unwrap_or_default());
    }
}

/// The case, what is written in it, what people write in its place, and the words that help. One fault, one message.
const WRONG: &[(&str, &str, &str, &str)] = &[
    // Numbers with quotes, units and commas.
    (CHUTE, "-45.0]", "\"-45\"]", "write the number without quotes: -45"),
    (CHUTE, "\"altitude\": 1000", "\"altitude\": \"1 km\"", "in m this is 1000"),
    (CHUTE, "8.5,", "\"8,5\",", "write a decimal point: 8.5"),
    (CHUTE, "42.9", "\"42.9 m^2\"", "in m^2 this is 42.9"),
    (CHUTE, "90.7", "\"90.7kg\"", "in kg this is 90.7"),
    (SAIL, "1e-2", "\"5 ms\"", "in s this is 0.005"),
    (SAIL, "1e-2", "\"0.002s\"", "in s this is 0.002"),
    (SAIL, "1e-2", "\"5 mm\"", "this one is in s"),
    (SAIL, "1e-2", "0,01", "write a decimal point: 0.01"),
    (SAIL, "1e-2", "5 ms", "in s this is 0.005"),
    (SAIL, "1e-2", "0.002s", "in s this is 0.002"),
    (SAIL, "\"columns\": 4", "\"columns\": \"4\"", "write the number without quotes: 4"),
    (SAIL, "\"newmark\"", "newmark", "in double quotes: \"newmark\""),
    (SAIL, "\"newmark\"", "'newmark'", "a text in double quotes"),
    (SAIL, "\"method\"", "'method'", "in double quotes"),
    // Keys of other names, or at another place.
    (CHUTE, "nominal_diameter", "diameter", "did you mean \"nominal_diameter\"?"),
    (CHUTE, "nominal_diameter", "nominalDiameter", "did you mean \"nominal_diameter\"?"),
    (CHUTE, "nominal_diameter", "D0", "did you mean \"nominal_diameter\"?"),
    (CHUTE, "{\"drag_area\"", "{\"start_time\": 1, \"drag_area\"", "did you mean \"start\"?"),
    (CHUTE, "\"axial_rigidity\": 8000.0", "\"EA\": 8000.0", "did you mean \"axial_rigidity\"?"),
    (CHUTE, "\"modulus\"", "\"youngs_modulus\"", "did you mean \"modulus\"?"),
    (SAIL, "\"step\"", "\"dt\"", "did you mean \"step\"?"),
    (SAIL, "\"step\"", "\"time_step\"", "did you mean \"step\"?"),
    (SAIL, "\"end\"", "\"duration\"", "did you mean \"end\"?"),
    (SAIL, "\"end\"", "\"end_time\"", "did you mean \"end\"?"),
    (SAIL, "\"stiffness\"", "\"k\"", "did you mean \"stiffness\"?"),
    (SAIL, "\"stiffness\"", "\"Stiffness\"", "did you mean \"stiffness\"?"),
    (SAIL, "\"areal_density\"", "\"density\"", "did you mean \"areal_density\"?"),
    (SAIL, "{\"name\": \"sail\"", "{\"gravity\": [0, 0, -9.81], \"name\": \"sail\"", "system.network.gravity"),
    (SAIL, "\"slack\": \"tension-only\"", "\"slack\": \"tension_only\"", "did you mean \"tension-only\"?"),
    (SAIL, "\"reaction\"", "\"reactions\"", "did you mean \"reaction\"?"),
    (SAIL, "\"on\": \"all\", \"stiff", "\"on\": \"cloth\", \"stiff", "{\"group\": \"cloth\"}"),
    // A number or an object where more is needed.
    (SAIL, "{\"every\": 0.05}", "0.05", "for example {\"every\": 0.05}"),
    (SAIL, "\"step\": 1e-2", "\"tolerance\": 1e-3", "for example {\"relative\": 0.001, \"absolute\": ...}"),
    (SAIL, "{\"cp\": 1.2, \"air_density\": 1.225}", "1.0", "\"cp\": 1.0"),
    (SAIL, "{\"axial\": {\"time\": 1e-3}}", "0.01", "for example {\"axial\": {"),
    (SAIL, "{\"time\": 1e-3}", "0.01", "for example {\"coefficient\": 0.01}"),
    (SAIL, "{\"areal_density\": 0.05}", "0.05", "known keys: areal_density, nodal, points"),
    (SAIL, "\"end\": 0.1", "\"end\": 0.1, \"until_rest\": 0.01", "for example {\"speed\": 0.01}"),
    (SAIL, "\"end\": 0.1", "\"end\": 0.1, \"mass_scaling\": 1e-4", "for example {\"step\": 0.0001}"),
    (CHUTE, "{\"length\": 7.21, \"segments\": 2}", "2.4", "for example {\"length\": 2.4}"),
    (CHUTE, "{\"length\": 1.0}", "1.0", "for example {\"length\": 1.0}"),
    (SAIL, "[{\"on\": \"outer\", \"fix\": \"xyz\"}]", "{\"on\": \"outer\", \"fix\": \"xyz\"}", "into a list: [{...}]"),
    (SAIL, "[0, 0, -9.81]", "-9.81", "a vector [x, y, z] of exactly 3 numbers"),
    // Degrees and millimetres.
    (CHUTE, "\"flat-circular\"", "\"conical\", \"cone_angle\": 25", "25 degrees are 0.4363"),
    (CHUTE, "\"flat-circular\"", "\"biconical\", \"cone_angles\": [20, 30]", "20, 30 degrees are 0.3491, 0.5236"),
    (CHUTE, "\"flat-circular\"", "\"extended-skirt\", \"skirt_angle\": 57", "57 degrees are 0.9948"),
    (CHUTE, "8.5,", "8500,", "is nominal_diameter in millimetres? 8500 mm are 8.5 m"),
    (CHUTE, "0.457", "457", "is vent_diameter in millimetres? 457 mm are 0.457 m"),
];

#[test]
fn a_wrong_input_is_told_what_was_meant() {
    for (case, right, wrong, words) in WRONG {
        assert!(case.contains(right), "{right}");
        let said = only_fault(&case.replacen(right, wrong, 1), &[]);
        assert!(said.contains(words), "{wrong}: no {words:?} in\n{said}");
        assert!(!said.contains("1000000000") && !said.contains("3000000000"), "a stand-in in\n{said}");
    }
}

/// Values that cannot be read make no fault elsewhere, whatever they stand for.
#[test]
fn a_value_that_cannot_be_read_is_the_only_fault() {
    let table = r#""wind": {"table": [[0, 0, 0, 10], [1, 0, 0, "a"]]}"#;
    for (case, right, wrong) in [
        (CHUTE, "-45.0]", "true]"),
        (CHUTE, "\"altitude\": 1000", "\"altitude\": \"high\""),
        (CHUTE, "\"lines\": {\"length\": 7.21", "\"lines\": {\"length\": \"long\""),
        (CHUTE, "\"diameter\": 1.2", "\"diameter\": \"small\""),
        (CHUTE, "\"drag_area\": 42.9", "\"drag_area\": \"wide\""),
        (CHUTE, "\"filling_constant\": 8", "\"filling_constant\": \"eight\""),
        (CHUTE, "\"mass\": 90.7", "\"mass\": [90.7]"),
        (SAIL, "\"wind\": [0, 0, 10]", table),
        (SAIL, "\"end\": 0.1", "\"end\": \"soon\""),
        (SAIL, "\"every\": 0.05", "\"every\": \"often\""),
        (SAIL, "\"areal_density\": 0.05", "\"areal_density\": \"light\""),
        (SAIL, "\"width\": 1.0", "\"width\": \"wide\""),
        (SAIL, "\"stiffness\": 100.0", "\"stiffness\": \"stiff\""),
        (SAIL, "\"of\": \"reaction\"", "\"of\": \"weight\""),
        (SAIL, "\"on\": \"outer\"", "\"on\": \"edges\""),
    ] {
        assert!(case.contains(right), "{right}");
        let said = only_fault(&case.replacen(right, wrong, 1), &[]);
        assert!(!said.contains("00000000") && !said.contains("999999"), "a stand-in in\n{said}");
    }
}

/// Assignments of the command line, and the words that help; without any, the value is taken.
#[test]
fn assignments_are_read_as_they_are_meant() {
    for (set, words) in [
        ("stiffness=500", "paths that end so: system.network.springs.0.stiffness"),
        ("dt=1e-3", "paths that end so: time.step"),
        ("step=1e-3", "paths that end so: time.step"),
        ("every=0.1", "paths that end so: output.frames.every"),
        ("tolerance=1e-3", "paths that end so: time.tolerance"),
        ("method=rk4", "paths that end so: time.method"),
        ("sistem.network.gravity=null", "did you mean \"system\"?"),
        ("colour=3", "paths begin with: "),
        ("system.network.spring.0.stiffness=5", "did you mean \"springs\"?"),
        ("system.network.springs[0].stiffness=5", "did you mean system.network.springs.0.stiffness?"),
        ("time.step=0,001", "write a decimal point: 0.001"),
        ("time.step=5ms", "in s this is 0.005"),
        ("time.method='rk4'", "did you mean \"rk4\"?"),
    ] {
        let (key, value) = set.split_once('=').expect("an assignment");
        let said = only_fault(SAIL, &[(key.to_owned(), value.to_owned())]);
        assert!(said.contains(words), "{set}: no {words:?} in\n{said}");
    }
    for (value, step) in [(".001", 1e-3), ("+1e-3", 1e-3), ("5.", 5.0)] {
        let sets = [("time.step".to_owned(), value.to_owned()), ("time.end".to_owned(), "10".to_owned())];
        let case =
            Case::from_text(SAIL.to_owned(), "case.json", PathBuf::new(), &sets).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(case.problem().time.step.fixed(), Some(step), "{value}");
    }
}

/// Words of other programs on the command line.
#[test]
fn commands_and_options_of_other_programs_are_told() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("sail.json"), SAIL).expect("written");
    for (args, words) in [
        (&["run", "sail.json"][..], "'solve'"),
        (&["simulate", "sail.json"], "'solve'"),
        (&["validate", "sail.json"], "'check'"),
        (&["sail.json"], "'solve sail.json'"),
        (&["solve", "sail.json", "--dt", "1e-3"], "'--step'"),
        (&["solve", "sail.json", "--dt=1e-3"], "'--step'"),
        (&["check", "sail.json", "--t_end", "1"], "'--end'"),
        (&["solve", "sail.json", "--output", "x"], "'--out'"),
        (&["solve", "sail.json", "-o", "x"], "'--out'"),
        (&["solve", "sail.json", "--step", "5ms"], "in s this is 0.005"),
        (&["solve", "sail.json", "--end", "0,1"], "write a decimal point: 0.1"),
    ] {
        let run = program_with(folder.path(), args);
        assert_eq!(run.status, Some(2), "{args:?}: {}", run.stderr);
        assert!(run.stderr.contains(words), "{args:?}: no {words:?} in\n{}", run.stderr);
    }
    let run = program_with(folder.path(), &["check", "sail.json", "--tolerance", ".001"]);
    assert_eq!(run.status, Some(0), "{}", run.stderr);
}

/// Moduli, thicknesses and rigidities in other units are warned of, with the unit that would fit; usual ones are not.
#[test]
fn materials_that_no_cloth_has_are_warned_of() {
    let sheet = |modulus: &str, thickness: &str| {
        let springs = SAIL.lines().find(|line| line.contains("springs")).expect("springs");
        let membrane = format!(
            "\"membranes\": [{{\"on\": \"all\", \"thickness\": {thickness}, \"modulus\": {modulus}, \"poisson\": 0.3, \"wrinkling\": true}}],"
        );
        SAIL.replace(springs, &membrane)
    };
    for (text, words) in [
        (CHUTE.replace("4.3e8", "0.43"), Some("membrane/modulus: 0.43 Pa")),
        (CHUTE.replace("4.3e8", "430"), Some("is it in MPa?")),
        (CHUTE.replace("4.3e8", "4.3e14"), Some("4.3e14 Pa")),
        (CHUTE.replace("1e-4", "0.1"), Some("0.1 m, where cloth has 1e-5 to 2e-3 m; is it in mm?")),
        (CHUTE.replace("8000.0", "4"), Some("4 N, where lines have 1e2 to 1e6 N; is it in kN?")),
        (sheet("0.4", "1e-4"), Some("0.4 Pa, where cloth has 1e5 to 1e11 Pa; is it in GPa?")),
        (sheet("4e8", "100"), Some("100 m")),
        (CHUTE.to_owned(), None),
        (sheet("4e8", "1e-4"), None),
        (CHUTE.replace("8000.0", "100").replace("100000.0", "1e10"), None),
        (sheet("1e5", "2e-3"), None),
    ] {
        let case = Case::from_text(text, "case.json", PathBuf::new(), &[]).unwrap_or_else(|e| panic!("{e}"));
        let told: Vec<String> = case.warnings().iter().map(ToString::to_string).collect();
        let of_material: Vec<&String> = told.iter().filter(|text| text.ends_with("[unlikely-material]")).collect();
        match words {
            Some(words) => assert!(of_material.iter().any(|text| text.contains(words)), "no {words:?} in {told:#?}"),
            None => assert!(of_material.is_empty(), "{told:#?}"),
        }
    }
}

/// A rest length a thousand times the edge, of ropes that may be slack too; a reefing line longer than the skirt.
#[test]
fn a_length_in_millimetres_is_told() {
    let text = SAIL.replace("\"stiffness\"", "\"rest_length\": 250.0, \"stiffness\"");
    for (text, words) in [
        (text, "one is a thousand times the other: is it in millimetres?"),
        (
            CHUTE.replace("\"diameter\": 1.2", "\"diameter\": 1200"),
            "is reefing.diameter in millimetres? 1200 mm are 1.2 m",
        ),
    ] {
        let case = Case::from_text(text, "case.json", PathBuf::new(), &[]).unwrap_or_else(|e| panic!("{e}"));
        assert!(case.warnings().iter().any(|w| w.text.contains(words)), "no {words:?} in {:?}", case.warnings());
    }
}
