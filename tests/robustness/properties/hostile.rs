//! Random magnitudes from one end of a double to the other: every end is a documented one.

use super::nets::{Net, net};
use crate::extremes::verdict::{Kind, attempt, judge};
use canopy_fem::integrate::registry::methods;
use proptest::prelude::*;

/// 10 to a random power.
fn magnitude(least: f64, most: f64) -> impl Strategy<Value = f64> {
    (least..=most).prop_map(|e| 10.0_f64.powf(e))
}

/// A sensible net with some of its numbers replaced by any.
fn spoilt() -> impl Strategy<Value = Net> {
    let springs = (magnitude(-12.0, 15.0), magnitude(-15.0, 12.0), magnitude(-6.0, 3.0), magnitude(-12.0, 12.0));
    let outside = (magnitude(-3.0, 12.0), magnitude(-3.0, 9.0), magnitude(-6.0, 9.0), magnitude(-9.0, 9.0));
    let motion = (magnitude(-15.0, 6.0), magnitude(-12.0, 9.0), magnitude(-9.0, 9.0), 0_usize..20);
    (net(), any::<u16>(), springs, outside, motion).prop_map(|(mut net, which, springs, outside, motion)| {
        let (step, speed, offset, node) = motion;
        let mut count = 0;
        // Each with one chance in four: all at once would mostly be refused.
        let mut spoil = |by: &mut dyn FnMut()| {
            let hit = which >> count & 1 == 1 && (which >> ((count + 5) % 16)) & 1 == 1;
            count += 1;
            if hit {
                by();
            }
        };
        // The last node is never held.
        let node = net.nodes.len() - 1 - node % 2 * usize::from(!net.held.contains(&(net.nodes.len() - 2)));
        spoil(&mut || net.stiffness = springs.0);
        spoil(&mut || net.dashpot = springs.1);
        spoil(&mut || net.rest_scale = springs.2);
        spoil(&mut || net.masses[node] = springs.3);
        spoil(&mut || net.wind = net.wind.map(|v| v * outside.0));
        spoil(&mut || net.pressure *= outside.1);
        spoil(&mut || net.gravity = net.gravity.map(|g| g * outside.2));
        spoil(&mut || net.rayleigh = net.rayleigh.map(|r| r * outside.3));
        spoil(&mut || net.step = step);
        spoil(&mut || net.velocity[node] = net.velocity[node].map(|v| v * speed));
        spoil(&mut || net.nodes.iter_mut().flatten().for_each(|x| *x += offset));
        spoil(&mut || net.masses.iter_mut().for_each(|m| *m *= springs.3));
        net
    })
}

proptest! {
    #![proptest_config(super::config(64))]

    #[test]
    fn every_end_is_documented(net in spoilt()) {
        let case = net.case();
        let show = std::env::var_os("EXTREMES_SHOW").is_some();
        for method in methods() {
            let end = attempt(&case, &[("time.method".to_owned(), method.name.to_owned())]);
            let judged = judge(&end);
            if show {
                println!("END {} {judged:?} {}", method.name, end.words().replace('\n', " "));
                continue;
            }
            match judged {
                // Refused with what is allowed instead.
                Ok(Kind::Refused) => prop_assert!(end.words().contains("allowed"), "{}", end.words()),
                Ok(_) => {}
                Err(why) => prop_assert!(false, "{}: {}", method.name, why),
            }
        }
    }
}
