/* The plain loop over springs that a spring-force pass is measured against: what one writes first in C.
   Also a velocity-Verlet step and an RK4 step around it, for a network without velocity-dependent forces. */
#include <math.h>

void spring_forces(int n_springs, const int *nodes, const double *k, const double *l0, const double *x, double *f) {
  for (int e = 0; e < n_springs; e++) {
    int a = 3 * nodes[2 * e], b = 3 * nodes[2 * e + 1];
    double dx = x[b] - x[a], dy = x[b + 1] - x[a + 1], dz = x[b + 2] - x[a + 2];
    double l = sqrt(dx * dx + dy * dy + dz * dz);
    double s = k[e] * (l - l0[e]) / l;
    f[a] += s * dx, f[a + 1] += s * dy, f[a + 2] += s * dz;
    f[b] -= s * dx, f[b + 1] -= s * dy, f[b + 2] -= s * dz;
  }
}

void verlet_steps(int steps, double h, int n_dof, const double *inverse_mass, int n_springs, const int *nodes,
                  const double *k, const double *l0, double *x, double *v, double *f) {
  for (int s = 0; s < steps; s++) {
    for (int i = 0; i < n_dof; i++) v[i] += 0.5 * h * inverse_mass[i] * f[i], x[i] += h * v[i], f[i] = 0.0;
    spring_forces(n_springs, nodes, k, l0, x, f);
    for (int i = 0; i < n_dof; i++) v[i] += 0.5 * h * inverse_mass[i] * f[i];
  }
}
