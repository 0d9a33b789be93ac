// SUNDIALS on the same right-hand side, compiled: ARKODE's explicit pairs of order 5 and 8, CVODE's BDF with GMRES, and
// ARKODE's implicit ARK4(3)6L[2]SA, the tableau of our `esdirk4`. `bdf` has no preconditioner; `bdf-cholesky` and `esdirk4`
// have the Cholesky factor of M + gamma C + gamma^2 K, which is exact but for the air and where a tangent was not positive
// definite.
#include "fast_vector.hpp"
#include "tangent.hpp"
#include <arkode/arkode_arkstep.h>
#include <arkode/arkode_erkstep.h>
#include <cvode/cvode.h>
#include <memory>
#include <sundials/sundials_version.h>
#include <sunlinsol/sunlinsol_spgmr.h>

struct System {
  const Scene &s;
  std::unique_ptr<Tangent> tangent;
  Cholesky solver;
  Eigen::VectorXd right, step;
  double gamma = 0;
  long passes = 0, factorisations = 0;
};

static void check(int flag, const char *what) {
  if (flag < 0) throw std::runtime_error(std::string(what) + " gave " + std::to_string(flag));
}

// y = (x, v): x' = v, v' = f/m.
static int rhs(realtype, N_Vector y, N_Vector dy, void *user) {
  System &system = *(System *)user;
  const Scene &s = system.s;
  int n = s.dofs();
  const double *x = N_VGetArrayPointer(y), *v = x + n;
  double *dx = N_VGetArrayPointer(dy), *dv = dx + n;
  forces(s, x, v, dv);
  for (int i = 0; i < n; i++) dx[i] = v[i], dv[i] *= s.inverse_mass[i];
  system.passes++;
  return 0;
}

// P = I - gamma J with J = [0 I; -K/M -C/M].
static int setup(realtype, N_Vector y, N_Vector, booleantype, booleantype *fresh, realtype gamma, void *user) {
  System &system = *(System *)user;
  factorise(system.solver, *system.tangent, system.s, N_VGetArrayPointer(y), 1, gamma, gamma * gamma);
  system.gamma = gamma;
  system.factorisations++;
  *fresh = SUNTRUE;
  return 0;
}

// P (p, q) = (rx, rv) by q: (M + gamma C + gamma^2 K) q = M rv - gamma K rx, K rx = (W rx - M rx - gamma C rx)/gamma^2 being
// spared: p solves (M + gamma C + gamma^2 K) p = M (rx + gamma rv) + gamma C rx, then q = (p - rx)/gamma.
static int solve(realtype, N_Vector, N_Vector, N_Vector rv_, N_Vector z_, realtype, realtype, int, void *user) {
  System &system = *(System *)user;
  const Scene &s = system.s;
  int n = s.dofs();
  double g = system.gamma, *z = N_VGetArrayPointer(z_);
  const double *rx = N_VGetArrayPointer(rv_), *rv = rx + n;
  for (int i = 0; i < n; i++) z[i] = s.mass[i / 3] * (rx[i] + g * rv[i]);
  for (const Spring &e : s.springs)
    for (int d = 0; d < 3; d++) {
      double t = g * e.c * (rx[3 * e.a + d] - rx[3 * e.b + d]);
      z[3 * e.a + d] += t, z[3 * e.b + d] -= t;
    }
  const std::vector<int> &dof = system.tangent->dof;
  for (size_t i = 0; i < dof.size(); i++) system.right[i] = z[dof[i]];
  system.step = system.solver.solve(system.right);
  for (int i = 0; i < n; i++) z[i] = rx[i] + g * rv[i], z[n + i] = rv[i];  // fixed nodes
  for (size_t i = 0; i < dof.size(); i++) z[dof[i]] = system.step[i], z[n + dof[i]] = (system.step[i] - rx[dof[i]]) / g;
  return 0;
}

static std::string erk(System &system, Job &job, SUNContext context, N_Vector y, int order) {
  const Scene &s = system.s;
  void *ark = ERKStepCreate(rhs, 0, y, context);
  check(ERKStepSetUserData(ark, &system), "user data");
  check(ERKStepSetOrder(ark, order), "order");
  check(ERKStepSStolerances(ark, job.value, job.value / 100), "tolerances");
  check(ERKStepSetMaxNumSteps(ark, 10000000), "step limit");
  for (int frame = 1; frame <= s.frames(); frame++) {
    realtype t;
    check(ERKStepEvolve(ark, s.end * frame / s.frames(), y, &t, ARK_NORMAL), "ERKStep");
    job.keep(N_VGetArrayPointer(y), s.dofs());
  }
  long steps = 0;
  ERKStepGetNumSteps(ark, &steps);
  ERKStepFree(&ark);
  return std::to_string(steps) + " steps, " + std::to_string(system.passes) + " force passes";
}

static void prepare_preconditioner(System &system) {
  system.tangent = std::make_unique<Tangent>(system.s);
  system.solver.analyzePattern(system.tangent->w);
  system.right.resize(system.tangent->dof.size());
}

