// The symmetric splitting method SRKN_11^b of Blanes and Moan for x'' = a(x), a Runge-Kutta-Nystrom method:
//   v += b1 dt a;  x += a1 dt v;  v += b2 dt a;  ...  x += a6 dt v;  and back again in the reverse order;
//   a = M^-1 f(x, v) at every kick.
// Twelve kicks, eleven forces a step: that of the last kick is the next step's first. Sixth order and
// symplectic without damping, as conditions of order are fewer where a is a function of x alone. A damping
// force uses the velocity before the kick, and before both of two steps' that meet, which reduces it to first
// order. Stable while w dt < 3.1414 without damping: there eigenvalues meet at -1, and motions grow by at
// most 5e-4 a step up to w dt = 3.1423. J. Comput. Appl. Math. 142 (2002) 313, table 3.
#include "integrators/explicit/kick_first.hpp"

namespace mss {

namespace {

const std::vector<DriftKick> parts = symmetric_parts(
    {0.0414649985182624, 0.198128671918067, -0.0400061921041533, 0.0752539843015807, -0.0115113874206879},
    {0.123229775946271, 0.290553797799558, -0.127049212625417, -0.246331761062075, 0.357208872795928});

template <class Real>
class Srkn6 final : public KickFirst<Real> {
 public:
  explicit Srkn6(const IntegratorOptions& options) : KickFirst<Real>(parts, options.dt) {}
};

double srkn6_limit(double omega, double damping) { return splitting_limit(parts, omega, damping); }

}  // namespace

IntegratorInfo srkn6() {
  return describe<Srkn6>(
      {.name = "srkn6",
       .summary = "Blanes and Moan: sixth order and symplectic undamped, eleven forces a step",
       .order_undamped = 6,
       .order_damped = 1,
       .symplectic = true,
       .limit = srkn6_limit,
       .resonant_limit = true,
       .splitting = parts});
}

}  // namespace mss
