// The sums of SUNDIALS' serial vector, compiled here with the options of every other peer: the packaged library's own
// are several times slower, and a peer must not lose by how a distribution compiles it.
#pragma once
#include <algorithm>
#include <cmath>
#include <nvector/nvector_serial.h>

namespace fast {

inline double *of(N_Vector v) { return NV_DATA_S(v); }

inline void scale(realtype c, N_Vector x, N_Vector z) {
  const double *a = of(x);
  double *out = of(z);
  for (long i = 0, n = NV_LENGTH_S(x); i < n; i++) out[i] = c * a[i];
}

inline void sum(realtype p, N_Vector x, realtype q, N_Vector y, N_Vector z) {
  const double *a = of(x), *b = of(y);
  double *out = of(z);
  for (long i = 0, n = NV_LENGTH_S(x); i < n; i++) out[i] = p * a[i] + q * b[i];
}

// A function of its own: g++ would else swap the two loops around it and gather.
__attribute__((noinline)) static void add(double factor, const double *__restrict a, double *__restrict out, long n) {
  for (long i = 0; i < n; i++) out[i] += factor * a[i];
}

inline int combination(int count, realtype *c, N_Vector *x, N_Vector z) {
  double *out = of(z);
  const long n = NV_LENGTH_S(z), piece = 512;
  double part[piece];  // z may be one of the x
  for (long from = 0; from < n; from += piece) {
    const long m = std::min(piece, n - from);
    for (long i = 0; i < m; i++) part[i] = 0;
    for (int k = 0; k < count; k++) add(c[k], of(x[k]) + from, part, m);
    for (long i = 0; i < m; i++) out[from + i] = part[i];
  }
  return 0;
}

inline realtype dot(N_Vector x, N_Vector y) {
  const double *a = of(x), *b = of(y);
  double lane[8] = {0};
  long n = NV_LENGTH_S(x), i = 0;
  for (; i + 8 <= n; i += 8)
    for (int k = 0; k < 8; k++) lane[k] += a[i + k] * b[i + k];
  for (; i < n; i++) lane[0] += a[i] * b[i];
  return ((lane[0] + lane[1]) + (lane[2] + lane[3])) + ((lane[4] + lane[5]) + (lane[6] + lane[7]));
}

inline realtype wrms(N_Vector x, N_Vector w) {
  const double *a = of(x), *b = of(w);
  double lane[8] = {0};
  long n = NV_LENGTH_S(x), i = 0;
  for (; i + 8 <= n; i += 8)
    for (int k = 0; k < 8; k++) lane[k] += a[i + k] * b[i + k] * a[i + k] * b[i + k];
  for (; i < n; i++) lane[0] += a[i] * b[i] * a[i] * b[i];
  return std::sqrt((((lane[0] + lane[1]) + (lane[2] + lane[3])) + ((lane[4] + lane[5]) + (lane[6] + lane[7]))) / (double)n);
}

inline void magnitude(N_Vector x, N_Vector z) {
  const double *a = of(x);
  double *out = of(z);
  for (long i = 0, n = NV_LENGTH_S(x); i < n; i++) out[i] = std::fabs(a[i]);
}

inline void inverse(N_Vector x, N_Vector z) {
  const double *a = of(x);
  double *out = of(z);
  for (long i = 0, n = NV_LENGTH_S(x); i < n; i++) out[i] = 1 / a[i];
}

inline void shift(N_Vector x, realtype b, N_Vector z) {
  const double *a = of(x);
  double *out = of(z);
  for (long i = 0, n = NV_LENGTH_S(x); i < n; i++) out[i] = a[i] + b;
}

// Vectors that SUNDIALS clones from this one have the same operations.
inline N_Vector vector(long n, SUNContext context) {
  N_Vector y = N_VNew_Serial(n, context);
  N_VEnableFusedOps_Serial(y, SUNTRUE);
  auto *ops = y->ops;
  ops->nvscale = scale, ops->nvlinearsum = sum, ops->nvlinearcombination = combination, ops->nvdotprod = dot;
  ops->nvwrmsnorm = wrms, ops->nvabs = magnitude, ops->nvinv = inverse, ops->nvaddconst = shift;
  return y;
}

}  // namespace fast
