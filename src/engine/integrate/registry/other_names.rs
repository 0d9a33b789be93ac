//! Names by which people know the methods, for hints; a case takes only those of the table.

use super::methods;

/// A method under another name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OtherName {
    /// its name in the table
    pub method: &'static str,
    /// what to know if it is not quite the same
    note: &'static str,
}

impl OtherName {
    /// The advice to take it.
    pub fn hint(self) -> String {
        let OtherName { method, note } = self;
        if note.is_empty() { format!("did you mean \"{method}\"?") } else { format!("take \"{method}\", {note}") }
    }
}

/// The method that people also call `name`, or that differs from it by capitals and separators only.
pub fn other_name(name: &str) -> Option<OtherName> {
    let plain_name = plain(name);
    let spelt = methods().iter().find(|m| plain(m.name) == plain_name).map(|m| OtherName { method: m.name, note: "" });
    let other = || OTHER_NAMES.iter().find(|(names, ..)| names.contains(&plain_name.as_str()));
    spelt.or_else(|| other().map(|&(_, method, note)| OtherName { method, note }))
}

/// In small letters, without separators.
fn plain(name: &str) -> String {
    name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

/// Other names as [`plain`] writes them, the method, and a note.
static OTHER_NAMES: &[(&[&str], &str, &str)] = &[
    (&["euler", "forwardeuler", "eulerforward", "eulerexplicit", "feuler"], "explicit-euler", ""),
    (&["semiimplicit", "semiimpliciteuler", "symplecticeuler", "symplectic"], "euler-cromer", ""),
    (&["midpoint", "rk2", "rungekutta2", "explicitmidpoint"], "euler-richardson", "the midpoint rule"),
    (&["heun", "heuns", "modifiedeuler", "explicittrapezoidal"], "improved-euler", "Heun's method"),
    (
        &["verlet", "leapfrog", "leapfrogverlet", "stormer", "stormerverlet", "velverlet", "positionverlet", "vv"],
        "velocity-verlet",
        "whose positions are those of Verlet's and of the leapfrog method",
    ),
    (&["beemans", "beemansmethod", "beemanschofield", "schofield"], "beeman", ""),
    (
        &["centraldifferences", "centraldiff", "cd", "cdm", "explicitnewmark", "explicit"],
        "central-difference",
        "which is velocity-verlet where nothing depends on velocity",
    ),
    (
        &["respa", "rrespa", "verleti", "subcycling", "substepping", "localtimestep", "multipletimestep", "mts"],
        "multirate",
        "which makes short steps of stiff springs (r-RESPA)",
    ),
    (&["rungekutta", "rk", "rungekutta4", "classicalrungekutta", "kutta"], "rk4", "Kutta's method of order four"),
    (
        &[
            "rk45", "ode45", "dopri", "dopri5", "dp5", "rkf45", "rkdp", "fehlberg", "tsit5", "bs32", "rk23", "ode23",
            "cashkarp",
        ],
        "dormand-prince",
        "an embedded pair of orders five and four, with time.tolerance",
    ),
    (&["dopri8", "dopri853", "dop8", "rk8", "rk78", "ode78", "ode89", "dp8", "rkf78"], "dop853", "with time.tolerance"),
    (
        &[
            "newmarkbeta",
            "trapezoidal",
            "trapezoid",
            "trapezoidalrule",
            "averageacceleration",
            "constantacceleration",
            "cranknicolson",
            "implicit",
            "implicitnewmark",
        ],
        "newmark",
        "by default the trapezoidal rule (average acceleration)",
    ),
    (
        &[
            "sdirk",
            "sdirk4",
            "esdirk",
            "dirk",
            "dirk4",
            "ark4",
            "ark436l2sa",
            "esdirk43",
            "kencarp4",
            "radau",
            "radau5",
        ],
        "esdirk4",
        "diagonally implicit, of order four, L-stable",
    ),
    (&["hilberhughestaylor", "hhtalpha", "alpha", "alphamethod"], "hht", ""),
    (
        &["impliciteuler", "eulerimplicit", "eulerbackward", "beuler", "bdf", "bdf1", "bdf2", "baraffwitkin"],
        "backward-euler",
        "the implicit Euler method, of order one; \"generalized-alpha\" is of order two and damps high frequencies too",
    ),
    (
        &["generalisedalpha", "genalpha", "galpha", "chunghulbert", "woodbossakzienkiewicz", "wbz", "bossak"],
        "generalized-alpha",
        "",
    ),
    (
        &[
            "emm",
            "edmc",
            "simotarnow",
            "greenspan",
            "gonzalez",
            "discretegradient",
            "energyconserving",
            "implicitmidpoint",
        ],
        "energy-momentum",
        "the implicit midpoint rule with discrete gradients",
    ),
    (
        &["pbd", "positionbaseddynamics", "extendedpbd", "extendedpositionbaseddynamics", "xpbdsmallsteps"],
        "xpbd",
        "position-based dynamics with compliant springs, which do not depend on the number of iterations once converged",
    ),
    (&["vertexblockdescent", "blockdescent", "avbd"], "vbd", "vertex block descent"),
];

#[cfg(test)]
mod tests {
    use super::*;

    /// Every entry leads to a method of the table, no name is listed twice, and none is a method's own.
    #[test]
    fn other_names_lead_to_methods() {
        let mut seen = Vec::new();
        for (names, method, _) in OTHER_NAMES {
            assert!(methods().iter().any(|m| m.name == *method), "{method}");
            for name in *names {
                assert_eq!(plain(name), *name);
                assert!(!seen.contains(name) && methods().iter().all(|m| plain(m.name) != *name), "{name}");
                seen.push(name);
            }
        }
        assert_eq!(["Runge-Kutta", "RK4"].map(|name| other_name(name).map(|found| found.method)), [Some("rk4"); 2]);
        assert_eq!(other_name("sail"), None);
    }
}
