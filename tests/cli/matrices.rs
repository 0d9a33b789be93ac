//! `--dump-matrices`: what a user reads in another program is M, -df/dv and -df/dx.

use std::path::{Path, PathBuf};

use canopy_fem::case::Case;
use canopy_fem::model::state::State;
use canopy_fem::scene::Scene;
use canopy_fem::simulation::build_scene;

use crate::bench::{Bench, SAIL};

/// A dense matrix from a MatrixMarket file.
fn matrix(path: &Path) -> Vec<Vec<f64>> {
    let triplets = sprs::io::read_matrix_market::<f64, usize, _>(path).expect("a MatrixMarket file");
    let mut dense = vec![vec![0.0; triplets.cols()]; triplets.rows()];
    for (&value, (i, j)) in triplets.triplet_iter() {
        dense[i][j] += value;
    }
    dense
}

/// Node and axis of every row, as `unknowns.csv` tells.
fn unknowns(folder: &Path) -> Vec<(u32, String)> {
    let text = std::fs::read_to_string(folder.join("unknowns.csv")).expect("a file");
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("unknown,node,axis"));
    let row = |(i, line): (usize, &str)| {
        let cells: Vec<&str> = line.split(',').collect();
        assert_eq!(cells[0], i.to_string());
        (cells[1].parse().expect("a node"), cells[2].to_owned())
    };
    lines.enumerate().map(row).collect()
}

/// One mass, one spring, one dashpot: m, c and k themselves.
#[test]
fn an_oscillators_matrices_are_its_three_numbers() {
    let bench = Bench::new();
    let case = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/cases/oscillator-damped.json");
    let case = case.to_str().expect("UTF-8");
    let ended = bench.run(&["solve", case, "--out", "out", "--end", "0.1", "--dump-matrices", "m"]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    for (name, value) in [("M", 2.0), ("C", 0.5), ("K", 3.0)] {
        assert_eq!(matrix(&bench.path("m").join(format!("{name}.mtx"))), [[value]], "{name}");
    }
    assert_eq!(unknowns(&bench.path("m")), [(1, "x".to_owned())]);
}

/// -df/dx (or -df/dv) of the sail at its start by central differences, in the order of `dofs`.
fn difference(scene: &dyn Scene, dofs: &[usize], move_by: fn(&mut State, usize, f64)) -> Vec<Vec<f64>> {
    let d = 1e-6;
    let mut columns = Vec::new();
    for &j in dofs {
        let force = |by: f64| {
            let (mut state, mut forces) = (scene.initial_state(), scene.new_forces());
            move_by(&mut state, j, by);
            scene.evaluate(state.as_ref(), &mut forces);
            forces.total
        };
        let (plus, minus) = (force(d), force(-d));
        columns.push(dofs.iter().map(|&i| -(plus[i] - minus[i]) / (2.0 * d)).collect());
    }
    columns
}

/// On a net with every kind of term the files hold the differences of the forces, in the order `unknowns.csv` tells.
#[test]
fn the_sails_matrices_are_the_differences_of_its_forces() {
    let bench = Bench::new();
    let moved = "system.network.initial={\"displacement\":[0.1,0.05,0.2],\"velocity\":[0.3,0.1,-0.4]}";
    let ended = bench.solve(&["--end", "0.01", "--dump-matrices", "m", "--set", moved]);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let folder = bench.path("m");
    let (key, value) = moved.split_once('=').expect("a pair");
    let overrides = [(key.to_owned(), value.to_owned())];
    let mut problem =
        Case::from_text(SAIL.to_owned(), "sail.json", PathBuf::new(), &overrides).expect("good").into_problem();
    let scene = build_scene(problem.take_system(), 1).expect("good");
    let named = |dof: usize| {
        let (node, axis) = scene.name_of(dof);
        (node, axis.to_owned())
    };
    let place = |name: &(u32, String)| (0..scene.n_dof()).find(|&dof| &named(dof) == name).expect("a dof of that name");
    let dofs: Vec<usize> = unknowns(&folder).iter().map(place).collect();
    assert_eq!(dofs.len(), 12);

    let expected = [
        ("K", difference(&*scene, &dofs, |state, j, by| state.x[j] += by)),
        ("C", difference(&*scene, &dofs, |state, j, by| state.v[j] += by)),
    ];
    for (name, columns) in expected {
        let found = matrix(&folder.join(format!("{name}.mtx")));
        let size = columns.iter().flatten().fold(0.0, |m: f64, v| m.max(v.abs()));
        for (i, row) in found.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                let error = (value - columns[j][i]).abs();
                // Central differences with 1e-6: rounding of forces of 1e2 N over 2e-6 m, relative to a stiffness of
                // 1e2 N/m.
                assert!(error < 1e-7 * size, "{name}[{i}][{j}] = {value}, differences give {}", columns[j][i]);
            }
        }
    }
    let mass = matrix(&folder.join("M.mtx"));
    for (i, &dof) in dofs.iter().enumerate() {
        for (j, value) in mass[i].iter().enumerate() {
            let expected = if i == j { 1.0 / scene.inverse_mass()[dof] } else { 0.0 };
            assert!((value - expected).abs() < 1e-15, "M[{i}][{j}] = {value}");
        }
    }
}
