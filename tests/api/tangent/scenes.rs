//! The list of terms.

use crate::common::{patch, spring_group};
use canopy_fem::mesh::Mesh;
use canopy_fem::model::spec::*;

fn with_dashpots(slack: Slack, kind: DashpotKind) -> NetworkSpec {
    let mut spec = patch();
    let mut group = spring_group(&spec, slack);
    let coefficient = (0..group.edges.len()).map(|i| 5.0 + i as f64).collect();
    group.dashpot = Some(DashpotSpec { kind, coefficient, from_step: false });
    spec.springs = vec![group];
    spec
}

fn with_springs(slack: Slack) -> NetworkSpec {
    let mut spec = patch();
    spec.springs = vec![spring_group(&spec, slack)];
    spec
}

/// Two materials on half of the triangles each.
fn membranes(wrinkling: bool, damping_time: f64, orthotropic: bool) -> Vec<MembraneSpec> {
    let all = 0..patch().mesh.triangles.len() as u32;
    let (even, odd): (Vec<u32>, Vec<u32>) = all.partition(|t| t % 2 == 0);
    let modulus = if orthotropic { [4e4, 1.5e4] } else { [3e4; 2] };
    let shear = if orthotropic { 4e3 } else { 3e4 / 2.6 };
    let spec = MembraneSpec {
        triangles: even,
        thickness: 1e-3,
        modulus,
        poisson: 0.3,
        shear,
        warp: orthotropic.then_some([1.0, 0.4, 0.3]),
        wrinkling,
        damping_time,
        strength: None,
    };
    vec![spec.clone(), MembraneSpec { triangles: odd, thickness: 2e-3, ..spec }]
}

fn air(linear: f64, quadratic: f64) -> NetworkSpec {
    let wind = Series { t: vec![0.0, 1.0], value: vec![[1.0, -2.0, 4.0], [3.0, 0.5, -6.0]] };
    NetworkSpec { air: Some(AirSpec { linear, quadratic, wind }), ..patch() }
}

fn pressure(kind: PressureKind) -> NetworkSpec {
    let factor = Some(Series { t: vec![0.0, 2.0], value: vec![0.5, 1.5] });
    let load = PressureLoad { triangles: vec![0, 1, 4, 7], pressure: 30.0, kind, factor };
    NetworkSpec { pressures: vec![load], ..patch() }
}

/// A wind with a gust, over a table.
fn stream() -> StreamSpec {
    let wind = Series { t: vec![0.0, 1.0], value: vec![[1.0, -2.0, 4.0], [3.0, 0.5, -6.0]] };
    let gusts = vec![GustSpec { velocity: [0.5, 1.0, -2.0], start: -3.0, duration: 8.0 }];
    StreamSpec { gusts, ..StreamSpec::of_wind(wind) }
}

/// The same, with a wind and a density that change over the height.
fn uneven_stream() -> StreamSpec {
    let profile = Series { t: vec![-9.0, 11.0], value: vec![[-4.0, 1.0, 2.0], [3.0, -2.0, -5.0]] };
    let atmosphere = AtmosphereSpec::Exponential { density: 1.3, scale_height: 3.0 };
    StreamSpec { profile: Some(profile), atmosphere, altitude: 0.7, ..stream() }
}

fn canopy() -> Vec<CanopySpec> {
    let triangles: Vec<u32> = (0..6).collect();
    let pressure_coefficient = triangles.iter().map(|&t| 1.0 + 0.3 * f64::from(t)).collect();
    let (skirt, apex, confluence) = (vec![2, 5, 7], vec![0, 1], vec![8]);
    vec![CanopySpec {
        triangles,
        pressure_coefficient,
        skirt,
        apex,
        confluence,
        air: CanopyAir::Coefficient,
        apparent_mass: None,
        inflow_loss: None,
        glide: None,
        nominal_area: 1.0,
    }]
}

