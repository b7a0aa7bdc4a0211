#pragma once

#include <Eigen/SparseCore>
#include <cstddef>
#include <vector>

#include "core/base/field.hpp"

namespace mss {

/// Which derivative of the force a tangent matrix contains.
enum class Tangent {
  exact,     ///< all of it; unsymmetric where springs damp while they rotate
  elastic,   ///< without the change of damping forces as springs rotate: symmetric, indefinite under pressure
  projected  ///< the elastic one made positive semidefinite, spring by spring and cell by cell
};

/// The matrix a M + b C + c K, with C = -df/dv and K = -df/dx, that one step of an implicit method needs.
struct TangentCoefficients {
  double mass = 0;       ///< a
  double damping = 0;    ///< b
  double stiffness = 0;  ///< c
  Tangent kind = Tangent::exact;

  friend bool operator==(const TangentCoefficients&, const TangentCoefficients&) = default;
};

/// A coordinate that nothing prescribes.
struct FreeDof {
  std::ptrdiff_t site;
  int axis;
};

/// Rows in compressed form; rows and columns are unknowns.
using SparseMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor, int>;

/// Derivatives of a system's forces: what implicit methods, equilibria and modes need and explicit methods do
/// not.
template <class Real>
class Tangents {
 public:
  Tangents() = default;
  Tangents(const Tangents&) = delete;
  Tangents& operator=(const Tangents&) = delete;
  virtual ~Tangents() = default;

  /// In the order of a matrix's rows: by particle, then axis.
  virtual const std::vector<FreeDof>& unknowns() = 0;

  /// A matrix with an entry for every number that may not be zero; all are zero.
  virtual SparseMatrix pattern() = 0;
  /// False: what touches what changes from state to state, and with it the entries that values() writes.
  virtual bool has_fixed_pattern() const { return true; }

  /// Rewrites the values of a matrix from pattern() in place.
  virtual void values(double t, const Field<Real>& x, const Field<Real>& v, const TangentCoefficients& sum,
                      SparseMatrix& matrix) = 0;

  /// out = (a M + b C + c K) p for all coordinates, prescribed ones included, without the matrix;
  /// overwritten. Not for Tangent::exact.
  virtual void product(double t, const Field<Real>& x, const Field<Real>& v, const TangentCoefficients& sum,
                       const Field<Real>& p, Field<Real>& out) = 0;

  /// The 3 x 3 blocks on the diagonal, one per particle, prescribed coordinates included; resized and
  /// overwritten.
  virtual void diagonal(double t, const Field<Real>& x, const Field<Real>& v, const TangentCoefficients& sum,
                        std::vector<Eigen::Matrix3d>& blocks) = 0;
};

}  // namespace mss
