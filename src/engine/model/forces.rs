//! The result of a force pass: the nodal forces by role, and each term's energy or power.

/// The role of a force term in the energy ledger.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Its stored energy is counted as `elastic`.
    Elastic,
    /// Its potential is counted as `gravity`.
    Gravity,
    /// Its work is `external_work`: the air and the loads.
    External,
    /// Its work is minus `dissipated`: dashpots and Rayleigh damping.
    Dissipative,
}

/// One term's share of a force pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Tally {
    /// [J] stored energy, for a term whose role is [`Role::Elastic`] or [`Role::Gravity`]; else 0
    pub energy: f64,
    /// [W] power f·v, for a term whose role is [`Role::External`] or [`Role::Dissipative`]. For springs whose rest
    /// lengths are times a factor s, sum of T l0 [J]: their energy changes by minus this times ds. For a gas, what its
    /// energy gains by its amount [J/m^3]. Else 0
    pub power: f64,
}

impl std::ops::AddAssign for Tally {
    fn add_assign(&mut self, other: Self) {
        self.energy += other.energy;
        self.power += other.power;
    }
}

/// Nodal forces [N] of one pass over all degrees of freedom, split as the ledger needs them.
///
/// `total` is zero at fixed degrees of freedom; the forces there give `reactions`. The split vectors exist only where
/// the scene has terms of that role.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Forces {
    /// [N] all forces; zero at fixed degrees of freedom
    pub total: Vec<f64>,
    /// [N] forces of the external terms; empty when the scene has none
    pub external: Vec<f64>,
    /// [N] forces of the dissipative terms; empty when the scene has none
    pub dissipative: Vec<f64>,
    /// [N] reaction of each fixed degree of freedom (minus the applied force), in the order of the fixed list
    pub reactions: Vec<f64>,
    /// Energy or power of every term, in the order of [`crate::model::system::System::terms`].
    pub tallies: Vec<Tally>,
}

impl Forces {
    /// Whether both have the sizes of the same scene.
    pub fn fits(&self, other: &Forces) -> bool {
        let sizes =
            |f: &Forces| [f.total.len(), f.external.len(), f.dissipative.len(), f.reactions.len(), f.tallies.len()];
        sizes(self) == sizes(other)
    }

    /// Copies the sums of another result of the same nodes, where both have them, without allocating. A sum that the
    /// other has not is 0 there.
    pub fn take_sums(&mut self, other: &Forces) {
        let sums = [(&mut self.total, &other.total), (&mut self.external, &other.external)];
        for (own, other) in sums.into_iter().chain([(&mut self.dissipative, &other.dissipative)]) {
            match other.as_slice() {
                [] => own.fill(0.0),
                other if other.len() == own.len() => own.copy_from_slice(other),
                _ => {}
            }
        }
    }

    /// Copies another result of the same scene without allocating.
    pub fn copy_from(&mut self, other: &Forces) {
        self.total.copy_from_slice(&other.total);
        self.external.copy_from_slice(&other.external);
        self.dissipative.copy_from_slice(&other.dissipative);
        self.reactions.copy_from_slice(&other.reactions);
        self.tallies.copy_from_slice(&other.tallies);
    }
}
