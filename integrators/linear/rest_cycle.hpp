#pragma once

#include <array>
#include <memory>
#include <vector>

#include "core/springs/solid_system.hpp"
#include "integrators/integrator.hpp"
#include "integrators/linear/rest_level.hpp"

namespace mss {

/// What a plane makes of a particle: directions in which it cannot move, as a projection onto them, and by
/// how much friction changes with its velocity [kg], which counts among masses.
struct HeldParticle {
  std::ptrdiff_t site;
  Eigen::Matrix3d directions, friction;
};

/// An approximate inverse of a M + b C + c K for quasi-Newton methods, symmetric and positive definite: one
/// V-cycle (or an additive cycle) in single precision on the lattice of springs at rest (rest_level.hpp),
/// with the particles' rotations Q on both sides,
///   H = Q A_rest^-1 Q^T,
/// as warping turns a linear body's stiffness (Mueller and Gross, Interactive virtual materials, Graphics
/// Interface 2004). Nothing in it depends on strains, so it is prepared once a step size, and placed once a
/// stage. Where cells have several sizes there is a lattice for each (rest_level.hpp), and particles that
/// hang on others follow them.
///
/// Along axes in which nothing of a piece is held it is P H P^T + 1 1^T / m, P what keeps the piece's centre
/// of mass and m its mass: then a step of a quasi-Newton method changes linear momentum by what the residual
/// says, to rounding, and pieces that hang together with nothing fall. Pieces are what springs connect, and
/// what hangs on their particles.
class RestCycle {
 public:
  /// For a body of cells, whose springs stand for whatever fills them. The system must outlive it, and its
  /// holds must stay. Throws InputError if the system is no such body; `user` is who asks.
  RestCycle(System<double>& system, const std::string& user, Cycle kind = Cycle::v);
  ~RestCycle();

  /// Prepares for a matrix. Status ok, or not_positive_definite.
  Status prepare(const TangentCoefficients& sum);
  /// Takes the rotations that particles at x have.
  void place(const Field<double>& x);
  /// Takes one rotation for every piece, next to that of all its particles. Where those of neighbours differ
  /// much, fields that only turn with them strain the body, and place() takes them for rigid motions: too
  /// soft by far at long steps.
  void place_stiffly(const Field<double>& x);
  /// Holds these from now on. place() keeps what is held.
  void hold(std::vector<HeldParticle> held);

  /// v += change, of every piece along the axes in which nothing of it is held or prescribed.
  void add_where_free(const Vec3& change, Field<double>& v);

  /// Bends the paths of pieces that nothing holds, from x to x + seconds v, by what turning at their angular
  /// velocity does: on straight ones a body that spins would grow.
  void bend_paths(const Field<double>& x, double seconds, Field<double>& v);

  /// z = H r. Prescribed coordinates of r must be 0; those of z are, and so are its held directions, but for
  /// those of `values`, to which the rest of z gives way: of size 0, none.
  /// `norm`, of r, scales it to what single precision can hold.
  void solve(const Field<double>& r, double norm, const Field<double>& values, Field<double>& z);

 private:
  /// Particles that springs connect.
  struct Piece {
    double mass = 0;                                 ///< [kg]
    Eigen::Array3d free = Eigen::Array3d::Ones();    ///< 1 along axes in which nothing is prescribed, else 0
    Eigen::Array3d unheld = Eigen::Array3d::Ones();  ///< the same of what is held
    Vec3 keeps(const Vec3& vector) const { return free * unheld * vector.array(); }
  };
  /// Some of a piece's particles, which one thread adds up.
  struct Portion {
    std::size_t piece, first, last;  ///< of sites_
  };

  /// One of the body's lattices: its particles, where they lie in the cycle's lattice for cells of their
  /// size, and how they have turned.
  struct TurnedLattice {
    TurnedLattice(const Level& of_body, RestLevel& of_cycle, std::size_t depth,
                  const std::array<int, 3>& corner);

    /// Of a particle at a site of it.
    Eigen::Matrix3d rotation(std::ptrdiff_t site) const;

    const Body& body;
    std::ptrdiff_t first;   ///< of its sites in fields
    RestLevel& level;       ///< of the cycle
    std::size_t depth = 0;  ///< how many of the cycle's have smaller cells
    LatticeWindow window;
    PaddedArrays positions, rotations;
    PaddedArrays turning;  ///< shares of edges ahead and behind by axis, and 1 for a particle that moves
    PaddedArrays vectors;  ///< where the lattices differ
  };

  void build(const Field<double>& unknown);
  void build_refined(const RefinedBody& body, const Field<double>& unknown);
  void find_edges(TurnedLattice& lattice, const Field<double>& unknown) const;
  void find_pieces(const Field<double>& unknown);
  bool any_piece_keeps() const;
  template <class Part>
  std::vector<Vec3> means(Part&& part) const;
  template <class Part>
  void for_each_of_pieces(Part&& part) const;
  TurnedLattice& lattice_of(std::ptrdiff_t site_in_field);
  void set_rotations();
  void hold_in_lattice();
  void turn_back(const TurnedLattice& lattice, const Field<double>& r, double norm, PaddedArrays& out) const;
  void turn_back(const Field<double>& r, double norm);
  void turn(double norm, Field<double>& z);
  void subtract_forces_of(const Field<double>& values, Field<double>& r);
  void take_held(const Field<double>& values, Field<double>& z) const;

  System<double>& system_;
  const SolidSystem<double>& solid_;
  Parallel parallel_;
  Cycle kind_;
  TangentCoefficients sum_;
  std::vector<std::unique_ptr<const Body>> merged_;  ///< with smaller cells merged, the largest cells first
  std::unique_ptr<RestLevel> finest_;
  std::vector<TurnedLattice> lattices_;    ///< as the solid's levels
  std::vector<RestLevel*> partly_filled_;  ///< where the body has fewer particles than the cycle
  std::vector<HeldParticle> held_;
  std::vector<Piece> pieces_;
  std::vector<int> piece_of_;          ///< by site in fields
  std::vector<std::ptrdiff_t> sites_;  ///< in fields, piece by piece
  std::vector<double> masses_;         ///< of them [kg]
  std::vector<Portion> portions_;
  Field<double> r_;
};

}  // namespace mss
