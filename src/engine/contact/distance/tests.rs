use super::*;
use crate::mesh::random::SplitMix64;

const KINDS: [PairKind; 4] = [PairKind::NodeNode, PairKind::NodeEdge, PairKind::NodeTriangle, PairKind::EdgeEdge];

fn random(draw: &mut SplitMix64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| 2.0 * draw.uniform() - 1.0)
}

/// Of {-1, 0, 1}^3: many pairs that cross, touch, are parallel, or without length or area.
fn snapped(draw: &mut SplitMix64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| (draw.draw() % 3) as f64 - 1.0)
}

/// A pair of the kind that trial `n` has: general, on a grid, a grid with rounding, flat or thin.
fn pair(draw: &mut SplitMix64, n: usize) -> [Vector3<f64>; 4] {
    let noise = [0.0, 1e-15, 1e-12, 1e-8, 1e-4][n / 3 % 5];
    std::array::from_fn(|_| match n % 3 {
        0 => random(draw),
        1 => snapped(draw) + random(draw) * noise,
        _ => snapped(draw).component_mul(&Vector3::new(1.0, 1.0, noise)) * 0.3,
    })
}

fn weighted(w: &[f64; 4], x: &[Vector3<f64>; 4]) -> Vector3<f64> {
    w.iter().zip(x).map(|(w, x)| x * *w).sum()
}

/// [m] a bound of the distance from below: elements are convex, so the slab normal to n that no node enters parts them
fn parted(kind: PairKind, x: &[Vector3<f64>; 4], n: &Vector3<f64>) -> f64 {
    let (first, second) = x[..kind.nodes()].split_at(kind.nodes_of_first());
    let pairs = first.iter().flat_map(|a| second.iter().map(move |b| (a - b).dot(n)));
    pairs.fold(f64::INFINITY, f64::min)
}

/// [m] the widest slab normal to r, to r without its part along an edge, or to two edges
fn widest_slab(kind: PairKind, x: &[Vector3<f64>; 4], r: &Vector3<f64>) -> f64 {
    let nodes = [(1, 0), (2, 1), (3, 2), (1, 3), (2, 3)];
    let edges = nodes.map(|(a, b)| x[a] - x[b]);
    let edges = &edges[..if kind.nodes() == 4 { 5 } else { kind.nodes() - 1 }];
    let off = edges.iter().map(|e| r - e * (r.dot(e) / e.norm_squared()));
    let across = edges.iter().flat_map(|a| edges.iter().map(move |b| a.cross(b)));
    let normals = std::iter::once(*r).chain(off).chain(across).map(|n| n.normalize());
    normals.filter(|n| n.x.is_finite()).map(|n| parted(kind, x, &n)).fold(0.0, f64::max)
}

/// What is said to be beyond a distance is, up to rounding, and most of what is far beyond it is said to be.
#[test]
fn what_is_beyond_a_distance_is_that_far_apart() {
    let (mut draw, mut far, mut told) = (SplitMix64::of_seed(4), 0, 0);
    for n in 0..120_000 {
        let (kind, x) = (KINDS[n % 4], pair(&mut draw, n / 4));
        let distance = nearest(kind, &x).distance;
        // What touches up to rounding is neither.
        if distance > 1e-9 {
            assert!(!is_beyond(kind, &x, 1.000_001 * distance), "{kind:?} {x:?}: {distance}");
            (far, told) = (far + 1, told + usize::from(is_beyond(kind, &x, 0.7 * distance)));
        }
    }
    assert!(far > 60_000 && 2 * told > far, "{told} of {far}");
}

/// The points are of the elements, so nothing is further apart; a slab parts the elements by as much, so nothing is
/// nearer.
#[test]
fn the_distance_is_the_least_one() {
    let mut draw = SplitMix64::of_seed(1);
    for n in 0..120_000 {
        let (kind, x) = (KINDS[n % 4], pair(&mut draw, n / 4));
        let found = nearest(kind, &x);
        let (first, second) = found.weights.split_at(kind.nodes_of_first());
        assert!(first.iter().all(|w| (0.0..=1.0).contains(w)), "{kind:?} {x:?} {found:?}");
        assert!(second.iter().all(|w| (-1.0..=0.0).contains(w)), "{kind:?} {x:?} {found:?}");
        assert!((first.iter().sum::<f64>() - 1.0).abs() < 4e-15, "{kind:?} {x:?} {found:?}");
        assert!((second.iter().sum::<f64>() + 1.0).abs() < 4e-15, "{kind:?} {x:?} {found:?}");
        assert!((weighted(&found.weights, &x) - found.r).norm() < 4e-15, "{kind:?} {x:?} {found:?}");
        let missed = found.distance - parted(kind, &x, &found.normal());
        if found.distance > 4e-15 && missed > 4e-15 {
            let missed = found.distance - widest_slab(kind, &x, &found.r);
            assert!(missed < 4e-15, "missed {missed:e}: {kind:?} {x:?} {found:?}");
        }
        let numbers = found.gradient().iter().all(|g| g.iter().all(|x| x.is_finite()));
        assert!(numbers && found.hessian().iter().flatten().all(|h| h.iter().all(|x| x.is_finite())), "{found:?}");
    }
}

