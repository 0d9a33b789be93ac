//! What a shell, an editor and a terminal get: completions, manual pages, templates with their schema, JSON, colour,
//! lines of a width, and the log.

use crate::bench::{Bench, Ended};
use canopy_fem::integrate::registry::methods;
use serde_json::Value;

/// The program in the bench with variables of the environment.
fn run_with(bench: &Bench, variables: &[(&str, &str)], arguments: &[&str]) -> Ended {
    let output = bench.program().envs(variables.iter().copied()).args(arguments).output().expect("the program starts");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    Ended { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
}

fn done(bench: &Bench, arguments: &[&str]) -> String {
    let ended = bench.run(arguments);
    assert_eq!(ended.code, Some(0), "{arguments:?}: {}", ended.stderr);
    ended.stdout
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|e| panic!("{e}: {text}"))
}

/// Every template runs to its end without a warning, with a good energy error, and `check` finds nothing either.
#[test]
fn templates_run_without_a_warning() {
    let bench = Bench::new();
    let listed = done(&bench, &["init", "--list"]);
    for template in ["canopy", "flag", "drop", "pendulum", "cloth"] {
        assert!(listed.lines().any(|line| line.starts_with(&format!("{template} "))), "{listed}");
        done(&bench, &["init", template, "--template", template]);
        let file = format!("{template}.json");
        let text = std::fs::read_to_string(bench.path(&file)).expect("a case");
        // A parachute is short by its materials; its comments lead to the commands that say the rest.
        let (lines, least) = if template == "drop" { (25, 3) } else { (usize::MAX, 8) };
        assert!(text.lines().filter(|line| line.contains("//")).count() > least, "{template} has few comments");
        assert!(text.lines().count() <= lines, "{template} is long");
        let solved = bench.run(&["solve", &file]);
        assert_eq!((solved.code, solved.stderr.as_str()), (Some(0), ""), "{template}");
        assert!(solved.stdout.contains("exchanged: good (below 1 %)"), "{}", solved.stdout);
        let checked = done(&bench, &["check", &file, "--end", "0.01"]);
        assert!(checked.starts_with(&format!("{template}: no faults\n")), "{checked}");
    }
    // Without a name the case has that of the template.
    done(&bench, &["init", "--template", "drop", "--force"]);
    assert!(bench.run(&["init", "--template", "drop"]).stderr.contains("drop.json exists already"));
    // A template that does not exist, and a list with a name.
    for wrong in [&["init", "x", "--template", "sail"][..], &["init", "x", "--list"], &["init"]] {
        assert_eq!(bench.run(wrong).code, Some(2), "{wrong:?}");
    }
}

/// Commands that do the same kind of work take the same options.
#[test]
fn options_are_the_same_for_all_commands() {
    let bench = Bench::new();
    for (command, options) in [
        ("solve", "--set --threads --quiet --json --out --force"),
        ("static", "--set --threads --quiet --json --out --force"),
        ("check", "--set --threads --quiet --json"),
        ("tradeoff", "--set --threads --quiet --json --out --force"),
        ("sweep", "--set --threads --quiet --json --out --force"),
        ("require", "--set --threads --quiet --json --out --force"),
        ("stability", "--set --threads --quiet --json --out --force"),
        ("plot", "--quiet --out"),
    ] {
        let help = done(&bench, &[command, "--help"]);
        for option in options.split(' ') {
            assert!(help.contains(option), "{command} has no {option}");
        }
    }
}

