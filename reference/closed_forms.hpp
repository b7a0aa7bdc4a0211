#pragma once

namespace mss::reference {

/// A straight prismatic bar of square cross-section; SI units. Small deflections.
struct SquareBar {
  double young, poisson;
  double width, length;
};

/// Extension under a pull F at its end: F L / (E A).
double pulled_extension(const SquareBar& bar, double force);

/// Tip deflection of a cantilever under a shear force F at its tip, by Timoshenko's theory with Cowper's
/// shear coefficient 10 (1 + nu) / (12 + 11 nu) (J. Appl. Mech. 33 (1966) 335): F L^3 / (3 E I) + F L / (k G
/// A). A clamp that holds the whole end also stops it from narrowing, which makes a real one stiffer.
double cantilever_deflection(const SquareBar& bar, double force);

/// The same for E = 1e5 Pa, nu = 0.3, 4 x 1 x 1 m, F = 1 N with its whole end clamped: finite elements
/// (CalculiX 2.20, C3D20, converged), mean over the end face [m].
inline constexpr double clamped_cantilever_deflection = 2.632e-3;

}  // namespace mss::reference
