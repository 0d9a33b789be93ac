// Velocity Verlet (kick, drift, kick), leapfrog and RK4 as one writes them in plain C++, with fixed steps.
#include "plain.hpp"

static std::string version() { return std::string("g++ ") + __VERSION__; }

// With velocity-dependent forces, these are taken at the predicted velocity v + h a, which keeps order 2 at one evaluation
// a step.
static std::string verlet(const Scene &s, Job &job) {
  int n = s.dofs();
  long each = steps_a_frame(s, job);
  double h = s.every / each;
  Vector x = s.x0, v(n, 0), predicted(n, 0), f(n);
  forces(s, x.data(), v.data(), f.data());
  for (long frame = 0; frame < s.frames(); frame++) {
    for (long step = 0; step < each; step++) {
      for (int i = 0; i < n; i++) {
        double kick = 0.5 * h * s.inverse_mass[i] * f[i];
        v[i] += kick;
        x[i] += h * v[i];
        if (s.damped) predicted[i] = v[i] + kick;
      }
      forces(s, x.data(), predicted.data(), f.data());
      for (int i = 0; i < n; i++) v[i] += 0.5 * h * s.inverse_mass[i] * f[i];
    }
    job.keep(x.data(), n);
  }
  return std::to_string(each * s.frames()) + " steps";
}

// One loop over the nodes a step. Velocities live between two steps, and forces that depend on them are half a step behind,
// which leaves order 1 in the damping.
static std::string leapfrog(const Scene &s, Job &job) {
  int n = s.dofs();
  long each = steps_a_frame(s, job);
  double h = s.every / each, kick = 0.5 * h;
  Vector x = s.x0, v(n, 0), f(n);
  for (long frame = 0; frame < s.frames(); frame++) {
    for (long step = 0; step < each; step++) {
      forces(s, x.data(), v.data(), f.data());
      for (int i = 0; i < n; i++) {
        v[i] += kick * s.inverse_mass[i] * f[i];
        x[i] += h * v[i];
      }
      kick = h;
    }
    job.keep(x.data(), n);
  }
  return std::to_string(each * s.frames()) + " steps";
}

static std::string rk4(const Scene &s, Job &job) {
  int n = s.dofs();
  long each = steps_a_frame(s, job);
  double h = s.every / each;
  Vector x = s.x0, v(n, 0), xs(n), vs(n), dx(n), dv(n), f(n);
  const double at[4] = {0, 0.5, 0.5, 1}, weight[4] = {1. / 6, 1. / 3, 1. / 3, 1. / 6};
  for (long frame = 0; frame < s.frames(); frame++) {
    for (long step = 0; step < each; step++) {
      for (int i = 0; i < n; i++) xs[i] = x[i], vs[i] = v[i], dx[i] = dv[i] = 0;
      for (int stage = 0; stage < 4; stage++) {
        forces(s, xs.data(), vs.data(), f.data());
        double next = stage < 3 ? at[stage + 1] * h : 0, share = weight[stage] * h;
        for (int i = 0; i < n; i++) {
          double a = s.inverse_mass[i] * f[i];
          dx[i] += share * vs[i], dv[i] += share * a;
          xs[i] = x[i] + next * vs[i], vs[i] = v[i] + next * a;
        }
      }
      for (int i = 0; i < n; i++) x[i] += dx[i], v[i] += dv[i];
    }
    job.keep(x.data(), n);
  }
  return std::to_string(each * s.frames()) + " steps";
}

int main(int argc, char **argv) {
  return serve(argc, argv, version(), [](const Scene &s, Job &job) {
    if (job.method == "verlet") return verlet(s, job);
    if (job.method == "leapfrog") return leapfrog(s, job);
    if (job.method == "rk4") return rk4(s, job);
    throw std::runtime_error("verlet, leapfrog or rk4");
  });
}
