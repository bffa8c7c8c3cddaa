// The wires rig by Boost.odeint: dense output of dopri5, switches located on it.
//
// Usage: boost CELLS.csv STEM RTOL STEPS   (writes STEM.csv, STEM.json)
#include <array>
#include <boost/numeric/odeint.hpp>
#include <boost/version.hpp>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

using State = std::array<double, 2>;

constexpr double A0 = 0.89e-3, L = 0.075, G = 9.81, M = 0.298, KI = 5.5e6, CI = 1.2e3;
constexpr int CYCLES = 300, RECORDED = 100;
// Relative tolerance (the absolute is a hundredth of it), and steps per drive period at least.
double rtol = 1e-8, steps = 16;

struct Rig {
  double gap, omega;
  bool contact = false;

  // Penetration and its rate.
  void surface(const State &y, double &delta, double &rate) const {
    delta = L * std::sin(y[0]) - gap;
    rate = L * y[1] * std::cos(y[0]);
  }
  double force(const State &y) const {
    double delta, rate;
    surface(y, delta, rate);
    return KI * delta + CI * rate;
  }
  // Equations (3-15) and (3-16).
  void operator()(const State &y, State &d, double t) const {
    double s = std::sin(y[0]), c = std::cos(y[0]);
    d[0] = y[1];
    d[1] = (A0 * omega * omega * c * std::sin(omega * t) - G * s) / L;
    if (contact)
      d[1] -= (KI * (L * s - gap) + CI * L * y[1] * c) / (M * L);
  }
  double force_rate(const State &y, double t) const {
    State d;
    (*this)(y, d, t);
    double s = std::sin(y[0]), c = std::cos(y[0]);
    return KI * L * y[1] * c + CI * L * (d[1] * c - y[1] * y[1] * s);
  }
  // Positive: this side of the switch is left.
  double leaving(const State &y) const {
    double delta, rate;
    surface(y, delta, rate);
    double f = KI * delta + CI * rate;
    return contact ? -f : std::fmin(KI * delta, f);
  }
};

// Root of f in [a, b], f(a) < 0 < f(b), by the Illinois method; ends on the positive side.
template <class F> double root(F f, double a, double fa, double b, double fb) {
  for (int i = 0; i < 100 && b - a > 1e-13; i++) {
    double c = (a * fb - b * fa) / (fb - fa);
    if (!(c > a && c < b))
      c = 0.5 * (a + b);
    double fc = f(c);
    if (fc > 0) {
      b = c;
      fb = fc;
      fa *= 0.5;
    } else {
      a = c;
      fa = fc;
      fb *= 0.5;
    }
    if (i % 8 == 7) { // never slower than bisection by much
      double m = 0.5 * (a + b), fm = f(m);
      if (fm > 0)
        b = m, fb = fm;
      else
        a = m, fa = fm;
    }
  }
  return b;
}

struct Strobe {
  double q, v, force;
  int onsets;
};

std::vector<Strobe> simulate(double gap, double hz) {
  using namespace boost::numeric::odeint;
  Rig rig{gap, 2 * M_PI * hz};
  const double period = 1 / hz;
  auto stepper = make_dense_output(0.01 * rtol, rtol, period / steps, runge_kutta_dopri5<State>());
  State y{0, 0};
  stepper.initialize(y, 0.0, 1e-5);
  rig.contact = rig.leaving(y) > 0;
  std::vector<Strobe> strobes;
  Strobe now{0, 0, 0, 0};
  int cycle = 1;
  while (cycle <= CYCLES) {
    auto [t0, t1] = stepper.do_step(std::ref(rig));
    State y0 = stepper.previous_state(), y1 = stepper.current_state();
    auto at = [&](double t) {
      State s;
      stepper.calc_state(t, s);
      return s;
    };
    double g0 = rig.leaving(y0), g1 = rig.leaving(y1), end = t1;
    bool leaves = g1 > 0;
    if (!leaves && !rig.contact && y0[1] > 0 && y1[1] < 0) {
      // The hammer turns inside the step: the crest may have touched.
      double top = root([&](double t) { return -at(t)[1]; }, t0, -y0[1], t1, -y1[1]);
      double crest = rig.leaving(at(top));
      if (crest > 0)
        leaves = true, t1 = top, g1 = crest;
    }
    if (leaves) {
      auto g = [&](double t) { return rig.leaving(at(t)); };
      end = g0 < 0 ? root(g, t0, g0, t1, g1) : root(g, t0, -1e-300, t1, g1);
    }
    State ye = at(end);
    if (rig.contact) {
      double peak = std::fmax(rig.force(y0), rig.force(ye));
      double r0 = rig.force_rate(y0, t0), r1 = rig.force_rate(ye, end);
      if (r0 > 0 && r1 < 0) {
        double top = root([&](double t) { return -rig.force_rate(at(t), t); }, t0, -r0, end, -r1);
        peak = std::fmax(peak, rig.force(at(top)));
      }
      now.force = std::fmax(now.force, peak);
    }
    while (cycle <= CYCLES && cycle * period <= end) {
      State s = at(cycle * period);
      now.q = s[0];
      now.v = s[1];
      if (cycle >= CYCLES - RECORDED)
        strobes.push_back(now);
      now = Strobe{0, 0, 0, 0};
      cycle++;
    }
    if (leaves) {
      rig.contact = !rig.contact;
      if (rig.contact)
        now.onsets++;
      stepper.initialize(ye, end, 1e-5);
    }
  }
  return strobes;
}

int main(int argc, char **argv) {
  if (argc != 5) {
    fprintf(stderr, "say CELLS.csv STEM RTOL STEPS\n");
    return 2;
  }
  rtol = std::stod(argv[3]);
  steps = std::stod(argv[4]);
  std::ifstream in(argv[1]);
  std::string line;
  std::getline(in, line);
  std::vector<std::array<double, 2>> cells;
  while (std::getline(in, line)) {
    double gap, hz;
    char comma;
    std::istringstream(line) >> gap >> comma >> hz;
    cells.push_back({gap * 1e-3, hz});
  }
  std::vector<std::vector<Strobe>> all;
  timespec a, b;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &a);
  for (auto [gap, hz] : cells)
    all.push_back(simulate(gap, hz));
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &b);
  std::string out = argv[2];
  FILE *f = fopen((out + ".csv").c_str(), "w");
  fprintf(f, "cell,q,v,onsets,force_n\n");
  for (size_t i = 0; i < all.size(); i++)
    for (auto &s : all[i])
      fprintf(f, "%zu,%.17g,%.17g,%d,%.17g\n", i, s.q, s.v, s.onsets, s.force);
  fclose(f);
  f = fopen((out + ".json").c_str(), "w");
  fprintf(f, "{\"name\": \"Boost.odeint %d.%d, dopri5, dense output, %g\", \"cycles\": %zu, \"cpu_s\": %.6f}\n",
          BOOST_VERSION / 100000, BOOST_VERSION / 100 % 1000, rtol, cells.size() * CYCLES,
          (b.tv_sec - a.tv_sec) + 1e-9 * (b.tv_nsec - a.tv_nsec));
  fclose(f);
}