/// `--json` prints what a study has written, and `--quiet` nothing.
#[test]
fn studies_print_their_results_as_json() {
    let bench = Bench::new();
    let case = format!("{}/assets/cases/oscillator-damped.json", env!("CARGO_MANIFEST_DIR"));
    let studies: [&[&str]; 4] = [
        &["require", "--within", "5%"],
        &["stability", "--methods", "rk4"],
        &["sweep", "--vary", "time.step=0.01,0.02"],
        &["tradeoff", "--methods", "rk4", "--steps", "0.01,0.02"],
    ];
    for study in studies {
        let name = study[0];
        let ended = bench.run(&[study, &[&case, "--out", name, "--quiet"]].concat());
        assert_eq!((ended.code, ended.stdout.as_str(), ended.stderr.as_str()), (Some(0), "", ""), "{name}");
        let printed = done(&bench, &[study, &[&case, "--out", name, "--json", "--force"]].concat());
        let written = std::fs::read_to_string(bench.path(name).join(format!("{name}.json"))).expect("results");
        assert_eq!(printed, written, "{name}");
        assert!(json(&printed).is_object());
    }
    let checked = bench.run(&["check", &case, "--quiet"]);
    assert_eq!((checked.code, checked.stdout.as_str(), checked.stderr.as_str()), (Some(0), "", ""));
    for part in ["--plan", "--shard=1/2"] {
        assert_eq!(
            bench.run(&["sweep", &case, "--vary", "time.step=0.01,0.02", part, "--json"]).code,
            Some(2),
            "{part}"
        );
    }
}

/// The schema that a written case names lies beside it, and is that of `schema`; a file of another kind is left alone.
#[test]
fn an_editor_finds_the_schema() {
    let bench = Bench::new();
    done(&bench, &["init", "mine"]);
    let text = std::fs::read_to_string(bench.path("mine.json")).expect("a case");
    assert!(text.contains("\"$schema\": \"./case.schema.json\""), "{text}");
    let schema = || std::fs::read_to_string(bench.path("case.schema.json")).expect("a schema");
    let expected = done(&bench, &["schema"]);
    assert_eq!(schema(), expected);
    // That of an older version is replaced.
    std::fs::write(bench.path("case.schema.json"), "{\"title\": \"canopy-fem case\"}").expect("written");
    done(&bench, &["init", "other"]);
    assert_eq!(schema(), expected);
    std::fs::write(bench.path("case.schema.json"), "{\"title\": \"mine\"}").expect("written");
    done(&bench, &["init", "third"]);
    assert_eq!(schema(), "{\"title\": \"mine\"}");
}

/// Completions know every command and the flags, for every shell; bash takes them.
#[test]
fn shells_complete_every_command() {
    let bench = Bench::new();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = done(&bench, &["completions", shell]);
        for word in
            ["solve", "check", "tradeoff", "stability", "plot", "mesh", "methods", "init", "accuracy", "template"]
        {
            assert!(script.contains(word), "{shell}: no {word}");
        }
    }
    std::fs::write(bench.path("c.bash"), done(&bench, &["completions", "bash"])).expect("written");
    let ask = "source c.bash; complete=$(complete -p canopy-fem | sed 's/.* -F \\([^ ]*\\) .*/\\1/'); \
               COMP_WORDS=(canopy-fem trade); COMP_CWORD=1; $complete canopy-fem trade canopy-fem; echo ${COMPREPLY[@]}";
    let bash = std::process::Command::new("bash").current_dir(bench.path("")).args(["-c", ask]).output();
    if let Ok(answer) = bash {
        assert_eq!(String::from_utf8_lossy(&answer.stdout).trim(), "tradeoff");
    }
}

/// There is a page for the program and for each command, with its options and, where it can fail, its exit status.
#[test]
fn every_command_has_a_manual_page() {
    let bench = Bench::new();
    done(&bench, &["man", "pages/man1"]);
    let page = |name: &str| std::fs::read_to_string(bench.path(&format!("pages/man1/{name}.1"))).expect(name);
    for (name, words) in [
        ("canopy-fem", &["Parachute canopies", "130"][..]),
        ("canopy-fem-solve", &["\\-\\-dump\\-matrices", "good below 1 %", "could not be solved"]),
        ("canopy-fem-check", &["\\-\\-within", "\\-\\-all"]),
        ("canopy-fem-mesh-inspect", &["\\-\\-json"]),
        ("canopy-fem-init", &["flag", "case.schema.json"]),
    ] {
        let text = page(name);
        for word in words {
            assert!(text.contains(word) || text.contains(&word.replace("\\-", "-")), "{name}: no {word} in {text}");
        }
    }
    // A folder that cannot be made.
    std::fs::write(bench.path("file"), "").expect("written");
    assert_eq!(bench.run(&["man", "file/man1"]).code, Some(1));
}

