#pragma once

#include <array>
#include <memory>
#include <tuple>
#include <vector>

#include "core/springs/body_tangents.hpp"
#include "reference/cell_sum.hpp"
#include "reference/fem/solid_law.hpp"

namespace mss {

/// One cell: a trilinear hexahedron with eight Gauss points.
class FemElement {
 public:
  using Corners = CellCorners;
  using Element = CellMatrix;

  /// Full of a part, of edge `size` [m]. Throws InputError if the part has no elastic constants.
  FemElement(const Part& part, double size, const SolidLaw& law);

  double energy(const Corners& x) const;                    ///< [J]
  Corners force(const Corners& x, const Corners& v) const;  ///< on the corners [N]
  /// b C + c K of a sum.
  Element tangent(const Corners& x, const Corners& v, const TangentCoefficients& sum) const;

  /// Largest eigenvalues of its matrices at rest.
  struct Largest {
    double stiffness;  ///< [N/m]
    double damping;    ///< [kg/s]
  };
  Largest largest() const;

 private:
  static constexpr std::size_t points = std::tuple_size_v<PointMatrices>;
  PointMatrices at_points(const Corners& x) const;  ///< deformation gradients, or rates
  Eigen::Matrix3d viscous_stress(const Eigen::Matrix3d& f, const Eigen::Matrix3d& rate) const;
  Matrix9 viscous_change(const Eigen::Matrix3d& f, const Eigen::Matrix3d& rate,
                         const TangentCoefficients& sum) const;
  CellStiffness stiffness(const PointMatrices& f, bool projected) const;

  SolidLaw law_;
  Lame lame_;
  Lame viscosity_;                                             ///< of the stress of a strain rate [Pa s]
  double size_;                                                ///< of an edge [m]
  double weight_;                                              ///< volume of a Gauss point [m^3]
  std::array<Eigen::Matrix<double, 8, 3>, points> gradients_;  ///< of shape functions, by corner [1/m]
};

/// A body whose cells are trilinear hexahedra with eight Gauss points each and its particles' lumped masses.
/// Partly filled cells resist as far as they are filled, evenly; several parts in a cell add up.
///
/// Damping, where the body has it, is viscous (Kelvin-Voigt): the stress 2 eta e' + lambda' tr(e') I of the
/// strain rate e', in the body's own frame. With a viscosity eta, lambda' = eta as calibrated springs have it
/// (Damping); by the other laws both are those of a strain times the ratio c/k that an interior edge spring
/// of the same material has. It is taken at every Gauss point by laws of a mean dilatation too.
class FemSystem final : public BodySystem<double> {
 public:
  /// The body must outlive the system. Throws InputError if it has no elastic constants.
  FemSystem(const Body& body, const Environment& environment, const SolidLaw& law, int threads = 0);

  StoredEnergy stored_energy(const Field<double>& x) const override;
  std::optional<std::vector<Eigen::Matrix3d>> cell_virials(const Field<double>& x,
                                                           const Field<double>& v) const override;
  const char* kernel_name() const override { return "finite elements"; }

  void force(double t, const Field<double>& x, const Field<double>& v, Field<double>& f) override;
  Tangents<double>* tangents() override { return &tangents_; }

 private:
  class FemTangents final : public BodyTangents<double> {
   public:
    explicit FemTangents(FemSystem& system) : BodyTangents<double>(system), system_(system) {}

   private:
    void add(double t, const Field<double>& x, const Field<double>& v, const TangentCoefficients& sum,
             BlockMatrix& blocks) override;
    void add_diagonal(double t, const Field<double>& x, const Field<double>& v,
                      const TangentCoefficients& sum, std::vector<Eigen::Matrix3d>& diagonal) override;
    void multiply(double t, const Field<double>& x, const Field<double>& v, const TangentCoefficients& sum,
                  const Field<double>& p, Field<double>& out) override;

    /// The cells' tangent without masses; kept, as every product with it would cost as much as assembling it.
    const BlockMatrix& assembled(const Field<double>& x, const Field<double>& v, TangentCoefficients sum);

    FemSystem& system_;
    std::unique_ptr<BlockMatrix> assembled_;
    Field<double> x_, v_;      ///< that it is assembled for
    TangentCoefficients sum_;  ///< likewise
  };

  CellCorners gather(const Field<double>& field, std::ptrdiff_t site) const {
    return corners_at(body(), field, site);
  }

  template <class Value, class OfPart>
  Value sum_over_parts(std::ptrdiff_t site, Value sum, OfPart&& of_part) const;
  CellCorners cell_force(const Field<double>& x, const Field<double>& v, std::ptrdiff_t site) const;
  CellMatrix tangent(const Field<double>& x, const Field<double>& v, const TangentCoefficients& sum,
                     std::ptrdiff_t site) const;

  std::vector<FemElement> elements_;  ///< by part
  CellSum cells_;
  FemTangents tangents_;
};

}  // namespace mss
