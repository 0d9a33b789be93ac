// What the C++ peers share: the scene file, its forces written plainly, and the line protocol of README.md.
#pragma once
#include <cmath>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

using Vector = std::vector<double>;

struct Spring {
  int a, b;
  double k, rest, c;
};

struct Triangle {
  int n[3];
};

// A triangle of constant strain of an isotropic St. Venant-Kirchhoff sheet.
struct Membrane {
  int n[3];
  double r[3];        // inverse of the sides in the triangle's plane, the first one along x: r[0] r[1]; 0 r[2] [1/m]
  double stiff, nu;   // E t A0/(1 - nu^2) [N m], Poisson's ratio
  bool wrinkles;
};

struct Scene {
  double end = 0, every = 0;
  Vector x0, mass;         // 3 and 1 a node
  std::vector<int> fixed;  // 1 a node
  std::vector<Spring> springs;
  std::vector<Triangle> triangles;
  std::vector<Membrane> membranes;
  double gravity[3] = {0, 0, 0};
  Vector load;  // 3 a node, or empty
  double linear = 0, quadratic = 0, wind[3] = {0, 0, 0};  // dp = linear v_n + quadratic v_n |v_n|
  Vector inverse_mass, weight;  // 3 a node; 0 where fixed; the weight has the load in it
  bool damped = false;

  int dofs() const { return (int)x0.size(); }
  int frames() const { return (int)std::lround(end / every); }
};

inline void add_rest_shape(Membrane &m, const Vector &x, double thickness, double modulus) {
  double p[3], q[3], pp = 0, pq = 0, qq = 0;
  for (int d = 0; d < 3; d++) {
    p[d] = x[3 * m.n[1] + d] - x[3 * m.n[0] + d], q[d] = x[3 * m.n[2] + d] - x[3 * m.n[0] + d];
    pp += p[d] * p[d], pq += p[d] * q[d], qq += q[d] * q[d];
  }
  double along = std::sqrt(pp), across = std::sqrt(qq - pq * pq / pp);
  m.r[0] = 1 / along, m.r[1] = -pq / pp / across, m.r[2] = 1 / across;
  m.stiff = modulus * thickness * 0.5 * along * across / (1 - m.nu * m.nu);
}

inline Scene read_scene(const char *file) {
  std::ifstream in(file);
  Scene s;
  std::string word;
  size_t n;
  while (in >> word) {
    if (word == "time") in >> s.end >> s.every;
    if (word == "nodes") {
      in >> n;
      s.x0.resize(3 * n), s.mass.resize(n), s.fixed.resize(n);
      for (size_t i = 0; i < n; i++)
        in >> s.x0[3 * i] >> s.x0[3 * i + 1] >> s.x0[3 * i + 2] >> s.mass[i] >> s.fixed[i];
    }
    if (word == "springs") {
      in >> n;
      s.springs.resize(n);
      for (Spring &e : s.springs) in >> e.a >> e.b >> e.k >> e.rest >> e.c, s.damped |= e.c != 0;
    }
    if (word == "gravity") in >> s.gravity[0] >> s.gravity[1] >> s.gravity[2];
    if (word == "membranes") {
      in >> n;
      s.membranes.resize(n);
      double thickness, modulus;
      for (Membrane &m : s.membranes) {
        in >> m.n[0] >> m.n[1] >> m.n[2] >> thickness >> modulus >> m.nu >> m.wrinkles;
        add_rest_shape(m, s.x0, thickness, modulus);
      }
    }
    if (word == "forces") {
      in >> n;
      s.load.resize(s.x0.size());
      size_t node;
      for (double f[3]; n-- && in >> node >> f[0] >> f[1] >> f[2];)
        for (int d = 0; d < 3; d++) s.load[3 * node + d] += f[d];
    }
    if (word == "air") in >> s.linear >> s.quadratic >> s.wind[0] >> s.wind[1] >> s.wind[2];
    if (word == "triangles") {
      in >> n;
      s.triangles.resize(n);
      for (Triangle &t : s.triangles) in >> t.n[0] >> t.n[1] >> t.n[2];
      s.damped = true;
    }
  }
  if (s.x0.empty() || (s.springs.empty() && s.membranes.empty()) || in.bad()) throw std::runtime_error(std::string("no scene in ") + file);
  s.inverse_mass.assign(s.x0.size(), 0), s.weight.assign(s.x0.size(), 0);
  for (size_t i = 0; i < s.x0.size(); i++)
    if (!s.fixed[i / 3]) {
      s.inverse_mass[i] = 1 / s.mass[i / 3];
      s.weight[i] = s.mass[i / 3] * s.gravity[i % 3] + (s.load.empty() ? 0 : s.load[i]);
    }
  return s;
}

inline void air_forces(const Scene &s, const double *x, const double *v, double *f) {
  for (const Triangle &t : s.triangles) {
    const double *p = x + 3 * t.n[0], *q = x + 3 * t.n[1], *r = x + 3 * t.n[2];
    double e[3], g[3], u[3];
    for (int d = 0; d < 3; d++) {
      e[d] = q[d] - p[d], g[d] = r[d] - p[d];
      u[d] = s.wind[d] - (v[3 * t.n[0] + d] + v[3 * t.n[1] + d] + v[3 * t.n[2] + d]) / 3;
    }
    double a[3] = {0.5 * (e[1] * g[2] - e[2] * g[1]), 0.5 * (e[2] * g[0] - e[0] * g[2]),
                   0.5 * (e[0] * g[1] - e[1] * g[0])};  // area times unit normal
    double area = std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
    double through = (a[0] * u[0] + a[1] * u[1] + a[2] * u[2]) / area;
    double third = (s.linear + s.quadratic * std::fabs(through)) * through / 3;
    for (int n : t.n)
      for (int d = 0; d < 3; d++) f[3 * n + d] += third * a[d];
  }
}

