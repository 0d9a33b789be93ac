//! A scheme bound to a scene that has the interface the scheme needs.

use super::form::StepForm;
use super::{CarriedState, Counters, ErrorEstimate, Integrator, LawChange, PairInfo, StepError, StepInput, StepReport};
use crate::assembly::{SceneInterfaces, TangentSystem};
use crate::model::links::NoLinks;
use crate::model::point::Point;
use crate::model::step_block::StepSummary;
use crate::model::system::{SpringGraph, System};
use crate::solve::LinearStats;

/// A scheme, by the interface that it needs.
pub enum Scheme {
    /// forces
    Explicit(Box<dyn Integrator<dyn System>>),
    /// forces and tangents
    Implicit(Box<dyn Integrator<dyn TangentSystem>>),
    /// forces and the spring graph
    Graph(Box<dyn Integrator<dyn SpringGraph>>),
}

/// A scheme does not fit a scene.
#[derive(Clone, Copy, Debug, thiserror::Error, PartialEq, Eq)]
pub enum Unfit {
    /// It needs a spring network.
    #[error("this method goes along the springs of a network and the scene has none; choose another method")]
    Network,
    /// Its steps are longer than contact allows.
    #[error(
        "this method makes steps that springs would limit, and contact limits them too: it has no place in its filter or its short \
         steps; take velocity-verlet, or an implicit method such as newmark"
    )]
    Contact,
    /// Its springs cannot be solved one by one.
    #[error(transparent)]
    Links(#[from] NoLinks),
}

/// A scheme bound to a scene.
pub struct Stepper<'a>(BoundScheme<'a>);

enum BoundScheme<'a> {
    Explicit(Box<dyn Integrator<dyn System>>, &'a (dyn System + 'static)),
    Implicit(Box<dyn Integrator<dyn TangentSystem>>, &'a (dyn TangentSystem + 'static)),
    Graph(Box<dyn Integrator<dyn SpringGraph>>, &'a (dyn SpringGraph + 'static)),
}

/// One step to attempt by a bound scheme.
#[derive(Clone, Copy, Debug)]
pub struct Attempt<'a> {
    /// start of the step
    pub from: &'a Point,
    /// [s] step size
    pub h: f64,
    /// [s] time at the end
    pub t_next: f64,
}

macro_rules! each {
    ($self:expr, $scheme:ident, $system:ident => $body:expr) => {
        match $self {
            BoundScheme::Explicit($scheme, $system) => $body,
            BoundScheme::Implicit($scheme, $system) => $body,
            BoundScheme::Graph($scheme, $system) => $body,
        }
    };
}

impl<'a> Stepper<'a> {
    /// Binds a scheme to a scene.
    ///
    /// # Errors
    /// When the scheme needs a spring network and the scene has none, or does not know something that the scene has,
    /// such as contact.
    pub fn bind(scheme: Scheme, scene: SceneInterfaces<'a>) -> Result<Self, Unfit> {
        let explicit = !matches!(scheme, Scheme::Implicit(_));
        let knows_contact = match &scheme {
            Scheme::Explicit(scheme) => scheme.knows_contact(),
            Scheme::Implicit(_) => true,
            Scheme::Graph(_) => false,
        };
        if scene.system.touches().is_some() && !knows_contact {
            return Err(Unfit::Contact);
        }
        scene.system.touches().into_iter().for_each(|touches| touches.set_explicit(explicit));
        Ok(Stepper(match scheme {
            Scheme::Explicit(s) => BoundScheme::Explicit(s, scene.system),
            Scheme::Implicit(s) => BoundScheme::Implicit(s, scene.tangent),
            Scheme::Graph(s) => {
                let graph = scene.graph.ok_or(Unfit::Network)?;
                s.fits(graph)?;
                BoundScheme::Graph(s, graph)
            }
        }))
    }

    /// The scheme with its carried state. Bound to the same scene again, it continues unchanged.
    pub fn unbind(self) -> Scheme {
        match self.0 {
            BoundScheme::Explicit(s, _) => Scheme::Explicit(s),
            BoundScheme::Implicit(s, _) => Scheme::Implicit(s),
            BoundScheme::Graph(s, _) => Scheme::Graph(s),
        }
    }

    /// See [`Integrator::start`].
    ///
    /// # Errors
    /// When matrices or solvers cannot be set up.
    pub fn start(&mut self, at: &Point) -> Result<(), StepError> {
        each!(&mut self.0, scheme, system => scheme.start(*system, at))
    }

    /// See [`Integrator::attempt`].
    ///
    /// # Errors
    /// When an implicit step does not converge.
    pub fn attempt(
        &mut self,
        Attempt { from, h, t_next }: Attempt<'_>,
        to: &mut Point,
        counters: &mut Counters,
    ) -> Result<StepReport, StepError> {
        if let BoundScheme::Implicit(_, system) = &self.0
            && let Some(touches) = system.touches()
        {
            touches.begin_step(from.state.as_ref());
        }
        let report = each!(&mut self.0, scheme, system => {
            scheme.attempt(StepInput { system: *system, from, h, t_next }, to, counters)
        })?;
        // Implicit steps are searched along ways on which nothing touches.
        let touches = match &self.0 {
            BoundScheme::Explicit(_, system) => system.touches(),
            BoundScheme::Graph(_, system) => system.touches(),
            BoundScheme::Implicit(..) => None,
        };
        match touches.and_then(|touches| touches.passage(from.state.as_ref(), to.state.as_ref())) {
            Some(passage) => Err(StepError::Passed(passage)),
            None => Ok(report),
        }
    }

