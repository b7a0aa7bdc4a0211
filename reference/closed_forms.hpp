#pragma once

namespace mss::reference {

/// A straight prismatic bar of square cross-section; SI units. Small deflections.
struct SquareBar {
  double young, poisson;
  double width, length;
};

/// Tip deflection of a cantilever under a shear force F at its tip, by Timoshenko's theory with Cowper's
/// shear coefficient 10 (1 + nu) / (12 + 11 nu) (J. Appl. Mech. 33 (1966) 335): F L^3 / (3 E I) + F L / (k G
/// A). A clamp that holds the whole end also stops it from narrowing, which makes it stiffer.
double cantilever_deflection(const SquareBar& bar, double force);

/// Torque for a twist by one radian of a bar whose ends may warp [N m], after Saint-Venant: G J / L with
///   J = a^4 / 3 (1 - 192 / pi^5 sum_{k odd} tanh(k pi / 2) / k^5) = 0.1406 a^4
/// (Timoshenko and Goodier, Theory of Elasticity, art. 109).
double torsion_stiffness(const SquareBar& bar);

/// How far the lowest point of the axis sinks when a bar hangs from its top under its own weight [m]:
/// rho g L^2 / (2 E), exactly, if the top's points are held on the paraboloid rho g nu r^2 / (2 E) that they
/// form where stresses are uniaxial (Timoshenko and Goodier, art. 86).
double hanging_sag(const SquareBar& bar, double density, double gravity);

/// Longitudinal frequency of a bar, one end held and sides free [Hz], mode 1, 2 ...:
/// (2 mode - 1) / (4 L) sqrt(stiffness / density). Thin bars have stiffness E; if the sides are held, C11; if
/// points move only across it, in shear, G.
double bar_frequency(double stiffness, double density, double length, int mode);

/// The same for the chain of `links` equal springs that a lattice makes of such a bar, its last mass half the
/// others (one at a free surface) [Hz]: sin(pi (2 mode - 1) / (4 links)) / pi sqrt(stiffness / density) / h.
double chain_frequency(double stiffness, double density, double length, int links, int mode);

/// How a string or a membrane that is held at its rim is stretched.
struct Stretched {
  double length;   ///< of a string, or of the edges of a square membrane, as it is stretched [m]
  double tension;  ///< of a string [N], or across a unit of length of a membrane, in every direction [N/m]
  double mass;     ///< of a unit of length of the string, or of area of the membrane, as stretched [kg/m^d]
};

/// Speed of waves across a string or a membrane [m/s]: sqrt(tension / mass).
double transverse_speed(const Stretched& body);

/// Frequency of a string across it, mode 1, 2 ... [Hz]: mode / (2 L) sqrt(T / mu); of a string with equal
/// beads, `links` apart from end to end, sin(pi mode / (2 links)) 2 links / (pi mode) of that (Lagrange).
double string_frequency(const Stretched& string, int mode);
double beaded_string_frequency(const Stretched& string, int links, int mode);

/// Frequency of a square membrane, with p and q half-waves along its edges [Hz]: sqrt(p^2 + q^2) / (2 L)
/// sqrt(N / sigma) (Rayleigh, The Theory of Sound, art. 195).
double membrane_frequency(const Stretched& membrane, int p, int q);
/// The same for a square net of equal beads, `squares` along an edge, whose edges resist motion across it
/// with N/2 and whose diagonals with N/4 [N/m]: with a = pi p / (2 squares), b = pi q / (2 squares)
///   w^2 = N / (sigma h^2) (2 sin^2 a + 2 sin^2 b + 1 - cos 2a cos 2b).
double net_frequency(const Stretched& membrane, int squares, int p, int q);

/// A rope that hangs between two points of equal height.
struct Catenary {
  double sag;   ///< of its middle below its ends [m]
  double pull;  ///< along the line between its ends, over its weight
  double rise;  ///< across it at each end, over its weight: 1/2
};
/// Of a length at rest [m], more than the span [m], and of a stiffness E A of 1 / `stretch` times its weight;
/// 0: it does not stretch. With a = pull times the length
///   span / length = stretch pull + 2 pull asinh(1 / (2 pull)),
///   sag / length = stretch / 8 + hypot(pull, 1/2) - pull
/// (Irvine, Cable Structures, 1981, section 1.3).
Catenary catenary(double length, double span, double stretch);

/// Logarithmic decrement of a vibration of a Kelvin-Voigt solid, ln of the ratio of two successive peaks:
/// 2 pi zeta / sqrt(1 - zeta^2), zeta = viscosity omega / (2 stiffness), with the viscosity [Pa s] and the
/// stiffness [Pa] of the mode's strain and omega = 2 pi times its undamped frequency [Hz].
double logarithmic_decrement(double viscosity, double stiffness, double frequency);

/// Height [m] a particle comes back to after a number of bounces, dropped from a height; each keeps e^2 of
/// it.
double bounce_height(double drop, double restitution, int bounces);

/// How far a block at rest slides down a slope in a time [m]: 1/2 g (sin - mu cos) t^2, or not at all where
/// tan(angle) <= mu.
double slope_distance(double gravity, double angle, double friction, double time);

/// How far a block slides on level ground before it stops [m]: v^2 / (2 mu g).
double stopping_distance(double gravity, double speed, double friction);

/// Of a rope that slides around a cylinder by an angle: tension where it goes over where it comes from,
/// exp(mu angle). Euler and Eytelwein.
double capstan_ratio(double friction, double angle);

}  // namespace mss::reference
