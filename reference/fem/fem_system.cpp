#include "reference/fem/fem_system.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <set>

#include "core/base/error.hpp"
#include "core/body/fill_shares.hpp"

namespace mss {

using Eigen::Matrix3d;

Lame lame_constants(const ElasticConstants& material) {
  const auto [young, poisson] = material;
  return {young / (2 * (1 + poisson)), young * poisson / ((1 + poisson) * (1 - 2 * poisson))};
}

namespace {

ElasticConstants material_of(const Part& part) {
  if (!part.elastic)
    throw InputError("finite elements need a material of young and poisson, not one of spring constants");
  return *part.elastic;
}

/// Viscosities that a part's damping stands for, see FemSystem.
Lame viscosity_of(const Part& part, double size, const Lame& lame) {
  if (part.damping.law == Damping::Law::none) return {};
  if (part.damping.law == Damping::Law::viscosity)
    return {.mu = part.damping.viscosity, .lambda = part.damping.viscosity};
  const double mass = part.density * (size * size * size), k = part.springs.edge;
  const double shear_modulus = cubic_stiffness(part.springs, size).c44;
  const double seconds = part.damping.coefficient(k, mass, mass, size, shear_modulus) / k;
  return {.mu = seconds * lame.mu, .lambda = seconds * lame.lambda};
}

/// 2 mu e + lambda tr(e) I.
Matrix3d linear_stress(const Lame& lame, const Matrix3d& strain) {
  return 2 * lame.mu * strain + lame.lambda * strain.trace() * Matrix3d::Identity();
}

Matrix3d symmetric(const Matrix3d& m) { return (m + m.transpose()) / 2; }

Eigen::Map<const Eigen::Matrix<double, 9, 1>> as_vector(const Matrix3d& m) {
  return Eigen::Map<const Eigen::Matrix<double, 9, 1>>(m.data());
}

/// A thread per some fifty cells pays: each takes ten microseconds or so.
int team_size(const Body& body, int requested) {
  if (requested > 0) return std::min(requested, int(std::min<std::size_t>(body.cell_count(), 1024)));
  return std::clamp(std::min(available_cores(), int(body.cell_count() / 50)), 1, 1024);
}

}  // namespace

FemElement::FemElement(const Part& part, double size, const SolidLaw& law)
    : law_(law),
      lame_(lame_constants(material_of(part))),
      viscosity_(viscosity_of(part, size, lame_)),
      size_(size),
      weight_(size * size * size / points) {
  const auto side = [](int corner, int axis) { return ((corner >> axis) & 1) != 0 ? 1.0 : -1.0; };
  for (std::size_t g = 0; g < points; ++g)
    for (int c = 0; c < 8; ++c)
      for (int axis = 0; axis < 3; ++axis) {
        double gradient = side(c, axis) / (4 * size);
        for (const int other : {(axis + 1) % 3, (axis + 2) % 3})
          gradient *= 1 + side(c, other) * side(int(g), other) / std::sqrt(3);
        gradients_[g](c, axis) = gradient;
      }
}

Matrix3d FemElement::viscous_stress(const Matrix3d& f, const Matrix3d& rate) const {
  const Matrix3d frame = law_.small_rotations ? Matrix3d::Identity() : f;
  return frame * linear_stress(viscosity_, symmetric(frame.transpose() * rate));
}

/// How b times viscous stress and c times what c counts of it change with F and its rate: column by column,
/// as it is linear in a change.
Matrix9 FemElement::viscous_change(const Matrix3d& f, const Matrix3d& rate,
                                   const TangentCoefficients& sum) const {
  Matrix9 d = Matrix9::Zero();
  if (viscosity_.mu == 0 || (sum.damping == 0 && sum.kind != Tangent::exact)) return d;
  for (int entry = 0; entry < 9; ++entry) {
    Matrix3d change = Matrix3d::Zero();
    change.data()[entry] = 1;
    Matrix3d response = sum.damping * viscous_stress(f, change);
    if (sum.kind == Tangent::exact && !law_.small_rotations) {
      const Matrix3d strain = symmetric(f.transpose() * rate), turned = symmetric(change.transpose() * rate);
      response += sum.stiffness *
                  (change * linear_stress(viscosity_, strain) + f * linear_stress(viscosity_, turned));
    }
    d.col(entry) += as_vector(response);
  }
  return d;
}

CellStiffness FemElement::stiffness(const PointMatrices& f, bool projected) const {
  CellStiffness stiffness;
  if (law_.stiffnesses)
    law_.stiffnesses(lame_, f, projected, stiffness);
  else
    for (std::size_t g = 0; g < points; ++g) stiffness.own[g] = law_.stiffness(lame_, f[g], projected);
  return stiffness;
}

PointMatrices FemElement::at_points(const Corners& x) const {
  PointMatrices f;
  for (std::size_t g = 0; g < points; ++g) f[g] = x * gradients_[g];
  return f;
}

FemElement::Corners FemElement::force(const Corners& x, const Corners& v) const {
  const PointMatrices f = at_points(x);
  PointMatrices stress;
  if (law_.stresses) {
    law_.stresses(lame_, f, stress);
  } else {
    for (std::size_t g = 0; g < points; ++g) stress[g] = law_.stress(lame_, f[g]);
  }
  if (viscosity_.mu != 0 && !(v.array() == 0).all())
    for (std::size_t g = 0; g < points; ++g) stress[g] += viscous_stress(f[g], v * gradients_[g]);
  Corners force = Corners::Zero();
  for (std::size_t g = 0; g < points; ++g) force -= weight_ * stress[g] * gradients_[g].transpose();
  return force;
}

/// K_cd = sum over Gauss points of the weight times sum over axes a, b of g_c[a] D[a, b] g_d[b], with D[a, b]
/// the change of P's column a with F's column b: first by the gradients of d, then by those of c. What points
/// share adds 8 weight shared s s^T, s_c the mean of R g_c over points.
FemElement::Element FemElement::tangent(const Corners& x, const Corners& v,
                                        const TangentCoefficients& sum) const {
  const PointMatrices f = at_points(x);
  const bool has_elastic = sum.stiffness != 0;
  const CellStiffness elastic = has_elastic ? stiffness(f, sum.kind == Tangent::projected) : CellStiffness{};
  Element transposed = Element::Zero();
  for (std::size_t g = 0; g < points; ++g) {
    const auto& gradients = gradients_[g];
    Matrix9 d = viscous_change(f[g], v * gradients, sum);
    if (has_elastic) d += sum.stiffness * elastic.own[g];
    d *= weight_;
    Eigen::Matrix<double, 24, 9> by_stress;
    for (Eigen::Index entry = 0; entry < 9; ++entry)
      for (Eigen::Index c = 0; c < 8; ++c)
        by_stress.block<3, 1>(3 * c, entry) =
            (gradients(c, 0) * d.block<1, 3>(entry, 0) + gradients(c, 1) * d.block<1, 3>(entry, 3) +
             gradients(c, 2) * d.block<1, 3>(entry, 6))
                .transpose();
    for (Eigen::Index c = 0; c < 8; ++c)
      for (Eigen::Index i = 0; i < 3; ++i)
        transposed.col(3 * c + i) += gradients(c, 0) * by_stress.col(i) +
                                     gradients(c, 1) * by_stress.col(3 + i) +
                                     gradients(c, 2) * by_stress.col(6 + i);
  }
  if (has_elastic && elastic.shared != 0) {
    Corners mean = Corners::Zero();
    for (std::size_t g = 0; g < points; ++g)
      mean += elastic.axes[g] * gradients_[g].transpose() / double(points);
    const Eigen::Map<const Eigen::Matrix<double, 24, 1>> shared(mean.data());
    transposed += points * weight_ * sum.stiffness * elastic.shared * shared * shared.transpose();
  }
  return transposed.transpose();
}

double FemElement::energy(const Corners& x) const {
  const PointMatrices f = at_points(x);
  if (law_.energies) return weight_ * law_.energies(lame_, f);
  double energy = 0;
  for (const Matrix3d& at_point : f) energy += weight_ * law_.energy(lame_, at_point);
  return energy;
}

FemElement::Largest FemElement::largest() const {
  Corners rest;
  for (int c = 0; c < 8; ++c) rest.col(c) = size_ * Vec3(c & 1, (c >> 1) & 1, (c >> 2) & 1);
  const auto eigenvalue = [&](const TangentCoefficients& sum) {
    const Element matrix = tangent(rest, Corners::Zero(), sum);
    return Eigen::SelfAdjointEigenSolver<Element>(matrix, Eigen::EigenvaluesOnly).eigenvalues()[23];
  };
  return {.stiffness = eigenvalue({.stiffness = 1, .kind = Tangent::elastic}),
          .damping = viscosity_.mu != 0 ? eigenvalue({.damping = 1, .kind = Tangent::elastic}) : 0};
}

namespace {

std::vector<FemElement> elements_of(const Body& body, const SolidLaw& law) {
  std::vector<FemElement> elements;
  for (const Part& part : body.parts()) elements.emplace_back(part, body.config().cell_size, law);
  return elements;
}

/// No body is faster than its fastest cell alone (Irons and Treharne, 1971): at a joint both stiffness and
/// mass are sums over cells.
SpectralBound bound_of(const Body& body, const SolidLaw& law) {
  std::vector<FemElement::Largest> largest;
  for (const FemElement& element : elements_of(body, law)) largest.push_back(element.largest());
  std::set<const CellContent*> seen;
  double omega_squared = 0, damping_rate = 0;
  body.for_each_cell([&](std::ptrdiff_t site) {
    const CellContent& content = body.content_at(site);
    if (!seen.insert(&content).second) return;
    double stiffness = 0, damping = 0;
    std::array<double, 8> mass{};
    for (const auto& [part, fill] : content) {
      const auto p = std::size_t(part);
      stiffness += double(fill.share()) * largest[p].stiffness;
      damping += double(fill.share()) * largest[p].damping;
      for (int c = 0; c < 8; ++c)
        mass[std::size_t(c)] += body.parts()[p].density * body.cell_volume() / 8 *
                                corner_share(fill, c, body.config().mass_floor());
    }
    const double lightest = *std::min_element(mass.begin(), mass.end());
    omega_squared = std::max(omega_squared, stiffness / lightest);
    damping_rate = std::max(damping_rate, damping / lightest);
  });
  return {.omega = std::sqrt(omega_squared), .damping = damping_rate};
}

}  // namespace

FemSystem::FemSystem(const Body& body, const Environment& environment, const SolidLaw& law, int threads)
    : BodySystem<double>(body, environment, bound_of(body, law), team_size(body, threads)),
      elements_(elements_of(body, law)),
      cells_(body),
      tangents_(*this) {}

/// What a cell's parts say, each as far as it fills the cell.
template <class Value, class OfPart>
Value FemSystem::sum_over_parts(std::ptrdiff_t site, Value sum, OfPart&& of_part) const {
  for (const auto& [part, fill] : body().content_at(site))
    sum += double(fill.share()) * of_part(elements_[std::size_t(part)]);
  return sum;
}

CellCorners FemSystem::cell_force(const Field<double>& x, const Field<double>& v, std::ptrdiff_t site) const {
  return sum_over_parts(site, CellCorners(CellCorners::Zero()), [&](const FemElement& element) {
    return element.force(gather(x, site), gather(v, site));
  });
}

CellMatrix FemSystem::tangent(const Field<double>& x, const Field<double>& v, const TangentCoefficients& sum,
                              std::ptrdiff_t site) const {
  return sum_over_parts(site, CellMatrix(CellMatrix::Zero()), [&](const FemElement& element) {
    return element.tangent(gather(x, site), gather(v, site), sum);
  });
}

StoredEnergy FemSystem::stored_energy(const Field<double>& x) const {
  double energy = 0;
  for (const std::ptrdiff_t site : cells_.cells())
    energy = sum_over_parts(site, energy,
                            [&](const FemElement& element) { return element.energy(gather(x, site)); });
  return {.elastic = energy, .volume = 0};
}

std::optional<std::vector<Matrix3d>> FemSystem::cell_virials(const Field<double>& x,
                                                             const Field<double>& v) const {
  std::vector<Matrix3d> virials;
  for (const std::ptrdiff_t site : cells_.cells())
    virials.push_back(virial_about_middle(cell_force(x, v, site), gather(x, site)));
  return virials;
}

void FemSystem::force(double t, const Field<double>& x, const Field<double>& v, Field<double>& f) {
  f.array() = 0;
  cells_.add(
      *this, [&](std::ptrdiff_t site) { return cell_force(x, v, site); }, f);
  loads().add(t, 0, size(), std::array<double*, 3>{f.axis(0), f.axis(1), f.axis(2)});
  add_gravity(f);
  add_penalty_force(t, x, v, f);
}

/// Element by element in order, so that sums are the same bits for any number of threads.
const BlockMatrix& FemSystem::FemTangents::assembled(const Field<double>& x, const Field<double>& v,
                                                     TangentCoefficients sum) {
  sum.mass = 0;
  const auto equal = [](const Field<double>& a, const Field<double>& b) {
    return a.size() == b.size() && (a.array() == b.array()).all();
  };
  if (assembled_ && sum == sum_ && equal(x, x_) && equal(v, v_)) return *assembled_;
  if (!assembled_) assembled_ = std::make_unique<BlockMatrix>(body());
  assembled_->begin(0);
  constexpr std::size_t together = 256;
  const std::vector<std::ptrdiff_t>& cells = system_.cells_.cells();
  std::vector<CellMatrix> matrices(std::min(together, cells.size()));
  for (std::size_t first = 0; first < cells.size(); first += together) {
    const std::size_t count = std::min(together, cells.size() - first);
    system_.parallel(std::ptrdiff_t(count), [&](std::ptrdiff_t i) {
      matrices[std::size_t(i)] = system_.tangent(x, v, sum, cells[first + std::size_t(i)]);
    });
    for (std::size_t i = 0; i < count; ++i)
      for (int c = 0; c < 8; ++c)
        for (int d = 0; d < 8; ++d) assembled_->add(cells[first + i], c, d, block_of(matrices[i], c, d));
  }
  x_ = x;
  v_ = v;
  sum_ = sum;
  return *assembled_;
}

void FemSystem::FemTangents::add(double, const Field<double>& x, const Field<double>& v,
                                 const TangentCoefficients& sum, BlockMatrix& blocks) {
  blocks.add(assembled(x, v, sum));
}

void FemSystem::FemTangents::multiply(double, const Field<double>& x, const Field<double>& v,
                                      const TangentCoefficients& sum, const Field<double>& p,
                                      Field<double>& out) {
  assembled(x, v, sum).multiply(system_, sum.mass, p, out);
}

void FemSystem::FemTangents::add_diagonal(double, const Field<double>& x, const Field<double>& v,
                                          const TangentCoefficients& sum, std::vector<Matrix3d>& diagonal) {
  const BlockMatrix& blocks = assembled(x, v, sum);
  for (std::size_t p = 0; p < diagonal.size(); ++p) diagonal[p] += blocks.diagonal(p);
}

}  // namespace mss