/// The same while it fills.
fn filling_canopy() -> Vec<CanopySpec> {
    let stage =
        |drag_area, start| FillingSpec { drag_area, start, duration: 9.0, exponent: 2.0, by_speed: false, event: None };
    let filling = vec![stage(2.5, -4.0), stage(7.0, -1.0)];
    canopy().into_iter().map(|one| CanopySpec { air: CanopyAir::Filling(filling.clone()), ..one }).collect()
}

/// One of these with a loss at its mouth.
fn losing(canopies: Vec<CanopySpec>) -> Vec<CanopySpec> {
    canopies.into_iter().map(|one| CanopySpec { inflow_loss: Some(1.3), ..one }).collect()
}

/// The same with a balance at its mouth.
fn cavity(cloth: Option<[f64; 2]>) -> Vec<CanopySpec> {
    let cloth = cloth.map(|[linear, quadratic]| ClothSpec { linear, quadratic });
    let air = CanopyAir::Cavity(CavitySpec { inflow: 0.7, outer_pressure_coefficient: -0.6, cloth });
    let one = |one: CanopySpec| {
        let pressure_coefficient = vec![1.0; one.triangles.len()];
        CanopySpec { pressure_coefficient, air: air.clone(), ..one }
    };
    canopy().into_iter().map(one).collect()
}

fn line_drag() -> Vec<LineDragSpec> {
    vec![LineDragSpec { edges: vec![0, 3, 4, 9], diameter: 0.2, coefficient: 1.1 }]
}

fn node_drag() -> Vec<NodeDragSpec> {
    vec![NodeDragSpec { nodes: vec![1, 4, 6], drag_area: 0.4, glide: None }]
}

/// The same with a lift whose heading changes.
fn gliding() -> Vec<NodeDragSpec> {
    let heading = Series { t: vec![0.0, 1.0], value: vec![-70.0, 230.0] };
    let glide = Some(GlideSpec { ratio: 2.3, heading });
    node_drag().into_iter().map(|one| NodeDragSpec { glide: glide.clone(), ..one }).collect()
}

/// A canopy that is a node, and glides.
fn gliding_point() -> Vec<CanopySpec> {
    let heading = Series { t: vec![0.0], value: vec![40.0] };
    let point = |one: CanopySpec| CanopySpec {
        triangles: Vec::new(),
        pressure_coefficient: Vec::new(),
        air: CanopyAir::Point(one.air.stages().to_vec()),
        skirt: vec![4],
        apex: vec![4],
        confluence: vec![4],
        glide: Some(GlideSpec { ratio: 1.7, heading: heading.clone() }),
        ..one
    };
    filling_canopy().into_iter().map(point).collect()
}

/// A closed surface, one corner of which is held.
fn octahedron() -> Mesh {
    let around = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]];
    let nodes = around.into_iter().chain([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]).collect();
    let side = |i: u32| [[i, (i + 1) % 4, 4], [(i + 1) % 4, i, 5]];
    Mesh { nodes, triangles: (0..4).flat_map(side).collect(), ..Mesh::default() }
}

/// Its upper half, which is open below.
fn pyramid() -> Mesh {
    let whole = octahedron();
    let triangles = whole.triangles.iter().copied().filter(|corners| corners.contains(&4)).collect();
    Mesh { nodes: whole.nodes[..5].to_vec(), triangles, ..whole }
}

fn gas_of(triangles: u32) -> GasSpec {
    let fill = GasFill::Pressure(Series { t: vec![0.0], value: vec![6.0] });
    GasSpec { triangles: (0..triangles).collect(), ambient: 20.0, gamma: 1.3, volume: None, fill }
}

/// Gas in a surface whose lower nodes are held, or one of them.
fn gas(mesh: Mesh, gas: GasSpec) -> NetworkSpec {
    let nodes = mesh.nodes.len();
    let held = |i: usize| i == 0 || nodes == 5 && i < 4;
    let fixed = (0..nodes).map(|i| [held(i); 3]).collect();
    NetworkSpec { mesh, mass: vec![0.4; nodes], fixed, gases: vec![gas], ..NetworkSpec::default() }
}

