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

struct Scene {
  double end = 0, every = 0;
  Vector x0, mass;         // 3 and 1 a node
  std::vector<int> fixed;  // 1 a node
  std::vector<Spring> springs;
  std::vector<Triangle> triangles;
  double gravity[3] = {0, 0, 0};
  double linear = 0, quadratic = 0, wind[3] = {0, 0, 0};  // dp = linear v_n + quadratic v_n |v_n|
  Vector inverse_mass, weight;                             // 3 a node; 0 where fixed
  bool damped = false;

  int dofs() const { return (int)x0.size(); }
  int frames() const { return (int)std::lround(end / every); }
};

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
    if (word == "air") in >> s.linear >> s.quadratic >> s.wind[0] >> s.wind[1] >> s.wind[2];
    if (word == "triangles") {
      in >> n;
      s.triangles.resize(n);
      for (Triangle &t : s.triangles) in >> t.n[0] >> t.n[1] >> t.n[2];
      s.damped = true;
    }
  }
  if (s.x0.empty() || s.springs.empty() || in.bad()) throw std::runtime_error(std::string("no scene in ") + file);
  s.inverse_mass.assign(s.x0.size(), 0), s.weight.assign(s.x0.size(), 0);
  for (size_t i = 0; i < s.mass.size(); i++)
    for (int d = 0; d < 3; d++)
      if (!s.fixed[i]) s.inverse_mass[3 * i + d] = 1 / s.mass[i], s.weight[3 * i + d] = s.mass[i] * s.gravity[d];
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

// f(x, v), fixed nodes included: what hangs on them is multiplied by an inverse mass of 0.
inline void forces(const Scene &s, const double *x, const double *v, double *f) {
  for (int i = 0; i < s.dofs(); i++) f[i] = s.weight[i];
  for (const Spring &e : s.springs) {
    int a = 3 * e.a, b = 3 * e.b;
    double dx = x[b] - x[a], dy = x[b + 1] - x[a + 1], dz = x[b + 2] - x[a + 2];
    double l = std::sqrt(dx * dx + dy * dy + dz * dz);
    double t = e.k * (l - e.rest) / l;
    f[a] += t * dx, f[a + 1] += t * dy, f[a + 2] += t * dz;
    f[b] -= t * dx, f[b + 1] -= t * dy, f[b + 2] -= t * dz;
  }
  if (!s.damped) return;
  for (const Spring &e : s.springs)
    for (int d = 0; d < 3; d++) {
      double t = e.c * (v[3 * e.b + d] - v[3 * e.a + d]);
      f[3 * e.a + d] += t, f[3 * e.b + d] -= t;
    }
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