// Stresses (11, 22, 12) times A0 t of an isotropic sheet by its Green strains (11, 22, 12): plane stress, or the tension field.
inline void sheet_stress(const Membrane &m, const double e[3], double out[3]) {
  out[0] = m.stiff * (e[0] + m.nu * e[1]), out[1] = m.stiff * (e[1] + m.nu * e[0]), out[2] = m.stiff * (1 - m.nu) * e[2];
  if (!m.wrinkles) return;
  double mean = 0.5 * (e[0] + e[1]), half = 0.5 * (e[0] - e[1]), radius = std::sqrt(half * half + e[2] * e[2]);
  double most = mean + radius, least = mean - radius;
  if (least + m.nu * most >= 0) return;
  // Wrinkled along the larger principal strain, or slack. A radius of 0 is slack, since then least = most < 0.
  double pull = most > 0 ? m.stiff * (1 - m.nu * m.nu) * most / (2 * radius) : 0;
  out[0] = pull * (radius + half), out[1] = pull * (radius - half), out[2] = pull * e[2];
}

inline void membrane_forces(const Scene &s, const double *x, double *f) {
  for (const Membrane &m : s.membranes) {
    const double *a = x + 3 * m.n[0], *b = x + 3 * m.n[1], *c = x + 3 * m.n[2];
    double u[3], w[3], uu = 0, ww = 0, uw = 0;  // the columns of the deformation gradient
    for (int d = 0; d < 3; d++) {
      double p = b[d] - a[d], q = c[d] - a[d];
      u[d] = p * m.r[0], w[d] = p * m.r[1] + q * m.r[2];
      uu += u[d] * u[d], ww += w[d] * w[d], uw += u[d] * w[d];
    }
    double e[3] = {0.5 * (uu - 1), 0.5 * (ww - 1), 0.5 * uw}, t[3];
    sheet_stress(m, e, t);
    for (int d = 0; d < 3; d++) {
      double p = t[0] * u[d] + t[2] * w[d], q = t[2] * u[d] + t[1] * w[d];
      double on_b = m.r[0] * p + m.r[1] * q, on_c = m.r[2] * q;
      f[3 * m.n[0] + d] += on_b + on_c, f[3 * m.n[1] + d] -= on_b, f[3 * m.n[2] + d] -= on_c;
    }
  }
}

template <bool DAMPED> void spring_forces(const Scene &s, const double *x, const double *v, double *f) {
  for (const Spring &e : s.springs) {
    int a = 3 * e.a, b = 3 * e.b;
    double d[3] = {x[b] - x[a], x[b + 1] - x[a + 1], x[b + 2] - x[a + 2]};
    double l = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    double pull = e.k * (l - e.rest) / l;
    for (int i = 0; i < 3; i++) {
      double t = pull * d[i];
      if (DAMPED) t += e.c * (v[b + i] - v[a + i]);
      f[a + i] += t, f[b + i] -= t;
    }
  }
}

// f(x, v), fixed nodes included: what hangs on them is multiplied by an inverse mass of 0.
inline void forces(const Scene &s, const double *x, const double *v, double *f) {
  for (int i = 0; i < s.dofs(); i++) f[i] = s.weight[i];
  if (s.damped) spring_forces<true>(s, x, v, f);
  else spring_forces<false>(s, x, v, f);
  membrane_forces(s, x, f);
  air_forces(s, x, v, f);
}

inline double cpu_seconds() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return t.tv_sec + 1e-9 * t.tv_nsec;
}

// A run fills `frames` with the positions at every multiple of scene.every, and tells what it took.
struct Job {
  std::string method, kind;
  double value;
  Vector frames;
  void keep(const double *x, int n) { frames.insert(frames.end(), x, x + n); }
};

// Steps between two frames; a step that does not divide their distance is refused, so that nobody interpolates.
inline long steps_a_frame(const Scene &s, const Job &job) {
  double ratio = s.every / job.value;
  long n = std::lround(ratio);
  if (n < 1 || std::fabs(ratio - n) > 1e-6 * ratio) throw std::runtime_error("the step does not divide the frames' distance");
  return n;
}

// Answers each line "METHOD step|tol VALUE FILE" with "done|diverged|refused SECONDS NOTE".
template <class Run> int serve(int argc, char **argv, const std::string &version, Run run) {
  if (argc != 2) return std::fprintf(stderr, "usage: %s SCENE < jobs\n", argv[0]), 2;
  Scene scene;
  try {
    scene = read_scene(argv[1]);
  } catch (const std::exception &why) {
    return std::fprintf(stderr, "%s\n", why.what()), 1;
  }
  std::cout << "ready " << version << std::endl;
  std::string line, file;
  while (std::getline(std::cin, line)) {
    Job job;
    std::istringstream(line) >> job.method >> job.kind >> job.value >> file;
    job.frames.reserve((size_t)scene.dofs() * scene.frames());
    try {
      double before = cpu_seconds();
      std::string note = run(scene, job);
      double seconds = cpu_seconds() - before;
      bool whole = job.frames.size() == (size_t)scene.dofs() * scene.frames();
      for (double x : job.frames) whole = whole && std::fabs(x) < 1e4;
      std::ofstream(file, std::ios::binary).write((const char *)job.frames.data(), 8 * (long)job.frames.size());
      std::cout << (whole ? "done " : "diverged ") << seconds << " " << note << std::endl;
    } catch (const std::exception &why) {
      std::cout << "refused 0 " << why.what() << std::endl;
    }
  }
  return 0;
}
