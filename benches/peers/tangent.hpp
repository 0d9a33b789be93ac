// W = m M + c C + k K of a scene of springs and relative dashpots, for Eigen's Cholesky: lower triangle, slots found once.
#pragma once
#include "plain.hpp"
#include <Eigen/SparseCholesky>
#include <algorithm>

using Matrix = Eigen::SparseMatrix<double>;
using Cholesky = Eigen::SimplicialLLT<Matrix, Eigen::Lower, Eigen::AMDOrdering<int>>;

class Tangent {
public:
  Matrix w;                // of the free unknowns
  std::vector<int> dof;    // unknown -> component of x

  explicit Tangent(const Scene &s) : unknown(s.dofs(), -1) {
    for (int i = 0; i < s.dofs(); i++)
      if (!s.fixed[i / 3]) unknown[i] = (int)dof.size(), dof.push_back(i);
    std::vector<Eigen::Triplet<double>> pattern;
    for (int i = 0; i < s.dofs(); i++) entry(i, i, pattern);
    for (const Spring &e : s.springs) each_pair(e, [&](int i, int j, int, int, double) { entry(i, j, pattern); });
    w.resize(dof.size(), dof.size());
    w.setFromTriplets(pattern.begin(), pattern.end());
    w.makeCompressed();
    for (int i = 0; i < s.dofs(); i++) diagonal.push_back(slot(i, i));
    for (const Spring &e : s.springs)
      each_pair(e, [&](int i, int j, int, int, double) { slots.push_back(slot(i, j)); });
  }

  // `convex` leaves out the geometric stiffness of compressed springs, so that W is positive definite.
  void assemble(const Scene &s, const double *x, double m, double c, double k, bool convex) {
    double *value = w.valuePtr();
    std::fill(value, value + w.nonZeros(), 0.0);
    for (int i = 0; i < s.dofs(); i++)
      if (diagonal[i] >= 0) value[diagonal[i]] += m * s.mass[i / 3];
    size_t next = 0;
    for (const Spring &e : s.springs) {
      double n[3], l2 = 0;
      for (int d = 0; d < 3; d++) n[d] = x[3 * e.b + d] - x[3 * e.a + d], l2 += n[d] * n[d];
      double l = std::sqrt(l2), across = (l - e.rest) / l;
      if (convex) across = std::max(across, 0.0);
      double block[3][3];
      for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
          block[i][j] = k * e.k * (1 - across) * n[i] * n[j] / l2 + (i == j ? k * e.k * across + c * e.c : 0);
      each_pair(e, [&](int, int, int i, int j, double sign) {
        int at = slots[next++];
        if (at >= 0) value[at] += sign * block[i][j];
      });
    }
  }

private:
  std::vector<int> unknown, diagonal, slots;

  // The 24 entries of a spring in the lower triangle whichever way its nodes are numbered: two diagonal blocks and one beside.
  template <class Do> static void each_pair(const Spring &e, Do visit) {
    for (int i = 0; i < 3; i++)
      for (int j = 0; j <= i; j++) visit(3 * e.a + i, 3 * e.a + j, i, j, 1.0), visit(3 * e.b + i, 3 * e.b + j, i, j, 1.0);
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++) visit(3 * e.a + i, 3 * e.b + j, i, j, -1.0);
  }
  void entry(int i, int j, std::vector<Eigen::Triplet<double>> &pattern) const {
    int p = unknown[i], q = unknown[j];
    if (p >= 0 && q >= 0) pattern.emplace_back(std::max(p, q), std::min(p, q), 0.0);
  }
  int slot(int i, int j) const {
    int p = unknown[i], q = unknown[j];
    if (p < 0 || q < 0) return -1;
    int row = std::max(p, q), column = std::min(p, q);
    const int *rows = w.innerIndexPtr(), *from = rows + w.outerIndexPtr()[column], *to = rows + w.outerIndexPtr()[column + 1];
    return (int)(std::lower_bound(from, to, row) - rows);
  }
};

// Factorises W at x, by its convex part where W itself is not positive definite.
inline void factorise(Cholesky &solver, Tangent &tangent, const Scene &s, const double *x, double m, double c, double k) {
  tangent.assemble(s, x, m, c, k, false);
  solver.factorize(tangent.w);
  if (solver.info() == Eigen::Success) return;
  tangent.assemble(s, x, m, c, k, true);
  solver.factorize(tangent.w);
  if (solver.info() != Eigen::Success) throw std::runtime_error("the convex tangent has no Cholesky factor");
}
