use super::*;

/// A tube of this length and radius [m] that is closed above, of six rings with twelve corners.
fn tube(length: f64, radius: f64) -> (Stations, Vec<Vector3<f64>>) {
    let (rings, corners) = (6_u32, 12_u32);
    let mut x = vec![Vector3::zeros()];
    let ring = |j: u32| (0..corners).map(move |i| 1 + j * corners + i).collect::<Vec<u32>>();
    for j in 0..rings {
        let z = -length * f64::from(j) / f64::from(rings - 1);
        x.extend((0..corners).map(|i| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / f64::from(corners)).sin_cos();
            Vector3::new(radius * cos, radius * sin, z)
        }));
    }
    let next = |list: &[u32], i: usize| list[(i + 1) % list.len()];
    let mut loops = vec![vec![0]];
    loops.extend((0..rings).map(ring));
    let mut bands = vec![(0..12).map(|i| [0, loops[1][i], next(&loops[1], i)]).collect::<Vec<[u32; 3]>>()];
    for pair in loops[1..].windows(2) {
        let (above, below) = (&pair[0], &pair[1]);
        let faces =
            (0..12).flat_map(|i| [[above[i], below[i], next(below, i)], [above[i], next(below, i), next(above, i)]]);
        bands.push(faces.collect());
    }
    (Stations::new(loops, bands, &x, 1.0), x)
}

/// A tube free to widen takes what the stream brings, A V = dVol/dt: r = r0 e^(V t/(2 l)).
#[test]
fn a_tube_free_to_widen() {
    let (length, speed, end, steps) = (3.0, 25.0, 0.4, 200);
    let (stations, start) = tube(length, 0.2);
    let widened = |scale: f64| start.iter().map(|x| Vector3::new(scale * x.x, scale * x.y, x.z)).collect::<Vec<_>>();
    let flat = |x: &Vector3<f64>| Vector3::new(x.x, x.y, 0.0);
    // The rate of the scale at which the air enters at the speed of the stream.
    let growth = |scale: f64| {
        let v: Vec<Vector3<f64>> = start.iter().map(flat).collect();
        let measured = stations.measure(NodeVectors::Nodes(&widened(scale)), NodeVectors::Nodes(&v));
        let mouth = stations.bands();
        speed * measured.area[mouth] / measured.rate[mouth]
    };
    let h = end / f64::from(steps);
    let mut scale = 1.0;
    for _ in 0..steps {
        let k1 = growth(scale);
        let k2 = growth(scale + 0.5 * h * k1);
        let k3 = growth(scale + 0.5 * h * k2);
        let k4 = growth(scale + h * k3);
        scale += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    }
    let expected = (speed * end / (2.0 * length)).exp();
    assert!((scale / expected - 1.0).abs() < 1e-9, "{scale} {expected}");
}