/// The same by points of both elements, which knows nothing of slabs: none is nearer, and one of a fine grid is as near
/// as its spacing allows.
#[test]
fn no_sample_is_nearer() {
    let mut draw = SplitMix64::of_seed(2);
    let shares = |n: usize| (0..=n).map(move |i| i as f64 / n as f64);
    for n in 0..2_000 {
        let (kind, x) = (KINDS[n % 4], pair(&mut draw, n / 4));
        let found = nearest(kind, &x);
        let mut least = f64::INFINITY;
        for (s, t) in shares(16).flat_map(|s| shares(16).map(move |t| (s, t))) {
            let w = match kind {
                PairKind::NodeNode => [1.0, -1.0, 0.0, 0.0],
                PairKind::NodeEdge => [1.0, s - 1.0, -s, 0.0],
                PairKind::NodeTriangle => [1.0, s - 1.0, -s * t, s * t - s],
                PairKind::EdgeEdge => [1.0 - s, s, t - 1.0, -t],
            };
            least = least.min(weighted(&w, &x).norm());
        }
        assert!(found.distance <= least + 4e-15, "{least}: {kind:?} {x:?} {found:?}");
        let spacing = (x[0] - x[1]).norm().max((x[2] - x[3]).norm()).max((x[1] - x[2]).norm()) / 16.0;
        assert!(least <= found.distance + 2.0 * spacing, "{least}: {kind:?} {x:?} {found:?}");
    }
}

/// Nodes as far from the origin as coordinates reach without rounding give the same bits.
#[test]
fn an_origin_far_away_costs_no_digits() {
    let mut draw = SplitMix64::of_seed(3);
    let far = Vector3::new(1e6, -3e6, 2e6);
    for n in 0..1_000 {
        let kind = KINDS[n % 4];
        let there = pair(&mut draw, n / 4).map(|x| x + far);
        // Differences of neighbours are exact.
        let here = there.map(|x| x - far);
        assert_eq!(nearest(kind, &here), nearest(kind, &there));
    }
}

/// Central differences, where no closest point is near another feature.
#[test]
fn derivatives_agree_with_differences() {
    let mut draw = SplitMix64::of_seed(4);
    let (mut worst, mut seen) = ((0.0_f64, 0.0_f64), std::collections::BTreeSet::new());
    let step = 1e-5;
    for n in 0..2_000 {
        let (kind, x) = (KINDS[n % 4], std::array::from_fn(|_| random(&mut draw)));
        let found = nearest(kind, &x);
        let (gradient, hessian) = (found.gradient(), found.hessian());
        let size = hessian.iter().flatten().map(|h| h.norm()).fold(0.0, f64::max);
        for (j, axis) in (0..kind.nodes()).flat_map(|j| (0..3).map(move |axis| (j, axis))) {
            let moved = |by: f64| {
                let mut x = x;
                x[j][axis] += by;
                nearest(kind, &x)
            };
            let (before, after) = (moved(-step), moved(step));
            if before.feature != after.feature || size > 30.0 {
                continue;
            }
            seen.insert((kind, found.feature));
            let difference = (after.distance - before.distance) / (2.0 * step);
            worst.0 = worst.0.max((difference - gradient[j][axis]).abs());
            for (k, (a, b)) in after.gradient().iter().zip(before.gradient()).enumerate() {
                let difference = (a - b) / (2.0 * step);
                worst.1 = worst.1.max((difference - hessian[k][j].column(axis)).norm() / size);
            }
        }
    }
    assert_eq!(seen.len(), 1 + 3 + 7 + 9, "{seen:?}");
    assert!(worst.0 < 2e-7 && worst.1 < 2e-6, "{worst:?}");
}

/// Rigid motions do not change the distance: the second derivatives are symmetric and their sums over a row vanish.
#[test]
fn second_derivatives_are_symmetric_and_free_of_translations() {
    let mut draw = SplitMix64::of_seed(5);
    for n in 0..4_000 {
        let (kind, x) = (KINDS[n % 4], pair(&mut draw, n / 4));
        let hessian = nearest(kind, &x).hessian();
        let size = hessian.iter().flatten().map(|h| h.norm()).fold(0.0, f64::max);
        for (j, row) in hessian.iter().enumerate() {
            assert!(row.iter().sum::<Matrix3<f64>>().norm() <= 1e-13 * size, "{kind:?} {x:?}");
            for (k, block) in row.iter().enumerate() {
                assert!((block - hessian[k][j].transpose()).norm() <= 1e-15 * size, "{kind:?} {x:?}");
            }
        }
    }
}

/// A crossing of two edges at a height of 1e-9 m has the normal and the distance to all digits.
#[test]
fn a_small_distance_keeps_its_direction() {
    let h = 1e-9;
    let ends = [[-0.7, -0.3, h], [0.9, 0.4, h], [0.3, -0.8, 0.0], [-0.2, 0.6, 0.0]];
    let found = nearest(PairKind::EdgeEdge, &ends.map(Vector3::from));
    assert!((found.normal() - Vector3::z()).norm() < 1e-14, "{found:?}");
    assert!((found.distance / h - 1.0).abs() < 1e-12, "{found:?}");
}

/// Without a distance there is no direction: the derivatives are 0.
#[test]
fn what_touches_has_no_derivatives() {
    for kind in KINDS {
        let found = nearest(kind, &[Vector3::new(1.0, 2.0, 3.0); 4]);
        assert_eq!((found.distance, found.gradient()), (0.0, [Vector3::zeros(); 4]));
        assert_eq!(found.hessian(), [[Matrix3::zeros(); 4]; 4]);
    }
}