/// Two zones, one of which has a coefficient over the angle.
fn surface_pressures() -> Vec<SurfacePressureSpec> {
    let table = Series { t: vec![0.0, 0.9, 2.0, 3.1], value: vec![0.8, -0.5, -1.2, -0.3] };
    let constant = Series { t: vec![0.0], value: vec![-0.7] };
    let zone = |triangles: &[u32], coefficient| SurfacePressureSpec { triangles: triangles.to_vec(), coefficient };
    vec![zone(&[0, 3, 4, 6], table), zone(&[1, 7], constant)]
}

/// Terms whose forces also change with the height, and gas over a rim that does not move.
pub fn uneven_scenes() -> Vec<(&'static str, NetworkSpec)> {
    let air = |spec: NetworkSpec| NetworkSpec { stream: Some(uneven_stream()), ..spec };
    vec![
        ("canopy in uneven air", air(NetworkSpec { canopies: canopy(), ..patch() })),
        ("filling canopy in uneven air", air(NetworkSpec { canopies: filling_canopy(), ..patch() })),
        ("canopy with an inflow loss in uneven air", air(NetworkSpec { canopies: losing(canopy()), ..patch() })),
        ("filling canopy with an inflow loss", air(NetworkSpec { canopies: losing(filling_canopy()), ..patch() })),
        ("cavity of tight cloth in uneven air", air(NetworkSpec { canopies: cavity(None), ..patch() })),
        ("cavity of porous cloth in uneven air", air(NetworkSpec { canopies: cavity(Some([3.0, 0.8])), ..patch() })),
        ("cavity of viscous cloth in uneven air", air(NetworkSpec { canopies: cavity(Some([12.0, 0.0])), ..patch() })),
        ("cavity of inertial cloth in uneven air", air(NetworkSpec { canopies: cavity(Some([0.0, 9.0])), ..patch() })),
        ("gas on the ground", gas(pyramid(), GasSpec { volume: Some(0.9), ..gas_of(4) })),
        ("surface pressure in uneven air", air(NetworkSpec { surface_pressures: surface_pressures(), ..patch() })),
        ("line drag in uneven air", air(NetworkSpec { line_drag: line_drag(), ..patch() })),
        ("node drag in uneven air", air(NetworkSpec { node_drag: node_drag(), ..patch() })),
        ("gliding nodes in uneven air", air(NetworkSpec { node_drag: gliding(), ..patch() })),
        ("gliding point in uneven air", air(NetworkSpec { canopies: gliding_point(), ..patch() })),
    ]
}

