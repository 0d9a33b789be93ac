// Newmark 1/2, 1/4 with true Newton iterations and Eigen's sparse Cholesky, as one writes it in plain C++.
#include "tangent.hpp"

struct Newmark {
  const Scene &s;
  double h, rounding = 0;  // what the springs' forces lose to rounding of positions [N]
  Tangent tangent;
  Cholesky solver;
  Vector x, v, a, x1, v1, a1, f, r;
  Eigen::VectorXd right, step;
  long factorisations = 0;

  Newmark(const Scene &scene, double h) : s(scene), h(h), tangent(scene) {
    x = s.x0;
    v = a = v1 = a1 = f = r = Vector(x.size(), 0);
    right.resize(tangent.dof.size());
    for (const Spring &e : s.springs) rounding += 2 * e.k * e.k;
    rounding = 4 * 2.2e-16 * std::sqrt(rounding) * std::fabs(*std::max_element(x.begin(), x.end()));
    solver.analyzePattern(tangent.w);
    forces(s, x.data(), v.data(), f.data());
    for (size_t i = 0; i < a.size(); i++) a[i] = s.inverse_mass[i] * f[i];
  }

  // M a - f at x1, and the size it is measured against.
  double residual() {
    double inertia = 0, inner = 0, outer = 0, square = 0;
    for (size_t i = 0; i < x.size(); i++) {
      a1[i] = s.inverse_mass[i] > 0 ? 4 / (h * h) * (x1[i] - x[i] - h * v[i]) - a[i] : 0;
      v1[i] = v[i] + 0.5 * h * (a[i] + a1[i]);
    }
    forces(s, x1.data(), v1.data(), f.data());
    for (int i : tangent.dof) {
      double ma = s.mass[i / 3] * a1[i], internal = f[i] - s.weight[i];
      r[i] = ma - f[i];
      square += r[i] * r[i], inertia += ma * ma, inner += internal * internal, outer += s.weight[i] * s.weight[i];
    }
    return std::max(std::sqrt(square) - rounding, 0.0) / std::sqrt(std::max({inertia, inner, outer}));
  }

  bool solve() {
    for (int iteration = 0; iteration < 50; iteration++) {
      double size = residual();
      if (!std::isfinite(size)) return false;
      if (size <= 1e-8) return true;
      factorise(solver, tangent, s, x1.data(), 4 / (h * h), 2 / h, 1);
      factorisations++;
      for (size_t i = 0; i < tangent.dof.size(); i++) right[i] = -r[tangent.dof[i]];
      step = solver.solve(right);
      for (size_t i = 0; i < tangent.dof.size(); i++) x1[tangent.dof[i]] += step[i];
    }
    return false;
  }

  // From constant acceleration; where that leads nowhere, from the old positions.
  void advance() {
    x1 = x;
    for (int i : tangent.dof) x1[i] += h * v[i] + 0.5 * h * h * a[i];
    if (!solve()) {
      x1 = x;
      if (!solve()) throw std::runtime_error("Newton's iteration did not converge");
    }
    x = x1, v = v1, a = a1;
  }
};

int main(int argc, char **argv) {
  std::string version = "Eigen " + std::to_string(EIGEN_WORLD_VERSION) + "." + std::to_string(EIGEN_MAJOR_VERSION) + "." +
                        std::to_string(EIGEN_MINOR_VERSION) + ", g++ " + __VERSION__;
  return serve(argc, argv, version, [](const Scene &s, Job &job) {
    if (job.method != "newmark") throw std::runtime_error("newmark");
    if (!s.triangles.empty()) throw std::runtime_error("no tangent of the air is written here");
    long each = steps_a_frame(s, job);
    Newmark run(s, s.every / each);
    for (long frame = 0; frame < s.frames(); frame++) {
      for (long step = 0; step < each; step++) run.advance();
      job.keep(run.x.data(), s.dofs());
    }
    return std::to_string(each * s.frames()) + " steps, " + std::to_string(run.factorisations) + " factorisations";
  });
}