/// The version names the package's, and the commit if the program was built in its repository.
#[test]
fn the_version_names_the_commit() {
    let bench = Bench::new();
    let text = done(&bench, &["--version"]);
    let rest = text.trim().strip_prefix(concat!("canopy-fem ", env!("CARGO_PKG_VERSION"))).expect("the version");
    let commit = rest.trim().trim_start_matches('(').trim_end_matches(')').trim_end_matches(" with changes");
    assert!(rest.is_empty() || commit.len() >= 7 && commit.chars().all(|c| c.is_ascii_hexdigit()), "{text}");
    let repository = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(".git").exists();
    let git = std::process::Command::new("git").arg("--version").output().is_ok();
    assert_eq!(!rest.is_empty(), repository && git, "{text}");
}

/// Exit statuses stand below the help of the program and of the commands that have several.
#[test]
fn help_tells_the_exit_status() {
    let bench = Bench::new();
    for command in [&["--help"][..], &["solve", "--help"], &["check", "-h"], &["tradeoff", "--help"]] {
        let text = done(&bench, command);
        let lines: Vec<&str> = text.lines().skip_while(|line| *line != "Exit status:").skip(1).collect();
        let codes: Vec<&str> = lines.iter().filter_map(|line| line.split_whitespace().next()).collect();
        assert_eq!(codes, ["0", "1", "2", "3", "130"], "{text}");
    }
}

/// `--json` prints data and nothing else: the summary as in the file, the methods as in the registry, a mesh's counts.
#[test]
fn json_is_the_whole_output() {
    let bench = Bench::new();
    let solved = json(&bench.solve(&["--json"]).stdout);
    assert_eq!(solved, bench.results().summary());
    assert_eq!(solved["status"], "completed");
    // Quiet silences the messages, not the data; a run that is done already has its summary too.
    let quiet = bench.solve(&["--json", "--quiet", "--force", "--set", "output.checkpoint.every=0.5"]);
    assert_eq!((json(&quiet.stdout)["steps"].clone(), quiet.stderr.as_str()), (solved["steps"].clone(), ""));
    let again = bench.solve(&["--json", "--resume", "--set", "output.checkpoint.every=0.5"]);
    assert_eq!(json(&again.stdout), bench.results().summary(), "{}", again.stderr);
    // A failed run, with its status.
    let failed = bench.solve(&["--json", "--force", "--method", "explicit-euler", "--step", "0.2", "--end", "100"]);
    assert_eq!((failed.code, &json(&failed.stdout)["status"]), (Some(3), &Value::from("diverged")));

    let all = json(&done(&bench, &["methods", "--json"]));
    let names: Vec<&str> = all.as_array().expect("a list").iter().filter_map(|m| m["name"].as_str()).collect();
    assert_eq!(names, methods().iter().map(|m| m.name).collect::<Vec<_>>());
    let newmark = all.as_array().and_then(|all| all.iter().find(|m| m["name"] == "newmark")).expect("newmark");
    assert_eq!((&newmark["order"], &newmark["family"]), (&Value::from(2), &Value::from("implicit")));
    assert_eq!(newmark["parameters"][0]["default"], 0.25);

    done(
        &bench,
        &["mesh", "rectangle", "--width", "2", "--height", "1", "--columns", "4", "--rows", "2", "-o", "m.vtu"],
    );
    let mesh = json(&done(&bench, &["mesh", "inspect", "m.vtu", "--json"]));
    assert_eq!((&mesh["nodes"], &mesh["triangles"], &mesh["edges"]["boundary"]), (&15.into(), &16.into(), &12.into()));
    assert_eq!((&mesh["area"]["all"], &mesh["loops"][0]["nodes"]), (&Value::from(2.0), &12.into()));
    let right = mesh["angle"]["max"].as_f64().expect("an angle");
    assert!(mesh["notes"].as_array().is_some_and(Vec::is_empty) && (right - 90.0).abs() < 1e-9, "{mesh}");
}