    /// See [`Integrator::advance_block`].
    pub fn advance_block(
        &mut self,
        Attempt { from, h, t_next }: Attempt<'_>,
        to: &mut Point,
        summaries: &mut [StepSummary],
        counters: &mut Counters,
    ) -> bool {
        each!(&mut self.0, scheme, system => {
            scheme.advance_block(StepInput { system: *system, from, h, t_next }, to, summaries, counters)
        })
    }

    /// See [`Integrator::accept`].
    pub fn accept(&mut self) {
        each!(&mut self.0, scheme, _system => scheme.accept());
    }

    /// See [`Integrator::restart`].
    pub fn restart(&mut self, at: &Point) {
        each!(&mut self.0, scheme, system => scheme.restart(*system, at));
    }

    /// See [`Integrator::set_near_corner`].
    pub fn set_near_corner(&mut self, near: bool) {
        each!(&mut self.0, scheme, _system => scheme.set_near_corner(near));
    }

    /// See [`Integrator::keep_over_change`].
    pub fn keep_over_change(&mut self, at: &Point) -> bool {
        each!(&mut self.0, scheme, system => scheme.keep_over_change(*system, at))
    }

    /// See [`Integrator::force_velocities`].
    pub fn force_velocities(&self) -> Option<&[f64]> {
        each!(&self.0, scheme, _system => scheme.force_velocities())
    }

    /// See [`Integrator::laws_changed`].
    ///
    /// # Errors
    /// When matrices or solvers cannot be set up.
    pub fn laws_changed(&mut self, at: &Point, change: LawChange) -> Result<(), StepError> {
        each!(&mut self.0, scheme, system => scheme.laws_changed(*system, at, change))
    }

    /// See [`Integrator::set_end`].
    pub fn set_end(&mut self, end: f64) {
        each!(&mut self.0, scheme, _system => scheme.set_end(end));
    }

    /// See [`Integrator::drop_unsaved`].
    pub fn drop_unsaved(&mut self) {
        each!(&mut self.0, scheme, _system => scheme.drop_unsaved());
    }

    /// See [`Integrator::lags`]; friction at the end of an implicit step is that of the pressures at its start.
    pub fn lags(&self) -> bool {
        let rubs = match &self.0 {
            BoundScheme::Implicit(_, system) => system.touches().is_some_and(|touches| touches.rubs()),
            BoundScheme::Explicit(..) | BoundScheme::Graph(..) => false,
        };
        rubs || each!(&self.0, scheme, system => scheme.lags(*system))
    }

    /// See [`Integrator::save`].
    pub fn save(&self) -> CarriedState {
        let near = match &self.0 {
            BoundScheme::Implicit(_, system) => system.touches().and_then(|touches| touches.save()),
            BoundScheme::Explicit(..) | BoundScheme::Graph(..) => None,
        };
        CarriedState { near, ..each!(&self.0, scheme, _system => scheme.save()) }
    }

    /// See [`Integrator::save_into`].
    pub fn save_into(&self, to: &mut CarriedState) {
        each!(&self.0, scheme, _system => scheme.save_into(to));
    }

    /// See [`Integrator::restore`].
    ///
    /// # Errors
    /// When the saved state does not fit.
    pub fn restore(&mut self, carried: &CarriedState) -> Result<(), StepError> {
        each!(&mut self.0, scheme, _system => scheme.restore(carried))
    }

    /// See [`Integrator::filter_error`].
    ///
    /// # Errors
    /// When the factorised W cannot be solved with.
    pub fn filter_error(&mut self, e: &mut [f64], counters: &mut Counters) -> Result<(), StepError> {
        each!(&mut self.0, scheme, system => scheme.filter_error(e, *system, counters))
    }

    /// See [`Integrator::pair`].
    pub fn pair(&self) -> Option<PairInfo> {
        each!(&self.0, scheme, _system => scheme.pair())
    }

    /// See [`Integrator::embedded_error`].
    pub fn embedded_error(&mut self, Attempt { from, h, t_next }: Attempt<'_>, to: &Point, out: ErrorEstimate<'_>) {
        each!(&mut self.0, scheme, system => {
            scheme.embedded_error(StepInput { system: *system, from, h, t_next }, to, out);
        });
    }

    /// See [`Integrator::form`].
    pub fn form(&self, h: f64) -> Option<StepForm> {
        each!(&self.0, scheme, system => scheme.form(h, system.velocity_dependent()))
    }

    /// See [`Integrator::stage_acceleration`].
    pub fn stage_acceleration(&self, stage: usize) -> Option<&[f64]> {
        each!(&self.0, scheme, _system => scheme.stage_acceleration(stage))
    }

    /// Degree of freedom of an unknown of an implicit scheme.
    pub fn dof_of_unknown(&self, unknown: usize) -> usize {
        each!(&self.0, scheme, _system => scheme.dof_of_unknown(unknown))
    }

    /// See [`Integrator::linear_stats`].
    pub fn linear_stats(&self) -> Option<LinearStats> {
        each!(&self.0, scheme, _system => scheme.linear_stats())
    }
}