/// Every term, alone in a scene, with its name.
pub fn scenes() -> Vec<(&'static str, NetworkSpec)> {
    let slacks = [
        ("plain", Slack::None),
        ("tension-only", Slack::TensionOnly),
        ("dead zone", Slack::DeadZone { eps: 0.11 }),
        ("compression limit", Slack::CompressionLimit { eps: 0.13 }),
        ("compression-only", Slack::CompressionOnly),
    ];
    let mut list = Vec::new();
    for (name, slack) in slacks {
        list.push((name, with_springs(slack)));
        list.push((name, with_dashpots(slack, DashpotKind::Axial)));
    }
    for (name, slack, kind) in [
        ("reeled", Slack::None, None),
        ("reeled, tension-only", Slack::TensionOnly, Some(DashpotKind::Axial)),
        ("reeled, compression limit", Slack::CompressionLimit { eps: 0.13 }, Some(DashpotKind::Relative)),
    ] {
        let mut spec = kind.map_or_else(|| with_springs(slack), |kind| with_dashpots(slack, kind));
        spec.springs[0].rest_scale = Some(Series { t: vec![0.0, 1.0], value: vec![0.8, 1.15] });
        list.push((name, spec));
    }
    let factor = Series { t: vec![0.0, 1.0], value: vec![1.0, 0.85] };
    for (name, law) in [
        ("green bars", ElasticLaw::Green),
        ("tabled bars", ElasticLaw::Table(vec![[-0.5, -20.0], [-0.1, -9.0], [0.0, 0.0], [0.15, 2.0], [0.4, 60.0]])),
    ] {
        let with_law = |mut spec: NetworkSpec| {
            spec.springs[0].law = law.clone();
            spec
        };
        for (_, slack) in slacks {
            list.push((name, with_law(with_dashpots(slack, DashpotKind::Axial))));
        }
        let mut reeled = with_law(with_springs(Slack::TensionOnly));
        reeled.springs[0].rest_scale = Some(factor.clone());
        list.push((name, reeled));
    }
    list.push(("relative dashpots", with_dashpots(Slack::TensionOnly, DashpotKind::Relative)));
    let rayleigh = Some(RayleighSpec { mass: 0.7, stiffness: 0.02 });
    list.push(("rayleigh", NetworkSpec { rayleigh, ..with_springs(Slack::TensionOnly) }));
    for (name, wrinkling, damping_time) in [
        ("sheet", false, 0.0),
        ("damped sheet", false, 0.03),
        ("wrinkling", true, 0.0),
        ("damped wrinkling", true, 0.03),
    ] {
        for orthotropic in [false, true] {
            list.push((name, NetworkSpec { membranes: membranes(wrinkling, damping_time, orthotropic), ..patch() }));
        }
    }
    let spec = NetworkSpec { membranes: membranes(true, 0.0, true), ..patch() };
    list.push(("rayleigh of a membrane", NetworkSpec { rayleigh, ..spec }));
    let bend = BendingSpec {
        hinges: vec![[4, 0, 1, 3], [4, 8, 5, 7]],
        stiffness: 0.7,
        chains: vec![[0, 1, 2], [6, 4, 2]],
        flexural_rigidity: 0.9,
    };
    list.push(("bending", NetworkSpec { bending: vec![bend], ..patch() }));
    list.push(("gravity", NetworkSpec { gravity: Some([1.0, -2.0, -9.81]), ..patch() }));
    list.push(("viscous air", air(3.0, 0.0)));
    list.push(("inertial air", air(0.0, 2.0)));
    list.push(("porous air", air(1.5, 2.5)));
    list.push(("follower pressure", pressure(PressureKind::Follower)));
    list.push(("dead pressure along a direction", pressure(PressureKind::Dead(Some([0.0, 0.6, 0.8])))));
    list.push(("snow", pressure(PressureKind::Plan([0.0, 0.6, -0.8]))));
    list.push(("dead pressure along the first normal", pressure(PressureKind::Dead(None))));
    let base_acceleration = Some(Series { t: vec![0.0, 1.0], value: vec![[1.0, -2.0, 4.0], [3.0, 0.5, -6.0]] });
    list.push(("base acceleration", NetworkSpec { base_acceleration, ..patch() }));
    let forces = vec![NodalLoad { nodes: vec![3, 8], force: [1.0, 2.0, 3.0], factor: None }];
    list.push(("nodal forces", NetworkSpec { forces, ..patch() }));
    let air = |spec: NetworkSpec| NetworkSpec { stream: Some(stream()), ..spec };
    list.push(("canopy", air(NetworkSpec { canopies: canopy(), ..patch() })));
    list.push(("inflow loss", air(NetworkSpec { canopies: losing(canopy()), ..patch() })));
    list.push(("cavity", air(NetworkSpec { canopies: cavity(Some([3.0, 0.8])), ..patch() })));
    for (name, gamma, fill) in [
        ("gas by its pressure", 1.4, GasFill::Pressure(Series { t: vec![0.0, 1.0], value: vec![4.0, 9.0] })),
        ("gas by its amount", 1.0, GasFill::Amount(Series { t: vec![0.0, 1.0], value: vec![1.0, 1.9] })),
    ] {
        list.push((name, gas(octahedron(), GasSpec { gamma, fill, ..gas_of(8) })));
    }
    list.push(("surface pressure", air(NetworkSpec { surface_pressures: surface_pressures(), ..patch() })));
    list.push(("line drag", air(NetworkSpec { line_drag: line_drag(), ..patch() })));
    list.push(("node drag", air(NetworkSpec { node_drag: node_drag(), ..patch() })));
    list.push(("gliding nodes", air(NetworkSpec { node_drag: gliding(), ..patch() })));
    list
}