static std::string work(long steps, const System &system) {
  return std::to_string(steps) + " steps, " + std::to_string(system.passes) + " force passes, " +
         std::to_string(system.factorisations) + " factorisations";
}

// Fixed steps solve their stages as far as a tolerance of 1e-6 asks for; `tol` chooses steps and both by the tolerance.
static std::string esdirk(System &system, Job &job, SUNContext context, N_Vector y) {
  const Scene &s = system.s;
  bool fixed = job.kind == "step";
  double tolerance = fixed ? 1e-6 : job.value;
  void *ark = ARKStepCreate(nullptr, rhs, 0, y, context);
  check(ARKStepSetUserData(ark, &system), "user data");
  check(ARKStepSetTableNum(ark, ARKODE_ARK436L2SA_DIRK_6_3_4, ARKODE_ERK_NONE), "tableau");
  check(ARKStepSStolerances(ark, tolerance, tolerance / 100), "tolerances");
  check(ARKStepSetMaxNumSteps(ark, 10000000), "step limit");
  // Faster on these scenes than its defaults, which extrapolate nothing: half the time.
  check(ARKStepSetPredictorMethod(ark, 1), "predictor");
  check(ARKStepSetLSetupFrequency(ark, 4), "factorisations");
  check(ARKStepSetMaxNonlinIters(ark, 10), "iterations");
  if (fixed) check(ARKStepSetFixedStep(ark, s.every / steps_a_frame(s, job)), "step");
  SUNLinearSolver gmres = SUNLinSol_SPGMR(y, SUN_PREC_LEFT, 5, context);
  check(ARKStepSetLinearSolver(ark, gmres, nullptr), "linear solver");
  check(ARKStepSetEpsLin(ark, 0.3), "tolerance of GMRES");
  prepare_preconditioner(system);
  check(ARKStepSetPreconditioner(ark, setup, solve), "preconditioner");
  for (int frame = 1; frame <= s.frames(); frame++) {
    realtype t, until = s.end * frame / s.frames();
    check(ARKStepSetStopTime(ark, until), "stop");
    check(ARKStepEvolve(ark, until, y, &t, ARK_NORMAL), "ARKStep");
    job.keep(N_VGetArrayPointer(y), s.dofs());
  }
  long steps = 0;
  ARKStepGetNumSteps(ark, &steps);
  ARKStepFree(&ark);
  SUNLinSolFree(gmres);
  return work(steps, system);
}

static std::string bdf(System &system, Job &job, SUNContext context, N_Vector y, bool preconditioned) {
  const Scene &s = system.s;
  void *cv = CVodeCreate(CV_BDF, context);
  check(CVodeInit(cv, rhs, 0, y), "CVodeInit");
  check(CVodeSetUserData(cv, &system), "user data");
  check(CVodeSStolerances(cv, job.value, job.value / 100), "tolerances");
  check(CVodeSetMaxNumSteps(cv, 10000000), "step limit");
  SUNLinearSolver gmres = SUNLinSol_SPGMR(y, preconditioned ? SUN_PREC_LEFT : SUN_PREC_NONE, preconditioned ? 5 : 30, context);
  check(CVodeSetLinearSolver(cv, gmres, nullptr), "linear solver");
  if (preconditioned) {
    prepare_preconditioner(system);
    check(CVodeSetPreconditioner(cv, setup, solve), "preconditioner");
  }
  for (int frame = 1; frame <= s.frames(); frame++) {
    realtype t;
    check(CVode(cv, s.end * frame / s.frames(), y, &t, CV_NORMAL), "CVode");
    job.keep(N_VGetArrayPointer(y), s.dofs());
  }
  long steps = 0;
  CVodeGetNumSteps(cv, &steps);
  CVodeFree(&cv);
  SUNLinSolFree(gmres);
  return work(steps, system);
}

int main(int argc, char **argv) {
  return serve(argc, argv, std::string("SUNDIALS ") + SUNDIALS_VERSION, [](const Scene &s, Job &job) {
    SUNContext context;
    check(SUNContext_Create(nullptr, &context), "context");
    N_Vector y = fast::vector(2 * s.dofs(), context);
    N_VConst(0, y);
    std::copy(s.x0.begin(), s.x0.end(), N_VGetArrayPointer(y));
    System system{s, {}, {}, {}, {}};
    std::string note;
    if (job.method == "erk5" || job.method == "erk8") note = erk(system, job, context, y, job.method == "erk5" ? 5 : 8);
    else if (job.method == "bdf" || job.method == "bdf-cholesky") note = bdf(system, job, context, y, job.method != "bdf");
    else if (job.method == "esdirk4") note = esdirk(system, job, context, y);
    else throw std::runtime_error("erk5, erk8, bdf, bdf-cholesky or esdirk4");
    N_VDestroy(y);
    SUNContext_Free(&context);
    return note;
  });
}
