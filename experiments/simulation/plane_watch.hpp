#pragma once

#include <optional>
#include <vector>

#include "core/base/record.hpp"
#include "core/environment/obstacle.hpp"
#include "core/mesh/embedded_surface.hpp"
#include "core/scene/scene.hpp"
#include "core/springs/solid_system.hpp"

namespace mss {

/// Where a run had something behind a plane, or in an obstacle, that should not be there.
struct Penetration {
  std::size_t plane = 0;     ///< in the environment's order; obstacles follow planes
  double t = 0;              ///< of the row where it was deepest [s]
  double depth = 0;          ///< [m]
  bool ends_whole = false;   ///< the whole body is behind the plane at the end
  bool of_vertices = false;  ///< of the surface, instead of particles
};

/// Watches at the rows of a run how deep the particles, or where planes touch a surface its vertices, are
/// behind planes or in obstacles. Rounding is allowed, and of penalty planes, which push what is behind them,
/// a share of a cell. Not counted: particles that are held against the plane, and what has been behind it
/// from the start, unless it is still there at the end. A mesh may be a hundredth of a cell deep, where its
/// edges turn in.
template <class Real>
class PlaneWatch {
 public:
  /// Depth that penalty planes may have, over a cell's size: falls of a few m/s make that.
  static constexpr double tolerated_by_penalties = 0.1;

  /// Both must outlive it.
  PlaneWatch(const Scene& scene, const SolidSystem<Real>& system);

  /// All ranks must call it.
  void add(const State<Real>& state);

  /// Whether a plane of the law `impulse` has yet to push out what began behind it.
  bool lifts() const;
  /// Of every plane that was passed.
  std::vector<Penetration> found() const;
  void remember(Record& record) {
    for (Watched& watched : watched_)
      record.keep(watched.was_clear, watched.t, watched.depth, watched.ends_whole);
  }

 private:
  struct Depths {
    double largest, smallest;  ///< [m], of all points; negative in front
    double rounding;           ///< of the deepest point [m]
  };
  struct Watched {
    std::vector<std::ptrdiff_t> sites;
    double tolerated = 0;     ///< [m]
    bool was_clear = false;   ///< nothing was behind it at some row
    double t = 0, depth = 0;  ///< of the deepest row since; before, of the last one
    bool ends_whole = false;
  };
  Depths depths(std::size_t plane, const State<Real>& state) const;
  ContactLaw law(std::size_t plane) const {
    return plane < planes_.size() ? planes_[plane].contact
                                  : obstacles_[plane - planes_.size()].obstacle().contact;
  }
  double gap(std::size_t plane, const Vec3& x, double t) const {
    return plane < planes_.size() ? planes_[plane].gap(x) : obstacles_[plane - planes_.size()].gap(x, t);
  }

  const std::vector<Plane>& planes_;
  std::vector<ObstacleSurface> obstacles_;
  const SolidSystem<Real>& system_;
  /// A mesh that planes touch, and the part of the fields that carries it.
  struct Touched {
    EmbeddedSurface surface;
    std::ptrdiff_t first, size;
  };
  std::vector<Touched> surfaces_;
  std::vector<Watched> watched_;  ///< by plane, then by obstacle
};

}  // namespace mss