/// Colour only where it is asked for, and never with `NO_COLOR`; the words are the same.
#[test]
fn colour_is_for_terminals() {
    let bench = Bench::new();
    let wrong = ["solve", "sail.json", "--step", "0"];
    let plain = bench.run(&wrong);
    assert!(plain.stderr.starts_with("error: ") && !plain.stderr.contains('\x1b'), "{}", plain.stderr);
    let forced = run_with(&bench, &[("CLICOLOR_FORCE", "1")], &wrong);
    assert!(forced.stderr.starts_with("\x1b[") && forced.stderr.contains("error:\x1b[0m"), "{:?}", forced.stderr);
    let none = run_with(&bench, &[("NO_COLOR", "1")], &wrong);
    assert_eq!(none.stderr, plain.stderr);
    let solved = run_with(&bench, &[("CLICOLOR_FORCE", "1")], &["solve", "sail.json", "--out", "out"]);
    assert!(solved.stdout.contains("\x1b[32mgood\x1b[0m"), "{:?}", solved.stdout);
    let data = run_with(
        &bench,
        &[("CLICOLOR_FORCE", "1"), ("COLUMNS", "50")],
        &["solve", "sail.json", "--out", "o", "--json"],
    );
    assert_eq!(json(&data.stdout)["status"], "completed");
}

/// Lines end at the width, with the same words in the same order; quoted lines of a case are not broken.
#[test]
fn lines_are_wrapped_to_the_width() {
    let bench = Bench::new();
    for arguments in [
        &[
            "solve",
            "sail.json",
            "--out",
            "out",
            "--force",
            "--method",
            "explicit-euler",
            "--step",
            "0.2",
            "--end",
            "100",
        ][..],
        &["check", "sail.json"],
        &["mesh", "inspect", "no.inp"],
    ] {
        let wide = bench.run(arguments);
        for width in [80, 120] {
            let ended = run_with(&bench, &[("COLUMNS", &width.to_string())], arguments);
            for (text, whole) in [(&ended.stdout, &wide.stdout), (&ended.stderr, &wide.stderr)] {
                let long = text.lines().find(|line| line.chars().count() > width);
                assert_eq!(long, None, "{arguments:?} at {width}");
                // Seconds differ from run to run.
                let words = |text: &str| {
                    text.split_whitespace()
                        .filter(|w| !w.contains(|c: char| c.is_ascii_digit()))
                        .map(str::to_owned)
                        .collect::<Vec<_>>()
                };
                if arguments[0] != "check" {
                    assert_eq!(words(text), words(whole), "{arguments:?} at {width}");
                }
            }
        }
    }
    let help = run_with(&bench, &[("COLUMNS", "80")], &["solve", "--help"]).stdout;
    assert!(help.lines().all(|line| line.chars().count() <= 80), "{help}");
}

/// The log has phases and the solver, with -vv factorisations too; without -v there is none, and results are the same.
#[test]
fn the_log_tells_phases_and_solvers() {
    let bench = Bench::new();
    let newmark = ["--method", "newmark", "--force"];
    let silent = bench.solve(&newmark);
    let once = bench.solve(&[&newmark[..], &["-v"]].concat());
    let twice = bench.solve(&[&newmark[..], &["-vv"]].concat());
    let log =
        |text: &str| text.lines().filter(|line| !line.starts_with("warning: ")).map(str::to_owned).collect::<Vec<_>>();
    assert_eq!(log(&silent.stderr), Vec::<String>::new());
    for words in [
        "case read in ",
        "scene built in ",
        "first force pass in ",
        "matrix pattern found in ",
        "linear solver at the end: ",
    ] {
        assert!(once.stderr.contains(words), "no {words} in {}", once.stderr);
    }
    assert!(log(&once.stderr).iter().all(|line| line.starts_with('[') && line.contains(" s] ")), "{}", once.stderr);
    let count = |text: &str| text.lines().filter(|line| line.contains("] factorisation in ")).count();
    assert!(count(&once.stderr) == 0 && count(&twice.stderr) > 0, "{}", twice.stderr);
    let words = |text: &str| text.lines().find(|line| line.contains("energy error")).map(str::to_owned);
    assert_eq!(words(&silent.stdout), words(&twice.stdout));
}
